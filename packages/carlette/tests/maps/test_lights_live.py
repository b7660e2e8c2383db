"""Through the client: which lanes stop for a light, and which lights belong to a junction."""

from __future__ import annotations

import pytest

from serving import running_server

pytestmark = pytest.mark.integration

carla = pytest.importorskip("carla")


@pytest.fixture(scope="module")
def world():
    with running_server("--map", "grid_town") as port:
        client = carla.Client("127.0.0.1", port)
        client.set_timeout(60.0)
        yield client.get_world()


def test_traffic_light_stop_lanes_lead_to_governed_lanes(world):
    """The stop waypoints of a light lie on exactly the lanes that lead to the lanes it governs."""
    lights = world.get_actors().filter("traffic.traffic_light")
    assert len(lights) == 28
    for light in lights:
        stopping = {(at.road_id, at.lane_id) for at in light.get_stop_waypoints()}
        governed = [before for at in light.get_affected_lane_waypoints() for before in at.previous(2.0)]
        assert stopping == {(at.road_id, at.lane_id) for at in governed}


def test_lit_junction_has_one_light_per_arm(world):
    """A junction with lights has one for each of its arms."""
    junctions = {at.junction_id: at.get_junction() for pair in world.get_map().get_topology() for at in pair}
    arms = {}
    for number, junction in junctions.items():
        if junction is not None:
            pairs = junction.get_waypoints(carla.LaneType.Driving)
            arms[number] = len({begin.previous(1.0)[0].road_id for begin, _ in pairs})
    lit = {number: len(world.get_traffic_lights_in_junction(number)) for number in arms}
    assert {number for number, count in lit.items() if count not in (0, arms[number])} == set()
    assert sorted(count for count in lit.values() if count) == [3, 3, 3, 3, 4, 4, 4, 4]
