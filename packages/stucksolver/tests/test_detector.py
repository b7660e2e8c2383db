"""When the detector says that the vehicle is immobilized, and when it holds its tongue."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stucksolver.immobilization import Detector, DetectorSettings, Trigger
from stucksolver.scene import LineKind, Status
from stucksolver.solver import EventKind
from worlds import World, drive, straight_road

DT = 0.05
SLOW = 4.9 / 3.6
FAST = 5.1 / 3.6


def feed(detector, speeds, *, start_s=0.0, start_m=0.0, at_destination=False):
    """Triggers for a speed at each tick; progress follows the speed."""
    answers, at = [], start_m
    for k, speed in enumerate(speeds):
        at += speed * DT
        now = round(start_s + k * DT, 6)
        answers.append(
            detector.update(Status(time_s=now, speed_mps=speed, progress_m=at, at_destination=at_destination))
        )
    return answers


def test_detector_below_5_kmh_for_1_s_fires():
    """The detector fires after 1 s below 5 km/h, on that tick and on each later one."""
    answers = feed(Detector(), [SLOW] * 40)
    assert answers[:20] == [None] * 20
    assert set(answers[20:]) == {Trigger.SPEED}


def test_just_above_5_km_per_hour_is_driving():
    assert set(feed(Detector(), [FAST] * 2000)) == {None}


def test_a_moment_at_speed_starts_the_second_anew():
    assert set(feed(Detector(), ([SLOW] * 19 + [FAST]) * 10)) == {None}


def test_the_onset_is_where_the_slow_spell_began():
    detector = Detector()
    feed(detector, [FAST] * 10 + [0.0] * 30)
    assert detector.slow_since_s == pytest.approx(10 * DT)
    feed(detector, [FAST], start_s=2.0)
    assert detector.slow_since_s is None


def test_at_the_destination_standing_is_right():
    detector = Detector()
    assert set(feed(detector, [0.0] * 1000, at_destination=True)) == {None}
    assert detector.slow_since_s is None


def circling(detector, seconds, gained_m, speed=3.0):
    """Driving at speed while the route progresses by so much altogether."""
    ticks = round(seconds / DT)
    return [
        detector.update(Status(time_s=round(k * DT, 6), speed_mps=speed, progress_m=gained_m * k / ticks))
        for k in range(ticks)
    ]


def test_detector_progress_below_5_m_in_20_s_fires():
    """Less than 5 m of progress in 20 s counts as immobilized even while the ego moves."""
    answers = circling(Detector(), 30.0, gained_m=30.0 * 4.5 / 20.0)
    first = answers.index(Trigger.PROGRESS)
    assert 19.0 <= first * DT <= 21.0
    assert set(answers[first:]) == {Trigger.PROGRESS}


def test_5_m_in_20_s_is_progress_enough():
    assert set(circling(Detector(), 60.0, gained_m=60.0 * 5.5 / 20.0)) == {None}


def test_leaving_a_red_light_is_no_lack_of_progress():
    detector = Detector()
    feed(detector, [0.0] * 1200)
    assert set(feed(detector, [FAST] * 400, start_s=60.0)) == {None}


def test_circling_after_a_standstill_is_noticed_a_window_later():
    detector = Detector()
    feed(detector, [0.0] * 600)
    answers = [detector.update(Status(time_s=30.0 + k * DT, speed_mps=3.0, progress_m=0.001 * k)) for k in range(1000)]
    assert answers[100] is None
    assert answers[-1] is Trigger.PROGRESS


def test_detector_forget_restarts_both_windows():
    """After `forget`, the detector needs a whole second and a whole progress window again."""
    detector = Detector()
    feed(detector, [0.0] * 1000)
    detector.forget()
    assert detector.progress_in_window_m is None
    answers = feed(detector, [0.0] * 30, start_s=50.0)
    assert answers[:20] == [None] * 20
    assert answers[20] is Trigger.SPEED


@pytest.mark.integration
@given(speeds=st.lists(st.floats(FAST, 30.0), min_size=1, max_size=600))
def test_a_vehicle_at_speed_on_its_route_never_triggers(speeds):
    assert set(feed(Detector(), speeds)) == {None}


@given(bound=st.floats(0.1, 5.0), dwell=st.floats(0.1, 3.0))
def test_the_settings_move_the_bounds(bound, dwell):
    detector = Detector(DetectorSettings(v_min_mps=bound, dwell_s=dwell))
    answers = feed(detector, [bound * 0.99] * 80)
    first = answers.index(Trigger.SPEED)
    assert dwell - 1e-6 <= first * DT <= dwell + DT + 1e-6
    assert Trigger.SPEED not in feed(Detector(DetectorSettings(v_min_mps=bound, dwell_s=dwell)), [bound * 1.01] * 80)


@pytest.mark.parametrize("name", ["v_min_mps", "dwell_s", "progress_m", "progress_window_s"])
@pytest.mark.parametrize("value", [0.0, -1.0, float("nan")])
def test_settings_that_make_no_sense_are_refused_by_name(name, value):
    with pytest.raises(ValueError, match=name):
        DetectorSettings(**{name: value})


def creeps(**options):
    """What reasoners decide about a vehicle that drives at 7 km/h on a free road."""
    world = World(straight_road(left=LineKind.BROKEN), speed=7.0 / 3.6, cruise_mps=7.0 / 3.6)
    return [event for event in drive(world, 6.0, **options).events if event.kind is EventKind.DECIDED]


def test_detector_default_settings_leave_a_creeping_vehicle_alone():
    assert creeps() == []


def test_detector_settings_decide_what_reasoners_call_immobilized():
    """One definition for detector and reasoner: with a threshold of 10 km/h, 7 km/h is not "moving along the route"."""
    first = creeps(detector=DetectorSettings(v_min_mps=10.0 / 3.6))[0]
    moving = next(step for step in first.decision.analysis.steps if step.id == "S2.3")
    assert (moving.answer, first.decision.analysis.immobilized) == (False, True)
    assert first.scene.ego.immobilized_below_mps == pytest.approx(10.0 / 3.6)
