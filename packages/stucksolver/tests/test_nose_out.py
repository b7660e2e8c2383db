"""Beside a stream: the nose goes out, the plan waits there as long as it takes, and one proof lets it go."""

from __future__ import annotations

import contextlib
import math

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from grids import sample
from streams import ROAD, Stream
from stucksolver.guard import NOBODY, Guard, RejectCode, begin_nosed_out
from stucksolver.plan import Execute, RecoveryPlan
from stucksolver.plan.behaviors import AbortAction, BehaviorStart, BorrowOncomingLane, ChangeLane, NoPathError, NoseOut
from stucksolver.plan.frenet_path import STEP_M, turned_shift
from stucksolver.plan.lateral_shift import lateral_shift
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.solver.state_machine import execution
from stucksolver.solver.state_machine.execution import Execution
from stucksolver.solver.state_machine.execution_steps import ExecutionOutcome
from stucksolver.solver.state_machine.gap_wait import SENSED_WAIT_S
from worlds import LANE_M, World, straight_road, thing

GUARD = Guard()
LEFT = ChangeLane(side="left", distance_m=30.0, speed_mps=5.5)
PLAN = RecoveryPlan(behaviors=(NoseOut(side="left"), LEFT))
OBSTACLE_M = 8.0


def beside_a_stream(**more):
    return Stream(ROAD, [thing("lead", 100.0 + 2.45 + OBSTACLE_M + 2.3)], x=100.0, dt=0.1, **more)


def carry_out(world, seconds, plan=PLAN):
    """Returns the outcome (None if it still runs), the smallest gap to anybody, and the last order."""
    running = Execution(plan, GUARD, guided=False)
    verdict = running.start(world.view(), world.time_s)
    assert verdict.accepted, str(verdict)
    nearest, told = math.inf, None
    while world.time_s < seconds:
        told = running.tick(world.view(), world.time_s)
        if isinstance(told, ExecutionOutcome):
            return told, nearest, told
        world.drive(told)
        nearest = min(nearest, world.clearance())
    return None, nearest, told


def at_the_border(gap_m, pace_mps, accelerates_mps2=3.5):
    """An ego with its nose 0.4 m over the border, and a car whose front is `gap_m` behind its own front."""
    world = Stream(ROAD, [thing("lead", 113.0)], x=100.0, yaw=0.25, pace_mps=pace_mps)
    world.accelerates_mps2 = accelerates_mps2
    world.y = LANE_M / 2 + 0.4 - 2.45 * math.sin(0.25) - 0.925 * math.cos(0.25)
    world.objects.append(thing("car1", 102.45 - gap_m - 2.3, LANE_M, speed=pace_mps))
    return world


def test_nose_out_ends_at_lane_border_turned_to_next_lane():
    """The front stops at the border of the ego's lane, turned to the adjacent one."""
    world = beside_a_stream()
    outcome, _, _ = carry_out(world, 30.0, RecoveryPlan(behaviors=(NoseOut(side="left"),)))
    nose = world.y + 2.45 * math.sin(world.yaw) + 0.925 * math.cos(world.yaw)
    assert outcome is not None and outcome.finished
    assert LANE_M / 2 - 0.45 < nose < LANE_M / 2 + 0.15 and world.yaw > 0.15


@pytest.mark.parametrize("sd_m", [0.02, 0.1])
def test_nose_out_sensor_mode_keeps_position_margin_to_border(sd_m):
    """In sensor mode, the front stops inside the border by more than the position uncertainty.

    Beside an oncoming lane, where no vehicle may wait: the plan ended when the uncertainty grew by a few
    centimeters.
    """

    def told(world, sd):
        seen = world.surroundings()
        return FrenetScene(seen.model_copy(update={"ego": seen.ego.model_copy(update={"position_sd_m": sd})}))

    world = World(straight_road(), [thing("lead", 114.0)], x=100.0)
    plan = (NoseOut(side="left"),)
    proven = GUARD.lay_out(plan, told(world, sd_m), False, NOBODY)
    known = GUARD.lay_out(plan, told(world, None), False, NOBODY)
    assert proven.path.end_d < known.path.end_d
    world.x, world.y = float(proven.path.s[-2]), float(proven.path.d[-2])
    verdict = GUARD.recheck(proven, told(world, sd_m + 0.04))
    assert RejectCode.STOPPING_PLACE not in [reject.code for reject in verdict.rejects], str(verdict)


@pytest.mark.integration
def test_nose_out_wait_outlasts_plan_time_until_flow_ends():
    """The wait is longer than the time of the plan and ends when the traffic flow does."""
    world = beside_a_stream(spacing_m=15.0, ends_s=35.0).fill(3.0)
    outcome, nearest, _ = carry_out(world, 80.0)
    assert outcome is not None and outcome.finished, outcome
    assert world.time_s > 35.0 and nearest > 0.25


