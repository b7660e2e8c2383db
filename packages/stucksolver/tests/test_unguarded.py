"""The experiment without a guard: what is proposed is driven, however bad."""

from __future__ import annotations

import pytest

from worlds import LANE_M, World, straight_road, thing

pytest.importorskip("carla")

from stucksolver.guard import Guard, RejectCode
from stucksolver.plan.behaviors import BorrowOncomingLane, ChangeLane
from stucksolver_eval.systems.factory import SystemSpecError, check_arm
from stucksolver_eval.systems.spec import SystemSpec
from stucksolver_eval.systems.unguarded import PermissiveGuard

BORROW = BorrowOncomingLane(past_object_id="lead", speed_mps=5.0)


def test_what_the_guard_refuses_and_aborts_is_driven():
    world = World(straight_road(), [thing("lead", 72.0), thing("oncoming", 110.0, LANE_M, speed=-10.0)])
    assert not Guard().accept([BORROW], world.view(), False)[0].accepted
    verdict, proven = PermissiveGuard().accept([BORROW], world.view(), False)
    assert verdict.accepted and proven is not None
    assert not Guard().recheck(proven, world.view()).accepted
    assert PermissiveGuard().recheck(proven, world.view()).accepted


def test_what_has_no_path_is_refused_still():
    change = ChangeLane(side="right", distance_m=30.0, speed_mps=5.0)
    verdict, proven = PermissiveGuard().accept([change], World(straight_road(), []).view(), False)
    assert proven is None and [r.code for r in verdict.rejects] == [RejectCode.NO_PATH]


@pytest.mark.parametrize("recovery", ["none", "timers"])
def test_only_a_recovery_with_a_guard_can_be_without_it(recovery):
    check_arm(SystemSpec(recovery="search", guarded=False))
    with pytest.raises(SystemSpecError, match="--unguarded"):
        check_arm(SystemSpec(recovery=recovery, guarded=False))
