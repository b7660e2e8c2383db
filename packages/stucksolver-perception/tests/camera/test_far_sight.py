"""Sight along lanes by the camera: what was not looked at, or not well, is not free."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from stucksolver_perception.camera.camera_sight_distance import CameraSight, LaneCoverage, SightModel, wilson_lower
from stucksolver_perception.measurements import Floats
from stucksolver_perception.rig import load_rig

CAMERA = load_rig().camera
DAY, NIGHT = np.array([150.0, 30.0]), np.array([20.0, 5.0])
NOTHING = np.zeros((0, 7))


def card() -> dict[str, Any]:
    """By day everything is found up to 175 m, by night up to 75 m; beyond, four in five are."""
    day = [[400, 400]] * 6 + [[320, 400]] * 2
    night = [[400, 400]] * 2 + [[320, 400]] * 6
    return {
        "bins_m": [25.0 * k for k in range(1, 10)],
        "look_edges": {"brightness": [60.0], "contrast": []},
        "recall": {"vehicle": [night, day]},
        "repeated_miss": [20, 100],
    }


MODEL = SightModel.from_card(card())
SIGHT = CameraSight(CAMERA, MODEL)


def lane(y: float = 3.5, length: float = 220.0) -> Floats:
    x = np.arange(0.0, length + 1.0, 5.0)
    return np.stack([x, np.full(len(x), y)], 1)


def seen(line: Floats, blockers: Floats = NOTHING, look: Floats = DAY, earlier: tuple[LaneCoverage, ...] = ()) -> float:
    return SIGHT.visible_length_m(line, SIGHT.look(10.0, look, line, blockers), earlier)


def car(x: float, y: float, length: float = 4.5, width: float = 1.9, height: float = 1.5) -> Floats:
    return np.array([[x, y, height / 2.0, length, width, height, 0.0]])


def test_sight_open_straight_lane_reaches_detector_range() -> None:
    """An open straight lane is visible as far as the detector was good enough."""
    assert seen(lane()) == pytest.approx(175.0, abs=3.0)


def test_at_night_it_is_seen_less_far() -> None:
    assert seen(lane(), look=NIGHT) == pytest.approx(75.0, abs=3.0)


def test_beyond_the_ranges_that_were_measured_nothing_is_seen() -> None:
    always = SightModel.from_card({**card(), "recall": {"vehicle": [[[400, 400]] * 8] * 2}})
    sight, line = CameraSight(CAMERA, always), lane(length=300.0)
    assert sight.visible_length_m(line, sight.look(0.0, DAY, line, NOTHING)) == pytest.approx(225.0, abs=3.0)


def test_few_pictures_to_measure_recall_with_give_no_sight() -> None:
    scarce = SightModel.from_card({**card(), "recall": {"vehicle": [[[3, 3]] * 8] * 2}})
    assert scarce.reach_m(DAY) <= 25.0


def test_a_car_in_the_lane_ends_the_sight() -> None:
    assert seen(lane(), car(60.0, 3.5)) == pytest.approx(60.0, abs=5.0)


def test_sight_van_close_ahead_occludes_oncoming_lane() -> None:
    """A van close ahead in the ego's lane occludes the oncoming lane far away."""
    assert seen(lane(), car(12.0, 0.0, 5.9, 2.1, 2.6)) < 80.0


def test_a_car_behind_or_far_beside_hides_nothing() -> None:
    assert seen(lane(), np.concatenate([car(-15.0, 0.0), car(60.0, -30.0)])) == pytest.approx(seen(lane()))


def test_sight_box_beside_lens_occludes_its_side() -> None:
    """A box that begins beside the lens occludes its own side."""
    bus = car(4.0, 2.6, 12.0, 2.5, 3.2)
    assert seen(lane(6.0), bus) < 60.0
    assert seen(lane(-6.0), bus) == pytest.approx(seen(lane(-6.0)))


def test_beyond_a_bend_nothing_is_seen() -> None:
    angle = np.linspace(0.0, 1.5, 60)
    bend = np.concatenate([lane(0.0, 40.0), np.stack([40.0 + 80.0 * np.sin(angle), 80.0 * (1.0 - np.cos(angle))], 1)])
    assert seen(bend) < 120.0


def test_beyond_a_crest_nothing_is_seen() -> None:
    flat = lane(0.0)
    crest = np.column_stack([flat, -0.06 * np.maximum(flat[:, 0] - 60.0, 0.0)])
    assert seen(crest) < 100.0 < seen(flat)


def test_a_lane_out_of_the_picture_is_not_seen() -> None:
    away = np.stack([np.full(40, 5.0), np.arange(0.0, 200.0, 5.0)], 1)
    assert seen(away) < 10.0


def test_sight_second_look_helps_only_if_clear_and_independent() -> None:
    """A second look helps only if it covered the lane and is independent of the first one."""
    line = lane()
    half_hidden = SIGHT.look(9.0, DAY, line, car(60.0, 3.5))
    clear = SIGHT.look(9.0, DAY, line, NOTHING)
    same = LaneCoverage(9.9, clear.visible_m, DAY)
    dark = LaneCoverage(9.0, clear.visible_m, NIGHT)
    assert seen(line, earlier=(clear, LaneCoverage(8.0, clear.visible_m, DAY))) > 200.0
    for useless in (half_hidden, same, dark):
        assert seen(line, earlier=(useless,)) == pytest.approx(seen(line))


def test_lane_coverage_moved_is_shorter() -> None:
    """A look from farther back covers less of the lane ahead."""
    assert LaneCoverage(0.0, 100.0, DAY).moved(30.0).visible_m == 70.0
    assert LaneCoverage(0.0, 10.0, DAY).moved(30.0).visible_m == 0.0


def test_wilson_lower_is_below_share_and_rises_with_count() -> None:
    """The lower bound of a share is below it and rises with the count."""
    few, many = wilson_lower(np.array([9.0, 900.0]), np.array([10.0, 1000.0]))
    assert 0.0 < few < many < 0.9
    assert wilson_lower(np.array(0.0), np.array(0.0)) == 0.0
