"""Who may be in a junction of the demo town, and whom a red light keeps out of it."""

from __future__ import annotations

import itertools
import math
from types import SimpleNamespace
from typing import Any

import pytest

carla = pytest.importorskip("carla")

from carlette.maps import DEMO_TOWN  # noqa: E402
from stucksolver_eval.actors import LanePath  # noqa: E402
from stucksolver_eval.actors.cars import Car, SimulatedCars  # noqa: E402
from stucksolver_eval.actors.lane_path import JunctionSpan, StopOnPath  # noqa: E402

GREEN, RED = carla.TrafficLightState.Green, carla.TrafficLightState.Red


def car(number: int, lane: Any, light: Any) -> Car:
    """Stands 6 m before the end of a lane that a light governs."""
    line = StopOnPath(light, lane.transform.location.x, lane.transform.location.y)
    path = LanePath([lane.previous(6.0)[0]], stops={(lane.road_id, lane.lane_id): line})
    path.grow(60.0)
    return Car(SimpleNamespace(id=number, half_length_m=2.3), path, steering=None, wish_mps=8.0)  # type: ignore[arg-type]


def ways_that_meet() -> tuple[Any, Any]:
    """Last waypoints of two lanes that lead into one junction across one another."""
    town = carla.Map("demo_town", DEMO_TOWN.read_text(encoding="utf-8"))
    entries: dict[int, list[Any]] = {}
    for first, second in town.get_topology():
        if second.is_junction and not first.is_junction:
            lane = first.next_until_lane_end(1.0)[-1]
            entries.setdefault(second.junction_id, []).append(lane)
    pairs = (pair for lanes in entries.values() for pair in itertools.combinations(lanes, 2))
    return next(pair for pair in pairs if abs(math.sin(math.radians(turn_deg(*pair)))) > 0.9)


def turn_deg(one: Any, other: Any) -> float:
    return float(one.transform.rotation.yaw - other.transform.rotation.yaw)


def crossing_of(one: Car) -> JunctionSpan:
    return one.path.crossings[0]


def test_lane_claims_red_light_releases_claim_to_junction() -> None:
    """A car that a red light holds loses its claim to the junction, so that another car may enter."""
    here, there = ways_that_meet()
    light = SimpleNamespace(state=GREEN)
    first, second = car(1, here, light), car(2, there, SimpleNamespace(state=GREEN))
    cars = SimulatedCars(None, 0.05)  # type: ignore[arg-type]
    assert cars._stop_in(first, 0.0) is None
    assert cars._stop_in(second, 0.0) is not None, "their ways meet, and the first one was first"
    light.state = RED
    assert cars._stop_in(first, 0.0) is not None
    assert cars._stop_in(second, 0.0) is None
    light.state = GREEN
    assert cars._stop_in(first, 0.0) is not None, "now the second has it"
    cars.claims.release(second, crossing_of(second))
    assert cars._stop_in(first, 0.0) is None


def test_nobody_crosses_before_a_car_that_will_not_brake() -> None:
    here, there = ways_that_meet()
    flowing, waiting = car(1, here, SimpleNamespace(state=GREEN)), car(2, there, SimpleNamespace(state=GREEN))
    cars = SimulatedCars(None, 0.05)  # type: ignore[arg-type]
    flowing.constant, flowing.yields = True, False
    flowing.s = crossing_of(flowing).enter_s - 6.0 * flowing.wish_mps - 10.0
    cars._press_on(flowing)
    assert cars._stop_in(waiting, 0.0) is None, "it is still far away"
    cars.claims.release(waiting, crossing_of(waiting))
    flowing.s += 10.0
    cars._press_on(flowing)
    assert cars._stop_in(waiting, 0.0) is not None
    flowing.s = crossing_of(flowing).leave_s + 4.0
    cars._press_on(flowing)
    assert cars._stop_in(waiting, 0.0) is None, "it is past"
