"""A call to stop is never lost: not to other words, to a busy reader, to a clock, or to another person."""

from __future__ import annotations

import threading
from typing import ClassVar

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from grids import each_value
from stucksolver import StuckSolver
from stucksolver.interpreter import ScriptedInterpreter
from stucksolver.plan import Execute, SafeStop
from stucksolver.scene import GuidanceIntent, LineKind
from stucksolver.solver import EventKind
from stucksolver.solver.workers.delivery_clock import Lockstep, WallClock, make_clock
from stucksolver.solver.workers.interpreter_worker import MOST_WAITING, InterpreterWorker
from worlds import READER, World, ladder, red_light, straight_road, thing

TWO_WAY = straight_road()
CLOCKS = ["lockstep", "latency:0.3", "latency:3", "latency:measured", "wall"]
SECOND = ["go", "please overtake", "what a lovely day", "yes", "back up", "that's only a bag", "blub"]
STOP = ["stop!", "STOP! You'll hit her!", "halt", "¡para!", "Hit the brakes!"]


class Known:
    """The shipped reader, with its readings kept; it may hang until it is let go."""

    name = READER.name
    kept: ClassVar[dict[tuple[str, str], object]] = {}

    def __init__(self, hangs=False):
        self.let = threading.Event()
        if not hangs:
            self.let.set()

    def read(self, text, situation):
        self.let.wait(30.0)
        key = (text, situation)
        if key not in self.kept:
            self.kept[key] = READER.read(text, situation)
        return self.kept[key]


class Ride:
    """A drive past a parked car; `say` speaks when the plan has run for a moment."""

    def __init__(self, clock="lockstep", reader=None, **more):
        self.world = World(TWO_WAY, [thing("lead", 100.0)], x=60.0)
        self.events, self.directives = [], []
        self.reader = reader or Known()
        self.solver = StuckSolver(
            self.world.scene, on_event=self.events.append, clock=clock, reader=self.reader, **more
        )

    def step(self):
        directive = self.solver.step(self.world.status(), self.world.surroundings)
        self.directives.append(directive)
        self.world.drive(directive)

    def until_begun(self):
        for _ in range(2000):
            self.step()
            if any(e.kind is EventKind.STARTED for e in self.events):
                return self
        raise AssertionError("no plan began")

    def steps(self, seconds):
        for _ in range(round(seconds / self.world.dt)):
            self.step()
        return self

    def times(self, kind):
        return [e.time_s for e in self.events if e.kind is kind]

    def withdrawn(self):
        return [e.text for e in self.events if e.kind is EventKind.ABORTED] == ["withdrawn"]

    def begun_since(self, time_s):
        return [t for t in self.times(EventKind.STARTED) if t > time_s]


@pytest.mark.parametrize(("other", "stop_comes_first"), each_value(SECOND, [True, False]))
def test_stop_and_other_words_in_one_tick_stop_wins(other, stop_comes_first):
    ride = Ride().until_begun()
    for words in ("stop!", other) if stop_comes_first else (other, "stop!"):
        ride.solver.guide(words)
    said_s = ride.world.time_s
    ride.steps(10.0)
    assert ride.withdrawn()
    assert not ride.begun_since(said_s)


@pytest.mark.parametrize(("stop", "clock"), each_value(STOP, CLOCKS))
def test_stop_is_acted_on_in_the_same_tick(stop, clock):
    """Whatever is still being read, and with a reader that never answers."""
    ride = Ride("lockstep").until_begun()
    reader = Known(hangs=True)
    ride.solver._reader = InterpreterWorker(reader, make_clock("wall") if clock == "lockstep" else make_clock(clock))
    if clock.startswith("latency:") and clock != "latency:measured":
        reader.let.set()  # a simulated world waits for its reader
    for words in ("go", "please overtake", "what a lovely day"):
        ride.solver.guide(words)
    ride.step()
    ride.solver.guide(stop)
    ride.step()
    assert ride.solver.state.activity.name.value == "monitoring" or ride.solver.state.activity.withdrawn
    assert isinstance(ride.directives[-1], Execute | SafeStop) and not getattr(ride.directives[-1], "path", ())
    said_s = ride.world.time_s
    reader.let.set()
    ride.steps(8.0)
    assert ride.withdrawn()
    assert not ride.begun_since(said_s)


