"""Tracks vehicles that only the camera detects: their ranges and range rates, from image to image.

The range from one image has an error of a tenth or more. Most of it is the same in each image, because the vehicle is
larger than usual, or the road slopes. The remaining difference between images is small, with a slow drift as more of a
vehicle becomes visible. The filter treats only these two as noise, so that the rate is known after a second or two. The
error that all images share is added to the result (`FarTrack.range_sd_m`, `rate_sd_mps`).

The state has one dimension, along the line of sight. At these ranges the lanes of the road are nearly parallel to it.
The tracks are placed on a lane later (`stucksolver_perception/carla/far_vehicle_reports.py`). The ego's motion is
removed with its poses, so that the rate is a speed over ground.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from stucksolver_perception.camera.far_detector import FarDetections
from stucksolver_perception.camera.far_range import COLUMN_SIGMA_PX, RangeModel, far_places
from stucksolver_perception.free_space import CELL_M, FreeSpace
from stucksolver_perception.measurements import Floats, PoseEstimate
from stucksolver_perception.rig import CameraRig
from stucksolver_perception.tracking import Track
from stucksolver_perception.vehicle_frame import points_into_vehicle

FIRST_ID = 1_000_000
"""First id of these tracks, far above those of the LiDAR's tracks."""
LABELS = (0, 1)
"""Vehicles and two-wheelers (`horizon_strip.LABELS`). Pedestrians at such ranges do not matter at town speeds."""
NEAREST_M = 40.0
"""Minimum range of a new or reported track (m). The LiDAR detects nearly all nearer vehicles, and one in eight of the
camera's nearer detections is false. A track that moves below this range is mostly an object that the LiDAR tracks at
another position."""
NOISE_SHARE = 0.05
"""Standard deviation of the range between consecutive images, as a share of the range. Ours."""
DRIFT_SHARE = 0.05
"""Standard deviation of the drift of a vehicle's range per second, as a share of the range: more of the vehicle becomes
visible. Ours."""
RATE_SD_MPS = 15.0
"""Standard deviation of the rate before it is measured (m/s): 95 % of vehicles are slower than twice this, 108 km/h."""
ACCELERATION_MPS2 = 2.0
"""Standard deviation of the acceleration (m/s²), as in the LiDAR's tracker for vehicles."""
LATERAL_M = 0.7
"""Standard deviation of a vehicle's motion across the line of sight between two images, with bends (m). Three times
this is more than the motion in a lane."""
GATE = 3.0
"""Maximum number of standard deviations, in range and in bearing, between a detection and its track. Ours."""
SAME_SDS = 2.5
"""Number of standard deviations of the range within which a LiDAR track is the same vehicle. Ours."""
SAME_M = 6.0
"""Distance in range within which a LiDAR track is the same vehicle in any case (m). Ours."""
SAME_LATERAL_M = 2.0
"""Distance across the line of sight within which a LiDAR track is the same vehicle (m). Ours."""
CONFIRMED_HITS = 2
"""Minimum number of detections of a reported vehicle. Ours."""
CONFIRMED_SHARE = 1.0 / 3.0
"""Minimum share of the images since the first detection in which a reported vehicle was detected, because false
detections come in twos. Sight ends at the detections in any case."""
STEADY_S, STEADY_HITS = 5.0, 15
"""Time (s) and number of detections without a change of range after which a vehicle counts as stopped, while the ego is
stopped. Ours."""
LATEST_HITS = 5
"""Number of latest detections whose mean must not differ from that of the others, so that a starting vehicle is noticed
soon. Until then, two standard deviations of the rate cover the speed that it may have reached. Ours."""
MIN_SCATTER = 0.002
"""Minimum scatter of the ranges, as a share of the range: in identical images the detector gives identical boxes."""
START_MPS2 = 2.5
"""Acceleration of a vehicle that starts briskly (m/s²). Ours."""
STOPPED_MPS = 0.1
"""Speed below which the ego counts as stopped (m/s). Ours."""
HANDOVER_HITS = 10
"""Number of the LiDAR's detections, in one second, after which a vehicle is handed over to the LiDAR. At the edge of
its grid, the LiDAR first measures speeds of 20 m/s as 10 to 14 m/s."""
LOST_S = 2.0
"""Time without a detection after which a track ends (s). It is long, because a missed oncoming vehicle continues."""
REFUTED_SDS = 3.0
"""Number of standard deviations of the range in which the area must be free to end a track. Ours."""
REFUTED_FROM_M = 6.0
"""Minimum range of that area (m): around the ego the LiDAR measures nothing."""
MIN_TOWARDS, MAX_ODDS = 0.02, 4.0
"""Minimum probability of either side, front or rear, from one image, and maximum log odds of all images together,
because errors repeat from image to image. Ours."""


