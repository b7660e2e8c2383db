"""Orders expire: when the solver falls silent, the stack performs what was proven to be safe without it."""

from __future__ import annotations

import pytest

from stucksolver.guard import Guard
from stucksolver.plan import CONTINUE, Continue, Execute, Lease, PathPoint, RecoveryPlan, SafeStop
from stucksolver.plan.behaviors import BorrowOncomingLane, KeepLane, Wait
from stucksolver.plan.directive import EXPIRES_TICKS, directive_adapter
from stucksolver.solver.state_machine.execution import Execution
from stucksolver.solver.state_machine.execution_steps import ExecutionOutcome
from worlds import LANE_M, World, straight_road, thing

GUARD = Guard()
ON = KeepLane(distance_m=60.0, speed_mps=5.0)


def silent_drive(world, behaviors, silent_from_s, then=None, seconds=30.0):
    """The solver is heard until a time; the stack goes on ticking. Returns what it performed and the least gap."""
    execution, lease = Execution(RecoveryPlan(behaviors=tuple(behaviors)), GUARD, False), Lease()
    assert execution.start(world.view(), 0.0).accepted
    performed, nearest = [], []
    while world.time_s < seconds:
        if world.time_s < silent_from_s:
            told = execution.tick(world.view(), world.time_s)
            lease.renew(CONTINUE if isinstance(told, ExecutionOutcome) else told)
        elif then is not None:
            world.objects.append(then)
            then = None
        done = bool(performed) and isinstance(performed[-1], Execute) and at_end(performed[-1], world)
        order = lease.tick(world.x, world.y, path_is_done=done, at_rest=abs(world.speed) < 0.1)
        performed.append(order)
        if isinstance(order, Continue) and world.time_s > silent_from_s:
            break  # the stack drives itself again, which is another test
        world.drive(order)
        nearest.append(world.clearance())
    return performed, min(nearest)


def at_end(order, world):
    return bool(order.path) and world.x >= order.path[-1].x_m - 1.0


def test_before_the_commit_point_silence_means_stop():
    world = World(straight_road(), [])
    performed, _ = silent_drive(world, [ON], 3.0)
    assert world.speed < 0.1 and isinstance(performed[-1], Continue)
    assert performed[-2].behavior.name == "wait"


@pytest.mark.parametrize("silent_from_s", [0.5, 1.0, 1.5, 2.0])
def test_lease_silent_solver_avoids_new_oncoming_car(silent_from_s):
    """Without a solver, the ego does not drive into a new oncoming car."""
    world = World(straight_road(), [thing("lead", 75.0)])
    performed, nearest = silent_drive(
        world,
        [BorrowOncomingLane(past_object_id="lead", speed_mps=5.0)],
        silent_from_s,
        thing("oncoming", 125.0, LANE_M, speed=-4.0),
    )
    assert nearest > 0.3 or performed[-2].path, "committed already: what was proven is finished"


def test_after_the_commit_point_it_is_finished():
    world = World(straight_road(), [thing("lead", 72.0)])
    performed, nearest = silent_drive(world, [BorrowOncomingLane(past_object_id="lead", speed_mps=5.0)], 5.0)
    order = performed[0]
    assert not order.path[0].no_stop and any(point.no_stop for point in order.path)
    assert all(item is order for item in performed[:-1])
    assert abs(world.y) < 0.3 and nearest > 0.25 and isinstance(performed[-1], Continue)


PATH = (PathPoint(x_m=50.0, y_m=0.0, speed_mps=5.0), PathPoint(x_m=90.0, y_m=0.0, speed_mps=5.0))


def test_lease_renewed_stays_valid_and_unrenewed_expires():
    """A renewed directive never expires; without renewal, it does after its ticks."""
    lease, order = Lease(), Execute(behavior=ON, path=PATH)
    there = {"x_m": 50.0, "y_m": 0.0, "path_is_done": False, "at_rest": False}
    for _ in range(5 * EXPIRES_TICKS):
        lease.renew(order)
        assert lease.tick(**there) is order
    for _ in range(EXPIRES_TICKS - 1):
        assert lease.tick(**there) is order
    assert lease.tick(**there).behavior == Wait(duration_s=1.0)
    assert lease.expired


def test_lease_wait_directive_is_its_own_fallback():
    """A directive to stop is its own fallback and keeps its braking."""
    lease, order = Lease(), Execute(behavior=Wait(duration_s=5.0), brake_mps2=6.0)
    lease.renew(order)
    for _ in range(3 * EXPIRES_TICKS):
        assert lease.tick(0.0, 0.0, path_is_done=False, at_rest=False) is order
    assert isinstance(lease.tick(0.0, 0.0, path_is_done=False, at_rest=True), Continue)


def test_lease_expire_applies_fallback_at_once():
    """The fallback is due at once if no renewal can come."""
    lease = Lease()
    lease.renew(Execute(behavior=ON, path=PATH))
    lease.expire()
    assert lease.tick(50.0, 0.0, path_is_done=False, at_rest=False).behavior.name == "wait"


def test_lease_committed_path_blocked_in_silence_is_aborted():
    """A path that is finished without a solver and blocked is aborted."""
    lease = Lease()
    order = Execute(behavior=ON, path=tuple(point.model_copy(update={"no_stop": True}) for point in PATH))
    lease.renew(order)
    performed = [lease.tick(60.0, 0.0, path_is_done=False, at_rest=True) for _ in range(400)]
    assert performed[EXPIRES_TICKS + 150] is order, "who stands for a moment goes on"
    assert isinstance(performed[-1], Continue)


def test_what_is_said_anew_counts_anew():
    lease, order = Lease(), Execute(behavior=ON, path=PATH)
    lease.renew(order)
    for _ in range(2 * EXPIRES_TICKS):
        lease.tick(50.0, 0.0, path_is_done=False, at_rest=False)
    assert lease.expired
    lease.renew(order)
    assert not lease.expired
    assert lease.tick(50.0, 0.0, path_is_done=False, at_rest=False) is order


def test_left_m_starts_at_nearest_path_point():
    """The remaining length of a path starts at the nearest point."""
    order = Execute(behavior=ON, path=(*PATH, PathPoint(x_m=90.0, y_m=30.0, speed_mps=5.0)))
    assert [order.left_m(x, 1.0) for x in (0.0, 60.0, 85.0)] == [70.0, 70.0, 30.0]
    assert order.left_m(91.0, 29.0) == 0.0
    assert Execute(behavior=ON).left_m(0.0, 0.0) == 0.0


def test_a_safe_stop_is_held_in_silence():
    lease = Lease()
    lease.renew(SafeStop(reason="blocked"))
    assert all(isinstance(lease.tick(0.0, 0.0, path_is_done=True, at_rest=True), SafeStop) for _ in range(1000))


def test_the_json_form_has_the_lease():
    order = Execute(behavior=ON, expires_ticks=4, path=(PathPoint(x_m=1.0, y_m=2.0, speed_mps=3.0, no_stop=True),))
    assert directive_adapter.validate_json(order.model_dump_json()) == order
