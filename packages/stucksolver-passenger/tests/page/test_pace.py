"""A simulation at the pace of the clock on the wall."""

from __future__ import annotations

import pytest

pytest.importorskip("carla")
from stucksolver_eval.passenger import RealTimePacer


class Clock:
    """Time passes while somebody sleeps, and while they work."""

    now_s = 5.0

    def __call__(self):
        return self.now_s

    def sleep(self, seconds):
        self.now_s += seconds


def beats(works_s):
    """When each tick begins, where each takes so long."""
    clock = Clock()
    pace, begun = RealTimePacer(0.05, clock, clock.sleep), []
    for work_s in works_s:
        pace.wait()
        begun.append(round(clock.now_s - 5.0, 6))
        clock.now_s += work_s
    return pace, begun


def test_ticks_that_are_quick_begin_on_the_beat():
    pace, begun = beats([0.01, 0.04, 0.0, 0.02])
    assert begun == [0.0, 0.05, 0.1, 0.15]
    assert (pace.ticks, pace.late) == (4, 0)


def test_a_little_behind_is_caught_up():
    pace, begun = beats([0.06, 0.01, 0.01])
    assert begun == [0.0, 0.06, 0.1]
    assert pace.late == 0


def test_a_late_tick_is_counted_and_the_beat_begins_anew():
    pace, begun = beats([0.2, 0.01, 0.01])
    assert begun == [0.0, 0.2, 0.25]
    assert pace.late == 1
    assert pace.worst_s == pytest.approx(0.15)
