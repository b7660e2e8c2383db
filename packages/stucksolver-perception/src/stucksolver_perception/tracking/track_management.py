"""Decides which tracks end: those that were not detected, although they could be."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from stucksolver_perception.free_space import FreeSpace, footprints, within
from stucksolver_perception.measurements import Floats, PoseEstimate
from stucksolver_perception.rig import LidarRig
from stucksolver_perception.tracking.motion_groups import WHEELED
from stucksolver_perception.tracking.stationarity import MotionState
from stucksolver_perception.tracking.track_state import MAX_ODDS, TrackState
from stucksolver_perception.vehicle_frame import into_vehicle

NEAR_DETECTION_PROB = (0.6, 0.6, 0.6, 0.6, 0.4, 0.6, 0.6, 0.4)
"""(labels,): probability that a nearby visible object is detected in one cycle. It is lower than the measured recall
(see `noise.py`: 0.96 for cars, 0.98 for trucks), because misses are correlated: five cycles are not five independent
chances."""
FAR_DETECTION_PROB = (0.4, 0.35, 0.3, 0.35, 0.2, 0.4, 0.3, 0.15)
"""(labels,): this probability at the end of the group's `range_m`, where the recall is 0.93 for cars and 0.7 for
trucks."""
OCCUPIED_DETECTION_PROB = 0.25
"""Maximum of this probability if the position is not proven free, although no nearer object hides it: its points have
no detection. This ends the tracks of walls and hedges that were once detected as an object. Ours."""
MIN_ODDS = -1.5
"""Log odds of existence below which a track ends (18 %). Ours."""
UNCONFIRMED_S = 0.35
"""Time after which an unconfirmed track without further detections ends (s). Ours."""
MAX_HIT_SHARE = 0.95
"""Maximum probability of existence from one detection. Ours."""
MAX_HIDDEN_SD_M = 2.5
"""Standard deviation of a hidden object's position above which its track ends (m). The object may be anywhere in the
occluded area, which does not count as free in any case. Ours."""
STRENGTH_GAIN = 0.2
"""Gain of the running mean of scores, over about five cycles. Ours."""
ODDS_MARGIN = 2.0
"""Maximum difference of the log odds from those of the mean score, so that an object with weak detections in every
second cycle never becomes certain. Ours."""
NEARER_M = 0.5
"""Minimum distance of a tall return before an object's front, to hide the object (m). Ours."""
LOW_M, LOW_STATIC_M = 0.5, 1.0
"""Heights below which objects are not excluded by free space (m): rays may pass above them (`free_space.HEIGHT_M`). The
second value is for static objects, which cannot leave. A cone continues if a passing car hides it for a short time, or
if it is detected only sometimes. Ours."""
SHORT_M = 1.0
"""Length by which the box of a long vehicle may be too short (m), because the network detects only its rear."""
BOX_MARGIN_M = 0.2
"""Margin around a box within which returns come from its object (m). Ours."""
LOW_SHARE = 0.3
"""Minimum height of these returns, as a share of the object's height. Ours."""
MIN_VEHICLE_RETURNS = 12
"""Minimum number of these returns that prove that a vehicle still exists. Ours."""
MIN_OTHER_RETURNS = 4
"""Minimum number of these returns that prove that another object still exists. Ours."""
PATH_HALF_WIDTH_M = 1.5
"""Half width of the ego's path (m). Ours."""
CONCEALED_M = 5.0
"""Distance within which the LiDAR's lowest beam passes above low objects (m)."""
CONCEALED_SCORE = 5.0
"""Minimum sum of the scores of an object that certainly exists: ten good detections. The network sometimes detects
static objects that do not exist. Ours."""
OCCLUSION_MARGIN = 0.8
"""Share of an object's width that a nearer one must cover to hide it. Ours."""


