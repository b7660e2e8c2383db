"""Tracks vehicles that only the camera sees: their range and its rate, image by image.

The range from one image is off by a tenth or more, and mostly in the same way in each image: the vehicle is larger than
usual, or the road slopes. The remaining difference between images is small, with a slow drift as more of a vehicle
comes into view. A filter treats only these two as noise, so that the rate is known after a second or two. The error
that all images share is added to the output (`FarTrack.range_sd_m`, `rate_sd_mps`).

The state has one dimension, along the line of sight. At these ranges a lane of the road is nearly parallel to it; the
tracks are placed on the lane later (`stucksolver_perception/carla/far_vehicle_reports.py`). The ego's own motion is
removed with its poses, so that the rate is one over ground.
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
"""Ids begin here, far above those of the LiDAR's tracks."""
LABELS = (0, 1)
"""Vehicles and two-wheelers (`far_strip.LABELS`). People this far away do not matter at town speeds."""
NEAREST_M = 40.0
"""Nearer detections begin no track, and tracks are not told there: the LiDAR finds nearly all, and one in eight of the
camera's is wrong. What drifts in is mostly something that the LiDAR tracks elsewhere.
"""
NOISE_SHARE = 0.05
"""Standard deviation of the range between consecutive images, as a share of the range."""
DRIFT_SHARE = 0.05
"""Standard deviation of the drift of one vehicle's range per second, as a share: more of it comes into view."""
RATE_SD_MPS = 15.0
"""Before a rate is measured: 95 % of vehicles are slower than twice this, 108 km/h."""
ACCELERATION_MPS2 = 2.0
"""Standard deviation of the acceleration, as in the LiDAR's tracker for vehicles."""
ASIDE_M = 0.7
"""Sideways motion of a vehicle across the line of sight between two images, with bends; three times this is no lane."""
GATE = 3.0
"""A detection belongs to a track within this many standard deviations in range and in bearing."""
SAME_SDS = 2.5
SAME_M = 6.0
SAME_ASIDE_M = 2.0
"""A LiDAR track within these standard deviations or meters in range, and this far aside, is the same vehicle."""
CONFIRMING_HITS = 2
CONFIRMING_SHARE = 1.0 / 3.0
"""A vehicle that was found in fewer of the images since its first one is not reported: false ones come in twos. Where
it was found, sight still ends.
"""
STEADY_S, STEADY_LOOKS = 5.0, 15
"""While the ego stands, a vehicle whose range has not changed over this time, in at least so many looks, stands too."""
LATEST_LOOKS = 5
"""Their mean must not differ from that of the others, so that who sets off is noticed soon. Until then, two standard
deviations of the rate are the speed that it may have reached.
"""
LEAST_SCATTER = 0.002
"""As a share of the range: the detector repeats itself as long as the picture does."""
SETS_OFF_MPS2 = 2.5
"""Acceleration of a vehicle that sets off briskly."""
STANDS_MPS = 0.1
HANDED_HITS = 10
"""The LiDAR takes a vehicle over after so many detections, a second: at the edge of its grid it measures speeds of
20 m/s as 10 to 14 at first.
"""
LOST_S = 2.0
"""A track ends when it has not been detected for this long. Long, since a missed vehicle keeps coming."""
REFUTED_SDS = 3.0
REFUTED_FROM_M = 6.0
"""Around the vehicle itself the LiDAR sees nothing."""
LEAST_TOWARDS, MOST_ODDS = 0.02, 4.0
"""No look counts for more than 0.98, and all together for no more than this log odds: looks repeat their mistakes."""


@dataclass(frozen=True, eq=False)
class FarTrack:
    """One vehicle that the camera tracks, at `time_s`."""

    id: int
    """Never that of a LiDAR track, and never used twice by one tracker."""
    time_s: float
    label: int
    """Index into `far_strip.LABELS`."""
    score: float
    """Mean of its detections' scores."""
    x_m: float
    y_m: float
    """Its center at the most likely range, local frame (m)."""
    bearing_rad: float
    """Direction in the local frame from the camera to it (rad)."""
    range_m: float
    """Range from the camera (m)."""
    range_sd_m: float
    rate_mps: float
    """Velocity over ground along the bearing (m/s); negative toward the ego."""
    rate_sd_mps: float
    towards: float
    """Probability that its front is visible."""
    first_seen_s: float
    last_seen_s: float
    hits: int


