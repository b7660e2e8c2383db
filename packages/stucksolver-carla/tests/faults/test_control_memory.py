"""A light that was seen is remembered until its line is behind: what has vanished is unknown, and so red."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stucksolver.guard import Approvals, Guard, RejectCode
from stucksolver.plan.behaviors import AbortAction, BackUp, Creep, KeepLane
from stucksolver.record import Recorder, replay
from stucksolver.scene import ControlKind, LightState, TrafficControl
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.solver import EventKind
from stucksolver.solver.surroundings_monitor import SurroundingsMonitor
from worlds import World, drive, red_light, straight_road, stubborn, thing

ROAD = straight_road()
GUARD = Guard()
ON = KeepLane(distance_m=40.0, speed_mps=5.5)
FRONT_M = 4.9 / 2
LINE_X = 70.0
S = LightState
SIGN = TrafficControl(kind=ControlKind.STOP_SIGN, distance_m=0.0, applies=True)


class Street:
    """A stack that shows its lights as it is told to, and a solver's senses that look at it, now and then or often."""

    def __init__(self, x=60.0, speed=0.0, every_s=0.6):
        self.world, self.senses, self.now_s, self.every_s = (
            World(ROAD, x=x, speed=speed),
            SurroundingsMonitor(),
            0.0,
            every_s,
        )

    def look(self, *states, x=None, line_x=LINE_X, speed=None, controls=None, **more):
        """One look at a line with a light for each of the states, or with these controls."""
        self.now_s = round(self.now_s + self.every_s, 6)
        world = self.world
        world.x, world.speed = world.x if x is None else x, world.speed if speed is None else speed
        away_m = line_x - world.x - FRONT_M
        given = controls if controls is not None else [red_light(away_m, state, **more) for state in states]
        world.controls = tuple(given)
        world.frame, world.time_s = world.frame + 1, self.now_s
        self.seen = self.senses.look(world.surroundings, self.now_s)
        return self.seen

    def codes(self, *behaviors, **more):
        return set(GUARD.accept(behaviors or (ON,), FrenetScene(self.seen), False, **more)[0].codes)


@pytest.mark.parametrize("before", [S.RED, S.YELLOW, S.GREEN, S.OFF, S.UNKNOWN, None])
@pytest.mark.parametrize("gone", [1, 5, 100])
def test_light_that_vanishes_is_unknown_and_is_not_passed(before, gone):
    street = Street()
    street.look(before)
    for _ in range(gone):
        street.look()
    assert [(c.kind, c.state) for c in street.seen.controls] == [(ControlKind.TRAFFIC_LIGHT, S.UNKNOWN)]
    assert street.seen.controls[0].distance_m == pytest.approx(LINE_X - 60.0 - FRONT_M)
    assert RejectCode.RED_LIGHT in street.codes()


@pytest.mark.parametrize("after", list(S))
def test_light_that_comes_back_is_what_it_shows(after):
    street = Street()
    for states in ((S.RED,), (), (), (after,)):
        street.look(*states)
    assert [c.state for c in street.seen.controls] == [after]
    assert (RejectCode.RED_LIGHT in street.codes()) is (after not in (S.GREEN, S.OFF))


@pytest.mark.integration
@given(
    shows=st.lists(st.sampled_from([None, *S]), min_size=1, max_size=20),
    steps=st.lists(st.floats(-1.0, 1.4), min_size=20, max_size=20),
    jitter=st.lists(st.floats(-0.4, 0.4), min_size=20, max_size=20),
)
def test_line_ahead_is_passed_only_with_green_light_visible(shows, steps, jitter):
    """No line ahead is passed unless its light is perceived as green now.

    The light is visible, lost and visible again while the ego drives to and fro, over the line and back.
    """
    street, x, was_seen = Street(x=55.0), 55.0, False
    for state, step, off in zip(shows, steps, jitter, strict=False):
        x += step
        ahead_m = LINE_X - x - FRONT_M
        shown = () if state is None else (state,)
        street.look(*shown, x=x, line_x=LINE_X + off, speed=0.0)
        was_seen |= state is not None
        if was_seen and ahead_m - 0.4 > 0.5 and state not in (S.GREEN, S.OFF):
            assert RejectCode.RED_LIGHT in street.codes()
        if state is S.GREEN:
            assert RejectCode.RED_LIGHT not in street.codes()


