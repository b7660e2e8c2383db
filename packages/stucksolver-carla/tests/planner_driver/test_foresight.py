"""Braking for whom the ego is about to meet, and for nobody else."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("carla")

from stucksolver_carla.drivers.behavior.nearby_objects import NearbyObjects
from stucksolver_carla.drivers.behavior.path import PlanarPose, make_path
from stucksolver_carla.drivers.behavior.predictive_braking import TurnRates, allowed_acceleration
from stucksolver_carla.drivers.behavior.route_bodies import objects_on_route
from stucksolver_carla.drivers.behavior.vehicle_model import VehicleModel

MODEL = VehicleModel(2.4, 1.0, 2.9, 1.2)
LINE = make_path(np.arange(0.0, 300.0), np.zeros(300), np.full(300, 30.0))


def one(x, y, vx, vy):
    """A car that drives where it points."""
    return NearbyObjects(
        actor_id=(7,),
        is_walker=np.zeros(1, np.bool_),
        x=np.array([x]),
        y=np.array([y]),
        yaw=np.array([np.arctan2(vy, vx)]),
        half_length=np.array([2.4]),
        half_width=np.array([0.95]),
        bottom=np.zeros(1),
        top=np.full(1, 1.5),
        vx=np.array([vx]),
        vy=np.array([vy]),
    )


def allowed(around, speed=8.0, wished=1.0, turning=0.0):
    where = LINE.project(PlanarPose(50.0, 0.0, 0.0))
    return allowed_acceleration(
        LINE, where, speed, wished, objects_on_route(LINE, 50.0, around), around, np.array([turning]), MODEL
    )


def test_foresight_brakes_for_vehicle_entering_path_from_side() -> None:
    assert allowed(one(65.0, -16.0, 0.0, 8.0)) < -1.0


@pytest.mark.parametrize("around", [one(65.0, -40.0, 0.0, 8.0), one(80.0, -3.5, -10.0, 0.0), one(50.0, 3.5, 8.0, 0.0)])
def test_it_does_not_brake_for_who_will_be_elsewhere(around) -> None:
    assert allowed(around) == 1.0


def test_who_turns_into_the_lane_beside_is_not_braked_for() -> None:
    """It comes towards the ego's lane now, and less and less so."""
    around = one(52.0, -6.5, 7.0, 4.0)
    assert allowed(around, turning=-0.5) == 1.0


@pytest.mark.parametrize("speed", [0.3, 0.8])
def test_one_that_hardly_moves_stops_for_good(speed) -> None:
    assert allowed(one(53.5, -9.0, 0.0, 6.0), speed) <= -2.0


def test_turn_rates_are_those_of_the_courses() -> None:
    rates, course, found = TurnRates(), 0.2, np.zeros(1)
    for _ in range(40):
        course += 0.4 * 0.05
        found = rates.observe(one(0.0, 0.0, 8.0 * np.cos(course), 8.0 * np.sin(course)), 0.05)
    assert found[0] == pytest.approx(0.4, abs=0.01)
