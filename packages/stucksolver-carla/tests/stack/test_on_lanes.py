"""A track keeps to its lane unless its speed across the lane is more than noise."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import carla
import numpy as np
import pytest

from stucksolver_perception.carla.lane_motion_prior import LATERAL_SD_M, with_lane_course
from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.tracking import Track

EGO = SimpleNamespace(x_m=0.0, y_m=0.0, z_m=0.0)
LANE_D, HALF_M = 3.5, 1.75


def lanes(junction: bool = False, yaw_deg: float = 0.0) -> Any:
    """A lane along the x axis of the local frame, whichever place is asked for."""

    def place(at: carla.Location) -> Any:
        transform = carla.Transform(carla.Location(at.x, -LANE_D, 0.0), carla.Rotation(yaw=yaw_deg))
        return SimpleNamespace(transform=transform, is_junction=junction, lane_width=2 * HALF_M)

    return SimpleNamespace(get_waypoint=place)


def car(x: float, d: float, v: float, across: float, sd: float = 0.4, label: str = "car") -> Track:
    return Track(
        id=1,
        time_s=0.0,
        label=LABELS.index(label),
        label_confidence=0.9,
        confidence=0.9,
        x_m=x,
        y_m=d,
        z_m=0.8,
        yaw_rad=0.1,
        vx_mps=v,
        vy_mps=across,
        length_m=4.5,
        width_m=1.9,
        height_m=1.6,
        covariance=np.diag([0.2, 0.2, 0.1, sd, sd]) ** 2,
        first_seen_s=-5.0,
        last_seen_s=0.0,
        hits=50,
        hidden=False,
        standing_since_s=None,
        moved_at_s=0.0,
    )


def sideways(track: Track) -> float:
    return track.vy_mps


@pytest.mark.parametrize("v", [8.0, -8.0])
def test_on_lane_removes_lateral_noise_and_keeps_speed(v: float) -> None:
    """Noise across the lane is removed, and the speed along it is kept."""
    told = with_lane_course(car(60.0, LANE_D, v, -0.7), lanes(), EGO)
    assert sideways(told) == pytest.approx(0.0)
    assert told.vx_mps == pytest.approx(v)
    assert abs(math.remainder(told.yaw_rad - (0.0 if v > 0 else math.pi), math.tau)) < 1e-6
    assert (told.x_m, told.y_m) == (60.0, LANE_D)


@pytest.mark.parametrize("x", [5.0, 15.0, 30.0])
def test_who_changes_lanes_nearby_is_seen_to(x: float) -> None:
    leaving = car(x, LANE_D, 8.0, -1.0)
    assert with_lane_course(leaving, lanes(), EGO) == leaving


def test_on_lane_new_track_follows_its_lane() -> None:
    """A new track of unknown course follows its lane."""
    fresh = car(72.0, LANE_D, -7.0, -3.5, sd=2.5)
    assert sideways(with_lane_course(fresh, lanes(), EGO)) == pytest.approx(0.0)
    settled = replace(fresh, covariance=np.diag([0.2, 0.2, 0.1, 0.4, 0.4]) ** 2)
    assert sideways(with_lane_course(settled, lanes(), EGO)) == -3.5


@pytest.mark.parametrize(
    ("track", "road"),
    [
        (car(60.0, LANE_D, 8.0, 0.3), lanes(junction=True)),
        (car(60.0, LANE_D + HALF_M + 0.3, 8.0, 0.3), lanes()),
        (car(60.0, LANE_D, 1.0, 0.3), lanes()),
        (car(60.0, LANE_D, 2.0, 0.3, label="pedestrian"), lanes()),
        (car(60.0, LANE_D, 8.0, 0.3), lanes(yaw_deg=90.0)),
        (car(60.0, LANE_D, 8.0, 0.3), SimpleNamespace(get_waypoint=lambda at: None)),
    ],
    ids=["in a junction", "beside the lane", "slow", "on foot", "across the lane", "off the map"],
)
def test_nothing_else_is_changed(track: Track, road: Any) -> None:
    assert with_lane_course(track, road, EGO) == track


@pytest.mark.parametrize("yaw_deg", [0.0, -35.0])
def test_on_lane_occluded_track_is_uncertain_only_along_lane(yaw_deg: float) -> None:
    """An occluded track that follows its lane stays in it, and may be anywhere along it."""
    yaw = -math.radians(yaw_deg)
    ahead, side = np.array([math.cos(yaw), math.sin(yaw)]), np.array([-math.sin(yaw), math.cos(yaw)])
    wide = np.diag([2.0, 2.0, 0.1, 1.5, 1.5]) ** 2
    seen = replace(car(20.0, LANE_D, 8.0 * ahead[0], 8.0 * ahead[1]), yaw_rad=yaw, covariance=wide)
    told = with_lane_course(replace(seen, hidden=True), lanes(yaw_deg=yaw_deg), EGO)
    assert side @ told.covariance[:2, :2] @ side == pytest.approx(LATERAL_SD_M**2)
    assert ahead @ told.covariance[:2, :2] @ ahead == pytest.approx(4.0)
    assert np.linalg.eigvalsh(told.covariance).min() > 0.0
    assert np.array_equal(with_lane_course(seen, lanes(yaw_deg=yaw_deg), EGO).covariance, wide), "not while it is seen"
    crossing = replace(seen, hidden=True, vx_mps=8.0 * side[0], vy_mps=8.0 * side[1])
    assert np.array_equal(with_lane_course(crossing, lanes(yaw_deg=yaw_deg), EGO).covariance, wide)
