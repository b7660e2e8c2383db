"""Sensors, positions and clocks that fail: the vehicle stays safe, and the fault is told."""

from __future__ import annotations

import base64
import itertools
import math

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from stucksolver import CONTINUE, StuckSolver
from stucksolver.guard import RejectCode
from stucksolver.plan import Execute
from stucksolver.scene import CameraImage, ObjectKind
from stucksolver.solver import EventKind
from stucksolver.solver.camera_health import CameraHealth
from stucksolver.solver.monotonic_time import MonotonicTime
from stucksolver.solver.surroundings_monitor import HOLD_S, SAME_S, SurroundingsMonitor
from worlds import LANE_M, World, drive, ladder, red_light, straight_road, stubborn, thing

TWO_WAY = straight_road()


def stuck(**more):
    return World(TWO_WAY, [thing("lead", 75.0)], x=66.0, **more)


def spoiled(world, seconds, spoil, **options):
    """Drives with surroundings that went through `spoil`, which may give None."""
    told, directives, nearest = [], [], math.inf
    options = {"ladder": stubborn(), **options}
    with StuckSolver(world.scene, clock="lockstep", on_event=told.append, **options) as solver:
        for _ in range(round(seconds / world.dt)):
            directive = solver.step(world.status(), lambda: spoil(world))
            directives.append(directive)
            world.drive(directive)
            nearest = min(nearest, world.clearance())
    return told, directives, nearest


def texts(events, kind):
    return [e.text for e in events if e.kind is kind]


def driving(world):
    return world.speed > 0.5


# ---- missing, frozen, black


def test_without_any_surroundings_no_plan_is_started():
    told, directives, _ = spoiled(stuck(), 10.0, lambda world: None)
    assert set(map(type, directives)) == {type(CONTINUE)}
    assert "there are no surroundings" in texts(told, EventKind.FAULT)


def test_without_a_scene_nobody_is_asked():
    told, world = [], stuck()
    with StuckSolver(lambda surroundings: None, clock="lockstep", on_event=told.append) as solver:
        for _ in range(200):
            assert solver.step(world.status(), world.surroundings) is CONTINUE
            world.drive(CONTINUE)
    assert "the stack has no scene to give" in texts(told, EventKind.FAILED)[0]


@pytest.mark.integration
@pytest.mark.parametrize("fault", ["missing", "frozen"])
def test_surroundings_missing_or_frozen_before_commit_point_end_plan(fault):
    """Surroundings that stop arriving before the commit point end the plan."""
    last = []

    def stops_coming(world):
        if world.speed < 0.3 or not last:
            last[:] = [world.surroundings()]
        return None if fault == "missing" and world.speed >= 0.3 else last[0]

    told, _, nearest = spoiled(stuck(), 12.0, stops_coming)
    assert RejectCode.STALE.value in texts(told, EventKind.ABORTED)[0]
    assert nearest > 0.3
    words = {"missing": "there are no surroundings", "frozen": "the same frame for 0.5 s"}[fault]
    assert words in texts(told, EventKind.FAULT)


def test_monitor_restamped_old_frames_grow_old_while_driving():
    """A sensor that gives old frames new time stamps is detected while the ego drives."""
    senses, world = SurroundingsMonitor(), stuck(speed=5.0)
    old = world.surroundings()
    ages = []
    for k in range(20):
        now = 0.05 * k
        ages.append(senses.look(lambda k=k: old.model_copy(update={"frame": k, "time_s": 0.05 * k}), now).age_s)
    assert ages[0] == 0.0
    assert ages[-1] == pytest.approx(0.95)


@pytest.mark.integration
def test_a_slow_sensor_is_no_frozen_one():
    """Ten frames a second for a loop of twenty ticks."""
    kept = []

    def half_as_often(world):
        if world.frame % 2 == 0 or not kept:
            kept[:] = [world.surroundings()]
        return kept[0]

    told, _, _ = spoiled(stuck(), 25.0, half_as_often)
    assert EventKind.RECOVERED in [e.kind for e in told]
    assert EventKind.FAULT not in [e.kind for e in told]


@pytest.mark.integration
def test_a_plan_does_not_run_for_ever_on_nothing():
    seen = []

    def blind_once_committed(world):
        if world.y < 2.5 and not seen:
            return world.surroundings()
        seen.append(world.time_s)
        return None

    told, directives, _ = spoiled(stuck(), 40.0, blind_once_committed)
    assert "nothing has been seen for 5 s" in texts(told, EventKind.ABORTED)
    assert directives[-1] is CONTINUE


def at_a_red_light():
    """Behind a car that is the first at a red light. A light is waited for up to three minutes."""
    return stuck(controls=(red_light(15.0),))