@dataclass(frozen=True, eq=False)
class FarTrack:
    """A vehicle that the camera tracks, at `time_s`."""

    id: int
    """Id that no LiDAR track has. One tracker never uses it twice."""
    time_s: float
    label: int
    """Index into `horizon_strip.LABELS`."""
    score: float
    """Mean score of its detections."""
    x_m: float
    y_m: float
    """Position of its center at the most likely range, in the local frame (m)."""
    bearing_rad: float
    """Direction from the camera to the vehicle in the local frame (rad)."""
    range_m: float
    """Range from the camera (m)."""
    range_sd_m: float
    """Standard deviation of the range (m)."""
    rate_mps: float
    """Velocity over ground along the bearing (m/s); negative toward the ego."""
    rate_sd_mps: float
    """Standard deviation of the rate (m/s)."""
    towards: float
    """Probability that its front is visible."""
    first_seen_s: float
    """Time of the first detection (s)."""
    last_seen_s: float
    """Time of the last detection (s)."""
    hits: int
    """Number of detections."""


def is_refuted(track: FarTrack, free_space: FreeSpace, pose: PoseEstimate) -> bool:
    """Return True if the LiDAR proves that the area of a track is free: its bearing, `REFUTED_SDS` around its range.

    A false track begins with detections of nearby objects whose range is overestimated, and moves nearer. The free
    space is in the vehicle frame at `pose`.
    """
    reach = REFUTED_SDS * track.range_sd_m
    ranges = np.arange(max(track.range_m - reach, REFUTED_FROM_M), track.range_m + reach, CELL_M)
    if not len(ranges):
        return False
    offsets = ranges - track.range_m
    line = np.array([math.cos(track.bearing_rad), math.sin(track.bearing_rad)])
    x, y = points_into_vehicle(np.array([track.x_m, track.y_m]) + offsets[:, None] * line, pose).T
    return bool(free_space.is_proven_free(x, y).all())


@dataclass(eq=False)
class _Filter:
    """The filter of one vehicle."""

    id: int
    x: Floats
    """(2,): range (m), rate over ground (m/s)."""
    p: Floats
    """(2, 2): covariance of `x`."""
    time_s: float
    bearing: float
    """Bearing in the local frame (rad)."""
    camera: Floats
    """(2,): position of the camera at `time_s` in the local frame (m)."""
    label: int
    first_seen_s: float
    last_seen_s: float
    bias: float
    """Standard deviation of the error common to all its ranges, as a share of the range."""
    ego_mps: float
    """Speed of the ego along the bearing at the last detection (m/s)."""
    scores: float = 0.0
    """Sum of the detections' scores."""
    odds: float = 0.0
    """Log odds that the front is visible."""
    hits: int = 0
    """Number of detections."""
    images: int = 1
    """Number of images since the first detection, including it."""
    steady: list[tuple[float, float]] = field(default_factory=list)
    """Times (s) and ranges (m) of the last detections while the ego is stopped."""


@dataclass(frozen=True, eq=False)
class _FarCandidates:
    """Detections in one image that may be far vehicles; equal lengths n."""

    time_s: float
    camera: Floats
    """(2,): position of the camera in the local frame (m)."""
    range_m: Floats
    """(n,): range from the camera (m)."""
    sd_m: Floats
    """(n,): standard deviation of the range (m)."""
    bearing: Floats
    """(n,): bearing in the local frame (rad)."""
    label: Floats
    """(n,): index into `horizon_strip.LABELS`."""
    score: Floats
    """(n,): score of the detection."""
    towards: Floats
    """(n,): probability that the front is visible."""
    ego_mps: Floats
    """(n,): speed of the ego along the bearing (m/s)."""
    ego_is_stopped: bool
    """True if the ego is stopped."""


