"""What a plan promises about the map that is made of it."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from carlette.maps.build import End, JunctionNode, Plan, PlanError, PlannedStreet, map_xml
from carlette.maps.build.sections import AVENUE, BIKE_STREET, PARKING_STREET, RURAL

carla = pytest.importorskip("carla")

DOCUMENT = Path(__file__).resolve().parents[4] / "docs" / "maps.md"


def crossing(control="none", section=BIKE_STREET):
    """Four arms of 100 m round a node at the origin, each ending at a node of its own."""
    places = {0: (120, 0), 90: (0, 120), 180: (-120, 0), 270: (0, -120)}
    outer = [JunctionNode(f"end {angle}", *place) for angle, place in places.items()]
    streets = [
        PlannedStreet("arm", End("middle", angle, control), End(f"end {angle}", angle + 180, reach_m=1.0), section)
        for angle in (0, 90, 180, 270)
    ]
    return Plan("crossing", [JunctionNode("middle", 0.0, 0.0), *outer], streets)


def test_the_example_of_the_documentation_is_a_map():
    example = re.search(r"```python\n(.*?)```", DOCUMENT.read_text("utf-8"), re.S)
    names = {}
    exec(example[1], names)
    assert carla.Map("corner", names["text"]).get_topology()


@pytest.mark.parametrize(("section", "ways"), [(PARKING_STREET, 12), (AVENUE, 16), (BIKE_STREET, 12)])
def test_built_crossing_has_path_per_lane_and_movement(section, ways):
    """A built crossing has one path for each lane of each movement."""
    built = carla.Map("crossing", map_xml(crossing(section=section)))
    inside = [start for start, _ in built.get_topology() if start.is_junction]
    assert len(inside) == ways


def test_streets_meet_nodes_at_their_heights_and_are_level_there():
    nodes = [JunctionNode("low", 0.0, 0.0, 1.0), JunctionNode("high", 300.0, 0.0, 9.0)]
    road = PlannedStreet("up", End("low", 0.0), End("high", 180.0), RURAL, heights=((0.5, 12.0),))
    built = carla.Map("hill", map_xml(Plan("hill", nodes, [road])))
    places = [built.get_waypoint_xodr(1, -1, s).transform for s in (0.01, 131.0, 261.99)]
    assert [place.location.z for place in places] == pytest.approx([1.0, 12.0, 9.0], abs=0.01)
    assert [abs((place.rotation.pitch + 180) % 360 - 180) for place in places] == pytest.approx([0, 0, 0], abs=0.05)


def test_plans_that_do_not_hold_together_are_refused():
    node, end = JunctionNode("A", 0.0, 0.0), End("A", 0.0)
    with pytest.raises(PlanError, match="unknown node: 'B' at the end of 'Lost Lane'"):
        Plan("lost", [node], [PlannedStreet("Lost Lane", end, End("B", 180.0), RURAL)])
    with pytest.raises(PlanError, match="duplicate node in map 'twins': A"):
        Plan("twins", [node, node], [])


def test_lights_are_posted_only_where_asked_for():
    assert "1000001" not in map_xml(crossing())
    lit = map_xml(crossing("light"))
    assert lit.count('type="1000001"') == 4
    assert lit.count("<signalReference") == 12