def test_stale_surroundings_request_assistance_despite_red_light():
    """After a long time without new surroundings, assistance is requested, whatever was perceived last.

    The light has long been green then.
    """
    kept = []

    def grows_old(world):
        if world.time_s < 5.0 or not kept:
            kept[:] = [world.surroundings()]
        new = kept[0].model_copy(update={"frame": world.frame, "time_s": world.time_s})
        wrong = ("the LiDAR seems turned by 2.0 degrees to the left",) if world.time_s >= 5.0 else ()
        return new.model_copy(update={"age_s": world.time_s - kept[0].time_s, "sensor_faults": wrong})

    asks = ladder(rungs={"model": None, "passenger": None})
    told, _, _ = spoiled(at_a_red_light(), 60.0, grows_old, ladder=asks)
    call = next(e for e in told if e.kind is EventKind.ASKED)
    assert "the sensors have shown nothing new for" in call.text
    assert "(the LiDAR seems turned by 2.0 degrees to the left)" in call.text
    assert texts(told, EventKind.FAULT) == ["the LiDAR seems turned by 2.0 degrees to the left"]
    assert call.time_s < 45.0


def test_who_sees_a_red_light_waits_for_it():
    asks = ladder(rungs={"model": None, "passenger": None})
    told, _, _ = spoiled(at_a_red_light(), 60.0, lambda world: world.surroundings(), ladder=asks)
    assert EventKind.ASKED not in [e.kind for e in told]
    assert EventKind.DECIDED in [e.kind for e in told]


def jpeg(size):
    return CameraImage(width=640, height=360, jpeg=base64.b64encode(b"\xff" * size))


