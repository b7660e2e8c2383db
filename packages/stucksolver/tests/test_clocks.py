"""When an answer is delivered: counted in ticks, never in wall time."""

from __future__ import annotations

import math
import threading
import time
from concurrent.futures import Future

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stucksolver.guard import Guard
from stucksolver.ladder import PROFILES, profile
from stucksolver.plan import CONTINUE
from stucksolver.reasoners import SearchReasoner
from stucksolver.solver import EventKind, StuckSolver, make_clock
from stucksolver.solver.query import Query
from stucksolver.solver.workers.delivery_clock import Pending
from stucksolver.solver.workers.reasoner_pool import ReasonerPool
from stucksolver.solver.workers.reasoner_worker import ReasonerWorker
from worlds import World, straight_road, thing


class Patient:
    """Answers as the rules do, once it is let."""

    name = "patient"

    def __init__(self, *, let: bool = False, takes_s: float = 0.0) -> None:
        self.let = threading.Event()
        self.asked = threading.Event()
        self.takes_s = takes_s
        if let:
            self.let.set()

    def decide(self, request):
        self.asked.set()
        self.let.wait(20.0)
        time.sleep(self.takes_s)
        return SearchReasoner().decide(request)


def ticks_until_answered(clock: str, dt: float = 0.05, reasoner=None) -> int:
    """Polls from the question to the answer."""
    pool = ReasonerPool({"asked": reasoner or SearchReasoner()}, profile(PROFILES[0]).waits)
    worker = ReasonerWorker(pool, Guard(), make_clock(clock))
    scene = World(straight_road(), time_s=100.0).scene()
    worker.work_on(Query(1, "asked", scene, 100.0, 60.0, screen=False, outlived=frozenset(), seen=None, reading=None))
    try:
        for tick in range(1, 1000):
            if worker.poll(100.0 + tick * dt) is not None:
                return tick
    finally:
        worker.work_on(None)
    raise AssertionError("never answered")


def test_lockstep_answers_on_the_next_tick_however_long_it_thinks():
    assert ticks_until_answered("lockstep", reasoner=Patient(let=True, takes_s=0.2)) == 1


@pytest.mark.parametrize(("latency", "dt"), [(0.0, 0.05), (0.02, 0.05), (0.05, 0.05), (0.51, 0.05), (2.0, 0.1)])
def test_clock_latency_answers_after_its_ticks(latency, dt):
    """The answer arrives after as many ticks as the latency takes; the world goes on meanwhile."""
    assert ticks_until_answered(f"latency:{latency}", dt) == max(math.ceil(round(latency / dt, 6)), 1)


@given(latency=st.floats(0.0, 10.0), dt=st.sampled_from([0.01, 0.05, 0.1]))
def test_latency_is_never_shorter_and_at_most_a_tick_longer(latency, dt):
    clock, answer = make_clock(f"latency:{latency!r}"), Future()
    answer.set_result(None)
    query = Pending(asked_s=3.0, asked_wall_s=0.0)
    tick = next(k for k in range(1, 2000) if clock.due(query, 3.0 + k * dt, answer))
    assert tick * dt >= latency - 2e-6
    assert (tick - 1) * dt < latency or tick == 1


def test_measured_charges_at_least_the_ticks_that_the_thinking_took():
    """A busy machine's thinking takes longer, and is charged more: only the least is known."""
    assert ticks_until_answered("latency:measured", reasoner=Patient(let=True, takes_s=0.22)) >= 5


@pytest.mark.parametrize(("took_s", "dt", "ticks"), [(0.22, 0.05, 5), (0.2, 0.05, 4), (0.001, 0.05, 1), (3.0, 0.1, 30)])
def test_measured_charges_as_many_ticks_as_the_answer_took(took_s, dt, ticks):
    clock, answer = make_clock("latency:measured"), Future()
    answer.set_result(None)
    query = Pending(asked_s=0.0, asked_wall_s=0.0, took_s=took_s)
    for tick in range(1, 1000):
        query.ticks = tick
        if clock.due(query, tick * dt, answer):
            break
    # The sum of the world's steps is rounded: one more tick where the time is a whole number of them.
    assert tick - ticks in ((0, 1) if math.isclose(took_s / dt, ticks) else (0,))


def test_measured_answers_quick_thoughts_at_once():
    assert ticks_until_answered("latency:measured", dt=10.0) == 1


def test_wall_never_waits_for_a_slow_reasoner():
    slow = Patient()
    world = World(straight_road(), [thing("car", 60.0)])
    told = []
    with StuckSolver(world.scene, reasoner=slow, clock="wall", on_event=told.append) as solver:
        for _ in range(100):
            assert solver.step(world.status(), world.surroundings) is CONTINUE
            world.drive(CONTINUE)
        assert slow.asked.wait(60.0)
        assert {e.kind for e in told} == {EventKind.TRIGGERED}
        slow.let.set()
        waited = 0
        while EventKind.DECIDED not in [e.kind for e in told] and waited < 6000:
            time.sleep(0.01)
            waited += 1
            solver.step(world.status(), world.surroundings)
        assert EventKind.STARTED in [e.kind for e in told]


def test_clock_of_solver_is_wall_by_default():
    with StuckSolver(World(straight_road()).scene) as solver:
        assert solver.clock.name == "wall"


@pytest.mark.parametrize("text", ["", "lock step", "latency", "latency:", "latency:abc", "latency:-1", "wall:1"])
def test_make_clock_unknown_name_is_rejected_with_choices(text):
    with pytest.raises(ValueError, match="lockstep, latency:SECONDS, latency:measured or wall"):
        make_clock(text)


@pytest.mark.parametrize("text", ["latency:nan", "latency:inf"])
def test_a_latency_that_never_ends_is_refused(text):
    with pytest.raises(ValueError, match="latency"):
        make_clock(text)


@pytest.mark.parametrize("text", ["lockstep", "wall", "latency:measured", "latency:0.5", "latency:2"])
def test_a_clock_is_named_as_it_was_asked_for(text):
    assert make_clock(text).name == text
