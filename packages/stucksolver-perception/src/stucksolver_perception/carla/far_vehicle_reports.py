"""Reports vehicles that only the camera tracks, on lanes of the map, to drivers and the solver.

A range from the camera has an error of 10 %, and the range rate is measured only after one or two seconds. So the
report is not the most probable state, but a worse one for a user of the lane:

* The position is on the center of its lane, two standard deviations of the range nearer than measured.
* In a lane toward the ego, the vehicle is oncoming, with the measured speed and two standard deviations more. Before
  the rate is known, the speed is limited to that of the fastest traffic of the road, as for occluded traffic
  (`lane_sight.FASTEST_SHARE`). The vehicle is reported differently only if it certainly drives away.
* In a lane away from the ego, the vehicle is reported when its rate is known well enough. Before that it is not
  reported, but sight ends there. It is oncoming only if the rate is certain.
* In a junction, where lanes overlap, the visible side, front or rear, decides.
* On no lane along the line of sight it is not reported, because its path cannot be measured. Sight ends there too.
"""

from __future__ import annotations

import math
from typing import Any

import carla
import numpy as np

from stucksolver_carla.stack.carla_frames import to_local, to_world, yaw_to_local
from stucksolver_perception.carla.lane_sight import FASTEST_SHARE
from stucksolver_perception.cycle_data import PerceptionResult
from stucksolver_perception.far_tracking import FarTrack
from stucksolver_perception.tracking import Track

BOUND_SDS = 2.0
"""Number of standard deviations of the bounds. Ours."""
CERTAIN_RATE_MPS = 1.0
"""Minimum range rate, less two standard deviations, of a vehicle whose direction is certain (m/s). Ours."""
USABLE_SD_MPS = 3.0
"""Maximum standard deviation of a range rate that is known well enough (m/s). Ours."""
MIN_HITS = 8
"""Number of detections, in about 1.5 s, before a vehicle in a lane toward the ego may count as driving away. Ours."""
FASTEST_MPS = 36.0
"""Maximum reported speed (m/s): 130 km/h, as on motorways."""
MAX_ANGLE_COS = math.cos(math.radians(30.0))
"""Cosine of the angle to the line of sight from which a lane crosses it. Ours."""
LANE_MARGIN_M = 1.0
"""Maximum distance beyond a lane's border of a vehicle in it (m). Ours."""
NEAREST_M = 20.0
"""Minimum reported range (m). The LiDAR detects all nearer vehicles."""
LATERAL_SD_M = 0.4
"""Standard deviation across the lane (m): with twice this on either side, a car fills a usual lane."""
YAW_SD_RAD = 0.1
"""Standard deviation of the yaw (rad). Ours."""
SIZES_M = ((4.6, 1.9, 1.6), (2.0, 0.8, 1.6))
"""Length, width and height (m) of a usual vehicle of each label of `horizon_strip.LABELS`. Ours."""
TRACK_LABELS = (0, 2)
"""The same labels in `stucksolver_perception.lidar_labels.LABELS`: a car, a two-wheeler."""


class FarVehicleReports:
    """The far vehicles of one map. The last report is cached, because it is requested several times per result."""

    def __init__(self, carla_map: carla.Map, vehicle: Any = None) -> None:
        """Create the reports. `vehicle` gives the road's speed limit; None assumes `FASTEST_MPS`."""
        self._map, self._vehicle = carla_map, vehicle
        self._last: tuple[PerceptionResult | None, tuple[Track, ...]] = (None, ())

    def reported_tracks(self, percept: PerceptionResult | None) -> tuple[Track, ...]:
        """Return the vehicles as tracks like those of the LiDAR, at the time of the result."""
        if percept is not self._last[0]:
            far_tracks = () if percept is None else percept.far_tracks
            limit = 0.0 if self._vehicle is None else FASTEST_SHARE * self._vehicle.get_speed_limit() / 3.6
            height_m = percept.pose.z_m if percept else 0.0
            tracks = (to_reported_track(item, self._map, height_m, limit or FASTEST_MPS) for item in far_tracks)
            self._last = (percept, tuple(track for track in tracks if track is not None))
        return self._last[1]