@pytest.mark.parametrize(("ticks", "other"), each_value([1, 2, 10, 30], ["go", "please overtake", "yes, overtake it"]))
def test_stop_words_of_another_soon_after_do_not_undo_it(other, ticks):
    ride = Ride().until_begun()
    ride.solver.guide("stop!")
    for _ in range(ticks):
        ride.step()
    ride.solver.guide(other)
    said_s = ride.world.time_s
    ride.steps(10.0)
    assert ride.withdrawn() and not ride.begun_since(said_s)


@pytest.mark.integration
def test_stop_words_well_after_it_count_again():
    ride = Ride().until_begun()
    ride.solver.guide("stop!")
    ride.steps(4.0)
    ride.solver.guide("please overtake it now")
    said_s = ride.world.time_s
    ride.steps(10.0)
    assert ride.begun_since(said_s)


@pytest.mark.integration
@pytest.mark.parametrize(
    ("words", "other"),
    each_value(
        ["please don't do that", "nein, lieber nicht", "no, wait for him", "cancel"],
        ["what a lovely day", "go", "lovely weather, isn't it"],
    ),
)
def test_stop_that_only_the_network_knows_is_not_overwritten(words, other):
    ride = Ride().until_begun()
    for text in (words, other):
        ride.solver.guide(text)
    said_s = ride.world.time_s
    ride.steps(10.0)
    assert ride.withdrawn() and not ride.begun_since(said_s)


@pytest.mark.integration
@settings(max_examples=8, deadline=None)
@given(
    before=st.lists(st.sampled_from(SECOND), max_size=4),
    after=st.lists(st.sampled_from(SECOND), max_size=4),
    gaps=st.lists(st.integers(0, 3), min_size=9, max_size=9),
)
def test_stop_among_any_words_always_ends_the_plan(before, after, gaps):
    ride = Ride().until_begun()
    said_s = None
    for words, gap in zip([*before, "stop!", *after], gaps, strict=False):
        for _ in range(gap):
            ride.step()
        ride.solver.guide(words)
        said_s = ride.world.time_s if words == "stop!" else said_s
    ride.steps(8.0)
    assert said_s is not None
    assert not ride.begun_since(said_s)
    assert not any(isinstance(d, Execute) and d.path for d in ride.directives[-20:])


def test_utterances_are_interpreted_in_order():
    """All utterances are interpreted in the order in which they were made."""
    ride = Ride()
    texts = ["what a lovely day", "my mother says hello", "there is a shop", "mi hija tiene siete años"]
    for text in texts:
        ride.solver.guide(text)
    ride.steps(2.0)
    assert [e.text for e in ride.events if e.kind is EventKind.GUIDANCE] == texts


def test_words_said_from_many_threads_are_all_read():
    ride = Ride(reader=ScriptedInterpreter({}))
    talkers = [threading.Thread(target=ride.solver.guide, args=(f"talk {k}",)) for k in range(20)]
    for talker in talkers:
        talker.start()
    for talker in talkers:
        talker.join()
    ride.steps(3.0)
    heard = [e.text for e in ride.events if e.kind is EventKind.GUIDANCE]
    assert sorted(heard) == sorted(f"talk {k}" for k in range(20))


def test_words_a_flood_is_bounded_and_holds_the_vehicle():
    ride = Ride(reader=ScriptedInterpreter({})).until_begun()
    for k in range(500):
        ride.solver.guide(f"talk {k}")
    ride.solver.guide("stop!")
    ride.step()
    assert len(ride.solver._reader._waiting) <= MOST_WAITING
    ride.steps(8.0)
    assert ride.withdrawn()


# ---- two people


def asked(to, **more):
    """Drive until a person is asked. Returns the solver's world and the question."""
    world = World(straight_road(oncoming=None), controls=(red_light(3.0),), x=60.0, cruise_mps=0.0)
    events = []
    solver = StuckSolver(world.scene, clock="lockstep", on_event=events.append, reader=Known(), **more)
    solver.guide("that light has been broken for days")
    for _ in range(400):
        world.drive(solver.step(world.status(), world.surroundings))
        if solver.pending_question is not None:
            assert solver.pending_question.to == to
            return world, solver, events
    raise AssertionError("nobody was asked")


