"""Who comes into the way ahead goes first; who keeps its lane in a bend does not come into it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stucksolver.reasoners.duties.observation import goes_first
from stucksolver.scene import CandidateWaypoint, LaneDirection, LineKind
from worlds import LANE_M, World, bent_road, strip, thing

COUNT = 160
EGO_S = 60.0
RADII = st.one_of(st.floats(30.0, 400.0), st.floats(-400.0, -30.0))
LANES = {
    "left": (LANE_M, LaneDirection.SAME),
    "right": (-LANE_M, LaneDirection.SAME),
    "oncoming": (2 * LANE_M, LaneDirection.OPPOSITE),
}


def pose(radius_m, s, d):
    """x, y and heading of a place of an arc that turns left about (0, radius); `d` meters to the left of it."""
    angle = s / radius_m
    return (radius_m - d) * math.sin(angle), radius_m - (radius_m - d) * math.cos(angle), angle


def scene_in_bend(radius_m, *others):
    """The ego stands in its lane of a bend of four lanes, with its way ahead told every 20 m."""
    lanes = tuple(strip(name, d, way, LineKind.BROKEN, COUNT) for name, (d, way) in LANES.items())
    x, y, yaw = pose(radius_m, EGO_S, 0.0)
    world = World(bent_road(radius_m, count=COUNT, lanes=lanes), list(others), x=x, y=y, yaw=yaw)
    scene = world.scene()
    waypoints = []
    for ahead in (20.0, 40.0):
        wx, wy, _ = pose(radius_m, EGO_S + ahead, 0.0)
        c, n = math.cos(yaw), math.sin(yaw)
        waypoints.append(
            CandidateWaypoint(
                id=f"own+{ahead:.0f}",
                lane_id=str(scene.ego.lane_id),
                x_m=(wx - x) * c + (wy - y) * n,
                y_m=(wy - y) * c - (wx - x) * n,
                distance_m=ahead,
            )
        )
    return scene.model_copy(update={"waypoints": tuple(waypoints)})


def driving(radius_m, s, d, along, across=0.0):
    """A car with a speed along and across the bend at its place."""
    x, y, heading = pose(radius_m, EGO_S + s, d)
    c, n = math.cos(heading), math.sin(heading)
    car = thing("car", x, y, speed=along * c - across * n, sideways=along * n + across * c)
    return car.model_copy(update={"yaw_rad": heading if along >= 0.0 else heading + math.pi})


@pytest.mark.integration
@given(RADII, st.sampled_from(sorted(LANES)), st.floats(-45.0, 45.0), st.floats(4.0, 15.0))
def test_who_keeps_another_lane_of_a_bend_does_not(radius_m, lane, s, speed):
    d, way = LANES[lane]
    car = driving(radius_m, s, d, speed if way is LaneDirection.SAME else -speed)
    assert goes_first(scene_in_bend(radius_m, car)) is None


@pytest.mark.integration
@given(RADII, st.floats(10.0, 35.0), st.sampled_from([-1.0, 1.0]), st.floats(4.0, 10.0))
def test_who_drives_across_the_bend_ahead_does(radius_m, s, side, speed):
    car = driving(radius_m, s, side * 3.0 * speed, 0.0, -side * speed)
    first = goes_first(scene_in_bend(radius_m, car))
    assert first is not None and first.id == "car"


@pytest.mark.integration
@given(RADII, st.sampled_from(["left", "right"]), st.floats(6.0, 12.0))
def test_who_changes_into_our_lane_ahead_does(radius_m, lane, speed):
    d, _ = LANES[lane]
    car = driving(radius_m, -20.0, d, speed, -np.sign(d) * 0.8)
    assert goes_first(scene_in_bend(radius_m, car)) is not None


@pytest.mark.parametrize("speed", [-8.0, 8.0])
def test_goes_first_oncoming_does_and_lead_does_not(speed):
    """An oncoming vehicle in the ego's lane goes first; a lead vehicle does not."""
    assert (goes_first(scene_in_bend(80.0, driving(80.0, 30.0, 0.0, speed))) is not None) == (speed < 0.0)
