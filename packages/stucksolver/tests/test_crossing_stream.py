"""Across a stream that never ends: proposed once the wait has outlived its reason, begun in a proven gap only."""

from __future__ import annotations

import math

from stucksolver.ladder import profile
from stucksolver.plan import WaitLimits, WaitReason
from stucksolver.scene import CandidateWaypoint
from test_duties import TWO_WAY
from worlds import World, red_light, searched, thing

AHEAD = [(20.0, 0.0, 20.0), (40.0, 0.0, 40.0)]
RIGHT = [(12.0, 0.0, 12.0), (18.0, -6.0, 20.0), (20.0, -26.0, 40.0)]


def crossing(away_m=60.0, speed=14.0):
    return thing("flow", 70.0, away_m, sideways=-speed, yaw=-math.pi / 2)


def decide(*others, stopped_s=121.0, route=AHEAD, limits=None, controls=(), **more):
    world = World(TWO_WAY, list(others), controls=controls)
    scene = world.scene()
    lane = scene.ego.lane_id
    waypoints = tuple(
        CandidateWaypoint(id=str(k), lane_id=lane, x_m=x, y_m=y, distance_m=s) for k, (x, y, s) in enumerate(route)
    )
    ego = scene.ego.model_copy(update={"stopped_for_s": stopped_s})
    scene = scene.model_copy(update={"waypoints": waypoints, "ego": ego, **more})
    return searched(world, scene, limits)


def plan(decision):
    return [] if decision.plan is None else [(b.name, b.speed_mps) for b in decision.plan.behaviors]


def test_flow_wait_is_legitimate_up_to_ladder_limit():
    """The wait for a gap is legitimate for as long as the ladder permits."""
    assert profile("default").waits.limits().yield_s == 120.0
    early = decide(crossing(), stopped_s=119.0)
    assert (plan(early), early.analysis.wait) == ([], WaitReason.YIELD)
    for late in (decide(crossing()), decide(crossing(), stopped_s=20.0, limits=WaitLimits(yield_s=10.0))):
        assert [name for name, _ in plan(late)] == ["keep_lane"]


def test_vehicle_that_is_crossing_is_let_by():
    assert plan(decide(crossing(away_m=1.0))) == []


def test_never_past_a_red_light():
    assert plan(decide(crossing(), controls=(red_light(3.0),), stopped_s=150.0)) == []