@pytest.mark.parametrize("ticks", [0, 1, 10])
@pytest.mark.parametrize("operator_is_first", [True, False])
def test_passenger_stop_wins_over_an_operators_yes(operator_is_first, ticks):
    world, solver, _ = asked("operator")

    def operator():
        if solver.pending_question is not None:
            solver.approve(solver.pending_question.id, by="operator")

    def passenger():
        solver.guide("stop!")

    for act in (operator, passenger) if operator_is_first else (passenger, operator):
        act()
        for _ in range(ticks):
            world.drive(solver.step(world.status(), world.surroundings))
    for _ in range(160):
        world.drive(solver.step(world.status(), world.surroundings))
    assert world.speed < 0.05
    assert world.x < 61.0


@pytest.mark.parametrize("no_comes_first", [True, False])
def test_two_replies_in_one_tick_the_no_wins(no_comes_first):
    world, solver, events = asked("operator")
    replies = [solver.deny, solver.approve] if no_comes_first else [solver.approve, solver.deny]
    for reply in replies:
        reply(by="operator")
    for _ in range(100):
        world.drive(solver.step(world.status(), world.surroundings))
    assert [e.answer for e in events if e.kind is EventKind.ANSWERED] == [False]
    assert EventKind.STARTED not in [e.kind for e in events]


@pytest.mark.parametrize("stop", ["stop!", None])
def test_operator_approval_with_passenger_stop_keeps_safe_stop(stop):
    """An operator's approval does not end the safe stop when a passenger calls a stop.

    The request for help stays open: the operator may approve again when no passenger calls a stop any more.
    """
    nobody = {"reasoner": {"tries": 1, "cooldown_s": 1.0}, "model": None, "passenger": None}
    closed = thing("wall", 66.0, 1.0, width=6.0, length=1.0)
    world, events = World(straight_road(oncoming=LineKind.SOLID), [closed]), []
    solver = StuckSolver(
        world.scene, clock="lockstep", ladder=ladder(rungs=nobody), on_event=events.append, reader=Known()
    )
    while solver.pending_question is None and world.time_s < 90.0:
        world.drive(solver.step(world.status(), world.surroundings))
    solver.approve(by="operator")
    if stop is not None:
        solver.guide(stop)
    for _ in range(20):
        world.drive(solver.step(world.status(), world.surroundings))
    assert (EventKind.RELEASED in [e.kind for e in events]) == (stop is None)
    assert (solver.pending_question is not None) == (stop is not None)


def test_yes_before_question_is_not_its_answer():
    """A yes that was said before a question was asked is not an answer to it."""
    _, solver, _ = asked("operator")
    assert solver.state.question is not None
    worker = InterpreterWorker(Known(), Lockstep())
    worker.take("yes", 0.0, 0.0, "")
    heard = worker.poll(0.0)
    assert heard is not None and heard.words.time_s < solver.state.question.time_s


def test_worker_alarm_overtakes_words_that_are_being_read():
    reader = Known(hangs=True)
    worker = InterpreterWorker(reader, WallClock())
    worker.take("please overtake", 0.0, 0.0, "")
    assert worker.poll(0.0) is None
    worker.take("stop!", 0.1, 0.1, "")
    heard = worker.poll(0.1)
    assert heard is not None and heard.words.text == "stop!"
    assert heard.words.reading is not None and heard.words.reading.intent is GuidanceIntent.WAIT
    reader.let.set()


def test_worker_request_to_get_out_follows_its_call_to_stop():
    worker = InterpreterWorker(Known(), Lockstep())
    worker.take("Stop! Let me out here, please.", 0.0, 0.0, "Driving, nothing in the way.")
    first, second = worker.poll(0.0), worker.poll(0.05)
    assert first is not None and first.words.reading.intent is GuidanceIntent.WAIT
    assert second is not None and second.words.reading.intent is GuidanceIntent.LET_ME_OUT
    assert worker.poll(0.1) is None and not worker.busy
