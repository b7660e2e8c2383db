"""Across a stream that never ends: proposed once the wait has outlived its reason, begun in a proven gap only."""

from __future__ import annotations

import math

import pytest

from stucksolver.guard import Guard
from stucksolver.ladder import profile
from stucksolver.plan import WaitLimits, WaitReason
from stucksolver.reasoners import ReasonerRequest, RuleReasoner
from stucksolver.scene import CandidateWaypoint, ControlKind, FailedAttempt, RejectCode, TrafficControl
from test_rules import TWO_WAY
from worlds import World, red_light, thing

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
    return RuleReasoner(limits).decide(ReasonerRequest(scene)).decision


def plan(decision):
    return [] if decision.plan is None else [(b.name, b.speed_mps) for b in decision.plan.behaviors]


def test_flow_wait_is_legitimate_up_to_ladder_limit():
    """The wait for a gap is legitimate for as long as the ladder permits."""
    assert profile("default").waits.limits().yield_s == 120.0
    early = decide(crossing(), stopped_s=119.0)
    assert (plan(early), early.analysis.wait) == ([], WaitReason.YIELD)
    assert plan(decide(crossing())) == [("keep_lane", 5.5)]
    assert plan(decide(crossing(), stopped_s=20.0, limits=WaitLimits(yield_s=10.0))) == [("keep_lane", 5.5)]


def test_who_is_just_crossing_stands_nowhere():
    found = decide(crossing(away_m=1.0))
    assert plan(found) == [("keep_lane", 5.5)]
    assert plan(decide(crossing(away_m=1.0), stopped_s=60.0)) == []


def test_nobody_is_led_into_the_lane_of_a_stream():
    found = decide(crossing(), route=RIGHT)
    assert (plan(found), found.analysis.wait) == ([], WaitReason.YIELD)


def test_never_past_a_red_light():
    assert plan(decide(crossing(), controls=(red_light(3.0),), stopped_s=150.0)) == []


def test_over_the_line_of_a_stop_sign_it_creeps_first():
    sign = TrafficControl(kind=ControlKind.STOP_SIGN, distance_m=3.0, applies=True)
    assert plan(decide(crossing(), controls=(sign,))) == [("keep_lane", 2.2), ("keep_lane", 5.5)]


@pytest.mark.parametrize(("ago_s", "again"), [(5.0, False), (20.0, True)])
def test_flow_failed_attempt_delays_next_attempt(ago_s, again):
    """After a failed attempt to find a gap, the next attempt comes only later."""
    attempt = FailedAttempt(time_s=-ago_s, behaviors=("keep_lane",), codes=(RejectCode.COLLISION,), outcome="")
    assert bool(plan(decide(crossing(), attempts=(attempt,)))) is again


@pytest.mark.parametrize(("away_m", "accepted"), [(40.0, True), (60.0, False), (80.0, False), (180.0, True)])
def test_flow_entry_behind_or_well_before_vehicle_is_accepted(away_m, accepted):
    """The guard accepts a start behind a vehicle that has crossed, or well before one."""
    proposed = decide(crossing())
    world = World(TWO_WAY, [crossing(away_m)])
    verdict, _ = Guard().accept(list(proposed.plan.behaviors), world.view(), False)
    assert verdict.accepted is accepted, str(verdict)
