"""The solver in a process of its own: five forms go through, and whatever becomes of it costs one tick."""

from __future__ import annotations

import math
import os
import signal
import socket
import struct
import subprocess
import sys
import time

import pytest
from own_street import Street

from stucksolver.record import replay
from stucksolver.record.recorder import RUN_ENDED
from stucksolver_bridge import JsonLease, SolverError, SolverProcess
from stucksolver_bridge.message_socket import Wire, WireError

pytestmark = pytest.mark.integration

SETTINGS = {"ladder": "evaluation", "clock": "lockstep"}
LIMIT_S = 60.0


@pytest.fixture
def solver():
    started = SolverProcess(sys.executable, {"settings": SETTINGS})
    yield started
    started.close()


def test_process_stack_in_json_passes_parked_car(solver):
    """A stack that speaks the JSON forms gets directives to pass a parked car, and passes it."""
    street = Street()
    kinds = set()
    while street.x < 120.0 and street.time_s < LIMIT_S:
        answer = solver.step({"status": street.status()}, street.give)
        assert answer is not None, solver.fault
        street.perform(answer.get("directive"))
        kinds.add(street.directive["kind"])
    assert street.x >= 120.0
    assert kinds == {"continue", "execute"}


def test_nothing_is_asked_for_while_the_vehicle_goes(solver):
    asked = []
    for k in range(100):
        status = {"time_s": 0.05 * k, "speed_mps": 8.0, "progress_m": 0.4 * k, "at_destination": False}
        answer = solver.step({"status": status}, asked.append)
        assert answer is not None and answer.keys() <= {"directive"}
    assert not asked


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_process_killed_solver_is_detected_on_next_tick(solver, number):
    street = Street()
    assert solver.step({"status": street.status()}, street.give) is not None
    os.kill(solver.process.pid, number)
    solver.process.wait()
    assert solver.step({"status": street.status()}, street.give) is None
    assert not solver.alive and solver.fault
    assert solver.step({"status": street.status()}, street.give) is None


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("time_s", math.nan),
        pytest.param("speed_mps", object(), id="speed_mps-object"),
        ("progress_m", 10**400),
    ],
    ids=str,
)
def test_step_status_field_wrong_is_one_event_over_the_link(solver, field, value):
    """What no JSON can hold; packages/stucksolver/tests/test_status_faults.py has many more values.

    The solver lives.
    """
    told = []
    for k in range(30):
        status = {"time_s": 0.05 * k, "speed_mps": 0.0, "progress_m": 1.0, "at_destination": False, field: value}
        answer = solver.step({"status": status}, lambda what: None)
        assert answer is not None, solver.fault
        told += answer.get("events", ())
        assert answer.get("directive", {"kind": "continue"}) == {"kind": "continue"}
    assert [event["kind"] for event in told] == ["fault"]
    assert told[0]["text"].startswith(f"status.{field} is ")


@pytest.mark.parametrize("status", [None, {"time_s": 0.0, "wheels": 4}], ids=str)
def test_step_without_status_ends_solver_with_one_line(solver, status, capfd):
    assert solver.step({"status": status}, lambda what: None) is None
    assert not solver.alive and "invalid status" in solver.fault
    said = capfd.readouterr().err
    assert said.count("drives by itself") == 1 and "Traceback" not in said


def test_step_odd_surroundings_are_one_event_over_the_link(solver):
    """Surroundings with a NaN count as not seen, and the field is named."""
    street, told, directives = Street(), [], set()

    def give(what):
        form = street.give(what)
        if what == "surroundings":
            form["ego"]["x_m"] = math.nan
        return form

    for _ in range(100):
        answer = solver.step({"status": {**street.status(), "speed_mps": 0.0}}, give)
        assert answer is not None, solver.fault
        told += answer.get("events", ())
        directives |= {answer.get("directive", {"kind": "continue"})["kind"]}
        street.perform(None)
    faults = [event["text"] for event in told if event["kind"] == "fault"]
    assert len(faults) == 1 and "ego.x_m" in faults[0] and "\n" not in faults[0]
    assert directives == {"continue"}


