"""Other ways through a junction are offered where the vehicle can turn to them from where it stands."""

from __future__ import annotations

import itertools
import math
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

carla = pytest.importorskip("carla")

import carlette.maps  # noqa: E402
from stucksolver.scene import EgoState, ObjectKind, TrackedObject  # noqa: E402
from stucksolver_carla.drivers.behavior.routing import trace_route  # noqa: E402
from stucksolver_carla.stack.alternative_routes import junction_alternatives, max_curvature, transition_curve  # noqa: E402
from stucksolver_carla.stack.carla_frames import to_local  # noqa: E402
from stucksolver_carla.stack.route_road import RouteRoad  # noqa: E402

JUNCTION_M = 39
"""Along the route; the turn to the right is 26 m long, the way straight on 39 m."""


@cache
def grid_town():
    path = Path(carlette.maps.__file__).parent / "grid_town.xodr"
    return carla.Map("grid_town", path.read_text("utf-8"))


@cache
def road():
    """Right at a crossing of two streets with two lanes each way, from the lane at the kerb, and over the next one."""
    places = [(565.25, -461.0), (565.25, -498.0), (583.0, -518.25), (862.0, -518.25), (918.0, -518.25)]
    points = []
    for start, end in itertools.pairwise(places):
        points += trace_route(grid_town(), carla.Location(*start, 0.0), carla.Location(*end, 0.0))[bool(points) :]
    return RouteRoad(grid_town(), points), points


def ways_from(into_m, *things, aside_m=0.0):
    """What is offered to who stands so far in the junction on the route."""
    here, points = road()
    waypoint = points[JUNCTION_M + into_m].waypoint
    assert waypoint.is_junction == (into_m >= 0)
    x, y = to_local(waypoint.transform.location)
    yaw = -math.radians(waypoint.transform.rotation.yaw)
    ego = EgoState(x_m=x, y_m=y + aside_m, yaw_rad=yaw, speed_mps=0.0, length_m=4.9, width_m=1.85)
    arc = here.arc_of(x, y, 0, len(here.stations))
    return junction_alternatives(grid_town(), here, arc, ego, things, points[-1].waypoint.transform.location)


def barrier(x, y):
    return TrackedObject(
        id="1",
        kind=ObjectKind.BARRIER,
        x_m=x,
        y_m=y,
        yaw_rad=0.0,
        vx_mps=0.0,
        vy_mps=0.0,
        length_m=3.0,
        width_m=0.4,
        height_m=1.0,
    )


@pytest.mark.integration
def test_other_ways_in_right_turn_offer_straight_on():
    """An ego that has begun to turn right may still go straight on."""
    (way,) = ways_from(6)
    assert way.turn == "straight" and way.distance_m < 5.0


def test_other_ways_route_avoids_closed_street():
    """The new route leads around the block and not back into the street."""
    (way,) = ways_from(6)
    _, points = road()
    assert way.route_length_m is not None and way.route_length_m > 2 * len(points)
    route = trace_route(grid_town(), way.waypoint.transform.location, points[-1].waypoint.transform.location)
    closed = points[JUNCTION_M + 60].waypoint.road_id
    assert closed not in {item.waypoint.road_id for item in route}


def test_other_ways_route_begins_on_offered_lane():
    (way,) = ways_from(6)
    found = grid_town().get_waypoint(way.waypoint.transform.location)
    assert (found.road_id, found.lane_id) == (way.waypoint.road_id, way.waypoint.lane_id)


@pytest.mark.parametrize("into_m", [18, 24])
def test_nothing_is_offered_that_lies_within_the_turning_circle(into_m):
    assert ways_from(into_m) == ()


@pytest.mark.parametrize("into_m", [-1, -10, -30])
def test_nothing_is_offered_before_the_stop_line(into_m):
    assert ways_from(into_m) == ()


def test_what_stands_on_the_way_over_closes_it():
    assert ways_from(6, barrier(565.0, 514.0)) == ()
    assert len(ways_from(6, barrier(572.0, 511.0))) == 1


def test_the_way_over_stays_on_the_road():
    assert ways_from(6, aside_m=0.0) and not ways_from(12, aside_m=-4.0)


@given(st.floats(-20, 20), st.floats(5, 20), st.floats(-0.8, 0.8), st.floats(-3, 3))
def test_a_way_over_begins_and_ends_as_it_should(x, ahead, turn, yaw):
    start, end = (x, 1.0, yaw), (x + ahead * math.cos(yaw), 1.0 + ahead * math.sin(yaw), yaw + turn)
    a, b, heading = transition_curve(start, end)
    assert (a[0], b[0], a[-1], b[-1]) == pytest.approx((start[0], start[1], end[0], end[1]))
    assert abs(math.remainder(heading[0] - start[2], math.tau)) < 0.15
    assert abs(math.remainder(heading[-1] - end[2], math.tau)) < 0.15


@pytest.mark.parametrize("radius_m", [5.0, 12.0])
def test_the_sharpest_bend_of_a_circle_is_its_own(radius_m):
    angle = np.linspace(0.0, 1.5, 60)
    assert 1.0 / max_curvature(radius_m * np.cos(angle), radius_m * np.sin(angle)) == pytest.approx(radius_m, rel=0.05)