def is_refuted(track: FarTrack, seen: FreeSpace, pose: PoseEstimate) -> bool:
    """True if the LiDAR saw that nobody is where the track may be: along its bearing, `REFUTED_SDS` around its range.

    False ones begin with detections of things nearby, whose range is taken for too long, and drift in. `seen` is in the
    vehicle frame at `pose`.
    """
    reach = REFUTED_SDS * track.range_sd_m
    along = np.arange(max(track.range_m - reach, REFUTED_FROM_M), track.range_m + reach, CELL_M)
    if not len(along):
        return False
    off = along - track.range_m
    line = np.array([math.cos(track.bearing_rad), math.sin(track.bearing_rad)])
    x, y = points_into_vehicle(np.array([track.x_m, track.y_m]) + off[:, None] * line, pose).T
    return bool(seen.is_proven_free(x, y).all())


@dataclass(eq=False)
class _Body:
    id: int
    x: Floats
    """(2,): range (m), rate over ground (m/s)."""
    p: Floats
    time_s: float
    bearing: float
    """Local frame."""
    at: Floats
    """(2,): position of the camera at `time_s`, local frame."""
    label: int
    first_seen_s: float
    last_seen_s: float
    bias: float
    """Standard deviation of the error common to all its ranges, as a share of the range."""
    own_mps: float
    """The ego's speed along the bearing at the last detection."""
    scores: float = 0.0
    odds: float = 0.0
    hits: int = 0
    looks: int = 1
    """Images since the first detection, with it."""
    steady: list[tuple[float, float]] = field(default_factory=list)
    """Times (s) and ranges (m) of the last detections while the ego stands."""


@dataclass(frozen=True, eq=False)
class _FarCandidates:
    """Detections of one image that may be far vehicles; equal lengths."""

    time_s: float
    at: Floats
    """(2,): position of the camera, local frame."""
    range_m: Floats
    sd_m: Floats
    bearing: Floats
    label: Floats
    score: Floats
    towards: Floats
    own_mps: Floats
    """The ego's speed along the bearing."""
    stands: bool
    """True if the ego does."""


class FarTracker:
    """Call `update` with each image's detections, and `tracks` whenever they are wanted."""

    def __init__(self, rig: CameraRig, model: RangeModel) -> None:
        # The first import takes a while: not in the first look.
        import filterpy.kalman  # type: ignore[import-untyped]  # noqa: F401

        self._rig, self._model = rig, model
        self._bodies: list[_Body] = []
        self._next = FIRST_ID
        self._with_own: set[int] = set()

    def update(self, found: FarDetections, pose: PoseEstimate, lidar: Sequence[Track]) -> None:
        """Add one image.

        Args:
            found: From `FarDetector.detect`; later than before.
            pose: The vehicle's pose at `found.time_s`.
            lidar: The LiDAR's tracks at about the same time; each explains at most one detection, which is then left to
                it.
        """
        seen = self._seen(found, pose)
        for body in self._bodies:
            _predict(body, seen.time_s, seen.at)
            body.looks += 1
        explained = _same(seen.bearing, seen.range_m, seen.sd_m, lidar, seen.at, seen.time_s)
        self._with_own = {lidar[k].id for k in explained.values()}
        left = [j for j in range(len(seen.range_m)) if j not in explained]
        taken = self._assign(seen, left)
        for i, j in taken.items():
            _update(self._bodies[i], seen, j)
        for j in set(left) - set(taken.values()):
            if seen.range_m[j] >= NEAREST_M:
                self._bodies.append(_born(self._next, seen, j))
                self._next += 1
        self._bodies = [body for body in self._bodies if seen.time_s - body.last_seen_s <= LOST_S]

    def tracks(self, time_s: float, lidar: Sequence[Track]) -> tuple[FarTrack, ...]:
        """Return all tracks at a time (s) not before the last image, except near ones.

        A track whose place the LiDAR has tracked for a second is handed over and no longer reported. If the last image
        showed both the LiDAR's and another vehicle there, the track is the other one and stays.
        """
        lidar = [track for track in lidar if track.hits >= HANDED_HITS]
        without_own = [track for track in lidar if track.id not in self._with_own]
        shown = [body for body in self._bodies if body.last_seen_s == body.time_s]
        rest = [body for body in self._bodies if body.last_seen_s != body.time_s]
        self._bodies = _left_over(shown, without_own, time_s) + _left_over(rest, lidar, time_s)
        # A vehicle that was detected once may be false.
        told = (_told(body, time_s) for body in self._bodies if _is_confirmed(body))
        return tuple(track for track in told if track.range_m + track.range_sd_m > NEAREST_M)

    def _seen(self, found: FarDetections, pose: PoseEstimate) -> _FarCandidates:
        part = found.part(np.isin(found.label, LABELS))
        places, mount = far_places(part, self._rig, self._model), self._rig.mount
        away = places.xy - np.array([mount.x_m, mount.y_m])
        c, n = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
        at = np.array([pose.x_m + c * mount.x_m - n * mount.y_m, pose.y_m + n * mount.x_m + c * mount.y_m])
        bearing = np.arctan2(away[:, 1], away[:, 0]) + pose.yaw_rad
        ranges = (places.range_m, places.range_sigma_m, bearing)
        own = pose.speed_mps * np.cos(bearing - pose.yaw_rad)
        stands = abs(pose.speed_mps) < STANDS_MPS
        return _FarCandidates(part.time_s, at, *ranges, part.label.astype(float), part.score, part.towards, own, stands)

    def _assign(self, seen: _FarCandidates, left: list[int]) -> dict[int, int]:
        """Return which detection belongs to which body, both by index."""
        if not self._bodies or not left:
            return {}
        state = np.array([(b.x[0], math.sqrt(b.p[0, 0]), b.bearing) for b in self._bodies])
        place, sd, bearing = (state[:, k, None] for k in range(3))
        range_m = seen.range_m[left]
        along = (place - range_m) / np.hypot(sd, NOISE_SHARE * range_m)
        aside = COLUMN_SIGMA_PX / self._rig.focal_px + ASIDE_M / np.maximum(place, 1.0)
        across = _wrapped(bearing - seen.bearing[left]) / aside
        # A detection further off than noise explains, but within the range error, begins no second track.
        near = (abs(along) < GATE) | (abs(place - range_m) < SAME_SDS * seen.sd_m[left])
        cost = along**2 + across**2
        return {i: left[j] for i, j in _pairs(np.where(near & (abs(across) < GATE), cost, np.inf))}