def add_hit(state: TrackState, score: float) -> None:
    """Update the odds of a track with a detection of this score."""
    share = min(MAX_HIT_SHARE, max(0.05, score))
    state.strength = score if state.hits <= 1 else state.strength + STRENGTH_GAIN * (score - state.strength)
    mean = min(MAX_HIT_SHARE, max(0.05, state.strength))
    max_odds = min(MAX_ODDS, math.log(mean / (1.0 - mean)) + ODDS_MARGIN)
    state.odds = min(max_odds, state.odds + math.log(share / (1.0 - share)) + 1.0)


def add_miss(state: TrackState, distance_m: float, free: bool) -> None:
    """Update the odds of a track that could be detected, but was not.

    `free` is True if its position is proven free, or belongs to another track.
    """
    distance_share = min(1.0, distance_m / state.group.range_m)
    near_prob, far_prob = NEAR_DETECTION_PROB[state.label], FAR_DETECTION_PROB[state.label]
    free_prob = near_prob + (far_prob - near_prob) * distance_share
    detection_prob = free_prob if free else min(OCCUPIED_DETECTION_PROB, near_prob)
    state.hidden = False
    state.strength *= 1.0 - STRENGTH_GAIN
    state.odds += math.log(1.0 - detection_prob)


def keep_occluded(state: TrackState, distance_m: float, now_s: float) -> None:
    """Extend the memory of a static object that the nose of the stopped ego hides.

    If a certain object were forgotten, the ego would drive over it when it starts.
    """
    if state.group.is_static and distance_m < CONCEALED_M and state.scores >= CONCEALED_SCORE:
        state.concealed_s += now_s - state.last_cycle_s


def tracks_explaining_returns(states: list[TrackState], pose: PoseEstimate, standing: Floats) -> dict[int, float]:
    """Return the ids and odds of the tracks from which some of the returns come.

    The network sometimes misses a van close ahead, or a box on the road, for a second. It still returns rays, which
    prove that the object exists. Next to the ego's path this applies only to vehicles: curbs and hedges return rays
    too, at positions of false detections.

    Args:
        states: Stationary tracks.
        pose: Pose of the ego.
        standing: (m, 3): x, y (m, vehicle frame) and height above the ground (m) of returns above the ground.
    """
    explaining = {}
    boxes = into_vehicle(np.array([(*b.x[:3], *b.size, b.x[3]) for b in states]).reshape(-1, 7), pose)
    for state, footprint in zip(states, footprints(boxes), strict=True):
        is_vehicle = WHEELED[state.label]
        if not is_vehicle and abs(footprint[1]) > PATH_HALF_WIDTH_M:
            continue
        inside = within(footprint[None], standing[:, 0], standing[:, 1], BOX_MARGIN_M, BOX_MARGIN_M)
        inside &= standing[:, 2] > LOW_SHARE * state.size[2]
        if inside.sum() >= (MIN_VEHICLE_RETURNS if is_vehicle else MIN_OTHER_RETURNS):
            explaining[state.id] = state.odds
    return explaining


def explained_by(states: list[TrackState], pose: PoseEstimate, standing: Floats) -> NDArray[np.bool_]:
    """Return (m,): True for the returns (see `tracks_explaining_returns`) that come from one of these tracks."""
    boxes = into_vehicle(np.array([(*b.x[:3], *b.size, b.x[3]) for b in states]).reshape(-1, 7), pose)
    return within(footprints(boxes), standing[:, 0], standing[:, 1], SHORT_M, BOX_MARGIN_M)


def is_ended(state: TrackState, now_s: float, confirmed: bool) -> bool:
    """Return True if a track ends."""
    missing_s = now_s - state.last_seen_s - state.concealed_s
    if state.odds < MIN_ODDS or (not confirmed and missing_s > UNCONFIRMED_S):
        return True
    if state.hidden and float(np.linalg.eigvalsh(state.p[:2, :2])[-1]) > MAX_HIDDEN_SD_M**2:
        return True
    is_stationary = state.motion is MotionState.STANDING
    return missing_s > (state.group.memory_stationary_s if is_stationary else state.group.memory_moving_s)


