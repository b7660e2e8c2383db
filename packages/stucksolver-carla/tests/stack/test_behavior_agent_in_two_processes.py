"""BehaviorAgent in one process, the solver in another: it recovers as with both in one, and survives the solver."""

from __future__ import annotations

import os
import signal
import sys

import pytest

carla = pytest.importorskip("carla")

from test_behavior_agent import agent_on, collisions_of, past, put, run  # noqa: E402
from townstage import CAR  # noqa: E402

from stucksolver_bridge import AgentDriver, RecoveryClient, SolverError  # noqa: E402
from stucksolver_bridge.timer_baseline import TimerBaseline  # noqa: E402

pytestmark = pytest.mark.integration

PARKED = (11, -1, 60.0)


def beside(stage, car, agent, **settings):
    """The agent with a solver process beside it, and what that tells."""
    told = []
    recovery = RecoveryClient(
        AgentDriver(agent, carla),
        stage.map,
        carla,
        {"ladder": "evaluation", "clock": "lockstep", **settings},
        sys.executable,
        on_event=told.append,
    )
    return recovery, told


def test_it_passes_a_parked_car(stage):
    put(stage, CAR, PARKED)
    car, agent = agent_on(stage)
    bumps = collisions_of(stage, car)
    recovery, told = beside(stage, car, agent)
    came = run(stage, car, recovery, 60.0, past(stage, car, PARKED))
    recovery.close()
    assert came, told
    assert not bumps
    assert {"decided", "started"} <= {event["kind"] for event in told}
    assert recovery.solver.process.returncode is not None


def test_solver_killed_in_plan_vehicle_stops_then_agent_drives(stage):
    """When the solver is killed while a plan runs, the vehicle stops; then the agent drives by itself."""
    put(stage, CAR, PARKED)
    car, agent = agent_on(stage)
    recovery, _told = beside(stage, car, agent)
    assert run(stage, car, recovery, 60.0, lambda: recovery.directive["kind"] == "execute")
    os.kill(recovery.solver.process.pid, signal.SIGKILL)
    recovery.solver.process.wait()
    recovery.run_step()
    assert not recovery.solver.alive
    assert run(stage, car, recovery, 1.0, lambda: recovery.directive == {"kind": "continue"})
    control = recovery.run_step()
    assert (control.throttle, control.brake) == (agent.run_step().throttle, agent.run_step().brake)
    run(stage, car, recovery, 2.0)
    assert car.get_velocity().length() < 0.3, "left alone it stands behind the parked car again"


def test_attach_invalid_settings_raise_error_with_name(stage):
    car, agent = agent_on(stage)
    with pytest.raises(SolverError, match="no_such_reasoner"):
        beside(stage, car, agent, recovery="no_such_reasoner")


def test_timers_reverse_and_then_overtake_looking_at_nothing(stage):
    put(stage, CAR, PARKED)
    car, agent = agent_on(stage)
    told = []
    timers = TimerBaseline(AgentDriver(agent, carla), told.append)
    came = run(stage, car, timers, 70.0, past(stage, car, PARKED))
    assert came, told
    assert [e["text"] for e in told if e["kind"] == "started"][:2] == ["reverse", "overtake left"]