class FarTracker:
    """Tracker of far vehicles. Call `update` with each image's detections, and `tracks` at any time."""

    def __init__(self, rig: CameraRig, model: RangeModel) -> None:
        # The first import takes long. It happens here so that it does not delay the first image.
        import filterpy.kalman  # type: ignore[import-untyped]  # noqa: F401

        self._rig, self._model = rig, model
        self._filters: list[_Filter] = []
        self._next_id = FIRST_ID
        self._detected_lidar_ids: set[int] = set()
        """Ids of the LiDAR tracks that the last image showed too."""

    def update(self, detections: FarDetections, pose: PoseEstimate, lidar: Sequence[Track]) -> None:
        """Add one image.

        Args:
            detections: From `FarDetector.detect`; later than those before.
            pose: The vehicle's pose at `detections.time_s`.
            lidar: The LiDAR's tracks at about the same time. Each explains at most one detection, which does not count
                here.
        """
        candidates = self._candidates(detections, pose)
        for state in self._filters:
            _predict(state, candidates.time_s, candidates.camera)
            state.images += 1
        explained = _match_lidar(
            candidates.bearing, candidates.range_m, candidates.sd_m, lidar, candidates.camera, candidates.time_s
        )
        self._detected_lidar_ids = {lidar[k].id for k in explained.values()}
        unexplained = [j for j in range(len(candidates.range_m)) if j not in explained]
        assigned = self._assign(candidates, unexplained)
        for i, j in assigned.items():
            _update(self._filters[i], candidates, j)
        for j in set(unexplained) - set(assigned.values()):
            if candidates.range_m[j] >= NEAREST_M:
                self._filters.append(_new_filter(self._next_id, candidates, j))
                self._next_id += 1
        self._filters = [state for state in self._filters if candidates.time_s - state.last_seen_s <= LOST_S]

    def tracks(self, time_s: float, lidar: Sequence[Track]) -> tuple[FarTrack, ...]:
        """Return all tracks at a time (s) not before the last image, except near ones.

        A track that the LiDAR has tracked for a second at the same position is handed over and no longer reported. If
        the last image showed both the LiDAR's vehicle and another one there, the track is the other one and continues.
        """
        lidar = [track for track in lidar if track.hits >= HANDOVER_HITS]
        undetected = [track for track in lidar if track.id not in self._detected_lidar_ids]
        in_last_image = [state for state in self._filters if state.last_seen_s == state.time_s]
        missed = [state for state in self._filters if state.last_seen_s != state.time_s]
        self._filters = _not_handed_over(in_last_image, undetected, time_s) + _not_handed_over(missed, lidar, time_s)
        # A vehicle that was detected only once may be false.
        tracks = (_to_track(state, time_s) for state in self._filters if _is_confirmed(state))
        return tuple(track for track in tracks if track.range_m + track.range_sd_m > NEAREST_M)

    def _candidates(self, detections: FarDetections, pose: PoseEstimate) -> _FarCandidates:
        part = detections.part(np.isin(detections.label, LABELS))
        places, mount = far_places(part, self._rig, self._model), self._rig.mount
        offset = places.xy - np.array([mount.x_m, mount.y_m])
        c, n = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
        camera = np.array([pose.x_m + c * mount.x_m - n * mount.y_m, pose.y_m + n * mount.x_m + c * mount.y_m])
        bearing = np.arctan2(offset[:, 1], offset[:, 0]) + pose.yaw_rad
        return _FarCandidates(
            part.time_s,
            camera,
            places.range_m,
            places.range_sigma_m,
            bearing,
            part.label.astype(float),
            part.score,
            part.towards,
            pose.speed_mps * np.cos(bearing - pose.yaw_rad),
            abs(pose.speed_mps) < STOPPED_MPS,
        )

    def _assign(self, candidates: _FarCandidates, unexplained: list[int]) -> dict[int, int]:
        """Return the detection of each filter that has one, both as indices."""
        if not self._filters or not unexplained:
            return {}
        states = np.array([(state.x[0], math.sqrt(state.p[0, 0]), state.bearing) for state in self._filters])
        predicted_m, sd, bearing = (states[:, k, None] for k in range(3))
        range_m = candidates.range_m[unexplained]
        along = (predicted_m - range_m) / np.hypot(sd, NOISE_SHARE * range_m)
        lateral_rad = COLUMN_SIGMA_PX / self._rig.focal_px + LATERAL_M / np.maximum(predicted_m, 1.0)
        across = _wrapped(bearing - candidates.bearing[unexplained]) / lateral_rad
        # A detection beyond the noise, but within the range error, begins no second track.
        is_near = (abs(along) < GATE) | (abs(predicted_m - range_m) < SAME_SDS * candidates.sd_m[unexplained])
        cost = along**2 + across**2
        return {i: unexplained[j] for i, j in _pairs(np.where(is_near & (abs(across) < GATE), cost, np.inf))}


