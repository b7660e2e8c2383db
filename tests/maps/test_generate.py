"""The committed town is what the script makes, and the script's lines join what they are asked to join."""

from __future__ import annotations

import math
import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from carlette.maps import DEMO_TOWN
from carlette.maps.lines import Pose, connect, end_of

coordinate = st.floats(-500, 500)
heading = st.floats(-math.pi, math.pi)
leg_m = st.floats(1, 100)


def test_the_committed_file_is_what_the_script_writes():
    pytest.importorskip("scenariogeneration")
    from carlette.maps.generate import town_xml

    assert DEMO_TOWN.read_bytes() == town_xml().encode()
    assert town_xml() == town_xml()


def test_check_mode_names_a_difference(tmp_path, monkeypatch, capsys):
    pytest.importorskip("scenariogeneration")
    from carlette.maps import generate

    changed = tmp_path / "demo_town.xodr"
    changed.write_text("changed")
    monkeypatch.setattr(generate, "DEMO_TOWN", changed)
    assert generate.main(["--check"]) == 1
    assert "demo_town.xodr differs" in capsys.readouterr().err
    assert generate.main([]) == 0
    assert generate.main(["--check"]) == 0


def test_the_map_is_found_without_the_generator_installed():
    code = "import sys; sys.modules['scenariogeneration'] = None; from carlette.maps import DEMO_TOWN as town; "
    code += "assert town.exists()"
    subprocess.run([sys.executable, "-c", code], check=True)


@given(coordinate, coordinate, heading, leg_m, st.floats(0.1, 2.5), st.booleans(), leg_m)
def test_connecting_lines_arrive_where_and_how_they_should(x, y, yaw_rad, first_m, turn_rad, left, second_m):
    start = Pose(x, y, yaw_rad)
    corner = start.moved(first_m)
    end = Pose(corner.x, corner.y, yaw_rad + (turn_rad if left else -turn_rad)).moved(second_m)
    reached = end_of(start, connect(start, end))
    assert math.hypot(reached.x - end.x, reached.y - end.y) < 1e-5
    assert abs(math.remainder(reached.yaw_rad - end.yaw_rad, 2 * math.pi)) < 1e-9


@pytest.mark.parametrize("end", [Pose(-10, 0, 0), Pose(10, 3, 0), Pose(-10, 10, math.pi / 2)])
def test_impossible_connections_are_refused(end):
    with pytest.raises(ValueError, match="leads from"):
        connect(Pose(0, 0, 0), end)