def _is_confirmed(body: _Body) -> bool:
    return body.hits >= CONFIRMING_HITS and body.hits >= CONFIRMING_SHARE * body.looks


def _left_over(bodies: list[_Body], lidar: Sequence[Track], time_s: float) -> list[_Body]:
    """Return those at whose place the LiDAR tracks nothing."""
    if not bodies or not lidar:
        return bodies
    told = [_told(body, time_s) for body in bodies]
    bearing, range_m, sd_m = np.array([(item.bearing_rad, item.range_m, item.range_sd_m) for item in told]).T
    handed = _same(bearing, range_m, sd_m, lidar, bodies[0].at, time_s)
    return [body for i, body in enumerate(bodies) if i not in handed]


def _same(
    bearing: Floats, range_m: Floats, sd_m: Floats, lidar: Sequence[Track], at: Floats, time_s: float
) -> dict[int, int]:
    """Match far objects to LiDAR tracks, by index; each at most once."""
    if not len(range_m) or not lidar:
        return {}
    rows = [(t.x_m + t.vx_mps * (time_s - t.time_s), t.y_m + t.vy_mps * (time_s - t.time_s)) for t in lidar]
    away = np.array(rows) - at
    place = np.hypot(away[:, 0], away[:, 1])[None]
    aside = np.abs(_wrapped(bearing[:, None] - np.arctan2(away[:, 1], away[:, 0])[None])) * place
    along = np.abs(range_m[:, None] - place)
    reach = np.maximum(SAME_SDS * sd_m, SAME_M)[:, None]
    return dict(_pairs(np.where((aside < SAME_ASIDE_M) & (along < reach), along / reach + aside, np.inf)))


def _pairs(cost: Floats) -> Iterable[tuple[int, int]]:
    """Return matching rows and columns, the cheapest pair first; infinite costs never match."""
    cost = cost.copy()
    while cost.size and np.isfinite(cost).any():
        i, j = (int(k) for k in np.unravel_index(int(cost.argmin()), cost.shape))
        yield i, j
        cost[i], cost[:, j] = np.inf, np.inf


def _born(number: int, seen: _FarCandidates, j: int) -> _Body:
    range_m = float(seen.range_m[j])
    p = np.diag([(NOISE_SHARE * range_m) ** 2, RATE_SD_MPS**2])
    body = _Body(
        number,
        np.array([range_m, 0.0]),
        p,
        seen.time_s,
        float(seen.bearing[j]),
        seen.at,
        int(seen.label[j]),
        seen.time_s,
        seen.time_s,
        float(seen.sd_m[j]) / range_m,
        float(seen.own_mps[j]),
    )
    _note(body, seen, j)
    return body


def _transition(dt: float, range_m: float) -> tuple[Floats, Floats]:
    """Return matrix and process noise of a step of `dt` s: constant velocity with white noise; ranges drift."""
    noise = ACCELERATION_MPS2**2 * np.array([[dt**3 / 3.0, dt**2 / 2.0], [dt**2 / 2.0, dt]])
    noise[0, 0] += (DRIFT_SHARE * range_m) ** 2 * dt
    return np.array([[1.0, dt], [0.0, 1.0]]), noise