def to_reported_track(far: FarTrack, carla_map: Any, height_m: float, fastest_mps: float = FASTEST_MPS) -> Track | None:
    """Return a far vehicle on its lane; None if it is not reported.

    Args:
        far: The vehicle.
        carla_map: The map.
        height_m: Height of the ego's position in the local frame (m).
        fastest_mps: Speed of the fastest traffic, which is assumed before the rate is known (m/s).
    """
    if far.range_m < NEAREST_M:
        return None
    waypoint = carla_map.get_waypoint(carla.Location(*to_world(far.x_m, far.y_m), height_m))
    if waypoint is None:
        return None
    x, y, yaw = _pose_of(waypoint)
    lateral_m = abs((far.y_m - y) * math.cos(yaw) - (far.x_m - x) * math.sin(yaw))
    along_cos = math.cos(yaw - far.bearing_rad)
    if lateral_m > waypoint.lane_width / 2.0 + LANE_MARGIN_M or abs(along_cos) < MAX_ANGLE_COS:
        return None
    rate_mps = _reported_rate_mps(far, far.towards > 0.5 if waypoint.is_junction else along_cos < 0.0, fastest_mps)
    if rate_mps is None:
        return None
    nearer_m = min(BOUND_SDS * far.range_sd_m, far.range_m - NEAREST_M)
    x, y, yaw = _pose_of(_shifted(waypoint, nearer_m, along_cos < 0.0))
    # The lane's direction away from the ego, for either direction of its traffic.
    away_yaw = yaw if along_cos > 0.0 else yaw + math.pi
    return _track(far, x, y, height_m, away_yaw, rate_mps)


def _reported_rate_mps(far: FarTrack, is_oncoming: bool, fastest_mps: float) -> float | None:
    """Return the reported speed over ground away from the ego (m/s); None if the vehicle is not reported."""
    min_mps, max_mps = far.rate_mps - BOUND_SDS * far.rate_sd_mps, far.rate_mps + BOUND_SDS * far.rate_sd_mps
    drives_away = min_mps > CERTAIN_RATE_MPS and far.hits >= MIN_HITS
    if (is_oncoming and not drives_away) or max_mps < -CERTAIN_RATE_MPS:
        # A measured rate counts also if it is above the road's speed.
        usual_mps = fastest_mps if far.rate_sd_mps > USABLE_SD_MPS else FASTEST_MPS
        return max(min(min_mps, 0.0), -max(usual_mps, -far.rate_mps))
    return max(far.rate_mps, 0.0) if far.rate_sd_mps < USABLE_SD_MPS else None


def _shifted(waypoint: Any, meters: float, with_lane: bool) -> Any:
    """Return the waypoint this distance ahead on a lane, or behind; the same waypoint if the lane ends."""
    if meters < 1.0:
        return waypoint
    shifted = waypoint.next(meters) if with_lane else waypoint.previous(meters)
    return shifted[0] if shifted else waypoint


def _pose_of(waypoint: Any) -> tuple[float, float, float]:
    """Return x, y (m) and direction (rad) of a waypoint in the local frame."""
    transform = waypoint.transform
    return *to_local(transform.location), yaw_to_local(transform.rotation.yaw)


def _track(far: FarTrack, x: float, y: float, height_m: float, away_yaw: float, rate_mps: float) -> Track:
    length, width, height = SIZES_M[far.label]
    front_yaw = away_yaw if rate_mps >= 0.0 else away_yaw + math.pi
    return Track(
        id=far.id,
        time_s=far.time_s,
        label=TRACK_LABELS[far.label],
        label_confidence=far.score,
        confidence=far.score,
        x_m=x,
        y_m=y,
        z_m=height_m + height / 2.0,
        yaw_rad=math.remainder(front_yaw, math.tau),
        vx_mps=rate_mps * math.cos(away_yaw),
        vy_mps=rate_mps * math.sin(away_yaw),
        length_m=length,
        width_m=width,
        height_m=height,
        covariance=np.diag([LATERAL_SD_M, LATERAL_SD_M, YAW_SD_RAD, far.rate_sd_mps, far.rate_sd_mps]) ** 2,
        first_seen_s=far.first_seen_s,
        last_seen_s=far.last_seen_s,
        hits=far.hits,
        hidden=far.last_seen_s < far.time_s,
        standing_since_s=None,
        moved_at_s=None,
    )
