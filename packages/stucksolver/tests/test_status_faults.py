"""What a status or a clock gets wrong is one event and one line of the log, and the vehicle is left to its driver."""

from __future__ import annotations

import itertools
import logging
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stucksolver import CONTINUE, StuckSolver
from stucksolver.plan import Execute
from stucksolver.record import Recorder, replay
from stucksolver.scene import Status
from stucksolver.solver import EventKind
from stucksolver.solver.monotonic_time import LONGEST_TICK_S, STUCK_TICKS, MonotonicTime
from worlds import World, ladder, straight_road, stubborn, thing

ROAD = straight_road()
HOSTILE = {
    "time_s": [math.nan, math.inf, -math.inf, 1e300, "now", None, True, [0.0], 10**400, object()],
    "speed_mps": [math.nan, math.inf, -math.inf, -1.0, -50.0, 1e9, "fast", None, False, (1.0,), 10**400, object()],
    "progress_m": [math.nan, math.inf, -math.inf, 1e200, "far", None, True, {}, -(10**400), object()],
    "pushes": [None, 1, 0, "no", math.nan, object()],
    "at_destination": [None, 1, 0, "no", math.nan, object()],
}
EVERY = [(field, value) for field, values in HOSTILE.items() for value in values]


class Raises:
    """Raises at whatever it is asked."""

    def __getattribute__(self, name):
        raise RuntimeError("never read me")


def stuck():
    return World(ROAD, [thing("lead", 60.0)])


def driven(spoil, seconds=12.0, world=None, **options):
    """Drives with statuses that went through `spoil(status, tick)`; what was told, ordered and the clearance."""
    world, told, orders = world or stuck(), [], []
    options = {"ladder": stubborn(), "clock": "lockstep", **options}
    with StuckSolver(world.scene, on_event=told.append, **options) as solver:
        for tick in range(round(seconds / world.dt)):
            directive = solver.step(spoil(world.status(), tick), world.surroundings)
            orders.append(directive)
            world.drive(directive)
    return told, orders, world


def faults(events):
    return [event.text for event in events if event.kind is EventKind.FAULT]


def lines(caplog):
    return [record.getMessage() for record in caplog.records if record.levelno >= logging.WARNING]


# ---- every status is wrong


@pytest.mark.parametrize(("field", "value"), EVERY, ids=[f"{field}-{str(value)[:8]}" for field, value in EVERY])
def test_step_status_field_wrong_from_the_start_is_reported_once(field, value, caplog):
    told, orders, _ = driven(lambda status, tick: status.model_copy(update={field: value}), 4.0)
    assert len(faults(told)) == 1 and [event.kind for event in told] == [EventKind.FAULT]
    assert lines(caplog) == faults(told)
    assert faults(told)[0].startswith(f"status.{field} is ") and "; give" in faults(told)[0]
    assert "\n" not in faults(told)[0] and len(faults(told)[0]) < 300
    assert set(orders) == {CONTINUE}


@pytest.mark.parametrize("what", [None, 7, "status", {"time_s": 0.0}, [], Status, Raises], ids=str)
def test_step_no_status_at_all_is_reported_once(what, caplog):
    told, orders, _ = driven(lambda status, tick: what() if what is Raises else what, 4.0)
    assert len(faults(told)) == 1 == len(lines(caplog)) and "give a Status" in faults(told)[0]
    assert set(orders) == {CONTINUE}


@pytest.mark.parametrize("field", HOSTILE)
def test_step_status_without_a_field_is_reported_once(field):
    def lacking(status, tick):
        del status.__dict__[field]
        return status

    told, orders, _ = driven(lacking, 4.0)
    assert len(faults(told)) == 1 and f"status.{field} is missing" in faults(told)[0] and set(orders) == {CONTINUE}


@pytest.mark.integration
@pytest.mark.parametrize("period", [2, 3, 7])
def test_step_status_that_flickers_is_reported_once(period):
    """A fault that comes and goes on single ticks is one fault, and the vehicle is helped in between."""

    def flickers(status, tick):
        return status.model_copy(update={"progress_m": math.nan}) if tick % period == 0 else status

    told, _, world = driven(flickers, 40.0)
    assert len(faults(told)) == 1
    assert EventKind.RECOVERED in [event.kind for event in told] and world.clearance() > 0.3


