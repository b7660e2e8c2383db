"""Roads with left-hand traffic, without a server: the stack and the drivers read the mirror image of the same road."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest

carla = pytest.importorskip("carla")

from towns import some_routes, town  # noqa: E402

from carlette.maps import DEMO_TOWN  # noqa: E402
from left_hand_maps import left_hand  # noqa: E402
from stucksolver.scene import RoadGeometry  # noqa: E402
from stucksolver.scene.mirror import KEY_SUFFIX, mirrored_surroundings  # noqa: E402
from stucksolver_bridge.traffic_side import drives_on_left, inner_lane, outer_lane  # noqa: E402
from stucksolver_bridge.world_data import waypoint_at  # noqa: E402
from stucksolver_carla.drivers.behavior import RoutePoint  # noqa: E402
from stucksolver_carla.drivers.behavior.conflict_paths import junction_conflicts  # noqa: E402
from stucksolver_carla.drivers.behavior.lane_graph import lane_graph  # noqa: E402
from stucksolver_carla.drivers.behavior.route_line import route_path  # noqa: E402
from stucksolver_carla.drivers.planner.adjacent_lane_widths import lane_widths_along  # noqa: E402
from stucksolver_carla.stack.route_road import RouteRoad  # noqa: E402
from stucksolver_carla.stack.route_side import TrafficSideError, is_left_hand_route  # noqa: E402
from worlds import World, thing  # noqa: E402


@lru_cache(maxsize=1)
def left_town():
    return carla.Map("demo_left", left_hand(DEMO_TOWN.read_text(encoding="utf-8")))


def image_of(route) -> list[RoutePoint]:
    """The same route on the mirrored map."""
    sides = {"change_left": "change_right", "change_right": "change_left", "left": "right", "right": "left"}
    places = [(p.waypoint.road_id, -p.waypoint.lane_id, p.waypoint.s) for p in route]
    commands = [sides.get(p.command, p.command) for p in route]
    found = [RoutePoint(waypoint_at(left_town(), place), name) for place, name in zip(places, commands, strict=True)]
    assert all(point.waypoint is not None for point in found)
    return found


@pytest.fixture(params=range(4))
def routes(request):
    """A route of the demo town, and its mirror image."""
    route = some_routes("demo_town")[request.param]
    return route, image_of(route)


def mirrored(road: RoadGeometry) -> RoadGeometry:
    """The road as the solver gets it: through the same function as the surroundings."""
    return mirrored_surroundings(World(road, [thing("1", 0.0)]).surroundings()).road


def plain(road: RoadGeometry) -> dict:
    """All that a guard can see of a road: without names and keys."""
    data = road.model_dump(exclude={"key", "mirrored"})
    for lane in data["lanes"]:
        del lane["id"]
    # Lanes at the same distance on either side are listed in the order of the map's sides.
    data["lanes"] = sorted(data["lanes"], key=lambda lane: (lane["start"], round(lane["offset_m"][0], 1)))
    return data


def test_left_hand_route_is_recognized(routes):
    right, left = routes
    assert not is_left_hand_route(town("demo_town"), right)
    assert is_left_hand_route(left_town(), left)
    assert all(drives_on_left(point.waypoint) for point in left)


def test_left_hand_road_is_mirrored_for_the_solver(routes):
    """The solver gets the same road from both maps: lanes, lines, zones and reference line."""
    right, left = routes
    roads = RouteRoad(town("demo_town"), right), RouteRoad(left_town(), left)
    middle_m = float(roads[0].arc[-1]) / 2
    geometry, image = (road.slice(middle_m, 13.9) for road in roads)
    assert not image.mirrored
    seen = mirrored(image)
    assert seen.mirrored and seen.key.endswith(KEY_SUFFIX)
    first, second = plain(geometry), plain(seen)
    assert np.allclose(first.pop("reference"), second.pop("reference"), atol=0.002)
    lanes, others = first.pop("lanes"), second.pop("lanes")
    assert len(lanes) == len(others)
    for lane, other in zip(lanes, others, strict=True):
        assert np.allclose(lane.pop("offset_m"), other.pop("offset_m"), atol=0.02)
        assert np.allclose(lane.pop("width_m"), other.pop("width_m"), atol=0.02)
        assert lane == other
    zones, areas = first.pop("zones"), second.pop("zones")
    assert [zone["kind"] for zone in zones] == [area["kind"] for area in areas]
    assert first.keys() == second.keys()


def test_left_hand_priority_is_mirrored(routes):
    """At junctions, the same road users go first: right before left becomes left before right."""
    found = []
    for carla_map, route in zip((town("demo_town"), left_town()), routes, strict=True):
        line = route_path(route)
        conflicts = junction_conflicts(route, line, lane_graph(carla_map), [], [])
        ways = [
            (round(j.wait_s), way.joins, way.straight, way.goes_first, round(way.route_meets_s))
            for j in conflicts
            for way in j.ways
        ]
        found.append(sorted(ways))
    assert found[0] == found[1]


def test_left_hand_lane_widths_swap_sides(routes):
    """The driver `planner` passes through the oncoming lane on the right, and yields toward the edge on the left."""
    right, left = (lane_widths_along(route, route_path(route)) for route in routes)
    half, left_same, left_oncoming, right_same, right_oncoming = range(5)
    swapped = left.widths[:, [half, right_same, right_oncoming, left_same, left_oncoming]]
    assert np.allclose(right.widths, swapped, atol=0.02)
    assert not right.widths[:, right_oncoming].any()
    assert (right.edge_side, left.edge_side) == (1.0, -1.0)


def test_inner_and_outer_lane_by_side():
    """The inner lane is the one toward oncoming traffic."""
    for carla_map, lane in ((town("demo_town"), -1), (left_town(), 1)):
        here = carla_map.get_waypoint_xodr(11, lane, 50.0)
        assert inner_lane(here).lane_id == -lane
        assert outer_lane(here).lane_id == 2 * lane


class OldWaypoint:
    """A waypoint of a client that does not read the rule."""


@pytest.mark.parametrize("text", ["<OpenDRIVE/>", '<road id="1" rule="RHT"/>', '<road rule="LHT" id="1"/>'])
def test_client_that_ignores_the_rule_is_named(text):
    """Such a client reports all traffic as right-hand traffic: a map with the other rule is named at the start."""

    class OldMap:
        def to_opendrive(self):
            return text

    route = [RoutePoint(OldWaypoint(), "lane_follow")]
    if "LHT" not in text:
        assert not is_left_hand_route(OldMap(), route)
        return
    with pytest.raises(TrafficSideError, match=r"left-hand traffic.*0\.9\.16"):
        is_left_hand_route(OldMap(), route)


def test_route_that_changes_sides_is_named(routes):
    right, left = routes
    with pytest.raises(TrafficSideError, match="not supported"):
        is_left_hand_route(left_town(), [*right, *left])