@pytest.mark.integration
def test_nose_out_flow_without_gap_ends_plan_stopped(monkeypatch):
    """The ego does not wait forever for a gap in a traffic flow."""
    monkeypatch.setattr(execution, "GAP_WAIT_S", 15.0)
    world = beside_a_stream(spacing_m=12.0).fill(3.0)
    outcome, nearest, _ = carry_out(world, 45.0)
    assert outcome is not None and not outcome.finished
    assert nearest > 0.25 and GUARD.may_stand(world.view()) and abs(world.speed) < 0.2


@pytest.mark.release
@pytest.mark.slow
@settings(max_examples=6, deadline=None, phases=(Phase.explicit, Phase.generate))
@given(st.floats(5.0, 12.0), st.floats(2.0, 6.0), st.floats(0.0, 1.0), st.floats(1.2, 4.0))
def test_nose_out_follower_watching_path_brakes_below_4_6_mps2(pace_mps, headway_s, first, quick_mps2):
    """A follower that reacts only to vehicles in its own path need not brake hard."""
    spacing = pace_mps * headway_s
    world = beside_a_stream(spacing_m=max(spacing, 8.0), pace_mps=pace_mps, accelerates_mps2=quick_mps2)
    outcome, nearest, told = carry_out(world.fill(first * spacing), 25.0)
    assert nearest > 0.25
    assert world.hardest_mps2 <= 4.6
    assert (outcome is not None and outcome.finished) or isinstance(told, Execute)


def seen_by_sensors(world, rng, sds):
    """The view of sensors with these standard deviations: others along and across their axis, and the ego's place."""
    along, across, own = sds
    seen = world.surroundings()
    others = [
        o.model_copy(
            update={
                "position_sd_m": along,
                "across_sd_m": across,
                "x_m": o.x_m + rng.normal(0.0, along / 2),
                "y_m": o.y_m + rng.normal(0.0, across / 2),
            }
        )
        for o in seen.objects
    ]
    ego = seen.ego.model_copy(update={"position_sd_m": own})
    return FrenetScene(seen.model_copy(update={"objects": tuple(others), "ego": ego}))


UNCERTAIN = [(seed, sds) for seed in (2, 4, 6, 10) for sds in ((0.2, 0.1, 0.05), (0.25, 0.15, 0.1))]


@pytest.mark.integration
@pytest.mark.parametrize(("seed", "sds"), sample(UNCERTAIN, 3))
def test_nose_out_uncertain_positions_hit_no_passing_vehicle(seed, sds):
    """With uncertain positions, no passing vehicle is hit or made to brake hard.

    Found in sensor mode at a construction site: larger boxes seemed to touch the front that waited beside them. The
    ego counted as being in their path already and went on in front of them.
    """
    rng = np.random.default_rng(seed)
    pace_mps, headway_s = rng.uniform(5.0, 12.0), rng.uniform(1.5, 5.5)
    spacing = max(pace_mps * headway_s, 8.0)
    world = beside_a_stream(spacing_m=spacing, pace_mps=pace_mps, accelerates_mps2=rng.uniform(1.2, 4.0))
    world.fill(rng.uniform(0.0, spacing))
    running, nearest = Execution(PLAN, GUARD, guided=False), math.inf
    assert running.start(seen_by_sensors(world, rng, sds), world.time_s).accepted
    while world.time_s < 30.0:
        told = running.tick(seen_by_sensors(world, rng, sds), world.time_s)
        if isinstance(told, ExecutionOutcome):
            break
        world.drive(told)
        nearest = min(nearest, world.clearance())
    assert nearest > 0.2
    assert world.hardest_mps2 <= 4.6


@pytest.mark.integration
def test_execution_stopped_for_gap_times_out():
    """In sensor mode, a plan that is stopped for a gap ends soon. The next one uses the newer objects.

    Before, the plan waited for three minutes, because a cone detected after its start was 5 cm too near to its
    path.
    """
    rng, world = np.random.default_rng(1), beside_a_stream(spacing_m=12.0).fill(3.0)
    running, told = Execution(PLAN, GUARD, guided=False), None
    assert running.start(seen_by_sensors(world, rng, (0.1, 0.05, 0.03)), world.time_s).accepted
    while world.time_s < 60.0:
        told = running.tick(seen_by_sensors(world, rng, (0.1, 0.05, 0.03)), world.time_s)
        if isinstance(told, ExecutionOutcome):
            break
        world.drive(told)
    assert isinstance(told, ExecutionOutcome) and not told.finished and "gave way" in told.text
    assert SENSED_WAIT_S < world.time_s < SENSED_WAIT_S + 25.0
    assert GUARD.may_stand(world.view()) and abs(world.speed) < 0.2


