"""Before a pass through the oncoming lane, by sensors: the plan stands until who hides the lane has gone by."""

from __future__ import annotations

import pytest

from stucksolver.guard import Guard, RejectCode
from stucksolver.plan import Execute, RecoveryPlan
from stucksolver.plan.behaviors import BackUp, BorrowOncomingLane
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.solver.state_machine.execution import Execution
from stucksolver.solver.state_machine.execution_steps import ExecutionOutcome
from stucksolver.solver.state_machine.gap_wait import SIGHT_COMES_S
from worlds import LANE_M, World, straight_road, thing

PLAN = RecoveryPlan(
    behaviors=(BackUp(distance_m=4.0), BorrowOncomingLane(past_object_id="lead", speed_mps=5.5)),
)
COMES_M, HIDES_FROM_M = 170.0, 100.0
ALL_M, TOO_LITTLE_M = 300.0, 60.0


def seen(world, sight_m, sd_m):
    """A car that comes hides what is behind it. `sight_m` of the lane are seen otherwise."""
    world.sight_m = min([sight_m, *(o.x_m - world.x for o in world.objects if o.vx_mps < 0.0 and o.x_m > world.x)])
    told = world.view().surroundings
    return FrenetScene(told.model_copy(update={"ego": told.ego.model_copy(update={"position_sd_m": sd_m})}))


def carried_out(world, sight_m, sd_m, seconds=40.0):
    """Returns the outcome or the order at the end, and the time (s). `sight_m` gives the sight by time."""
    running = Execution(PLAN, Guard(), guided=False)
    assert running.start(seen(world, ALL_M, sd_m), world.time_s).accepted
    told = None
    while world.time_s < seconds:
        told = running.tick(seen(world, sight_m(world.time_s), sd_m), world.time_s)
        if isinstance(told, ExecutionOutcome) or getattr(told.behavior, "name", "") == "borrow_oncoming_lane":
            break
        world.drive(told)
    return told, world.time_s


def before_a_van(*others):
    return World(straight_road(), [thing("lead", 61.0, hazard=True, position_sd_m=0.05), *others])


@pytest.mark.integration
@pytest.mark.parametrize(("sd_m", "waits"), [(0.05, True), (None, False)], ids=["sensed", "exact"])
def test_it_waits_for_who_comes_and_hides_the_lane(sd_m, waits):
    world = before_a_van(thing("car", COMES_M, LANE_M, speed=-8.0, yaw=3.14159, position_sd_m=sd_m))
    told, time_s = carried_out(world, lambda _: ALL_M, sd_m)
    assert isinstance(told, Execute) == waits
    if waits:
        passed_s = (COMES_M - 50.0) / 8.0
        assert time_s > passed_s - 1.0, "not before the car has gone by"
    else:
        assert {RejectCode.ONCOMING_SIGHT, RejectCode.ONCOMING_GAP} <= set(told.verdict.codes)


@pytest.mark.integration
@pytest.mark.parametrize(("comes_s", "goes"), [(SIGHT_COMES_S / 2, True), (2.0 * SIGHT_COMES_S, False)])
def test_wait_for_sight_without_traffic_ends_after_camera_time(comes_s, goes):
    """Without oncoming traffic, the plan waits for the cameras' next views and no longer."""
    _, there_s = carried_out(before_a_van(), lambda _: ALL_M, 0.05)
    told, time_s = carried_out(before_a_van(), lambda now_s: ALL_M if now_s > there_s + comes_s else TOO_LITTLE_M, 0.05)
    assert isinstance(told, Execute) == goes
    assert time_s == pytest.approx(there_s + min(comes_s, SIGHT_COMES_S), abs=0.5)


@pytest.mark.integration
def test_with_exact_sight_it_does_not_wait_for_more():
    _, there_s = carried_out(before_a_van(), lambda _: ALL_M, None)
    told, time_s = carried_out(before_a_van(), lambda _: TOO_LITTLE_M, None)
    assert isinstance(told, ExecutionOutcome) and time_s == pytest.approx(there_s, abs=0.2)