def test_red_light_lost_during_plan_ends_plan():
    """A red light that is lost while a plan runs toward it ends the plan.

    It was green when the plan began, and is lost where the ego can still stop.
    """
    street = Street(x=50.0)
    street.look(S.GREEN)
    proven = GUARD.accept([ON], FrenetScene(street.seen), False)[1]
    street.look(S.GREEN, x=54.0, speed=4.0)
    assert GUARD.recheck(proven, FrenetScene(street.seen)).accepted
    street.look(x=55.0, speed=4.5)
    verdict = GUARD.recheck(proven, FrenetScene(street.seen))
    assert set(verdict.codes) == {RejectCode.RED_LIGHT} and verdict.abort is AbortAction.STOP


@pytest.mark.parametrize("speed", [0.6, 2.0, 4.0, 5.5])
@pytest.mark.parametrize("last_seen_m", [0.6, 0.05])
def test_green_light_that_the_front_has_passed_ends_no_plan(speed, last_seen_m):
    """Many stacks stop to report a line as soon as the front is over it."""
    street = Street(x=50.0)
    street.look(S.GREEN)
    plan = ON.model_copy(update={"speed_mps": max(speed, 0.6)})
    proven = GUARD.accept([plan], FrenetScene(street.seen), False)[1]
    street.look(S.GREEN, x=LINE_X - FRONT_M - last_seen_m, speed=speed)
    for past_m in (0.01, 0.5, 0.99, 2.0):
        street.look(x=LINE_X - FRONT_M + past_m, speed=speed)
        assert GUARD.recheck(proven, FrenetScene(street.seen)).accepted


def test_line_that_the_ego_backs_over_is_ahead_again():
    street = Street(x=LINE_X - FRONT_M - 1.0)
    street.look(S.GREEN)
    for x in (LINE_X - 1.0, LINE_X + 3.0, LINE_X + 1.0):
        street.look(x=x)
        assert RejectCode.RED_LIGHT not in street.codes()
    street.look(x=LINE_X - FRONT_M - 2.0)
    assert RejectCode.RED_LIGHT in street.codes()
    assert RejectCode.RED_LIGHT not in street.codes(BackUp(distance_m=3.0))
    street.look(S.GREEN)
    assert RejectCode.RED_LIGHT not in street.codes()


@pytest.mark.parametrize(("beyond_m", "known"), [(40.0, True), (80.0, True), (95.0, False)])
def test_line_that_is_well_behind_is_forgotten(beyond_m, known):
    """The longest way back does not lead over a line that was forgotten."""
    street = Street(x=60.0)
    street.look(S.RED)
    street.look(x=LINE_X + beyond_m)
    street.look(x=60.0)
    assert [control.state for control in street.seen.controls] == ([S.UNKNOWN] if known else [])


@pytest.mark.parametrize("order", [(S.RED, S.GREEN), (S.GREEN, S.RED)])
def test_lights_lost_at_one_line_count_as_strictest(order):
    """Of several lights at a line, the strictest counts when they are lost."""
    street = Street()
    street.look(*order)
    assert RejectCode.RED_LIGHT in street.codes()
    street.look(S.GREEN)
    assert RejectCode.RED_LIGHT in street.codes()
    street.look(S.GREEN, S.GREEN)
    assert RejectCode.RED_LIGHT not in street.codes()


def test_lights_of_a_line_that_agreed_speak_for_each_other():
    """One of two heads is out of the camera's picture when both turn green: nobody waits for it for ever."""
    street = Street()
    street.look(S.RED, S.RED)
    street.look(S.GREEN)
    assert [c.state for c in street.seen.controls] == [S.GREEN] and street.codes() == set()