def _is_confirmed(state: _Filter) -> bool:
    return state.hits >= CONFIRMED_HITS and state.hits >= CONFIRMED_SHARE * state.images


def _not_handed_over(filters: list[_Filter], lidar: Sequence[Track], time_s: float) -> list[_Filter]:
    """Return the filters at whose positions the LiDAR has no track."""
    if not filters or not lidar:
        return filters
    tracks = [_to_track(state, time_s) for state in filters]
    bearing, range_m, sd_m = np.array([(track.bearing_rad, track.range_m, track.range_sd_m) for track in tracks]).T
    handed_over = _match_lidar(bearing, range_m, sd_m, lidar, filters[0].camera, time_s)
    return [state for i, state in enumerate(filters) if i not in handed_over]


def _match_lidar(
    bearing: Floats, range_m: Floats, sd_m: Floats, lidar: Sequence[Track], camera: Floats, time_s: float
) -> dict[int, int]:
    """Return the LiDAR track of each far object that has one, both as indices; each at most once."""
    if not len(range_m) or not lidar:
        return {}
    rows = [(t.x_m + t.vx_mps * (time_s - t.time_s), t.y_m + t.vy_mps * (time_s - t.time_s)) for t in lidar]
    offset = np.array(rows) - camera
    lidar_range_m = np.hypot(offset[:, 0], offset[:, 1])[None]
    bearing_error = np.abs(_wrapped(bearing[:, None] - np.arctan2(offset[:, 1], offset[:, 0])[None]))
    lateral_m = bearing_error * lidar_range_m
    along = np.abs(range_m[:, None] - lidar_range_m)
    reach = np.maximum(SAME_SDS * sd_m, SAME_M)[:, None]
    return dict(_pairs(np.where((lateral_m < SAME_LATERAL_M) & (along < reach), along / reach + lateral_m, np.inf)))


def _pairs(cost: Floats) -> Iterable[tuple[int, int]]:
    """Yield matching rows and columns, the cheapest pair first; infinite costs never match."""
    cost = cost.copy()
    while cost.size and np.isfinite(cost).any():
        i, j = (int(k) for k in np.unravel_index(int(cost.argmin()), cost.shape))
        yield i, j
        cost[i], cost[:, j] = np.inf, np.inf


def _new_filter(number: int, candidates: _FarCandidates, j: int) -> _Filter:
    range_m = float(candidates.range_m[j])
    p = np.diag([(NOISE_SHARE * range_m) ** 2, RATE_SD_MPS**2])
    state = _Filter(
        number,
        np.array([range_m, 0.0]),
        p,
        candidates.time_s,
        float(candidates.bearing[j]),
        candidates.camera,
        int(candidates.label[j]),
        candidates.time_s,
        candidates.time_s,
        float(candidates.sd_m[j]) / range_m,
        float(candidates.ego_mps[j]),
    )
    _add_hit(state, candidates, j)
    return state


def _transition(dt: float, range_m: float) -> tuple[Floats, Floats]:
    """Return matrix and process noise of a step of `dt` s: constant velocity with white noise, and drift of the
    range.
    """
    noise = ACCELERATION_MPS2**2 * np.array([[dt**3 / 3.0, dt**2 / 2.0], [dt**2 / 2.0, dt]])
    noise[0, 0] += (DRIFT_SHARE * range_m) ** 2 * dt
    return np.array([[1.0, dt], [0.0, 1.0]]), noise


def _predict(state: _Filter, time_s: float, camera: Floats) -> None:
    """Predict a filter to a time at which the camera is at another position."""
    from filterpy.kalman import predict as kalman_predict

    state.x, state.p = kalman_predict(state.x, state.p, *_transition(time_s - state.time_s, float(state.x[0])))
    line = np.array([math.cos(state.bearing), math.sin(state.bearing)])
    offset = state.camera + float(state.x[0]) * line - camera
    state.x = np.array([math.hypot(*offset), state.x[1]])
    state.bearing, state.camera, state.time_s = math.atan2(offset[1], offset[0]), camera, time_s