def test_step_two_fields_wrong_in_turn_are_two_reports():
    def both(status, tick):
        return status.model_copy(update={("speed_mps", "progress_m")[tick // 20 % 2]: math.nan})

    told, orders, _ = driven(both, 8.0)
    assert len(faults(told)) == 2 and set(orders) == {CONTINUE}


# ---- a plan is under way


@pytest.mark.integration
@pytest.mark.parametrize("field", ["time_s", "speed_mps", "progress_m"])
def test_step_status_lost_in_plan_ends_it_and_releases_vehicle(field, tmp_path):
    """A running plan is monitored for a while without a status.

    Then it ends, and the record replays all of it.
    """
    begun = []

    def lost(status, tick):
        if status.speed_mps > 1.0:
            begun.append(tick)
        return status.model_copy(update={field: math.nan}) if begun else status

    world = World(ROAD, [thing("lead", 75.0)], x=66.0)
    world.drive = slowed(world)
    with Recorder(tmp_path) as recorder:
        told, orders, world = driven(lost, 40.0, world, record=recorder)
    assert any(isinstance(order, Execute) for order in orders)
    assert orders[-1] is CONTINUE and world.clearance() > 0.3
    assert len([text for text in faults(told) if text.startswith("status.")]) == 1
    reports = [replay(path) for path in recorder.files]
    assert reports and all(report.matches for report in reports)


def slowed(world):
    """A world whose vehicle waits on the way: it drives on every fourth tick only."""
    drive, ticks = World.drive, itertools.count()

    def now_and_then(directive):
        if next(ticks) % 4 == 0 or not isinstance(directive, Execute):
            drive(world, directive)
        else:
            world.time_s, world.frame = world.time_s + world.dt, world.frame + 1

    return now_and_then


@pytest.mark.integration
@pytest.mark.parametrize("field", ["time_s", "speed_mps"])
def test_step_status_lost_for_6_s_is_one_report(field):
    """Six seconds without a status are one report and no jump of the clock.

    The vehicle is then helped in the same time as before.
    """

    def lost(status, tick):
        return status.model_copy(update={field: math.nan}) if 30 <= tick < 150 else status

    told, _, _ = driven(lost, 40.0)
    assert len(faults(told)) == 1 and faults(told)[0].startswith(f"status.{field} ")
    assert EventKind.RECOVERED in [event.kind for event in told]


def test_step_status_lost_begins_no_plan_not_even_by_words():
    def lost(status, tick):
        return status if tick < 40 else status.model_copy(update={"speed_mps": math.nan})

    world, told, orders = stuck(), [], []
    with StuckSolver(world.scene, on_event=told.append, ladder=stubborn(), clock="latency:3") as solver:
        for tick in range(400):
            if tick in (30, 60):
                solver.guide("please overtake this car on the left")
            orders.append(solver.step(lost(world.status(), tick), world.surroundings))
            world.drive(CONTINUE)
    assert EventKind.STARTED not in [event.kind for event in told] and set(orders) == {CONTINUE}


# ---- clocks


CLOCKS = {
    "does not advance": lambda tick: 5.0,
    "stands at nought": lambda tick: 0.0,
    "hardly goes": lambda tick: 5.0 + 1e-9 * tick,
    "runs backward": lambda tick: 1000.0 - 0.05 * tick,
    "runs far backwards": lambda tick: 1e6 - 7.0 * tick,
    "milliseconds": lambda tick: 50.0 * tick,
    "nanoseconds": lambda tick: 5e7 * tick,
    "two clocks in turn": lambda tick: 0.05 * tick + (1e5 if tick % 2 else 0.0),
}


@pytest.mark.parametrize("clock", CLOCKS)
def test_step_clock_that_does_not_run_is_reported_once(clock, caplog):
    told, orders, _ = driven(
        lambda status, tick: status.model_copy(update={"time_s": CLOCKS[clock](tick)}), 10.0, ladder=ladder()
    )
    assert len(faults(told)) == 1 and lines(caplog) == faults(told)
    assert faults(told)[0].startswith("status.time_s ") and "give the time of each tick in seconds" in faults(told)[0]
    assert set(orders) == {CONTINUE}
    assert EventKind.STARTED not in [event.kind for event in told]


@pytest.mark.integration
def test_step_clock_paused_and_resumed_still_recovers():
    """A clock that pauses and runs again does not prevent a recovery.

    A simulation is paused while its loop goes on.
    """
    world, told = stuck(), []
    with StuckSolver(world.scene, on_event=told.append, ladder=stubborn(), clock="lockstep") as solver:
        for tick in range(800):
            directive = solver.step(world.status(), world.surroundings)
            if not 10 <= tick < 10 + 2 * STUCK_TICKS:
                world.drive(directive)
    assert len(faults(told)) == 1 and faults(told)[0].startswith("status.time_s does not advance")
    assert EventKind.RECOVERED in [event.kind for event in told]


@pytest.mark.integration
def test_step_clock_that_stands_during_a_plan_frees_the_vehicle():
    begun = []

    def stops(status, tick):
        if status.speed_mps > 1.0:
            begun.append(status.time_s)
        return status.model_copy(update={"time_s": begun[0]}) if begun else status

    _, orders, world = driven(stops, 40.0, World(ROAD, [thing("lead", 75.0)], x=66.0))
    assert any(isinstance(order, Execute) for order in orders) and orders[-1] is CONTINUE
    assert world.clearance() > 0.3


@given(
    steps=st.lists(
        st.one_of(st.floats(0.0, 0.2), st.floats(-1e6, 1e6), st.none(), st.just(0.0)), min_size=1, max_size=80
    )
)
def test_timeline_own_time_is_continuous_with_missing_times(steps):
    """None is a tick without a time."""
    timeline, now, own = MonotonicTime(), 100.0, []
    for step in steps:
        if step is None:
            timeline.pass_on()
        else:
            now += step
            timeline.take(now)
        own.append(timeline.now_s)
    own = [item for item in own if item is not None]
    assert all(-1e-6 <= b - a <= LONGEST_TICK_S + 1e-6 for a, b in itertools.pairwise(own))


def test_timeline_high_rate_loop_is_no_fault():
    timeline = MonotonicTime()
    for tick in range(10_000):
        timeline.take(1e-4 * tick)
        assert timeline.fault is None and timeline.jump_s is None


# ---- surroundings that are late


LATE = {
    "surroundings.age_s": lambda surroundings: surroundings.model_copy(update={"age_s": 11.0}),
    "surroundings.age_s is": lambda surroundings: surroundings.model_copy(
        update={"age_s": 0.6 + 0.1 * (surroundings.frame % 7)}
    ),
    "surroundings.time_s": lambda surroundings: surroundings.model_copy(update={"time_s": surroundings.time_s - 11.0}),
    "surroundings.time_s is": lambda surroundings: surroundings.model_copy(
        update={"time_s": surroundings.time_s + 11.0}
    ),
    "surroundings.time_s is ": lambda surroundings: surroundings.model_copy(
        update={"time_s": 0.3 * surroundings.time_s - 1.0}
    ),
    "surroundings.frame": lambda surroundings: surroundings.model_copy(update={"frame": 7}),
}


@pytest.mark.integration
@pytest.mark.parametrize("field", LATE)
def test_step_surroundings_late_are_one_event_and_no_plan(field, caplog):
    world, told, orders = stuck(), [], []
    lead = world.objects[0].model_copy(update={"vx_mps": 0.0})
    walker = thing("walker", 120.0, -8.0, speed=0.8)
    world.objects[:] = [lead, walker]
    with StuckSolver(world.scene, on_event=told.append, ladder=stubborn(), clock="lockstep") as solver:
        for _ in range(500):
            orders.append(solver.step(world.status(), lambda: LATE[field](world.surroundings())))
            world.drive(orders[-1])
    assert len(faults(told)) == 1 and lines(caplog) == faults(told)
    assert faults(told)[0].startswith(field.strip()) and "give" in faults(told)[0]
    # A frame number can only be found out after a while: what began until then stops.
    begun = [k for k, order in enumerate(orders) if order is not CONTINUE]
    assert not begun or (field == "surroundings.frame" and begun[-1] - begun[0] < 5.0 / world.dt)
    assert set(orders[-200:]) == {CONTINUE} and world.clearance() > 0.3


def test_step_surroundings_with_a_stated_age_are_no_fault():
    """Data that are 0.3 s old, and say so in both ways, are used."""
    world, told = stuck(), []
    with StuckSolver(world.scene, on_event=told.append, ladder=stubborn(), clock="lockstep") as solver:
        for _ in range(600):

            def late():
                seen = world.surroundings()
                return seen.model_copy(update={"time_s": seen.time_s - 0.3, "age_s": 0.3})

            world.drive(solver.step(world.status(), late))
    assert not faults(told) and EventKind.RECOVERED in [event.kind for event in told]


def test_step_surroundings_stamped_late_without_an_age_are_aged():
    """A stamp that is 1 s behind is an age of 1 s, also where no age is given: nothing begins."""
    world, told = stuck(), []
    with StuckSolver(world.scene, on_event=told.append, ladder=stubborn(), clock="lockstep") as solver:
        for _ in range(400):
            late = world.surroundings().model_copy(update={"time_s": world.time_s - 1.0})
            assert solver.step(world.status(), lambda late=late: late) is CONTINUE
            world.drive(CONTINUE)
    assert len(faults(told)) == 1


class Unspeakable(Exception):
    """An error whose own text raises."""

    def __str__(self):
        raise ValueError("not even this")

    __repr__ = __str__


@pytest.mark.parametrize("part", ["surroundings", "scene", "listener"])
def test_step_errors_without_a_text_do_not_get_through(part):
    world, told = stuck(), []

    def broken(*_):
        raise Unspeakable

    on_event = broken if part == "listener" else told.append
    if part != "listener":
        setattr(world, part, broken)
    with StuckSolver(world.scene, on_event=on_event, ladder=stubborn(), clock="lockstep") as solver:
        for _ in range(200):
            world.drive(solver.step(world.status(), world.surroundings))
    assert part == "listener" or any("cannot be read" in event.text for event in told)


@pytest.mark.parametrize("scene", [None, 7, "scene", {}, Raises], ids=str)
def test_step_no_scene_at_all_is_no_answer(scene):
    world, told = stuck(), []
    with StuckSolver(
        lambda surroundings: scene() if scene is Raises else scene,
        on_event=told.append,
        ladder=stubborn(),
        clock="lockstep",
    ) as solver:
        for _ in range(200):
            assert solver.step(world.status(), world.surroundings) is CONTINUE
            world.drive(CONTINUE)
    assert EventKind.FAILED in [event.kind for event in told]
