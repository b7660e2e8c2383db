"""The baseline of timers: what it tries when, and that it stops when the car goes on."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

carla = pytest.importorskip("carla")

import numpy as np  # noqa: E402

from stucksolver_eval.systems.system_under_test import TickInfo  # noqa: E402
from stucksolver_eval.systems.timer_baseline import TimerSystem  # noqa: E402


class Driver:
    """Notes what it is told to drive; never gets anywhere."""

    def __init__(self) -> None:
        self.told: list[tuple[str, Any]] = []
        self.path_left_m = 10.0

    def run_step(self) -> str:
        return "control"

    def follow(self, path: list[Any], reverse: bool = False) -> None:
        self.told.append(("back" if reverse else "follow", path))

    def release(self) -> None:
        self.told.append(("release", None))


def street() -> Any:
    """100 m along x, lanes 3.5 m wide."""
    points = [
        SimpleNamespace(transform=carla.Transform(carla.Location(float(x), 0.0, 0.0)), lane_width=3.5)
        for x in range(100)
    ]
    return SimpleNamespace(waypoints=points, s_m=np.arange(100.0), project=lambda place: round(place.x))


def stand(seconds: float, moves_at_s: float = 1e9) -> tuple[TimerSystem, Driver]:
    ego = SimpleNamespace(
        get_transform=lambda: carla.Transform(carla.Location(10.0, 0.0, 0.0)),
        get_location=lambda: carla.Location(10.0, 0.0, 0.0),
    )
    driver = Driver()
    arm = TimerSystem(ego, driver, street())  # type: ignore[arg-type]
    for k in range(round(seconds / 0.05)):
        time_s = k * 0.05
        moving = time_s >= moves_at_s
        place_m = 10.0 + 5.0 * max(time_s - moves_at_s, 0.0)
        assert arm.step(TickInfo(time_s, 5.0 if moving else 0.0, place_m)) == "control"
    arm.close(seconds)
    return arm, driver


def test_timer_baseline_waits_reverses_then_overtakes_on_both_sides() -> None:
    """The baseline waits after 8 s, reverses after 15 s, and overtakes left after 30 s and right after 60 s."""
    arm, _ = stand(79.0)
    begun = [(i.rung, round(i.start_s)) for i in arm.log.interventions]
    assert begun == [("wait", 8), ("reverse", 15), ("overtake left", 30), ("overtake right", 60)]
    assert [i.moves for i in arm.log.interventions] == [False, True, True, True]


def test_an_action_that_gets_nowhere_is_given_up() -> None:
    arm, driver = stand(45.5)
    assert [what for what, _ in driver.told] == ["back", "release", "follow", "release"]
    assert arm.log.interventions[1].end_s == pytest.approx(30.0, abs=0.11)
    assert not arm.log.interventions[1].finished


def test_who_goes_on_by_himself_is_left_alone() -> None:
    arm, driver = stand(60.0, moves_at_s=7.0)
    assert (arm.log.interventions, driver.told) == ([], [])


def test_it_reverses_straight_back_and_overtakes_by_one_lane() -> None:
    _, driver = stand(31.0)
    back, left = driver.told[0][1], driver.told[2][1]
    assert [p.x_m for p in back] == [10.0, 9.0, 8.0, 7.0, 6.0, 5.0]
    assert (left[0].y_m, left[-1].y_m) == (pytest.approx(0.0), pytest.approx(0.0, abs=0.1))
    # CARLA's y grows to the right.
    assert min(p.y_m for p in left) == pytest.approx(-3.5)
