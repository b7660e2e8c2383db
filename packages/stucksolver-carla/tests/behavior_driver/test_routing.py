"""What a route promises."""

from __future__ import annotations

import math
import random
from itertools import pairwise

import carla
import pytest

from behavior_driver.roads import LANE_Y, straight_road
from carlette.maps import DEMO_TOWN
from stucksolver_carla.drivers.behavior import RouteError, trace_route
from stucksolver_carla.drivers.behavior.lane_graph import lane_graph

COMMANDS = {"lane_follow", "left", "right", "straight", "change_left", "change_right"}
TOWNS = ["Town01", "Town04", "Town10HD"]


def place(x: float, y: float) -> carla.Location:
    return carla.Location(x, y, 0.0)


def drivable_pairs(carla_map, count, seed=1):
    spots = [w.transform.location for w in carla_map.generate_waypoints(25.0)]
    chooser = random.Random(seed)
    return [(chooser.choice(spots), chooser.choice(spots)) for _ in range(count)]


def check_route(carla_map, start, end):
    route = trace_route(carla_map, start, end)
    assert route[0].waypoint.transform.location.distance(start) < 3.0
    assert route[-1].waypoint.transform.location.distance(end) < 3.0
    assert {point.command for point in route} <= COMMANDS
    for a, b in pairwise(route):
        before, after = a.waypoint.transform, b.waypoint.transform
        gap = before.location.distance(after.location)
        if not b.command.startswith("change"):
            assert gap < 1.6
            turn = math.radians(after.rotation.yaw - before.rotation.yaw)
            assert abs(math.remainder(turn, math.tau)) < 0.6
        else:
            assert gap < 6.0
    return route


@pytest.mark.integration
@pytest.mark.parametrize("name", TOWNS)
def test_route_between_any_two_places_is_continuous(town, name):
    carla_map = town(name)
    for start, end in drivable_pairs(carla_map, 12):
        check_route(carla_map, start, end)


def test_the_generated_town_has_routes_between_any_two_places():
    carla_map = carla.Map("demo_town", DEMO_TOWN.read_text(encoding="utf-8"))
    turns = set()
    for start, end in drivable_pairs(carla_map, 20):
        turns |= {point.command for point in check_route(carla_map, start, end)}
    assert {"left", "right"} <= turns


@pytest.mark.integration
def test_lane_graph_of_a_town_is_built_once(town):
    """Build the graph of a large town, which takes seconds, on the first call only."""
    carla_map = town("Town04")
    assert lane_graph(carla_map) is lane_graph(carla_map)


def test_points_lie_about_a_metre_apart():
    route = trace_route(straight_road(), place(10.0, LANE_Y[-1]), place(200.0, LANE_Y[-1]))
    steps = [a.waypoint.transform.location.distance(b.waypoint.transform.location) for a, b in pairwise(route)]
    assert min(steps) > 0.9 and max(steps) < 1.1
    assert {point.command for point in route} == {"lane_follow"}


@pytest.mark.parametrize(("from_lane", "to_lane", "command"), [(-1, -2, "change_right"), (-2, -1, "change_left")])
def test_a_route_changes_lane_once_where_the_marking_permits(from_lane, to_lane, command):
    route = trace_route(straight_road(), place(10.0, LANE_Y[from_lane]), place(200.0, LANE_Y[to_lane]))
    jumps = [b.command for a, b in pairwise(route) if a.waypoint.lane_id != b.waypoint.lane_id]
    assert jumps == [command]
    assert route[30].waypoint.lane_id == to_lane


def test_route_not_found_error_names_both_ends_and_remedy():
    with pytest.raises(RouteError, match=r"\(200\.0, 1\.8\).*\(10\.0, 1\.8\).*choose a destination"):
        trace_route(straight_road(), place(200.0, LANE_Y[-1]), place(10.0, LANE_Y[-1]))


def test_a_solid_line_is_never_crossed():
    with pytest.raises(RouteError):
        trace_route(straight_road(), place(200.0, LANE_Y[-1]), place(100.0, LANE_Y[1]))


def test_a_turn_is_named_as_the_driver_sees_it(town):
    carla_map = town("Town01")
    for start, end in drivable_pairs(carla_map, 6, seed=3):
        route = trace_route(carla_map, start, end)
        for i in range(1, len(route) - 1):
            before, here = route[i - 1], route[i]
            if here.waypoint.is_junction and not before.waypoint.is_junction and i + 1 < len(route):
                after = next((p for p in route[i:] if not p.waypoint.is_junction), route[-1])
                yaw = math.radians(after.waypoint.transform.rotation.yaw - before.waypoint.transform.rotation.yaw)
                sign = math.sin(yaw)
                expected = "straight" if abs(sign) < 0.5 else ("right" if sign > 0 else "left")
                assert here.command == expected
