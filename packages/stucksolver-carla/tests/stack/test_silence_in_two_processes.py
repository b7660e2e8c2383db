"""The solver in a process of its own is stopped, goes on, or is killed while a plan runs, on the road."""

from __future__ import annotations

import os
import signal
import sys
import time

import pytest

carla = pytest.importorskip("carla")

from fake_agents import FakeAgent  # noqa: E402
from test_agent_plan import leaderboard_plan  # noqa: E402
from test_behavior_agent import collisions_of, past, put  # noqa: E402
from test_behavior_agent import run as run_free  # noqa: E402
from test_carla_stack import speed_of  # noqa: E402
from townstage import CAR  # noqa: E402

from stucksolver_bridge import AgentDriver, RecoveryClient  # noqa: E402
from stucksolver_bridge.agent_plan import make_agent  # noqa: E402

pytestmark = pytest.mark.integration

TICK_S = 0.05
START, END, PARKED = (11, -1, 20.0), (11, -1, 115.0), (11, -1, 60.0)


class Halting(FakeAgent):
    """Stands 6 m behind what is in its lane, as BehaviorAgent does."""

    def run_step(self, debug=False):
        control = super().run_step(debug)
        here = self._vehicle.get_transform()
        ahead, right = here.get_forward_vector(), here.get_right_vector()
        for other in self._world.get_actors().filter("*vehicle*"):
            if other.id == self._vehicle.id:
                continue
            away = other.get_location() - here.location
            along, aside = away.x * ahead.x + away.y * ahead.y, away.x * right.x + away.y * right.y
            if 0.0 < along < 12.0 and abs(aside) < 2.0:
                control.throttle, control.brake = 0.0, 0.7
        return control


def run(stage, car, recovery, seconds, until=lambda: False):
    """As `run_free`, and no quicker than the clock on the wall where the solver goes by that.

    Otherwise seconds of the world pass while a busy machine's solver thinks for a tenth of one.
    """
    if not recovery.solver.live:
        return run_free(stage, car, recovery, seconds, until)
    for _ in range(round(seconds / TICK_S)):
        begun = time.monotonic()
        if run_free(stage, car, recovery, TICK_S, until):
            return True
        time.sleep(max(begun + TICK_S - time.monotonic(), 0.0))
    return False


@pytest.fixture
def stuck(stage):
    """A car behind a parked one, with a solver beside it."""
    put(stage, CAR, PARKED)
    car = stage.add(CAR, START, role="hero")
    stage.ticks(2)
    agent = make_agent(Halting, car, "normal", stage.map)
    driver = AgentDriver(agent, carla)
    driver.set_plan(leaderboard_plan(stage, agent, START, END))
    told, made = [], []

    def make(clock):
        settings = {"ladder": "evaluation", "clock": clock}
        made.append(RecoveryClient(driver, stage.map, carla, settings, sys.executable, on_event=told.append))
        return made[0]

    yield car, make, told
    os.kill(made[0].solver.process.pid, signal.SIGCONT) if made[0].solver.alive else None
    made[0].close()


def drives_a_path(recovery):
    return recovery.directive["kind"] == "execute" and len(recovery.directive.get("path", ())) > 1


@pytest.mark.slow
@pytest.mark.parametrize("seconds", [pytest.param(0.3, marks=pytest.mark.release), 2.5])
def test_stopped_solver_delays_no_tick_and_resumes(stage, stuck, seconds):
    """A stopped solver delays no tick, and its answers count again when it goes on."""
    car, make, told = stuck
    bumps = collisions_of(stage, car)
    recovery = make("wall")
    assert run(stage, car, recovery, 90.0, lambda: drives_a_path(recovery)), told
    run(stage, car, recovery, seconds)
    # On a busy machine the solver may have been late by itself before it is stopped.
    assert run(stage, car, recovery, 30.0, lambda: drives_a_path(recovery) and not recovery._lease.expired), told
    before = len(told)
    os.kill(recovery.solver.process.pid, signal.SIGSTOP)
    # Each of these ticks would take as long as the solver may be silent if one were waited for.
    assert run(stage, car, recovery, 20.0, lambda: recovery.directive["kind"] == "continue"), told
    assert [event["kind"] for event in told[before:]].count("order_expired") == 1
    run(stage, car, recovery, 2.0)
    assert recovery.solver.alive and not bumps
    os.kill(recovery.solver.process.pid, signal.SIGCONT)
    assert run(stage, car, recovery, 120.0, past(stage, car, PARKED)), told
    assert not bumps


def killed(stage, car, recovery, at_mps, stops):
    """Kills the solver once its plan drives so fast where a stop would do, or would not; whether it came to that.

    On a busy machine an order may expire once before, so the plan begins anew.
    """

    def due():
        stands_well = not recovery._lease.no_stop_at(*recovery._path_position())
        return drives_a_path(recovery) and speed_of(car) > at_mps and stands_well is stops

    came = run(stage, car, recovery, 120.0, due)
    os.kill(recovery.solver.process.pid, signal.SIGKILL)
    recovery.solver.process.wait()
    car.apply_control(recovery.run_step())
    stage.world.tick()
    assert not recovery.solver.alive
    return came


@pytest.mark.slow
@pytest.mark.parametrize("clock", ["wall", pytest.param("lockstep", marks=pytest.mark.release)])
def test_killed_solver_before_commit_point_stops_then_driver_drives(stage, stuck, clock):
    """A solver killed before the commit point leaves a vehicle that stops and then drives by itself."""
    car, make, _told = stuck
    bumps = collisions_of(stage, car)
    recovery = make(clock)
    assert killed(stage, car, recovery, 0.5, stops=True), "the test needs a plan that has just begun"
    assert recovery.directive["behavior"]["name"] == "wait"
    assert run(stage, car, recovery, 2.0, lambda: recovery.directive == {"kind": "continue"})
    run(stage, car, recovery, 5.0)
    assert speed_of(car) < 0.3 and not bumps, "left alone it stands behind the parked car again"


@pytest.mark.slow
def test_killed_past_the_commit_point_the_way_round_is_finished(stage, stuck):
    car, make, told = stuck
    bumps = collisions_of(stage, car)
    recovery = make("lockstep")
    assert killed(stage, car, recovery, 2.5, stops=False), "the test needs a plan that is past its commit point"
    assert drives_a_path(recovery)
    assert run(stage, car, recovery, 30.0, past(stage, car, PARKED)), told
    assert run(stage, car, recovery, 10.0, lambda: recovery.directive == {"kind": "continue"})
    assert not bumps


@pytest.mark.release
def test_in_lockstep_nothing_is_different_from_before(stage, stuck):
    car, make, told = stuck
    bumps = collisions_of(stage, car)
    recovery = make("lockstep")
    assert run(stage, car, recovery, 60.0, past(stage, car, PARKED)), told
    assert not bumps
    assert "order_expired" not in [event["kind"] for event in told]