@pytest.mark.integration
@settings(max_examples=60, deadline=None)
@given(st.floats(0.0, 45.0), st.floats(3.0, 14.0), st.floats(1.2, 4.0))
def test_what_ends_the_wait_is_what_lets_the_plan_run(gap_m, pace_mps, quick_mps2):
    """Whoever may go on after giving way may go on anyhow: no wait ends in a plan that is given up at once."""
    view = at_the_border(gap_m, pace_mps, quick_mps2).view()
    begun = begin_nosed_out(GUARD, (LEFT,), view, False, NOBODY, False)
    assert begun is not None, "it waits, or goes"
    verdict, proven = begun
    everybody, somebody, nobody = (GUARD.recheck(proven, view, to) for to in (True, frozenset({"car1"}), False))
    assert str(verdict) == str(everybody)
    assert verdict.accepted or verdict.abort is AbortAction.YIELD
    assert somebody.accepted or not everybody.accepted
    assert nobody.accepted or not somebody.accepted


def least_gap_m(goes):
    """Return the least gap between 10 and 45 m, in steps of 0.25 m, that is long enough; longer ones are, too."""
    few, many = 40, 180
    assert goes(many / 4) and not goes(few / 4)
    while many - few > 1:
        middle = (few + many) // 2
        few, many = (few, middle) if goes(middle / 4) else (middle, many)
    return many / 4


def test_recheck_vehicle_after_yielding_needs_shorter_gap():
    """The vehicle after the one that the ego yielded to is not confused with it.

    The later vehicle reacts to the ego and needs a shorter gap than the one that did not yield.
    """

    def goes(gap, to):
        view = at_the_border(gap, 9.0).view()
        proven = begin_nosed_out(GUARD, (LEFT,), view, False, NOBODY, False)[1]
        return GUARD.recheck(proven, view, to).accepted

    watched = least_gap_m(lambda gap: goes(gap, frozenset({"somebody else"})))
    let_by = least_gap_m(lambda gap: goes(gap, frozenset({"car1"})))
    # Half a second more of their reaction, at the speed that they have by then.
    assert 0.5 * 9.0 <= let_by - watched <= 0.5 * 13.4 + 0.25


def test_a_quicker_vehicle_needs_a_shorter_gap():
    def least(measured):
        def goes(gap):
            seen = at_the_border(gap, 9.0).surroundings()
            limits = seen.ego.limits.model_copy(update={"measured_acceleration_mps2": measured})
            view = FrenetScene(seen.model_copy(update={"ego": seen.ego.model_copy(update={"limits": limits})}))
            return begin_nosed_out(GUARD, (LEFT,), view, False, NOBODY, False)[0].accepted

        return least_gap_m(goes)

    assert least(3.2) < least(2.1) < least(1.0)
    assert least(3.5) == least(9.0), "never quicker than the configured value"
    assert least(2.1) == least(None), "unmeasured: 0.6 of it"


def test_nobody_waits_with_the_nose_in_the_oncoming_lane():
    world = World(straight_road(), [thing("lead", 113.0), thing("on", 130.0, LANE_M, speed=-9.0)], x=100.0, yaw=0.25)
    borrow = BorrowOncomingLane(past_object_id="lead", speed_mps=5.0)
    verdict, _ = GUARD.accept((borrow,), world.view(), False)
    assert RejectCode.ONCOMING_GAP in verdict.codes
    assert begin_nosed_out(GUARD, (borrow,), world.view(), False, NOBODY, False) is None


def test_begin_nosed_out_without_gap_starts_no_lane_change():
    """From inside the lane, a lane change does not start without its gap."""
    world = Stream(ROAD, [thing("lead", 113.0), thing("car1", 95.0, LANE_M, speed=9.0)], x=100.0)
    assert begin_nosed_out(GUARD, (LEFT,), world.view(), False, NOBODY, False) is None


@settings(max_examples=80, deadline=None)
@given(st.floats(0.0, 0.5), st.floats(0.15, 0.5), st.floats(2.0, 4.5), st.floats(8.0, 30.0))
def test_turned_shift_keeps_start_heading_and_turn_radius(d, yaw, to, length):
    """A shift starts with the given heading, ends straight, and turns no tighter than the vehicle."""
    view = World(ROAD, x=100.0).view()
    path = turned_shift((100.0, d), yaw, d + to, length, 5.0, view)
    if path is None:
        return
    slope = np.diff(path.d) / STEP_M
    assert math.atan(float(slope[0])) == pytest.approx(yaw, abs=0.12)
    assert path.d[0] == pytest.approx(d) and path.d[-1] == pytest.approx(d + to)
    assert abs(float(slope[-1])) < 0.12
    assert float(np.abs(np.diff(slope)).max()) / STEP_M <= 1.15 / view.ego.limits.min_turn_radius_m


def test_lateral_shift_from_turned_start_needs_shorter_gap():
    """With the front out, a gap is long enough that is too short for a straight start."""

    def least(yaw):
        for gap in np.arange(2.0, 9.0, 0.2):
            view = World(ROAD, [thing("lead", 100.0 + 2.45 + float(gap) + 2.3)], x=100.0, y=0.35).view()
            with contextlib.suppress(NoPathError):
                lateral_shift(view, BehaviorStart(100.0, 0.35, 0.0, yaw), LANE_M, 5.0)
                return float(gap)
        return math.inf

    assert least(0.35) < least(0.0) < 9.0
