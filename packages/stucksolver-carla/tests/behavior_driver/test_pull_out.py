"""Out of a place at the roadside: round what stands ahead, and when nobody comes."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

from stucksolver_carla.drivers.behavior.nearby_objects import NearbyObjects
from stucksolver_carla.drivers.behavior.path import PlanarPose, make_path
from stucksolver_carla.drivers.behavior.pull_out import (
    GAP_S,
    MIN_GAP_S,
    accepted_gap_s,
    find_pull_out_path,
    is_traffic_approaching,
)
from stucksolver_carla.drivers.behavior.route_line import rejoining_length, rejoining_path
from stucksolver_carla.drivers.behavior.vehicle_model import VehicleModel

CAR = VehicleModel(half_length=2.45, half_width=1.0, wheelbase=2.9, wheel_lock=1.2)
S = np.arange(0.0, 200.0)
LANE = make_path(S, np.zeros(200), np.full(200, 14.0))
BESIDE_M = 3.0
AT_M = 60.0


def cars(*places):
    """(x, y, speed along x) of cars."""
    x, y, speed = np.array(places, dtype=float).reshape(-1, 3).T
    zeros = np.zeros(len(x))
    return NearbyObjects(
        actor_id=tuple(range(len(x))),
        is_walker=np.zeros(len(x), dtype=bool),
        x=x,
        y=y,
        yaw=zeros,
        half_length=zeros + 2.3,
        half_width=zeros + 0.95,
        bottom=zeros,
        top=zeros + 1.5,
        vx=speed,
        vy=zeros,
    )


def way_out(around):
    gentle = rejoining_length(BESIDE_M, 0.0)
    pose = PlanarPose(AT_M, BESIDE_M, 0.0)
    return gentle, find_pull_out_path(lambda m: rejoining_path(LANE, AT_M, BESIDE_M, m), gentle, pose, around, CAR)


def back_after_m(way):
    return float(way.x[np.flatnonzero(np.abs(way.y) > 0.02)[-1]]) - AT_M


def test_pull_out_path_is_tight_only_behind_parked_car():
    """Without a vehicle ahead, the path is gentle; close behind a parked car, it is tight."""
    gentle, free = way_out(cars())
    _, tight = way_out(cars((AT_M + 9.0, BESIDE_M, 0.0)))
    assert back_after_m(free) == pytest.approx(gentle, abs=1.5)
    assert back_after_m(tight) < back_after_m(free) - 0.5


def test_wedged_in_there_is_no_way():
    assert way_out(cars((AT_M + 5.0, BESIDE_M, 0.0)))[1] is None


@pytest.mark.parametrize("speed", [5.0, 13.0])
def test_whoever_comes_within_the_time_gap_is_waited_for(speed):
    bumper_to_bumper = 2.45 + 2.3
    near = cars((AT_M - bumper_to_bumper - (GAP_S - 0.3) * speed, 0.0, speed))
    far = cars((AT_M - bumper_to_bumper - (GAP_S + 0.7) * speed, 0.0, speed))
    assert is_traffic_approaching(LANE, AT_M, 0.0, near, CAR)
    assert not is_traffic_approaching(LANE, AT_M, 0.0, far, CAR)


def test_pull_out_waits_only_for_vehicle_alongside():
    """A vehicle alongside is waited for. One that has passed, stopped farther back or drives elsewhere is not."""
    assert is_traffic_approaching(LANE, AT_M, 0.0, cars((AT_M + 3.0, 0.0, 6.0)), CAR)
    assert is_traffic_approaching(LANE, AT_M, 0.0, cars((AT_M, 0.0, 0.0)), CAR)
    elsewhere = cars((AT_M + 20.0, 0.0, 6.0), (AT_M - 10.0, 0.0, 0.0), (AT_M - 10.0, -3.5, 9.0))
    assert not is_traffic_approaching(LANE, AT_M, 0.0, elsewhere, CAR)


def test_at_speed_only_who_is_quicker_is_waited_for():
    same = cars((AT_M - 12.0, 0.0, 8.0))
    assert is_traffic_approaching(LANE, AT_M, 2.0, same, CAR)
    assert not is_traffic_approaching(LANE, AT_M, 8.0, same, CAR)


def test_whoever_has_waited_long_takes_a_smaller_gap():
    gaps = [accepted_gap_s(waited) for waited in (0.0, 5.0, 15.0, 60.0)]
    assert gaps[0] == GAP_S and gaps[-1] == MIN_GAP_S and gaps == sorted(gaps, reverse=True)
    close = cars((AT_M - 2.45 - 2.3 - 15.0, 0.0, 9.0))
    assert is_traffic_approaching(LANE, AT_M, 0.0, close, CAR, gaps[0])
    assert not is_traffic_approaching(LANE, AT_M, 0.0, close, CAR, gaps[-1])


def test_pull_out_wider_margin_makes_path_tighter_or_none():
    """With a wider margin, the path around a vehicle ahead is tighter, or there is none."""

    def way(away_m, margin_m):
        gentle = rejoining_length(BESIDE_M, 0.0)
        ways = partial(rejoining_path, LANE, AT_M, BESIDE_M)
        return find_pull_out_path(
            ways, gentle, PlanarPose(AT_M, BESIDE_M, 0.0), cars((AT_M + away_m, BESIDE_M, 0.0)), CAR, margin_m
        )

    places = np.arange(6.0, 12.0, 0.1)
    narrow, wide = ([away for away in places if way(away, margin) is not None] for margin in (0.15, 0.45))
    assert min(narrow) < min(wide)
    assert back_after_m(way(9.5, 0.45)) <= back_after_m(way(9.5, 0.15))
