"""By sensors, a stream much faster than the known limit is driven in at its own pace; with ground truth it is not."""

from __future__ import annotations

import carla
import pytest

from behavior_driver.fakes import FakeWorld
from behavior_driver.roads import straight_road
from behavior_driver.test_changing import RIGHT, Sensed
from behavior_driver.test_give_way import AT_THE_LINE, CAR, DT_S, LINE, WAIT_S, comers, way
from stucksolver_carla.drivers.behavior import BehaviorDriver, DriverOptions
from stucksolver_carla.drivers.behavior.acceleration_limits import USUAL, AccelerationLimits
from stucksolver_carla.drivers.behavior.conflict_paths import JunctionConflicts
from stucksolver_carla.drivers.behavior.flow_speed import TRACK_LOSS_S, PacedAccelerationLimits
from stucksolver_carla.drivers.behavior.junction_yield import EgoSpeeds, JunctionYield
from stucksolver_carla.drivers.behavior.local_planner import LocalPlanner
from stucksolver_carla.drivers.behavior.profiles import PROFILES
from stucksolver_carla.drivers.behavior.swept_path import Hazard

LIMITED_MPS = 7.5


def top_speed(behind_mps, sensed=True):
    world = FakeWorld(straight_road())
    ego = world.add_ego(80.0, RIGHT, 0.0, LIMITED_MPS)
    ego.speed_limit = 30.0
    if sensed:
        ego.perceiver = Sensed(world, ego)
    driver = BehaviorDriver(ego, "normal", DriverOptions(ignore_traffic_lights=True), world.map)
    driver.set_destination(carla.Location(390.0, RIGHT, 0.0))
    world.add("vehicle.a", 50.0, RIGHT, speed=behind_mps)
    fastest, nearest_m = 0.0, 30.0
    for _ in range(120):
        ego.apply_control(driver.run_step())
        world.tick()
        fastest = max(fastest, ego.speed)
        nearest_m = min(nearest_m, ego.x - world.actors[1].x)
    return fastest, nearest_m


def test_driver_fast_traffic_from_behind_does_not_hit_ego():
    """Traffic from behind, much faster than the limit, does not run into the ego."""
    fastest, nearest_m = top_speed(13.0)
    assert fastest == pytest.approx(13.0, abs=1.0)
    assert nearest_m > 7.0


@pytest.mark.parametrize(("behind_mps", "sensed"), [(8.5, True), (13.0, False)], ids=["little faster", "ground truth"])
def test_otherwise_it_keeps_to_its_limit(behind_mps, sensed):
    assert top_speed(behind_mps, sensed)[0] < LIMITED_MPS + 0.5


@pytest.mark.parametrize(("pace", "sensed", "flow"), [(16.0, True, 16.0), (8.5, True, 0.0), (16.0, False, 0.0)])
def test_yield_sensor_mode_much_faster_flow_sets_speed(pace, sensed, flow):
    """In sensor mode, a flow that is much faster than the limit is joined at its speed."""
    watch = JunctionYield([JunctionConflicts(WAIT_S, (way(joins=True),))], PROFILES["normal"], CAR, sensor_mode=sensed)
    watch.decide(LINE, AT_THE_LINE, EgoSpeeds(0.0, LIMITED_MPS), comers((10.0, pace)), DT_S)
    assert watch.flow_mps == flow


@pytest.mark.parametrize(
    ("kind", "least_m", "most_m"), [(PacedAccelerationLimits, 0.1, 0.3), (AccelerationLimits, 0.5, 1.0)]
)
def test_wait_aborted_start_ends_before_front_is_in_path(kind, least_m, most_m):
    """In sensor mode, an aborted start ends before the front is in the path."""
    profile = PROFILES["normal"]
    concerns = kind(profile, DriverOptions(), CAR, LocalPlanner(profile.lateral_accel, profile.deceleration))
    speed, gone_m = 1.0, 0.0
    for _ in range(200):
        speed = max(speed + concerns.wait(max(0.3 - gone_m, 0.0), speed) * DT_S, 0.0)
        gone_m += speed * DT_S
    assert least_m < gone_m < most_m


def in_a_stream(behind_mps=13.0, later_s=0.0):
    """In a stream of 13 m/s, with the follower last seen some time ago."""
    profile = PROFILES["normal"]
    planner = LocalPlanner(profile.lateral_accel, profile.deceleration)
    concerns = PacedAccelerationLimits(profile, DriverOptions(), CAR, planner)
    concerns.set_flow_speed(13.0, behind_mps, 30.0, DT_S)
    concerns.set_flow_speed(13.0, 0.0 if later_s else behind_mps, 30.0, later_s)
    concerns.cruise(LINE, 12.0, 30.0, "", USUAL)
    return concerns


@pytest.mark.parametrize("seen_mps", [13.0, 11.5], ids=["at its pace", "measured too low"])
def test_hazard_lead_in_flow_does_not_slow_ego(seen_mps):
    """In a traffic flow, the ego does not fall back behind its lead vehicle."""
    assert in_a_stream().hazard(Hazard(1, 9.0, seen_mps, False), 12.8) >= 0.0
    assert in_a_stream(0.0).hazard(Hazard(1, 9.0, seen_mps, False), 12.8) < -1.0


@pytest.mark.parametrize(("gap_m", "seen_mps"), [(4.0, 12.5), (9.0, 9.0)], ids=["too near", "surely slower"])
def test_hazard_near_or_braking_lead_in_flow_slows_ego(gap_m, seen_mps):
    """Behind a lead vehicle that is near or brakes, the ego falls back nevertheless."""
    assert in_a_stream().hazard(Hazard(1, gap_m, seen_mps, False), 12.8) < -1.0


@pytest.mark.parametrize(("later_s", "kept"), [(TRACK_LOSS_S / 2, True), (TRACK_LOSS_S + 0.1, False)])
def test_a_follower_may_be_lost_for_a_moment(later_s, kept):
    concerns = in_a_stream(later_s=later_s)
    assert (concerns.hazard(Hazard(1, 9.0, 13.0, False), 12.8) >= 0.0) is kept
