"""Where the ways of others meet a route: on the roads of the demo town."""

from __future__ import annotations

import math
import random
from functools import lru_cache

import carla
import numpy as np
import pytest

from carlette.maps import DEMO_TOWN
from stucksolver_carla.drivers.behavior import RouteError, trace_route
from stucksolver_carla.drivers.behavior.conflict_paths import CONFLICT_M, junction_conflicts
from stucksolver_carla.drivers.behavior.lane_graph import lane_graph
from stucksolver_carla.drivers.behavior.route_line import route_path


@lru_cache(maxsize=1)
def junctions():
    """(route, line, its meetings) of some routes through the town."""
    town = carla.Map("demo", DEMO_TOWN.read_text(encoding="utf-8"))
    spots = [w.transform.location for w in town.generate_waypoints(20.0)]
    chooser, found = random.Random(3), []
    while len(found) < 25:
        try:
            route = trace_route(town, chooser.choice(spots), chooser.choice(spots))
        except RouteError:
            continue
        line = route_path(route)
        found.append((route, line, junction_conflicts(route, line, lane_graph(town), [], [])))
    return found


def all_ways():
    return [(line, meeting, way) for _, line, found in junctions() for meeting in found for way in meeting.ways]


@pytest.mark.integration
def test_the_town_has_ways_that_cross_and_ways_that_join():
    assert {way.joins for _, _, way in all_ways()} == {True, False}


def test_conflict_path_meets_route_at_its_stated_place():
    """Each path comes near the route where it is stated to, and not before."""
    for line, _, way in all_ways():
        i = int(np.argmin(np.abs(way.s - way.meets_s)))
        away = np.hypot(line.x - way.x[i], line.y - way.y[i])
        assert away.min() < CONFLICT_M + 0.5
        assert way.route_meets_s <= way.route_parts_s and way.inside_s - 1.0 <= way.meets_s <= way.parts_s


def test_the_place_to_wait_lies_before_the_ways_meet():
    assert all(meeting.wait_s - 1.5 <= meeting.first_s for _, meeting, _ in all_ways())


def test_conflict_path_never_uses_approach_lane_of_route():
    """No path leads along the lane by which the route arrives."""
    for line, meeting, way in all_ways():
        x, y, yaw = line.at(np.array([meeting.wait_s - 5.0]))
        same = np.cos(way.yaw - yaw[0]) > 0.9
        away = np.hypot(way.x - x[0], way.y - y[0])
        assert not (same & (away < 1.0) & (way.s < way.inside_s)).any()


def test_left_turn_yields_to_through_traffic():
    left = [
        way
        for route, line, found in junctions()
        for meeting in found
        for way in meeting.ways
        if way.straight and _turn_deg(line, meeting) < -60.0
    ]
    assert left and all(item.goes_first for item in left)


def test_after_a_stop_sign_all_others_go_first():
    route, line, found = next(junction for junction in junctions() if junction[2])
    town = carla.Map("demo", DEMO_TOWN.read_text(encoding="utf-8"))
    signed = junction_conflicts(route, line, lane_graph(town), [], [meeting.wait_s for meeting in found])
    assert all(way.goes_first for meeting in signed for way in meeting.ways)


def _turn_deg(line, meeting):
    _, _, yaw = line.at(np.array([meeting.wait_s, max(meeting.last_s, meeting.wait_s + 20.0)]))
    return pytest.approx(0.0) if len(yaw) < 2 else math.degrees(float(yaw[1] - yaw[0]))
