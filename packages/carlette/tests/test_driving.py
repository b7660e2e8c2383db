"""Vehicles accelerate, brake, turn and rest as real ones do."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from carlette.blueprints import load_catalog
from carlette.geometry import Rotation
from carlette.physics.vehicle_dynamics import ENGAGE_S, MANUAL
from carlette.world.spawn import spawn
from carlette.world.world import World
from straight import CAR, add, drive, launch, on_lane, speed_of, straight_world, ticks

KMH_50 = 50 / 3.6


def test_a_car_reaches_50_kmh_in_two_to_five_seconds() -> None:
    world = straight_world()
    car = add(world)
    drive(world, car, throttle=1.0)
    seconds = next(w.elapsed_s for w in ticks(world, 200) if speed_of(w, car) >= KMH_50)
    assert 2.0 < seconds < 5.0


def test_car_braking_from_50_kmh_stops_within_16_m() -> None:
    """A car stops from 50 km/h within 9 to 16 m."""
    world = straight_world()
    car = add(world)
    launch(world, car, KMH_50)
    drive(world, car, brake=1.0)
    for _ in ticks(world, 100):
        if speed_of(world, car) == 0.0:
            break
    assert 9.0 < world.pose(car).location.x - 50.0 < 16.0
    assert speed_of(world, car) == 0.0


def test_car_at_full_lock_turns_within_4_m_radius() -> None:
    """At full lock, a car turns on a radius of 3.8 m, with a tolerance of 0.4 m."""
    world = straight_world()
    car = add(world, x=500.0)
    world.fleet.constant[car.index], world.fleet.is_constant[car.index] = (3.0, 0.0, 0.0), True
    drive(world, car, steer=1.0)
    path = [world.pose(car).location[:2] for _ in ticks(world, 400)][40:]
    x, y = np.array(path).T
    assert (np.ptp(x) / 2, np.ptp(y) / 2) == pytest.approx((3.8, 3.8), abs=0.4)


def test_steering_right_turns_right() -> None:
    world = straight_world()
    car = add(world)
    drive(world, car, throttle=0.4, steer=0.3)
    list(ticks(world, 40))
    assert world.pose(car).rotation.yaw > 5.0
    assert world.bodies.angular[car.row, 2] > 0.0


@pytest.mark.integration
@given(st.floats(0, 1), st.floats(-1, 1), st.floats(0, 1), st.floats(0, 40))
@settings(max_examples=25)
def test_no_control_gives_impossible_accelerations(throttle: float, steer: float, brake: float, mps: float) -> None:
    world = straight_world()
    car = add(world, x=900.0)
    launch(world, car, mps)
    drive(world, car, throttle, steer, brake)
    for _ in ticks(world, 40):
        # 13 m/s² of grip sideways and twice that along; in tight turns the middle swings about the rear axle.
        assert np.hypot(*world.bodies.acceleration[car.row, :2]) < 32.0


def test_acceleration_is_the_change_of_velocity() -> None:
    world = straight_world()
    car = add(world)
    drive(world, car, throttle=0.7, steer=0.1)
    before = np.zeros(3)
    for _ in ticks(world, 60):
        velocity = world.bodies.velocity[car.row].copy()
        assert world.bodies.acceleration[car.row] == pytest.approx((velocity - before) / world.step_s)
        before = velocity


def test_reverse_drives_backwards_and_the_hand_brake_stops() -> None:
    world = straight_world()
    car = add(world, x=500.0)
    drive(world, car, throttle=0.5, reverse=1.0)
    list(ticks(world, 60))
    assert world.bodies.velocity[car.row, 0] < -2.0
    assert world.bodies.record["gear"][car.row] == -1
    drive(world, car, hand_brake=1.0)
    list(ticks(world, 100))
    assert speed_of(world, car) == 0.0


def test_without_throttle_a_car_rolls_out() -> None:
    world = straight_world()
    car = add(world)
    launch(world, car, 14.0)
    drive(world, car)
    list(ticks(world, 20))
    assert 10.0 < speed_of(world, car) < 12.0
    list(ticks(world, 300))
    assert speed_of(world, car) == 0.0


@pytest.mark.parametrize("slope", [-0.12, 0.0, 0.12])
def test_a_parked_car_stays_put_even_on_a_slope(slope: float) -> None:
    world = straight_world(slope)
    car = add(world, z=50 * slope)
    list(ticks(world, 100))
    assert world.pose(car).location.x == pytest.approx(50.0, abs=0.01)


def test_a_car_follows_the_slope_of_the_road() -> None:
    world = straight_world(slope=0.1)
    car = add(world, z=5.5)
    drive(world, car, throttle=0.5)
    list(ticks(world, 100))
    place, turn = world.pose(car)
    assert place.z == pytest.approx(0.1 * place.x, abs=0.01)
    assert turn.pitch == pytest.approx(math.degrees(math.atan(0.1)), abs=0.1)


def test_a_car_dropped_above_the_road_lands_on_it() -> None:
    world = straight_world()
    car = add(world, z=0.5)
    heights = [world.pose(car).location.z for _ in ticks(world, 20)]
    assert heights[0] > 0.4
    assert heights[-1] == 0.0
    assert heights == sorted(heights, reverse=True)


def test_a_staged_car_stays_below_the_ground() -> None:
    world = straight_world()
    car = add(world, z=-50.0)
    world.bodies.simulated[car.row] = False
    list(ticks(world, 50))
    assert world.pose(car).location.z == -50.0


def test_nan_pedals_mean_full_pedals() -> None:
    world = straight_world()
    car = add(world)
    launch(world, car, 10.0)
    drive(world, car, brake=math.nan)
    list(ticks(world, 60))
    assert speed_of(world, car) == 0.0
    assert world.bodies.record["pedals"][car.row].tolist() == [0.0, 0.0, 1.0]


@pytest.mark.integration
@pytest.mark.parametrize("type_id", sorted(load_catalog().vehicles))
def test_every_vehicle_drives_and_stops(type_id: str) -> None:
    world = straight_world()
    car = add(world, type_id)
    drive(world, car, throttle=1.0)
    list(ticks(world, 100))
    assert speed_of(world, car) > 4.0
    drive(world, car, brake=1.0)
    list(ticks(world, 150))
    assert speed_of(world, car) == 0.0


def test_constant_velocity_holds_against_the_pedals() -> None:
    world = straight_world()
    car = add(world)
    world.fleet.constant[car.index], world.fleet.is_constant[car.index] = (8.0, 0.0, 0.0), True
    drive(world, car, brake=1.0)
    list(ticks(world, 20))
    assert speed_of(world, car) == pytest.approx(8.0)


def test_two_cars_do_not_disturb_each_other() -> None:
    alone, both = straight_world(), straight_world()
    first, second = add(alone, CAR, 50.0), add(both, CAR, 50.0)
    other = add(both, CAR, 300.0)
    both.teleport(other, on_lane(300.0)._replace(rotation=Rotation(yaw=90.0)))
    for world, car in ((alone, first), (both, second)):
        drive(world, car, throttle=0.6, steer=0.02)
        list(ticks(world, 60))
    assert alone.pose(first) == both.pose(second)


def first_moves_s(world: World, car) -> float:
    """Seconds until a vehicle moves."""
    for tick in range(100):
        if speed_of(world, car) > 0.01:
            return tick * 0.05
        list(ticks(world, 1))
    return math.inf


def test_new_vehicle_engages_gear_at_first_throttle() -> None:
    """A new vehicle engages its gear at the first throttle and moves only after that delay."""
    world = straight_world()
    car = spawn(world, CAR, {}, on_lane(50.0))
    list(ticks(world, 40))  # time alone does not do it
    drive(world, car, throttle=1.0)
    assert first_moves_s(world, car) == pytest.approx(ENGAGE_S, abs=0.11)
    drive(world, car, brake=1.0)
    list(ticks(world, 40))
    drive(world, car, throttle=1.0)
    assert first_moves_s(world, car) == pytest.approx(0.05)


@pytest.mark.parametrize("by", [{"gear": 1.0}, {"reverse": 1.0}])
def test_new_vehicle_manual_or_reverse_is_in_gear_at_once(by: dict[str, float]) -> None:
    """With a manual gear or in reverse, a new vehicle is in gear at once."""
    world = straight_world()
    car = spawn(world, CAR, {}, on_lane(50.0))
    drive(world, car, throttle=1.0, reverse=by.get("reverse", 0.0))
    world.fleet.control[car.index, MANUAL:] = ("gear" in by, by.get("gear", 0.0))
    assert first_moves_s(world, car) == pytest.approx(0.05)
