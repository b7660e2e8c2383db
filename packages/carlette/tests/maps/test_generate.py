"""The committed town is what the script makes, and the script's lines join what they are asked to join."""

from __future__ import annotations

import math
import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from carlette.maps import SHIPPED, generate
from carlette.maps.generate import WRITERS
from carlette.maps.reference_lines import Pose2D, connect, end_of, lead, two_arcs

coordinate = st.floats(-500, 500)
heading = st.floats(-math.pi, math.pi)
leg_m = st.floats(1, 100)
whole_m = st.integers(-500, 500)
whole_deg = st.integers(-170, 180)


@pytest.mark.integration
@pytest.mark.parametrize("name", WRITERS)
def test_the_committed_file_is_what_the_script_writes(name):
    if name == "demo_town":
        pytest.importorskip("scenariogeneration")
    text = WRITERS[name]()
    assert (SHIPPED / f"{name}.xodr").read_bytes() == text.encode()
    assert WRITERS[name]() == text


def test_every_map_that_ships_has_a_script():
    assert {path.stem for path in SHIPPED.glob("*.xodr")} == set(WRITERS)


def test_check_mode_names_each_difference(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(generate, "WRITERS", {"one": lambda: "first", "two": lambda: "second"})
    (tmp_path / "one.xodr").write_text("changed", encoding="utf-8")
    assert generate.main(["--check"], tmp_path) == 1
    printed = capsys.readouterr().err
    assert "one.xodr differs" in printed
    assert "two.xodr differs" in printed
    assert generate.main([], tmp_path) == 0
    assert generate.main(["--check"], tmp_path) == 0


def test_the_map_is_found_without_the_generator_installed():
    code = "import sys; sys.modules['scenariogeneration'] = None; from carlette.maps import DEMO_TOWN as town; "
    code += "assert town.exists()"
    subprocess.run([sys.executable, "-c", code], check=True)


@given(coordinate, coordinate, heading, leg_m, st.floats(0.1, 2.5), st.booleans(), leg_m)
def test_connecting_lines_arrive_where_and_how_they_should(x, y, yaw_rad, first_m, turn_rad, left, second_m):
    start = Pose2D(x, y, yaw_rad)
    corner = start.moved(first_m)
    end = Pose2D(corner.x, corner.y, yaw_rad + (turn_rad if left else -turn_rad)).moved(second_m)
    reached = end_of(start, connect(start, end))
    assert math.hypot(reached.x - end.x, reached.y - end.y) < 1e-5
    assert abs(math.remainder(reached.yaw_rad - end.yaw_rad, 2 * math.pi)) < 1e-9


@pytest.mark.parametrize("end", [Pose2D(-10, 0, 0), Pose2D(10, 3, 0), Pose2D(-10, 10, math.pi / 2)])
def test_impossible_connections_are_refused(end):
    with pytest.raises(ValueError, match="leads from"):
        connect(Pose2D(0, 0, 0), end)


@given(whole_m, whole_m, whole_deg, whole_m, whole_m, whole_deg)
def test_smooth_lines_arrive_where_and_how_they_should(x, y, yaw_deg, to_x, to_y, to_yaw_deg):
    start, end = Pose2D(x, y, math.radians(yaw_deg)), Pose2D(to_x, to_y, math.radians(to_yaw_deg))
    try:
        segments = two_arcs(start, end)
    except ValueError:
        return
    reached = end_of(start, segments)
    scale_m = 1.0 + sum(segment.length_m for segment in segments)
    assert math.hypot(reached.x - end.x, reached.y - end.y) < 1e-4 * scale_m
    assert abs(math.remainder(reached.yaw_rad - end.yaw_rad, 2 * math.pi)) < 1e-4


@given(st.floats(10, 100), st.floats(-8, 8))
def test_a_lane_shift_is_smooth(ahead_m, left_m):
    segments = lead(Pose2D(0, 0, 0), Pose2D(ahead_m, left_m, 0))
    reached = end_of(Pose2D(0, 0, 0), segments)
    # A shift of some thousandths of a millimeter is driven straight, the more the longer the way.
    assert (reached.x, reached.y, reached.yaw_rad) == pytest.approx((ahead_m, left_m, 0), abs=2e-7 * ahead_m)