def _predict(body: _Body, time_s: float, at: Floats) -> None:
    """Predict a body to a time at which the camera is elsewhere."""
    from filterpy.kalman import predict as kalman_predict

    body.x, body.p = kalman_predict(body.x, body.p, *_transition(time_s - body.time_s, float(body.x[0])))
    line = np.array([math.cos(body.bearing), math.sin(body.bearing)])
    away = body.at + float(body.x[0]) * line - at
    body.x = np.array([math.hypot(*away), body.x[1]])
    body.bearing, body.at, body.time_s = math.atan2(away[1], away[0]), at, time_s


def _update(body: _Body, seen: _FarCandidates, j: int) -> None:
    from filterpy.kalman import update as kalman_update

    range_m = float(seen.range_m[j])
    # A measurement further off than noise explains counts for less.
    noise = max((NOISE_SHARE * range_m) ** 2, (range_m - float(body.x[0])) ** 2 / GATE**2)
    body.x, body.p = kalman_update(body.x, body.p, range_m, noise, np.array([[1.0, 0.0]]))
    body.bearing, body.last_seen_s, body.own_mps = float(seen.bearing[j]), seen.time_s, float(seen.own_mps[j])
    body.bias += (float(seen.sd_m[j]) / range_m - body.bias) / (body.hits + 1)
    _note(body, seen, j)


def _note(body: _Body, seen: _FarCandidates, j: int) -> None:
    share = min(max(float(seen.towards[j]), LEAST_TOWARDS), 1.0 - LEAST_TOWARDS)
    body.odds = min(MOST_ODDS, max(-MOST_ODDS, body.odds + math.log(share / (1.0 - share))))
    body.scores, body.hits = body.scores + float(seen.score[j]), body.hits + 1
    since_s = seen.time_s - STEADY_S if seen.stands else math.inf
    body.steady = [item for item in (*body.steady, (seen.time_s, float(seen.range_m[j]))) if item[0] >= since_s]


def _steady_rate(body: _Body) -> tuple[float, float] | None:
    """Return the rate (m/s) of a vehicle that stands, and its standard deviation; None if it may move."""
    if len(body.steady) < STEADY_LOOKS:
        return None
    times, ranges = np.array(body.steady).T
    times = times - times.mean()
    spread = float(times @ times)
    rate = float(times @ ranges) / spread
    scatter = max(float((ranges - ranges.mean() - rate * times).std()), LEAST_SCATTER * float(body.x[0]))
    # Consecutive looks err alike, so that two say little more than one.
    sd = scatter * math.sqrt(2.0 / spread)
    shift = float(ranges[-LATEST_LOOKS:].mean() - ranges[:-LATEST_LOOKS].mean())
    noticed_m = SAME_SDS * scatter * math.sqrt(2.0 / LATEST_LOOKS)
    if abs(rate) > SAME_SDS * sd or abs(shift) > noticed_m:
        return None
    # The mean of the latest looks is half their time old.
    late_s = LATEST_LOOKS / 2.0 * float(np.diff(times).mean())
    reached_mps = math.sqrt(2.0 * SETS_OFF_MPS2 * noticed_m) + SETS_OFF_MPS2 * late_s
    return rate, math.hypot(sd, reached_mps / 2.0)


def _told(body: _Body, time_s: float) -> FarTrack:
    ahead = replace(body)
    _predict(ahead, time_s, body.at)
    range_m = max(float(ahead.x[0]), 1.0)
    known = _steady_rate(body)
    rate, rate_sd = known or (float(ahead.x[1]), math.sqrt(ahead.p[1, 1]))
    # A range that is off by some share makes its rate off by the same share.
    return FarTrack(
        id=body.id,
        time_s=time_s,
        label=body.label,
        score=body.scores / body.hits,
        x_m=float(ahead.at[0]) + range_m * math.cos(ahead.bearing),
        y_m=float(ahead.at[1]) + range_m * math.sin(ahead.bearing),
        bearing_rad=ahead.bearing,
        range_m=range_m,
        range_sd_m=math.hypot(math.sqrt(ahead.p[0, 0]), body.bias * range_m),
        rate_mps=rate,
        rate_sd_mps=math.hypot(rate_sd, body.bias * (rate - body.own_mps)),
        towards=1.0 / (1.0 + math.exp(-body.odds)),
        first_seen_s=body.first_seen_s,
        last_seen_s=body.last_seen_s,
        hits=body.hits,
    )


def _wrapped(angle: Floats) -> Floats:
    return np.remainder(angle + math.pi, math.tau) - math.pi
