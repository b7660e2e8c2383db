"""What Lemma 2 asks for at a lane's limit is required of the sight, however high the limit is."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from stucksolver.guard import Guard, RejectCode
from stucksolver.plan.behaviors import ChangeLane, RejoinRoute
from stucksolver.plan.speed_profile import rollout, slow_launch
from stucksolver.scene import LineKind, ObjectKind
from test_guard_turning import TURN, WIDE
from worlds import LANE_M, World, straight_road, thing

GUARD = Guard()
KMH = 1 / 3.6
MULTI = straight_road(left=LineKind.BROKEN, oncoming=None)
REACTION_S, BRAKING_MPS2 = 1.0, 4.5
"""rho, and the hardest braking that a running plan may require of others (Lemma 2)."""


def limited(road, limit_mps):
    lanes = tuple(lane.model_copy(update={"speed_limit_mps": limit_mps}) for lane in road.lanes)
    return road.model_copy(update={"lanes": lanes, "key": f"{road.key} far {limit_mps}"})


def lemma2_m(limit_mps):
    """What unseen traffic at the limit needs to stop."""
    return limit_mps * REACTION_S + limit_mps**2 / (2 * BRAKING_MPS2)


def turns(limit_mps, behind_m, ahead_m=400.0, objects=()):
    world = World(limited(WIDE, limit_mps), list(objects), x=200.0, behind_m=behind_m, sight_m=ahead_m)
    return set(GUARD.accept_turn(TURN, world.view())[0].codes)


@pytest.mark.integration
@given(limit_mps=st.floats(20 * KMH, 130 * KMH), share=st.floats(0.5, 0.99))
def test_turn_around_sight_below_stop_at_limit_is_rejected(limit_mps, share):
    """A turn with less sight than a stop at the speed limit takes is rejected."""
    seen_m = share * lemma2_m(limit_mps)
    assert turns(limit_mps, behind_m=seen_m) == {RejectCode.PATH_NOT_VISIBLE}
    assert turns(limit_mps, behind_m=400.0, ahead_m=seen_m) == {RejectCode.PATH_NOT_VISIBLE}


@pytest.mark.parametrize(("limit_kmh", "behind_m"), [(30, 24.0), (50, 50.0), (70, 75.0), (100, 129.0), (130, 199.0)])
def test_turn_around_sight_of_stop_at_limit_is_accepted(limit_kmh, behind_m):
    """A turn with the sight that a stop at the speed limit takes is accepted.

    The sight starts at the middle of the ego; the turn sweeps some meters behind it.
    """
    assert turns(limit_kmh * KMH, behind_m=behind_m) == set()


def test_turn_around_62_m_sight_at_100_kmh_is_rejected():
    assert turns(100 * KMH, behind_m=62.0) == {RejectCode.PATH_NOT_VISIBLE}


def test_turn_where_a_barrier_ends_the_sight_is_accepted():
    barrier = thing("works", 140.0, kind=ObjectKind.BARRIER, width=4.5, length=0.5)
    assert turns(100 * KMH, behind_m=60.0, objects=[barrier]) == set()


ENTRIES = st.one_of(
    st.builds(ChangeLane, side=st.just("left"), distance_m=st.floats(20.0, 60.0), speed_mps=st.floats(1.0, 11.0)),
    st.builds(RejoinRoute, speed_mps=st.floats(1.0, 11.0)),
)


CHANGE = ChangeLane(side="left", distance_m=40.0, speed_mps=5.0)


@pytest.mark.integration
@given(
    plan=ENTRIES,
    limit_mps=st.floats(40 * KMH, 130 * KMH),
    behind_m=st.floats(40.0, 190.0),
    speed=st.just(0.0) | st.floats(0.0, 5.5),
)
@example(plan=CHANGE, limit_mps=30.0, behind_m=60.0, speed=0.0)
@example(plan=CHANGE, limit_mps=36.0, behind_m=150.0, speed=0.0)
@example(plan=RejoinRoute(speed_mps=11.0), limit_mps=20.0, behind_m=60.0, speed=5.5)
def test_entry_traffic_visible_too_late_for_abort_can_brake(plan, limit_mps, behind_m, speed):
    """Traffic that becomes visible too late for an abort can brake.

    Phantom traffic is at the end of the sight, at the limit, at the last time at which the entry can be aborted.
    """
    world = World(
        limited(MULTI, limit_mps),
        x=200.0,
        y=LANE_M if isinstance(plan, RejoinRoute) else 0.0,
        speed=speed,
        behind_m=behind_m,
    )
    view = world.view()
    verdict, proven = GUARD.accept([plan], view, True)
    if proven is None:
        return
    path, limits = proven.path, view.ego.limits
    inside = np.abs(path.d - world.y) > LANE_M / 2 - 1.85 / 2 + 0.05
    k = int(inside.argmax())
    quick = rollout(path, speed, limits.comfort_acceleration_mps2, limits.comfort_braking_mps2)
    late = slow_launch(path, speed, limits)
    warned_s = min(float(late.t[k]), float(quick.v[k]) / (2 * limits.comfort_braking_mps2))
    there = 200.0 - behind_m + limit_mps * warned_s
    # The ego goes on from its entry, and others brake down to its speed.
    since = np.linspace(0.0, 12.0, 121)
    own = np.interp(late.t[k] + since, late.t, path.s) - 4.9 / 2
    braking = np.clip(since - REACTION_S, 0.0, limit_mps / BRAKING_MPS2)
    theirs = there + limit_mps * np.minimum(since, REACTION_S) + limit_mps * braking - BRAKING_MPS2 * braking**2 / 2
    short = late.t[k] + since < late.t[-1]
    assert (own - theirs)[short].min() > 0.0, verdict


@pytest.mark.parametrize("speed", [0.0, 5.0])
@pytest.mark.parametrize("limit_kmh", [30, 40, 50])
def test_lane_change_up_to_50_kmh_needs_60_m_behind(limit_kmh, speed):
    """A lane change in towns needs no more than 60 m of sight behind.

    The road behind that stacks report is enough up to 50 km/h.
    """
    world = World(limited(MULTI, limit_kmh * KMH), x=200.0, speed=speed, behind_m=56.0)
    assert GUARD.accept([CHANGE], world.view(), False)[0].accepted


def test_lane_change_vehicle_at_end_of_sight_is_enough():
    """A lane change needs no more sight where a known vehicle ends it."""
    lorry = thing("lorry", 160.0, LANE_M, speed=1.0, height=3.0)
    world = World(limited(MULTI, 100 * KMH), [lorry], x=200.0, behind_m=37.0)
    assert GUARD.accept([CHANGE], world.view(), False)[0].accepted