def test_the_solver_ends_when_the_stack_does():
    script = (
        "import os, sys; from stucksolver_bridge import SolverProcess; "
        f"solver = SolverProcess(sys.executable, {{'settings': {SETTINGS!r}}}); "
        "print(solver.process.pid, flush=True); os._exit(1)"
    )
    said = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=LIMIT_S, check=False)
    assert _gone(int(said.stdout))


def test_record_is_complete_after_close_and_truncated_after_death(tmp_path):
    """A stack that closes during a plan leaves a complete record; one that dies leaves a truncated one."""
    ended = {}
    for how in ("close", "die"):
        settings = {**SETTINGS, "record": str(tmp_path / how)}
        solver, street = SolverProcess(sys.executable, {"settings": settings}), Street()
        for _ in range(2000):
            street.perform(solver.step({"status": street.status()}, street.give).get("directive"))
            if street.directive["kind"] == "execute":
                break
        if how == "close":
            solver.close()
        else:
            solver._wire.close()
        assert solver.process.wait(LIMIT_S) == (0 if how == "close" else 1)
        (file,) = (tmp_path / how).glob("*.jsonl")
        ended[how] = replay(file).ended
    assert ended == {"close": RUN_ENDED, "die": None}


@pytest.mark.parametrize(
    ("settings", "named"),
    [({"ladder": "of_hope"}, "of_hope"), ({"speed": 9}, "speed")],
)
def test_process_invalid_settings_raise_error_with_name(settings, named):
    with pytest.raises(SolverError, match=named):
        SolverProcess(sys.executable, {"settings": settings})


def test_process_missing_python_raises_error_with_path():
    with pytest.raises(SolverError, match="/no/python"):
        SolverProcess("/no/python", {"settings": SETTINGS})


def test_wire_partial_oversized_or_garbage_message_is_fault():
    for sent in (b"\x00\x00", struct.pack(">I", 1 << 31), struct.pack(">I", 3) + b"abc", struct.pack(">I", 1) + b"7"):
        ours, theirs = socket.socketpair()
        theirs.sendall(sent)
        theirs.close()
        with pytest.raises(WireError):
            Wire(ours).receive(1.0)
        ours.close()


@pytest.mark.slow
def test_lease_of_user_stack_stops_and_resumes_with_solver(solver):
    """A user's own stack stops when the solver is paused and goes on when the solver does."""
    solver.close()
    live = SolverProcess(sys.executable, {"settings": {**SETTINGS, "clock": "wall"}})
    street, lease, stopped = Street(), JsonLease(), 0

    def tick():
        status = street.status()
        answer = live.step({"status": status, "again": lease.expired}, street.give)
        if answer is not None:
            lease.renew(answer.get("directive"), live.late_ticks)
        order = lease.order
        done = bool(order.get("path")) and street.x > order["path"][-1]["x_m"] - 5.0
        at = (street.x, street.y)
        street.perform(lease.tick(*at, path_is_done=done, at_rest=status["speed_mps"] < 0.1))

    while street.x < 120.0 and street.time_s < 10 * LIMIT_S:
        tick()
        if live.late_ticks:
            # This street's time flies; a solver that lags behind gets its chance to answer.
            time.sleep(0.02)
        if stopped == 0 and street.directive["kind"] == "execute" and street.directive.get("path"):
            os.kill(live.process.pid, signal.SIGSTOP)
            for _ in range(100):
                stopped += 1
                tick()
            assert lease.expired
            os.kill(live.process.pid, signal.SIGCONT)
    assert stopped == 100
    assert street.x >= 120.0, live.fault
    live.close()


def _gone(pid):
    until = time.monotonic() + LIMIT_S
    while time.monotonic() < until:
        try:
            with open(f"/proc/{pid}/stat") as stat:
                if stat.read().rpartition(")")[2].split()[0] == "Z":
                    return True
        except OSError:
            return True
        time.sleep(0.1)
    return False


def test_process_answer_costs_simulated_time_of_its_clock():
    started = {}
    for clock in ("lockstep", "latency:2.8"):
        solver, street = SolverProcess(sys.executable, {"settings": {**SETTINGS, "clock": clock}}), Street()
        while street.directive["kind"] == "continue" and street.time_s < LIMIT_S:
            street.perform(solver.step({"status": street.status()}, street.give).get("directive"))
        started[clock] = street.time_s
        solver.close()
    assert started["latency:2.8"] - started["lockstep"] == pytest.approx(2.8, abs=0.3)
