"""Vehicles that only the camera tracks, as reported to drivers and the solver: on lanes of the map.

A camera range is off by a tenth, and its rate is measured only after a second or two. So the report is not the
likeliest one but the one that is worse for a user of the lane:

* The position is on the center of its lane, two standard deviations of the range nearer than measured.
* In a lane that leads toward us it comes, with the measured speed and two standard deviations more. Before the rate is
  known, this is no more than the fastest traffic of the road drives, as for what is not seen (`sight.FASTEST_SHARE`).
  It is reported otherwise only if it surely drives away from us.
* In a lane that leads away from us it is reported once its rate is known well enough. Before that nothing is claimed,
  but sight ends there. It comes toward us only if the rate leaves no doubt.
* In a junction lanes overlap: there the visible side, front or rear, decides.
* On no lane along the line of sight it is not reported, because its way cannot be measured. Sight ends there, too.
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

SURE_SDS = 2.0
SURELY_MPS = 1.0
"""A vehicle surely drives one way if it has at least this rate, less two standard deviations."""
KNOWN_SD_MPS = 3.0
"""Standard deviation of a rate that is known well enough."""
MEASURED_HITS = 8
"""Detections, about a second and a half, before a vehicle in a lane toward us is believed to drive away."""
FASTEST_MPS = 36.0
"""130 km/h: no vehicle is reported as faster than motorway traffic."""
ALONG_COS = math.cos(math.radians(30.0))
"""A lane at a larger angle to the line of sight crosses it."""
BESIDE_M = 1.0
"""A vehicle this far beyond a lane's border may still be in it."""
NEAREST_M = 20.0
"""No vehicle is reported as nearer: there the LiDAR sees everything."""
LATERAL_SD_M = 0.4
"""With twice this on either side, a car fills a usual lane."""
YAW_SD_RAD = 0.1
SIZES_M = ((4.6, 1.9, 1.6), (2.0, 0.8, 1.6))
"""Length, width and height of a usual vehicle of each label of `far_strip.LABELS`."""
TRACK_LABELS = (0, 2)
"""The same in `stucksolver_perception.lidar_labels.LABELS`: a car, a two-wheeler."""


class FarVehicleReports:
    """The far vehicles of one map. `told` caches its last answer, since it is called several times per percept."""

    def __init__(self, carla_map: carla.Map, vehicle: Any = None) -> None:
        """`vehicle` has the speed limit of the road (`get_speed_limit`, km/h); without it, `FASTEST_MPS` is assumed."""
        self._map, self._vehicle = carla_map, vehicle
        self._last: tuple[PerceptionResult | None, tuple[Track, ...]] = (None, ())

    def reported_tracks(self, percept: PerceptionResult | None) -> tuple[Track, ...]:
        """Return them as tracks like those of the LiDAR, at the time of the percept."""
        if percept is not self._last[0]:
            found = () if percept is None else percept.far_tracks
            limit = 0.0 if self._vehicle is None else FASTEST_SHARE * self._vehicle.get_speed_limit() / 3.6
            height_m = percept.pose.z_m if percept else 0.0
            tracks = (to_reported_track(item, self._map, height_m, limit or FASTEST_MPS) for item in found)
            self._last = (percept, tuple(track for track in tracks if track is not None))
        return self._last[1]


def to_reported_track(far: FarTrack, carla_map: Any, height_m: float, fastest_mps: float = FASTEST_MPS) -> Track | None:
    """Return one of them on its lane; None if nothing is claimed.

    Args:
        far: The vehicle.
        carla_map: The map.
        height_m: Height of the ego's position, local frame.
        fastest_mps: Speed of the fastest traffic, assumed before the rate is known.
    """
    if far.range_m < NEAREST_M:
        return None
    waypoint = carla_map.get_waypoint(carla.Location(*to_world(far.x_m, far.y_m), height_m))
    if waypoint is None:
        return None
    x, y, yaw = _place(waypoint)
    beside = abs((far.y_m - y) * math.cos(yaw) - (far.x_m - x) * math.sin(yaw))
    along = math.cos(yaw - far.bearing_rad)
    if beside > waypoint.lane_width / 2.0 + BESIDE_M or abs(along) < ALONG_COS:
        return None
    rate = _reported_rate_mps(far, far.towards > 0.5 if waypoint.is_junction else along < 0.0, fastest_mps)
    if rate is None:
        return None
    nearer_m = min(SURE_SDS * far.range_sd_m, far.range_m - NEAREST_M)
    x, y, yaw = _place(_shifted(waypoint, nearer_m, along < 0.0))
    # The lane's direction away from the ego, whichever way its traffic goes.
    away = yaw if along > 0.0 else yaw + math.pi
    return _track(far, x, y, height_m, away, rate)


def _reported_rate_mps(far: FarTrack, comes: bool, fastest_mps: float) -> float | None:
    """Return the reported velocity over ground away from the ego; None if nothing is claimed."""
    least, most = far.rate_mps - SURE_SDS * far.rate_sd_mps, far.rate_mps + SURE_SDS * far.rate_sd_mps
    goes_away = least > SURELY_MPS and far.hits >= MEASURED_HITS
    if (comes and not goes_away) or most < -SURELY_MPS:
        # A measured rate counts also if it is above what the road allows.
        usual_mps = fastest_mps if far.rate_sd_mps > KNOWN_SD_MPS else FASTEST_MPS
        return max(min(least, 0.0), -max(usual_mps, -far.rate_mps))
    return max(far.rate_mps, 0.0) if far.rate_sd_mps < KNOWN_SD_MPS else None


def _shifted(waypoint: Any, metres: float, with_lane: bool) -> Any:
    """Return the place this much further along a lane, or back; the same place if the lane ends."""
    if metres < 1.0:
        return waypoint
    found = waypoint.next(metres) if with_lane else waypoint.previous(metres)
    return found[0] if found else waypoint


def _place(waypoint: Any) -> tuple[float, float, float]:
    """Return x, y (m) and direction (rad) in the local frame."""
    transform = waypoint.transform
    return *to_local(transform.location), yaw_to_local(transform.rotation.yaw)


def _track(far: FarTrack, x: float, y: float, height_m: float, away: float, rate: float) -> Track:
    length, width, height = SIZES_M[far.label]
    front = away if rate >= 0.0 else away + math.pi
    return Track(
        id=far.id,
        time_s=far.time_s,
        label=TRACK_LABELS[far.label],
        label_confidence=far.score,
        confidence=far.score,
        x_m=x,
        y_m=y,
        z_m=height_m + height / 2.0,
        yaw_rad=math.remainder(front, math.tau),
        vx_mps=rate * math.cos(away),
        vy_mps=rate * math.sin(away),
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