def test_two_lines_are_not_taken_for_one():
    street = Street()
    both = [red_light(6.0, S.RED), red_light(12.0, S.GREEN)]
    street.look(controls=both)
    street.look(controls=both[1:])
    assert [(c.distance_m, c.state) for c in street.seen.controls] == [(pytest.approx(6.0), S.UNKNOWN), (12.0, S.GREEN)]


@pytest.mark.parametrize("first_m", [88.0, 80.0, 73.0])
def test_line_seen_from_afar_may_lie_a_bit_elsewhere(first_m):
    """A distance is known less well from afar: the light that is seen nearer is the same one."""
    street = Street(x=10.0)
    street.look(S.RED, line_x=LINE_X + 0.09 * (LINE_X - 10.0 - FRONT_M))
    street.look(S.GREEN, x=LINE_X - 12.0)
    assert [c.state for c in street.seen.controls] == [S.GREEN]


def test_stop_sign_that_vanishes_still_stands_there():
    street = Street(x=60.0, speed=0.5)
    street.look(controls=[SIGN.model_copy(update={"distance_m": LINE_X - 60.0 - FRONT_M})])
    street.look()
    assert [c.kind for c in street.seen.controls] == [ControlKind.STOP_SIGN]
    assert RejectCode.STOP_LINE in street.codes()


@pytest.mark.parametrize("state", [None, S.UNKNOWN])
def test_map_light_without_state_is_red_from_start(state):
    """A light of the map without a state is red from the start."""
    street = Street()
    street.look(state)
    assert street.codes() == {RejectCode.RED_LIGHT}
    approved = Approvals(operator=frozenset({"red_light"}))
    assert street.codes(Creep(distance_m=15.0), approvals=approved) == set()


def test_dark_light_that_vanishes_is_no_all_way_stop():
    street = Street(x=LINE_X - FRONT_M - 1.0)
    street.look(S.OFF)
    slow = KeepLane(distance_m=20.0, speed_mps=2.0)
    assert street.codes(slow) == set()
    street.look()
    assert street.codes(slow) == {RejectCode.RED_LIGHT}


def test_lost_light_for_others_is_not_waited_for():
    """A light that applies only to others is not waited for when it is lost."""
    street = Street()
    street.look(S.RED, applies=False)
    street.look()
    assert street.codes() == set()


def test_surroundings_that_fail_for_a_moment_keep_the_lost_light():
    street = Street()
    street.look(S.RED)
    street.look()
    seen = street.senses.look(lambda: None, street.now_s + 0.1)
    assert [c.state for c in seen.controls] == [S.UNKNOWN]


def test_place_that_jumps_leaves_no_line_elsewhere():
    street = Street(x=60.0, speed=1.0, every_s=0.1)
    street.look(S.GREEN)
    for x in (63.5, 60.2):
        street.look(controls=[red_light(7.3, S.GREEN)], x=x)
    for _ in range(8):
        street.look(S.GREEN)
    assert [c.state for c in street.seen.controls] == [S.GREEN]


class Flickering(World):
    """A world whose red light is seen for half a second, and then lost for two."""

    def surroundings(self):
        shown = self.frame % 50 < 10
        self.controls = (red_light(LINE_X - self.x - FRONT_M),) if shown else ()
        return super().surroundings()


@pytest.mark.integration
def test_solver_passes_no_red_light_that_flickers(tmp_path):
    """The whole drive, and its record derived again: what the guard saw is in it."""
    world = Flickering(ROAD, [thing("lead", 80.0, hazard=True)], x=63.0, cruise_mps=0.0)
    with Recorder(tmp_path) as recorder:
        told = drive(world, 40.0, ladder=stubborn(), record=recorder)
    assert world.x + FRONT_M < LINE_X
    assert any("red light" in text for text in told.texts(EventKind.DECIDED)), told.events
    assert recorder.files and all(replay(file).matches for file in recorder.files)
