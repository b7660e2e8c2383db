"""A leader is followed only if the ego really stays behind it; one that the path swings round must keep its gap."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import event, given, settings
from hypothesis import strategies as st

from stucksolver.guard import Guard
from stucksolver.guard.path_tracking import tracked_path
from stucksolver.plan.behaviors import ChangeLane, FollowVehicle, KeepLane, Nudge, RejoinRoute
from stucksolver.plan.speed_profile import rollout, slow_launch
from stucksolver.scene import LineKind, ObjectKind
from stucksolver.scene.boxes import separation
from worlds import LANE_M, World, straight_road, thing

GUARD = Guard()
MULTI = straight_road(left=LineKind.BROKEN, oncoming=None)
BRAKING_MPS2 = 3.5
"""How others may brake (A2)."""


def driven(view, proven):
    """The ego's body over time, quick and sluggish, every tenth of a second: s, d and yaw."""
    path, limits = tracked_path(proven.path, view, GUARD.policy.tracking), view.ego.limits
    quick = rollout(path, view.ego.speed_mps, limits.comfort_acceleration_mps2, limits.comfort_braking_mps2)
    for run in (quick, slow_launch(path, view.ego.speed_mps, limits)):
        t = np.arange(0.0, run.duration_s, 0.1)
        s = np.interp(t, run.t, path.s)
        yield t, s, np.interp(s, path.s, path.d), np.interp(s, path.s, path.yaw)


def nearest_m(world, proven):
    """The least gap to the leader, if it drives on steadily or brakes at once."""
    view, lead = world.view(), world.objects[0]
    gaps = []
    for t, s, d, yaw in driven(view, proven):
        until = np.minimum(t, lead.vx_mps / BRAKING_MPS2)
        for way in (lead.vx_mps * t, lead.vx_mps * until - BRAKING_MPS2 * until**2 / 2):
            there = (lead.x_m + way, lead.y_m, 0.0)
            gap = separation((s, d, yaw), (4.9 / 2, 1.85 / 2), there, (lead.length_m / 2, lead.width_m / 2))
            gaps.append(float(gap.min()))
    return min(gaps)


def in_path_at_end(run, lead):
    """True if the ego's body, turned as it is at the end of its path, is in the leader's path (A6)."""
    _, _, d, yaw = run
    reach_m = 1.85 / 2 * np.cos(yaw[-1]) + 4.9 / 2 * abs(np.sin(yaw[-1]))
    return abs(d[-1] - lead.y_m) < reach_m + lead.width_m / 2


ASIDE = st.one_of(
    st.builds(ChangeLane, side=st.just("left"), distance_m=st.floats(20.0, 60.0), speed_mps=st.floats(1.0, 5.5)),
    st.builds(
        Nudge,
        side=st.sampled_from(["left", "right"]),
        offset_m=st.floats(0.3, 1.5),
        distance_m=st.floats(5.0, 40.0),
        speed_mps=st.floats(0.6, 5.5),
    ),
    st.builds(RejoinRoute, speed_mps=st.floats(1.0, 5.5)),
)


@pytest.mark.integration
@given(
    plan=ASIDE,
    gap_m=st.floats(0.5, 25.0),
    lead_mps=st.floats(0.55, 6.0),
    ego_mps=st.just(0.0) | st.floats(0.0, 5.5),
    y=st.floats(-1.6, 1.6),
    kind=st.sampled_from([ObjectKind.CAR, ObjectKind.BICYCLE, ObjectKind.TRUCK]),
    left=st.booleans(),
)
@settings(max_examples=120)
def test_plan_that_swings_round_a_leader_does_not_clip_it(plan, gap_m, lead_mps, ego_mps, y, kind, left):
    lane_d = LANE_M if left else 0.0
    lead = thing("lead", 0.0, lane_d + y, kind=kind, speed=lead_mps)
    lead = lead.model_copy(update={"x_m": 50.0 + 4.9 / 2 + gap_m + lead.length_m / 2})
    world = World(MULTI, [lead], speed=ego_mps, y=LANE_M if isinstance(plan, RejoinRoute) or left else 0.0)
    _, proven = GUARD.accept([plan], world.view(), False)
    if proven is None:
        return
    stays = all(in_path_at_end(run, lead) for run in driven(world.view(), proven))
    event(f"stays behind: {stays}")
    assert stays or nearest_m(world, proven) > 0.0


@pytest.mark.parametrize("lead_mps", [0.8, 1.2, 2.0, 3.0])
@pytest.mark.parametrize("ego_mps", [3.0, 4.0, 5.0])
def test_lane_change_round_a_slow_leader_just_ahead_is_refused(lead_mps, ego_mps):
    """Just far enough to fall back behind it: the corner clips it, if the path is driven as it was laid out."""
    gap_m = (ego_mps**2 - lead_mps**2) / 6.0 + 0.3 * (ego_mps - lead_mps) + 0.1
    lead = thing("lead", 50.0 + 4.9 / 2 + gap_m + 2.3, speed=lead_mps)
    world = World(MULTI, [lead], speed=ego_mps)
    verdict, proven = GUARD.accept([ChangeLane(side="left", distance_m=40.0, speed_mps=5.5)], world.view(), False)
    assert proven is None or nearest_m(world, proven) > 0.3, verdict


@pytest.mark.parametrize("gap_m", [6.0, 15.0, 30.0])
@pytest.mark.parametrize("lead_mps", [0.8, 2.0, 4.0])
@pytest.mark.parametrize(
    "plan", [KeepLane(distance_m=60.0, speed_mps=5.5), FollowVehicle(leader_id="lead", distance_m=60.0, speed_mps=5.5)]
)
def test_leader_that_the_path_stays_behind_is_followed(gap_m, lead_mps, plan):
    lead = thing("lead", 50.0 + 4.9 / 2 + gap_m + 2.3, speed=lead_mps)
    assert GUARD.accept([plan], World(MULTI, [lead]).view(), False)[0].accepted


@pytest.mark.parametrize("lead_mps", [1.0, 2.0, 4.0])
def test_lane_change_with_room_before_a_slow_leader_is_accepted(lead_mps):
    lead = thing("lead", 50.0 + 4.9 / 2 + 16.0 + 2.3, speed=lead_mps)
    plan = ChangeLane(side="left", distance_m=40.0, speed_mps=5.0)
    assert GUARD.accept([plan], World(MULTI, [lead]).view(), False)[0].accepted


@pytest.mark.parametrize("aside_m", [0.05, 0.15, 0.25])
def test_cyclist_too_near_to_path_is_not_followed(aside_m):
    """A cyclist that the path would pass too near does not count as followed.

    The stack has no reason to stay behind a cyclist beside the body's path.
    """
    rider = thing("rider", 62.0, -(1.85 / 2 + 0.3 + aside_m), kind=ObjectKind.BICYCLE, speed=1.5)
    assert not GUARD.accept([KeepLane(distance_m=60.0, speed_mps=5.5)], World(MULTI, [rider]).view(), False)[0].accepted
