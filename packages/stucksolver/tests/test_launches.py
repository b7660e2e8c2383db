"""What the vehicle's own starts say about its acceleration, and what proofs may make of it."""

from __future__ import annotations

import statistics

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stucksolver.plan.frenet_path import straight
from stucksolver.plan.speed_profile import SLUGGISH_ACCELERATION, slow_launch
from stucksolver.scene import FailedAttempt, LineKind, RejectCode, Status, VehicleLimits
from stucksolver.solver import StuckSolver
from stucksolver.solver.launch_acceleration import LaunchAcceleration
from test_search_moves import names
from worlds import LANE_M, World, drive, searched, straight_road, thing

MULTI = straight_road(left=LineKind.BROKEN, oncoming=None)


def launch(launches, mps2, begins_s, *, own=True, to_mps=5.0, sags=False):
    """The vehicle stands, and sets off at a steady acceleration; with `sags` it brakes on the way."""
    speeds = [0.0, 0.0, *np.arange(0.0, to_mps, mps2 * 0.05), to_mps]
    if sags:
        speeds[12:14] = [0.2, 0.2]
    for k, speed in enumerate(speeds):
        launches.update(Status(time_s=begins_s + 0.05 * k, speed_mps=float(speed), progress_m=0.0), own=own)


def measured(*rates, **more):
    launches = LaunchAcceleration()
    for k, rate in enumerate(rates):
        launch(launches, rate, 100.0 * k, **more)
    return launches.acceleration_mps2


def test_one_start_says_nothing_and_equal_ones_say_their_acceleration():
    assert measured(2.0) is None
    assert measured(2.0, 2.0) == pytest.approx(2.0, rel=0.05)


@pytest.mark.integration
@given(st.lists(st.floats(0.8, 4.0), min_size=2, max_size=8))
def test_measured_acceleration_is_below_mean_of_faster_launches(rates):
    """The value never exceeds the mean of the faster launches less their spread."""
    quicker = sorted(rates, reverse=True)[: max(2, (len(rates) + 1) // 2)]
    most = statistics.mean(quicker) - 2.0 * statistics.stdev(quicker)
    found = measured(*rates)
    assert found is None or found <= most * 1.05 + 0.15


def test_measured_acceleration_ignores_launches_behind_lead():
    """Launches behind a lead vehicle do not hide what the vehicle can do."""
    assert measured(0.8, 2.5, 0.9, 2.5) == pytest.approx(2.5, rel=0.05)


@pytest.mark.parametrize("more", [{"own": False}, {"sags": True}, {"to_mps": 2.0}], ids=str)
def test_starts_that_are_bounded_or_held_up_do_not_count(more):
    assert measured(2.0, 2.0, 2.0, **more) is None


@pytest.mark.parametrize(
    ("measured_mps2", "used_mps2"), [(None, 1.5 * SLUGGISH_ACCELERATION), (1.2, 1.2), (0.5, 0.5), (9.0, 1.5)]
)
def test_slow_launch_uses_measured_acceleration_up_to_configured(measured_mps2, used_mps2):
    """A proof uses the measured value and never more than the configured one."""
    limits = VehicleLimits(measured_acceleration_mps2=measured_mps2)
    run = slow_launch(straight(0.0, 0.0, 40.0, 50.0), 0.0, limits)
    assert run.v[20] ** 2 / (2 * 10.0) == pytest.approx(used_mps2, rel=0.05)


def test_the_guard_and_the_record_get_what_was_measured():
    """The driver sets off three times on a free road; then a van stands there."""
    seen = []
    world = World(MULTI)

    def change(world):
        world.cruise_mps = 0.0 if 3.0 < world.time_s < 4.5 or 8.0 < world.time_s < 9.5 else 6.0
        if world.time_s == 13.0:
            world.objects = [thing("van", world.x + 22.0, hazard=True)]

    class Watch:
        def begin(self, facts): ...
        def fault(self, event): ...
        def step(self, step):
            if step.sight is not None and step.sight.surroundings is not None:
                seen.append(step.sight.surroundings.ego.limits.measured_acceleration_mps2)

    with StuckSolver(world.scene, clock="lockstep", record=Watch()) as solver:
        while world.time_s < 22.0:
            world.drive(solver.step(world.status(), world.surroundings))
            change(world)
    # The world's driver gains 1.5 m/s² where it is free to.
    assert seen and seen[-1] == pytest.approx(1.5, rel=0.1)


def left_no_gap(world, *tries, code=RejectCode.LANE_ENTRY):
    """What the search proposes after plans, with how long ago they failed (s), to which traffic left no gap."""
    scene = world.scene()
    ego = scene.ego.model_copy(update={"stopped_for_s": 30.0})
    attempts = tuple(
        FailedAttempt(time_s=scene.time_s - ago_s, behaviors=behaviors, codes=(code,), outcome="")
        for ago_s, *behaviors in tries
    )
    return names(searched(world, scene.model_copy(update={"ego": ego, "attempts": attempts})))


def stream(road, *, past_x, spacing_m, speed):
    """A disabled car, and traffic in the lane on the left without a gap."""
    cars = [thing(f"car{k}", past_x + spacing_m * k, LANE_M, speed=speed) for k in range(10)]
    return World(road, [thing("lead", 65.0, hazard=True), *cars])


def test_search_noses_out_after_two_failures_for_traffic():
    """A gap may come: only after traffic left none twice, a move is made after which a shorter one is enough."""
    world = stream(MULTI, past_x=74.0, spacing_m=-12.0, speed=8.0)
    assert left_no_gap(world, (20.0, "change_lane"), (5.0, "change_lane"))[:2] == ["nose_out", "change_lane"]
    assert left_no_gap(world, (5.0, "change_lane"))[0] == "change_lane"
    assert left_no_gap(world, (90.0, "change_lane"), (5.0, "change_lane"))[0] == "change_lane"


def test_search_noses_out_before_oncoming_lane_is_borrowed():
    """Beside oncoming traffic, the front stays in the ego's lane until a gap comes."""
    world = stream(straight_road(), past_x=60.0, spacing_m=22.0, speed=-8.0)
    tries = ((20.0, "borrow_oncoming_lane"), (5.0, "borrow_oncoming_lane"))
    assert left_no_gap(world, *tries, code=RejectCode.ONCOMING_GAP) == ["nose_out", "borrow_oncoming_lane"]


@pytest.mark.slow
def test_a_stream_that_ends_is_waited_for_and_then_passed():
    cars = [thing(f"car{k}", 50.0 - 22.0 * k, LANE_M, speed=8.0) for k in range(-2, 20)]
    world = World(MULTI, [thing("lead", 65.0, hazard=True), *cars], dt=0.1)
    seen = drive(world, 100.0)
    assert world.x > 90.0 and seen.nearest_m > 0.25