def test_a_black_image_is_left_out_of_the_scene():
    watch, scene = CameraHealth(), stuck().scene()
    bright = scene.model_copy(update={"image": jpeg(30_000)})
    black = scene.model_copy(update={"image": jpeg(640 * 360 // 64)})
    assert watch.checked(bright, 0.0) == (bright, None)
    assert watch.checked(black, 0.0) == (scene, "the camera image shows nothing")


def test_camera_health_detects_frozen_image_after_motion():
    """A frozen image is detected when the vehicle has moved."""
    watch, scene = CameraHealth(), stuck().scene().model_copy(update={"image": jpeg(30_000)})
    assert watch.checked(scene, 10.0)[1] is None
    assert watch.checked(scene, 10.2)[1] is None
    assert watch.checked(scene, 12.0) == (scene.model_copy(update={"image": None}), "the camera image is frozen")


@pytest.mark.integration
def test_a_black_camera_does_not_keep_the_rules_from_helping():
    world = stuck()
    scene = world.scene
    world.scene = lambda surroundings=None: scene(surroundings).model_copy(update={"image": jpeg(100)})
    seen = drive(world, 25.0)
    assert EventKind.RECOVERED in seen.kinds()
    assert "the camera image shows nothing" in seen.texts(EventKind.FAULT)
    assert all(e.scene.image is None for e in seen.events if e.scene)


# ---- flickering


@pytest.mark.integration
@pytest.mark.parametrize("phase", [0, *(pytest.param(item, marks=pytest.mark.release) for item in (1, 2, 3))])
def test_a_flickering_oncoming_car_is_never_met(phase):
    """Seen on every fourth tick only."""
    cars = [thing(f"car{k}", 130.0 + 40.0 * k, LANE_M, speed=-9.0) for k in range(4)]
    world = World(TWO_WAY, [thing("lead", 75.0), *cars], x=66.0, sight_m=500.0)

    def flickers(world):
        seen = world.surroundings()
        if world.frame % 4 == phase:
            return seen
        return seen.model_copy(update={"objects": tuple(o for o in seen.objects if o.id == "lead")})

    told, _, nearest = spoiled(world, 45.0, flickers)
    assert nearest > 0.3
    assert EventKind.RECOVERED in [e.kind for e in told]


@example(gone=[False] * 3 + [True] * 10)
@given(gone=st.lists(st.booleans(), min_size=3, max_size=60))
def test_monitor_keeps_lost_object_for_limited_time(gone):
    """A lost object is kept for a second where it must be, and no longer."""
    senses, now, last = SurroundingsMonitor(), 0.0, None
    world = World(TWO_WAY, [thing("car", 100.0, LANE_M, speed=-8.0)])
    for k, missing in enumerate(gone):
        now = 0.1 * k
        seen = world.surroundings()
        missing = missing and last is not None
        if missing:
            seen = seen.model_copy(update={"objects": ()})
        else:
            last = now
        shown = {o.id: o for o in senses.look(lambda seen=seen: seen, now).objects}
        assert ("car" in shown) == (now - last <= HOLD_S + SAME_S)
        if "car" in shown:
            assert shown["car"].x_m == pytest.approx(world.objects[0].x_m, abs=1e-6)
        world.dt = 0.1
        world.drive(CONTINUE)


@pytest.mark.parametrize(("kind", "sd_m", "kept"), [("car", None, True), ("car", 0.2, False), ("bicycle", 0.2, True)])
def test_monitor_keeps_ended_track_only_of_vulnerable_kind(kind, sd_m, kept):
    """An object whose track has ended is kept only if it is a vulnerable road user."""
    one = thing("it", 100.0, LANE_M, kind=ObjectKind(kind), speed=3.0).model_copy(update={"position_sd_m": sd_m})
    seen, senses = World(TWO_WAY, [one, thing("other", 80.0)]).surroundings(), SurroundingsMonitor()
    senses.look(lambda: seen, 0.0)
    later = seen.model_copy(update={"objects": seen.objects[1:], "frame": seen.frame + 1, "time_s": seen.time_s + 0.1})
    shown = senses.look(lambda: later, 0.1)
    assert ("it" in {o.id for o in shown.objects}) is kept


# ---- a position that jumps


@pytest.mark.integration
@pytest.mark.parametrize("by", [(3.0, 0.0), (-3.0, 0.0), (0.0, 3.0), (0.0, -3.0)])
def test_position_jump_of_3_m_before_commit_point_ends_plan(by):
    state = {"jumped": False}

    def jumps(world):
        seen = world.surroundings()
        state["jumped"] |= world.speed > 0.5
        if not state["jumped"] or world.time_s > 8.0:
            return seen
        ego = seen.ego.model_copy(update={"x_m": seen.ego.x_m + by[0], "y_m": seen.ego.y_m + by[1]})
        return seen.model_copy(update={"ego": ego})

    told, _, nearest = spoiled(stuck(), 25.0, jumps)
    assert "the position jumped" in texts(told, EventKind.FAULT)
    assert texts(told, EventKind.ABORTED)
    assert nearest > 0.3


def test_driving_fast_is_no_jump():
    senses, world = SurroundingsMonitor(), World(TWO_WAY, speed=30.0, cruise_mps=30.0)
    for _ in range(100):
        assert senses.look(world.surroundings, world.time_s).age_s == 0.0
        world.drive(CONTINUE)


# ---- clocks


def jumping(jump_s, when_s):
    """Drives past a parked car with a clock that jumps; what was told, and how it was driven."""
    world, told, driven = stuck(), [], []
    with StuckSolver(world.scene, clock="latency:0.5", on_event=told.append) as solver:
        for k in range(400):
            status = world.status()
            late = status.time_s + (jump_s if k * world.dt >= when_s else 0.0)
            directive = solver.step(status.model_copy(update={"time_s": late}), world.surroundings)
            world.drive(directive)
            driven.append(round(world.x, 9))
    return told, driven


@pytest.fixture(scope="module")
def undisturbed():
    return jumping(0.0, 0.0)[1]


@pytest.mark.integration
@pytest.mark.parametrize(("jump_s", "when_s"), [(-1000.0, 3.0), (-3.0, 0.5), (5.0, 3.0), (3600.0, 1.2)])
def test_a_clock_that_jumps_leaves_the_plan_as_it_was(jump_s, when_s, undisturbed):
    told, driven = jumping(jump_s, when_s)
    assert f"the clock jumped by {jump_s + 0.05:.2f} s" in texts(told, EventKind.FAULT)
    assert EventKind.RECOVERED in [e.kind for e in told]
    # No more is lost than the one tick of which nobody knows how long it was.
    assert driven[-1] == pytest.approx(undisturbed[-1], abs=1.0)


@given(steps=st.lists(st.one_of(st.floats(0.0, 0.2), st.floats(-1e6, 1e6)), max_size=50))
def test_the_solvers_own_time_never_runs_back_nor_leaps(steps):
    timeline, now, own = MonotonicTime(), 100.0, []
    status = stuck().status()
    for step in steps:
        now += step
        own.append(timeline.follow(status.model_copy(update={"time_s": now})).time_s)
    gaps = [b - a for a, b in itertools.pairwise(own)]
    assert all(-1e-6 <= gap <= 2.0 + 1e-6 for gap in gaps)


def test_events_keep_the_stacks_own_time_after_a_jump():
    world, told = stuck(), []
    with StuckSolver(world.scene, clock="lockstep", on_event=told.append) as solver:
        for k in range(100):
            status = world.status()
            shifted = status.model_copy(update={"time_s": status.time_s + (1e5 if k > 5 else 0.0)})
            world.drive(solver.step(shifted, world.surroundings))
    assert min(e.time_s for e in told if e.kind is not EventKind.FAULT) > 1e5
    assert any(isinstance(e.time_s, float) for e in told)
    assert not any(isinstance(e, Execute) for e in told)
