"""Where the LiDAR's sight ends the camera goes on, with what its last pictures showed."""

from __future__ import annotations

import numpy as np
import pytest

from stucksolver_perception.camera.camera_sight_distance import CameraSight, SightModel
from stucksolver_perception.camera.far_detector import FarDetections
from stucksolver_perception.camera.far_range import FarPlaces
from stucksolver_perception.far_view import FRESH_S, FarImage, FarView, occluders_in
from stucksolver_perception.measurements import Floats, PoseEstimate
from stucksolver_perception.rig import load_rig
from stucksolver_perception.tracking import Track

CAMERA = load_rig().camera
DAY = np.array([150.0, 30.0])
NOTHING = np.zeros((0, 7))
LINE = np.stack([np.arange(0.0, 221.0), np.full(221, 3.5)], 1)


def model(found: int = 400, again: int = 20, part: int | None = None) -> SightModel:
    """Of 400 vehicles so many are found, up to 175 m; of 100 misses so many are repeated. `part`: of those in part."""
    recall = [[found, 400]] * 6 + [[0, 400]] * 2
    edges = {"brightness": [], "contrast": []}
    bins = [25.0 * k for k in range(1, 10)]
    card = {"bins_m": bins, "look_edges": edges, "recall": {"vehicle": [recall]}, "repeated_miss": [again, 100]}
    if part is not None:
        seen = [[[part, 400]] * 5 + [[0, 400]] * 3]
        card |= {"part": {"recall": seen, "repeated_miss": [again, 100]}}
    return SightModel.from_card(card)


def ahead(height_m: float) -> Floats:
    """A car that stands 5 m before the ego, in its lane."""
    return np.array([[9.8, 0.0, height_m / 2.0, 4.9, 1.84, height_m, 0.0]])


def nobody(time_s: float) -> FarDetections:
    none = np.zeros(0)
    return FarDetections(time_s, none, none, none, none, none, np.zeros(0, np.int64), none, DAY)


def pose(time_s: float) -> PoseEstimate:
    return PoseEstimate(time_s, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, np.eye(4))


def standing(x: float, y: float) -> Track:
    place = {"x_m": x, "y_m": y, "z_m": 0.8, "yaw_rad": 0.0, "vx_mps": 0.0, "vy_mps": 0.0}
    size = {"length_m": 4.5, "width_m": 1.9, "height_m": 1.6}
    seen = {"first_seen_s": 0.0, "last_seen_s": 1.0, "hits": 5, "hidden": False}
    return Track(
        1, 1.0, 0, 0.9, 0.9, **place, **size, **seen, covariance=np.eye(5), standing_since_s=0.0, moved_at_s=None
    )


def view(*times: float, recall: SightModel | None = None, blockers: Floats = NOTHING) -> FarView:
    recall = recall or model()
    empty = FarView((), CameraSight(CAMERA, recall), recall)
    for time_s in times:
        empty = empty.with_image(FarImage(nobody(time_s), pose(time_s), blockers))
    return empty


def test_the_camera_goes_on_to_where_it_finds_vehicles() -> None:
    assert view(1.0).clear_length_m(LINE, 50.0, 20.0, 1.0) == pytest.approx(175.0, abs=4.0)


def test_what_came_nearer_since_the_picture_is_taken_off() -> None:
    fresh, older = (view(1.0).clear_length_m(LINE, 50.0, 20.0, 1.0 + age) for age in (0.0, 0.3))
    assert fresh - older == pytest.approx(6.0)


def test_an_old_picture_says_nothing() -> None:
    assert view(1.0).clear_length_m(LINE, 50.0, 20.0, 1.01 + FRESH_S) == 50.0


def test_without_a_picture_sight_is_the_lidars() -> None:
    assert view().clear_length_m(LINE, 50.0, 20.0, 1.0) == 50.0


def test_clear_length_with_little_lidar_sight_is_not_extended() -> None:
    """A lane of which the LiDAR covers little is not extended by the camera."""
    assert view(1.0).clear_length_m(LINE, 15.0, 20.0, 1.0) == 15.0


def test_a_detector_that_misses_too_many_adds_nothing() -> None:
    assert view(1.0, recall=model(found=300)).clear_length_m(LINE, 50.0, 20.0, 1.0) == 50.0


def test_three_looks_show_what_one_does_not() -> None:
    weak = model(found=370, again=20)
    assert view(2.0, recall=weak).clear_length_m(LINE, 50.0, 20.0, 2.0) == 50.0
    assert view(1.0, 1.5, 2.0, recall=weak).clear_length_m(LINE, 50.0, 20.0, 2.0) > 120.0