def _update(state: _Filter, candidates: _FarCandidates, j: int) -> None:
    from filterpy.kalman import update as kalman_update

    range_m = float(candidates.range_m[j])
    # A measurement beyond the noise has less weight.
    noise = max((NOISE_SHARE * range_m) ** 2, (range_m - float(state.x[0])) ** 2 / GATE**2)
    state.x, state.p = kalman_update(state.x, state.p, range_m, noise, np.array([[1.0, 0.0]]))
    state.bearing, state.last_seen_s = float(candidates.bearing[j]), candidates.time_s
    state.ego_mps = float(candidates.ego_mps[j])
    # The mean uses the number of hits before this one, so `_add_hit` comes last.
    state.bias += (float(candidates.sd_m[j]) / range_m - state.bias) / (state.hits + 1)
    _add_hit(state, candidates, j)


def _add_hit(state: _Filter, candidates: _FarCandidates, j: int) -> None:
    share = min(max(float(candidates.towards[j]), MIN_TOWARDS), 1.0 - MIN_TOWARDS)
    state.odds = min(MAX_ODDS, max(-MAX_ODDS, state.odds + math.log(share / (1.0 - share))))
    state.scores, state.hits = state.scores + float(candidates.score[j]), state.hits + 1
    since_s = candidates.time_s - STEADY_S if candidates.ego_is_stopped else math.inf
    ranges = (*state.steady, (candidates.time_s, float(candidates.range_m[j])))
    state.steady = [item for item in ranges if item[0] >= since_s]


def _steady_rate(state: _Filter) -> tuple[float, float] | None:
    """Return the rate of a stopped vehicle and its standard deviation (m/s); None if the vehicle may move."""
    if len(state.steady) < STEADY_HITS:
        return None
    times, ranges = np.array(state.steady).T
    times = times - times.mean()
    spread = float(times @ times)
    rate = float(times @ ranges) / spread
    scatter = max(float((ranges - ranges.mean() - rate * times).std()), MIN_SCATTER * float(state.x[0]))
    # Consecutive detections have similar errors, so that two of them count as one.
    sd = scatter * math.sqrt(2.0 / spread)
    shift = float(ranges[-LATEST_HITS:].mean() - ranges[:-LATEST_HITS].mean())
    noticed_m = SAME_SDS * scatter * math.sqrt(2.0 / LATEST_HITS)
    if abs(rate) > SAME_SDS * sd or abs(shift) > noticed_m:
        return None
    # The mean of the latest detections has half the age of the first of them.
    late_s = LATEST_HITS / 2.0 * float(np.diff(times).mean())
    reached_mps = math.sqrt(2.0 * START_MPS2 * noticed_m) + START_MPS2 * late_s
    return rate, math.hypot(sd, reached_mps / 2.0)


def _to_track(state: _Filter, time_s: float) -> FarTrack:
    predicted = replace(state)
    _predict(predicted, time_s, state.camera)
    range_m = max(float(predicted.x[0]), 1.0)
    steady_rate = _steady_rate(state)
    rate, rate_sd = steady_rate or (float(predicted.x[1]), math.sqrt(predicted.p[1, 1]))
    # A relative error of the range causes the same relative error of its rate.
    return FarTrack(
        id=state.id,
        time_s=time_s,
        label=state.label,
        score=state.scores / state.hits,
        x_m=float(predicted.camera[0]) + range_m * math.cos(predicted.bearing),
        y_m=float(predicted.camera[1]) + range_m * math.sin(predicted.bearing),
        bearing_rad=predicted.bearing,
        range_m=range_m,
        range_sd_m=math.hypot(math.sqrt(predicted.p[0, 0]), state.bias * range_m),
        rate_mps=rate,
        rate_sd_mps=math.hypot(rate_sd, state.bias * (rate - state.ego_mps)),
        towards=1.0 / (1.0 + math.exp(-state.odds)),
        first_seen_s=state.first_seen_s,
        last_seen_s=state.last_seen_s,
        hits=state.hits,
    )


def _wrapped(angle: Floats) -> Floats:
    return np.remainder(angle + math.pi, math.tau) - math.pi