def undetectable(
    states: list[TrackState], others: list[TrackState], pose: PoseEstimate, lidar: LidarRig, space: FreeSpace | None
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return two masks (tracks,): tracks that could not be detected, and tracks at a position that is proven free.

    A track cannot be detected outside the LiDAR's cone or range, or if a nearer object hides it: a tall return in
    `space`, or without `space` one of `others`. An object with its center in free space would have blocked the rays
    that passed there, unless it is low. Without `space` every position counts as free.
    """
    x, y, size = _in_sensor(states, pose, lidar)
    distance = np.hypot(x, y)
    reach = np.array([state.group.range_m for state in states])
    up = lidar.mount.z_m
    # The lowest beam passes above nearby low objects.
    lowest = up - np.maximum(0.0, distance - size[:, 0] / 2) * math.tan(math.radians(-lidar.lower_deg))
    hidden: NDArray[np.bool_] = (distance > np.minimum(reach, lidar.range_m)) | (lowest > size[:, 2])
    free: NDArray[np.bool_] = np.ones(len(states), np.bool_)
    if space is not None:
        mount, count = lidar.mount, len(space.blocked_m)
        low = np.array([LOW_STATIC_M if state.group.is_static else LOW_M for state in states])
        free = space.is_proven_free(x + mount.x_m, y + mount.y_m) & (size[:, 2] >= low)
        bins = ((np.arctan2(y, x) + math.pi) / math.tau * count).astype(np.int64) % count
        front = distance - np.hypot(size[:, 0], size[:, 1]) / 2 - NEARER_M
        return hidden | (~free & (space.blocked_m[bins] < front)), free
    if others:
        hidden |= _shadowed(x, y, size, *_in_sensor(others, pose, lidar), up)
    return hidden, free


def _in_sensor(states: list[TrackState], pose: PoseEstimate, lidar: LidarRig) -> tuple[Floats, Floats, Floats]:
    """Return x and y (n,) of the tracks from the LiDAR's foot, along the vehicle's axes, and sizes (n, 3), all in m."""
    positions = np.array([state.x[:2] for state in states])
    dx, dy = positions[:, 0] - pose.x_m, positions[:, 1] - pose.y_m
    cos, sin = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
    x = dx * cos + dy * sin - lidar.mount.x_m
    y = dy * cos - dx * sin - lidar.mount.y_m
    return x, y, np.array([state.size for state in states])


def _shadowed(
    x: Floats, y: Floats, size: Floats, by_x: Floats, by_y: Floats, by_size: Floats, up: float
) -> NDArray[np.bool_]:
    """Return (n,): True for objects in the shadow of one of the others, from a sensor `up` meters above the ground.

    The apparent width of an object is the mean of its length and width. It hides another one if it is nearer, covers
    most of its directions, and the line from the sensor over its top passes above the other's top.
    """
    distance, by_distance = np.hypot(x, y), np.maximum(0.5, np.hypot(by_x, by_y))
    safe_distance = np.maximum(0.5, distance)
    half = np.arctan2((size[:, 0] + size[:, 1]) / 4, safe_distance)
    by_half = np.arctan2((by_size[:, 0] + by_size[:, 1]) / 4, by_distance)
    between = np.abs((np.arctan2(y, x)[:, None] - np.arctan2(by_y, by_x)[None] + np.pi) % (2 * np.pi) - np.pi)
    is_covered = between + OCCLUSION_MARGIN * half[:, None] <= by_half[None]
    is_nearer = by_distance[None] + by_size[None, :, :2].min(-1) / 2 < distance[:, None]
    is_lower = (up - by_size[:, 2])[None] / by_distance[None] <= (up - size[:, 2])[:, None] / safe_distance[:, None]
    return np.asarray((is_covered & is_nearer & is_lower).any(1))