def test_looks_in_quick_succession_are_one_look() -> None:
    weak = model(found=370, again=20)
    assert view(1.8, 1.9, 2.0, recall=weak).clear_length_m(LINE, 50.0, 20.0, 2.0) == 50.0


def test_clear_length_earlier_look_is_shorter_for_fast_traffic() -> None:
    """An earlier look covers less of a lane with fast traffic."""
    weak = model(found=370, again=20)
    slow, quick = (view(1.5, 2.0, recall=weak).clear_length_m(LINE[:120], 50.0, v, 2.0) for v in (5.0, 30.0))
    # Half a second earlier: 12.5 m between the two.
    assert slow - quick == pytest.approx(12.5, abs=2.5)


def test_behind_a_vehicle_nothing_is_seen() -> None:
    bus = np.array([[40.0, 2.5, 1.6, 12.0, 2.5, 3.2, 0.0]])
    assert view(1.0, blockers=bus).clear_length_m(LINE, 30.0, 20.0, 1.0) < 50.0


def test_blocker_of_found_vehicle_is_at_nearest_place() -> None:
    """A found vehicle occludes from the nearest place where it can be."""
    one = np.array([100.0])
    column = np.array([CAMERA.width_px / 2.0 - CAMERA.focal_px * 3.5 / 100.0])
    found = FarDetections(
        1.0,
        column,
        np.array([468.0]),
        np.array([20.0]),
        np.array([17.0]),
        np.array([0.9]),
        np.array([0]),
        np.array([0.9]),
        DAY,
    )
    places = FarPlaces(one, 0.1 * one, np.array([[100.8, 3.5]]), np.eye(2)[None])
    (box,) = occluders_in((), found, places, CAMERA, pose(1.0))
    assert box[0] == pytest.approx(80.8)
    assert box[1] == pytest.approx(2.8)
    seen = view(1.0, blockers=box[None]).clear_length_m(LINE, 50.0, 20.0, 1.0)
    assert 70.0 < seen < 90.0


def test_only_who_reaches_into_the_picture_can_hide() -> None:
    places = [(30.0, 3.0), (30.0, 24.0), (30.0, 40.0), (3.0, 1.0), (2.0, 5.0), (-10.0, 0.0)]
    tracks = [standing(x, y) for x, y in places]
    none = FarPlaces(np.zeros(0), np.zeros(0), np.zeros((0, 2)), np.zeros((0, 2, 2)))
    boxes = occluders_in(tracks, nobody(1.0), none, CAMERA, pose(1.0))
    assert [(x, y) for x, y in boxes[:, :2]] == [(30.0, 3.0), (30.0, 24.0), (3.0, 1.0), (2.0, 5.0)]


def test_only_looks_that_can_still_count_are_kept() -> None:
    many = view(*(0.2 * k for k in range(100)))
    assert len(many.images) <= 9
    assert many.images[0].detections.time_s == pytest.approx(19.8)


@pytest.mark.parametrize(
    ("height_m", "part", "seen_m"),
    [(1.49, 400, 150.0), (1.49, None, 70.0), (1.49, 280, 70.0), (1.9, 400, 70.0), (None, None, 175.0)],
)
def test_clear_length_over_low_car_uses_partly_visible_vehicles(
    height_m: float | None, part: int | None, seen_m: float
) -> None:
    """Over the roof of a low car, the camera detects the upper part of oncoming vehicles.

    The LiDAR, a meter higher, covered the first 70 m. Of these, the car occludes all from 27 m on from the camera.
    """
    blockers = NOTHING if height_m is None else ahead(height_m)
    seen = view(1.0, recall=model(part=part), blockers=blockers).clear_length_m(LINE, 70.0, 20.0, 1.0)
    assert seen == pytest.approx(seen_m, abs=4.0)


def test_clear_length_behind_roof_needs_lidar_coverage() -> None:
    """The space behind the roof that the LiDAR did not cover is not skipped."""
    assert view(1.0, recall=model(part=400), blockers=ahead(1.49)).clear_length_m(LINE, 35.0, 20.0, 1.0) < 38.0


def test_clear_length_over_roof_counts_repeated_misses() -> None:
    """Further looks over the roof count with the misses that they repeat.

    With nine in ten found in part, one look is too few.
    """
    once, three, repeated = (
        view(*times, recall=model(part=360, again=again), blockers=ahead(1.49)).clear_length_m(LINE, 70.0, 0.0, 2.0)
        for times, again in (((2.0,), 20), ((1.0, 1.5, 2.0), 20), ((1.0, 1.5, 2.0), 95))
    )
    assert once == repeated == 70.0
    assert three > 140.0
