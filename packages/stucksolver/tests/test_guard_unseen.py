"""Who comes out of what is not seen, by an oracle of its own: they appear at the worst moment, and meet nobody."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, event, given, settings
from hypothesis import strategies as st
from shapely.geometry import box

from stucksolver.guard import Guard, RejectCode
from stucksolver.plan.behaviors import AbortAction, BorrowOncomingLane
from worlds import LANE_M, World, straight_road, thing

GUARD = Guard()
DT = 0.1
LENGTH_M, WIDTH_M = 4.9, 1.85
CAR_M = 4.6
SLUGGISH_MPS2, SLUGGISH_SHARE = 0.9, 0.85
"""How slowly a vehicle with a comfortable 1.5 m/s² may drive a plan: docs/SAFETY.md."""


def limited(limit_mps):
    road = straight_road()
    lanes = tuple(lane.model_copy(update={"speed_limit_mps": limit_mps}) for lane in road.lanes)
    return road.model_copy(update={"lanes": lanes, "key": f"limit-{limit_mps}"})


def seen_at(edge_m, appears_s, speed_mps, t):
    """The car that comes out of what is hidden beyond `edge_m`, None before; its front is at the edge when it does."""
    if t < appears_s - 1e-9:
        return None
    return thing("comes", edge_m + CAR_M / 2 - speed_mps * (t - appears_s), LANE_M, speed=-speed_mps)


def drives(world, behavior, edge_m, appears_s, comes_mps, keen, guard=GUARD):
    """Drives an accepted plan among the lead and the car that appears; the least gap, and whether it was begun.

    The ego follows the path to the point; until the commit point a verdict against the plan stops it.
    """
    lead = world.objects[0]
    world.sight_m = edge_m - world.x
    _, proven = guard.accept([behavior], world.view(), False)
    if proven is None:
        return None
    limits = world.ego().limits
    acceleration = SLUGGISH_MPS2 + keen * (limits.comfort_acceleration_mps2 - SLUGGISH_MPS2)
    share = SLUGGISH_SHARE + keen * (1.0 - SLUGGISH_SHARE)
    least, stopping, t = np.inf, False, 0.0
    while world.x < proven.path.end_s - 0.5 and t < 60.0:
        other = seen_at(edge_m, appears_s, comes_mps, t)
        world.objects = [lead] if other is None else [lead, other]
        world.sight_m = edge_m - world.x
        committed = proven.committed(world.x)
        verdict = guard.recheck(proven, world.view())
        stopping = stopping or (not committed and verdict.abort is AbortAction.STOP)
        if other is not None:
            body = box(world.x - LENGTH_M / 2, world.y - WIDTH_M / 2, world.x + LENGTH_M / 2, world.y + WIDTH_M / 2)
            half = CAR_M / 2
            least = min(least, body.distance(box(other.x_m - half, LANE_M - 0.95, other.x_m + half, LANE_M + 0.95)))
        if stopping:
            world.speed = max(world.speed - limits.comfort_braking_mps2 * DT, 0.0)
            if world.speed <= 0.0:
                return least
        else:
            bound = share * float(np.interp(world.x, proven.path.s, proven.path.speed))
            world.speed = max(min(world.speed + acceleration * DT, bound), 0.3)
        world.x += world.speed * DT
        world.y = float(np.interp(world.x, proven.path.s, proven.path.d))
        ahead = float(np.interp(world.x + 0.5, proven.path.s, proven.path.d))
        world.yaw = float(np.arctan2(ahead - world.y, 0.5))
        t += DT
    return least


@pytest.mark.integration
@settings(max_examples=15, deadline=None, suppress_health_check=list(HealthCheck))
@given(
    more_m=st.floats(1.0, 25.0),
    lead_m=st.floats(61.0, 75.0),
    limit=st.sampled_from([8.3, 13.9, 19.4]),
    appears_s=st.floats(0.0, 14.0),
    speed=st.floats(3.0, 5.5),
    keen=st.floats(0.2, 1.0),
)
def test_lane_borrow_phantom_vehicle_at_limit_has_no_contact(more_m, lead_m, limit, appears_s, speed, keen):
    """A vehicle that appears from the occluded area at the speed limit at any time is not touched.

    The sight is barely more than required, and the time is the worst one.
    """
    behavior = BorrowOncomingLane(past_object_id="lead", speed_mps=speed)
    lead = thing("lead", lead_m)
    verdict, _ = GUARD.accept([behavior], World(limited(limit), [lead], sight_m=5.0).view(), False)
    (short,) = (r for r in verdict.rejects if r.code is RejectCode.ONCOMING_SIGHT)
    edge_m = 50.0 + short.needed_m + 0.01 + more_m
    world = World(limited(limit), [lead])
    least = drives(world, behavior, edge_m, appears_s, limit, keen)
    assume(least is not None)
    event(f"passed: {world.x > lead_m}, met on the way: {least < 50.0}")
    assert least > 0.3


@pytest.mark.release
@pytest.mark.slow
def test_oracle_detects_guard_with_too_little_required_sight():
    """The oracle detects a guard that requires too little sight.

    With half of the required sight, the car that appears right after the commit point is hit.
    """
    policy = GUARD.policy.model_copy(
        update={"oncoming": GUARD.policy.oncoming.model_copy(update={"unknown_limit_mps": 1.0, "sight_margin_m": 0.0})}
    )
    lax, found = Guard(policy), []
    road = limited(None)
    for appears_s in np.arange(0.0, 12.0, 0.5):
        world = World(road, [thing("lead", 65.0)], sight_m=5.0)
        behavior = BorrowOncomingLane(past_object_id="lead", speed_mps=5.0)
        verdict, _ = lax.accept([behavior], world.view(), False)
        needed_m = next(r.needed_m for r in verdict.rejects if r.code is RejectCode.ONCOMING_SIGHT)
        found.append(drives(world, behavior, 52.0 + needed_m, float(appears_s), 13.9, 0.3, lax))
    assert min(gap for gap in found if gap is not None) <= 0.0


def test_who_comes_before_the_commit_point_costs_no_sight():
    """The way to the border of the lane costs own meters, not seconds in which somebody may come."""
    needed = {}
    for lead_m in (62.0, 72.0):
        world = World(limited(13.9), [thing("lead", lead_m)], sight_m=5.0)
        behavior = BorrowOncomingLane(past_object_id="lead", speed_mps=5.0)
        rejects = GUARD.accept([behavior], world.view(), False)[0].rejects
        needed[lead_m] = next(r for r in rejects if r.code is RejectCode.ONCOMING_SIGHT)
    for reject in needed.values():
        assert reject.needed_m - reject.seen_m == pytest.approx(-reject.gap_m)
    view = World(limited(13.9), [thing("lead", 72.0)]).view()
    _, proven = GUARD.accept([BorrowOncomingLane(past_object_id="lead", speed_mps=5.0)], view, False)
    assert proven is not None and proven.commit_s(view.ego_s) > view.ego_s
    assert needed[72.0].time_s < proven.expected_s


def test_oncoming_sight_body_already_in_lane_counts_all_time():
    """If the body is in the oncoming lane already, the whole time there counts."""
    lead = thing("lead", 65.0)
    behavior = BorrowOncomingLane(past_object_id="lead", speed_mps=5.0)
    world = World(limited(13.9), [lead], y=1.6, sight_m=5.0)
    verdict, _ = GUARD.accept([behavior], world.view(), False)
    inside = next(r for r in verdict.rejects if r.code is RejectCode.ONCOMING_SIGHT)
    out, _ = GUARD.accept([behavior], replace(world, y=0.0).view(), False)
    outside = next(r for r in out.rejects if r.code is RejectCode.ONCOMING_SIGHT)
    assert inside.time_s > outside.time_s
