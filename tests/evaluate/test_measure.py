"""What is measured of a run: standing still, and the time to recover."""

from __future__ import annotations

import pytest

from stucksolver.scene import Status
from stucksolver_eval.measure import BLOCKED_S, Measures

DT = 0.05


def told(time_s: float, speed: float, progress: float, there: bool = False) -> Status:
    return Status(time_s=time_s, speed_mps=speed, progress_m=progress, at_destination=there)


class Trip:
    """A ride of stretches at constant speed, measured tick by tick."""

    def __init__(self, length_m: float = 200.0, start_m: float = 40.0) -> None:
        self.measures = Measures(length_m=length_m, start_m=start_m)
        self.time_s, self.place_m = 7.0, start_m
        self.measures.update(told(self.time_s, 8.0, self.place_m))

    def go(self, seconds: float, speed: float) -> Trip:
        for _ in range(round(seconds / DT)):
            self.time_s += DT
            self.place_m += speed * DT
            self.measures.update(told(self.time_s, speed, self.place_m))
        return self


def test_standing_is_below_0_1_mps_and_the_present_spell_is_known():
    trip = Trip().go(5, 8).go(12, 0).go(3, 8).go(4, 0.05).go(2, 0.2)
    assert trip.measures.standing_s == pytest.approx(16.0, abs=1e-6)
    assert trip.measures.standing_run_s == 0.0
    assert trip.go(6, 0).measures.standing_run_s == pytest.approx(6.0, abs=1e-6)


def test_a_run_is_blocked_after_60_s_of_standing_in_one_spell():
    trip = Trip().go(5, 8).go(59.9, 0)
    assert trip.measures.standing_run_s < BLOCKED_S == 60.0
    assert trip.go(0.2, 0).measures.standing_run_s > BLOCKED_S
    assert Trip().go(40, 0).go(1, 2).go(40, 0).measures.standing_run_s < BLOCKED_S


def test_a_stuck_span_reaches_from_the_onset_to_the_last_tick_of_it():
    trip = Trip().go(5, 8).go(10, 0).go(10, 8)
    assert trip.measures.stuck == [pytest.approx((12.05, 22.0), abs=0.06)]
    assert trip.measures.immobilizations == 1


def test_each_spell_is_a_span_of_its_own():
    spans = Trip().go(5, 8).go(10, 0).go(10, 8).go(6, 0).go(5, 8).measures.stuck
    assert [round(b - a) for a, b in spans] == [10, 6]


def test_a_stop_shorter_than_the_dwell_is_no_immobilization():
    measures = Trip().go(5, 8).go(0.9, 0).go(5, 8).measures
    assert (measures.stuck, measures.immobilizations, measures.recovery_times_s) == ([], 0, [])


def test_the_time_to_recover_is_from_the_onset_to_15_m_of_new_progress():
    measures = Trip().go(5, 8).go(10, 0).go(1.8, 8).measures
    assert measures.recovery_times_s == []
    measures = Trip().go(5, 8).go(10, 0).go(2.0, 8).measures
    assert measures.recovery_times_s == [pytest.approx(10.0 + 15.0 / 8.0, abs=0.11)]


def test_who_creeps_on_and_stands_again_within_15_m_has_one_immobilization():
    measures = Trip().go(5, 8).go(10, 0).go(1, 8).go(10, 0).go(4, 8).measures
    assert measures.immobilizations == 1
    assert measures.recovery_times_s == [pytest.approx(10 + 1 + 10 + 7 / 8, abs=0.11)]


def test_two_recoveries_are_two():
    measures = Trip(length_m=400).go(5, 8).go(10, 0).go(5, 8).go(20, 0).go(5, 8).measures
    assert measures.immobilizations == 2
    assert measures.recovery_times_s == [pytest.approx(11.9, abs=0.11), pytest.approx(21.9, abs=0.11)]


def test_who_never_gets_on_never_recovers():
    measures = Trip().go(5, 8).go(70, 0).measures
    assert (measures.immobilizations, measures.recovery_times_s) == (1, [])


def test_completion_is_the_share_of_the_route_and_100_only_there():
    trip = Trip(length_m=200.0).go(10, 8)
    assert trip.measures.completion_pct == pytest.approx(40.0, abs=0.5)
    trip.measures.update(told(trip.time_s + DT, 3.0, trip.place_m, there=True))
    assert trip.measures.completion_pct == 100.0
    assert Measures(length_m=10.0, start_m=0.0).completion_pct == 0.0
