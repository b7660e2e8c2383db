"""A way back that comes too early for the tracking error that may have grown is refused by the guard itself."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from shapely import affinity
from shapely.geometry import box

from stucksolver.guard import NOBODY, Guard, RejectCode
from stucksolver.guard.context import CheckContext
from stucksolver.guard.early_return import early_return
from stucksolver.plan import return_to_lane
from stucksolver.plan.behaviors import BorrowOncomingLane, borrow_oncoming_lane
from stucksolver.scene import ObjectKind
from test_guard_proofs import MANY
from worlds import World, straight_road, thing

GUARD = Guard()
ROAD = straight_road()
DRIFT_MPS, MOST_M = 0.25, 0.9
"""How a fault draws the body aside: A7 of docs/SAFETY.md."""
SOON_M = 0.25
"""A planner that returns as soon as the tail is so far from what is passed."""
PASSED = {ObjectKind.CAR: (4.6, 1.9), ObjectKind.BARRIER: (0.6, 1.8), ObjectKind.CONE: (0.4, 0.4)}


def judged(world, speed_mps):
    plan = BorrowOncomingLane(past_object_id="lead", speed_mps=speed_mps)
    return GUARD.accept([plan], world.view(), True)


def lead(kind, x, y):
    length, width = PASSED[kind]
    return thing("lead", x, y, kind=kind, length=length, width=width, hazard=True, stationary_s=60.0)


def body(x, y, yaw, length, width):
    flat = box(-length / 2, -width / 2, length / 2, width / 2)
    return affinity.translate(affinity.rotate(flat, yaw, origin=(0, 0), use_radians=True), x, y)


@pytest.mark.integration
@given(
    kind=st.sampled_from(list(PASSED)),
    x=st.floats(60.0, 75.0),
    y=st.floats(-1.0, 0.5),
    speed=st.floats(1.5, 9.0),
    clear_m=st.floats(0.2, 1.5),
    drifts_after=st.floats(0.0, 1.0),
)
@settings(max_examples=4 * MANY, deadline=None, suppress_health_check=list(HealthCheck))
def test_early_return_drift_after_commit_point_touches_nothing(kind, x, y, speed, clear_m, drifts_after):
    """An accepted return touches nothing even if the ego drifts aside after the commit point."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(return_to_lane, "CLEAR_M", clear_m)
        world = World(ROAD, [lead(kind, x, y)])
        _, proven = judged(world, speed)
    assume(proven is not None and proven.no_stop.any())  # before a commit point, a tracking error ends in a stop
    view, path = world.view(), proven.path
    t = CheckContext(view, path, GUARD.policy).slow.t
    commit, returns = int(proven.no_stop.argmax()), int(path.d.argmax())
    begins_s = t[commit] + drifts_after * (t[returns] - t[commit])
    aside = np.minimum(DRIFT_MPS * np.maximum(t - begins_s, 0.0), MOST_M)
    there = body(x, y, 0.0, *PASSED[kind])
    yaw, ego = path.heading(), world.ego()
    for k in range(returns, len(path.s), 2):
        here = body(path.s[k], path.d[k] - aside[k], yaw[k], ego.length_m, ego.width_m)
        assert not here.intersects(there), (path.s[k], aside[k])


@pytest.mark.parametrize("kind", list(PASSED))
@pytest.mark.parametrize("speed", [3.0, 5.5])
def test_early_return_too_soon_is_rejected(kind, speed, monkeypatch):
    """A return that comes too early is rejected, and a later one is accepted."""
    world = World(ROAD, [lead(kind, 70.0, 0.0)])
    assert judged(world, speed)[0].accepted
    monkeypatch.setattr(return_to_lane, "CLEAR_M", SOON_M)
    monkeypatch.setattr(borrow_oncoming_lane, "lack_toward_objects", lambda *_: 0.0)  # no second path
    rejects = judged(world, speed)[0].rejects
    assert [(r.code, r.object_id) for r in rejects] == [(RejectCode.GAP, "lead")]
    assert rejects[0].gap_m < MOST_M + 0.1


def test_early_return_narrow_pass_may_keep_its_gap():
    """A narrow pass may return with the gap that it had alongside."""
    world = World(ROAD, [thing("lead", 90.0, 1.4, width=2.2, hazard=True, stationary_s=60.0)])
    plan, view = BorrowOncomingLane(past_object_id="lead", speed_mps=2.0), world.view()
    proven = GUARD.lay_out([plan], view, True, NOBODY)
    abreast_m = float(proven.path.d.max()) - world.ego().width_m / 2 - (1.4 + 2.2 / 2)
    assert abreast_m < MOST_M
    assert early_return(CheckContext(view, proven.path, GUARD.policy), proven.no_stop) == []
