"""Assigns detections to tracks, and finds duplicates."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.measurements import Detections, Floats
from stucksolver_perception.tracking.motion_groups import GROUP_OF_LABEL, WHEELED
from stucksolver_perception.tracking.noise import NoisyDetections
from stucksolver_perception.tracking.stationarity import MotionState
from stucksolver_perception.tracking.track_state import TrackState

GATE = 49.0
"""Maximum squared Mahalanobis distance in x, y. It is wide (7 standard deviations), because errors of detections are
sometimes twice as large as assumed. The joint assignment and `reach_m` separate neighboring objects. Ours."""
OTHER_GROUP = 36.0
"""Additional cost of a detection of another group, so that a cyclist with one detection as a car remains one object.
Ours."""
MAX_COST = 1e6
"""Cost of a pair that is not allowed."""
INNER_SHARE = 0.9
"""Inner part of a box that contains no center of another object. Ours."""
WALKER_SHARE = 0.5
"""Score of a pedestrian, as a share of another object's score at the same position, below which it is a duplicate.
Pedestrians stand close to bicycles and barriers, and a missing one is the worst error. Ours."""
SAME_STATIC_M = 0.5
"""Distance of centers within which two static objects are the same, with detection errors (m). Ours."""
SAME_POSITION_M = 0.35
"""Distance of centers within which two detections are the same object (m). Ours."""
SWEEP_SPAN_S = 0.5
"""Time of the sweeps that the network uses (s)."""
TAIL_LATERAL_M = 0.5
"""Distance next to a vehicle's path within which its tail shifts static objects (m): the width of a cone."""
TAIL_MPS = 2.0
"""Speed below which a vehicle has no tail (m/s), because the tail is as short as a static object. Ours."""


def assign(states: list[TrackState], detections: NoisyDetections) -> list[tuple[int, int]]:
    """Return pairs (track, detection) with the least total cost, each used once.

    Centers are compared after the tracks were predicted with their velocity (Yin, Zhou, Krähenbühl, "Center-based 3D
    Object Detection and Tracking", 2021), with the Mahalanobis distance (Chiu et al., "Probabilistic 3D Multi-Object
    Tracking", 2020). The assignment is solved jointly (Weng et al., "AB3DMOT", 2020). The cost is the negative
    log-likelihood. Without its determinant, a hidden track with an uncertain position would get the detections of
    others.
    """
    from scipy.optimize import linear_sum_assignment  # type: ignore[import-untyped]

    if not states or not len(detections):
        return []
    squared, spread = _distances(states, detections)
    is_allowed = squared <= GATE
    rows, columns = linear_sum_assignment(np.where(is_allowed, squared + spread, MAX_COST))
    return [(int(i), int(j)) for i, j in zip(rows, columns, strict=True) if is_allowed[i, j]]


def is_inside_track(states: list[TrackState], x: float, y: float) -> bool:
    """Return True if a position is in the box of one of these tracks, so that no second object can be there."""
    for state in states:
        cos, sin = np.cos(state.x[3]), np.sin(state.x[3])
        dx, dy = x - state.x[0], y - state.x[1]
        if abs(dx * cos + dy * sin) < state.size[0] / 2 and abs(dy * cos - dx * sin) < state.size[1] / 2:
            return True
    return False


def is_in_track_wake(states: list[TrackState], x: float, y: float) -> bool:
    """Return True if one of these tracks drives past a position, or did in the last sweeps.

    The network uses the sweeps of half a second at once, so that a passing vehicle has a tail of returns. A cone next
    to it is then detected twice, or shifted toward the tail. A static object cannot be in the path of a vehicle that
    has just passed.
    """
    for state in states:
        speed = float(np.hypot(state.x[4], state.x[5]))
        if not WHEELED[state.label] or state.motion is not MotionState.MOVING or speed < TAIL_MPS:
            continue
        cos, sin = state.x[4] / speed, state.x[5] / speed
        dx, dy = x - state.x[0], y - state.x[1]
        behind, lateral_m = -(dx * cos + dy * sin), abs(dy * cos - dx * sin)
        if (
            -state.size[0] / 2 < behind < state.size[0] / 2 + speed * SWEEP_SPAN_S
            and lateral_m < state.size[1] / 2 + TAIL_LATERAL_M
        ):
            return True
    return False


def is_near_same_label(states: list[TrackState], static_object: TrackState) -> bool:
    """Return True if a static object is at the position of one of these tracks with the same label."""
    x, y = static_object.x[:2]
    return static_object.group.is_static and any(
        state.label == static_object.label and np.hypot(state.x[0] - x, state.x[1] - y) < SAME_STATIC_M
        for state in states
    )


def suppress_duplicates(detections: Detections) -> NDArray[np.int64]:
    """Return the indices of the detections whose center is not in the box of a better one of any label.

    The detector compares only detections of one group of labels, so that a parked bicycle may be a `two_wheeler` and a
    weaker `barrier` at once. No pedestrian or cone can be inside a car.
    """
    order = np.argsort(-detections.score, kind="stable")
    center, size, yaw = detections.center[order], detections.size[order], detections.yaw[order]
    dx, dy = (center[None, :, axis] - center[:, None, axis] for axis in (0, 1))
    cos, sin = np.cos(yaw)[:, None], np.sin(yaw)[:, None]
    along, across = np.abs(dx * cos + dy * sin), np.abs(dy * cos - dx * sin)
    inside = (along < INNER_SHARE * size[:, None, 0] / 2) & (across < INNER_SHARE * size[:, None, 1] / 2)
    is_duplicate = inside | (np.hypot(dx, dy) < SAME_POSITION_M)
    is_pedestrian = detections.label[order] == LABELS.index("pedestrian")
    is_duplicate &= ~is_pedestrian[None] | (
        detections.score[order][None] < WALKER_SHARE * detections.score[order][:, None]
    )
    remains = np.ones(len(order), np.bool_)
    for i in range(len(order)):
        if remains[i]:
            remains[i + 1 :] &= ~is_duplicate[i, i + 1 :]
    return np.asarray(order[remains], np.int64)


def _distances(states: list[TrackState], detections: NoisyDetections) -> tuple[Floats, Floats]:
    """Return two arrays (tracks, detections): the squared Mahalanobis distances, and the logarithms of the determinants
    of their covariances.

    The distances include the cost of another group. They are `MAX_COST` beyond the reach of the track.
    """
    positions = np.array([state.x[:2] for state in states])
    covariance = np.array([state.p[:2, :2] for state in states])
    groups = np.array([GROUP_OF_LABEL[state.label] for state in states])
    reach = np.array([state.group.reach_m for state in states])
    reach = reach + np.minimum(reach, 2.0 * np.sqrt(covariance.trace(axis1=1, axis2=2) / 2.0))
    offset = detections.z[None, :, :2] - positions[:, None]
    total = covariance[:, None] + detections.noise[None, :, :2, :2]
    squared: Floats = np.einsum("ijk,ijkl,ijl->ij", offset, np.linalg.inv(total), offset)
    squared = squared + OTHER_GROUP * (groups[:, None] != GROUP_OF_LABEL[detections.label][None])
    beyond: NDArray[np.bool_] = np.hypot(offset[..., 0], offset[..., 1]) > reach[:, None]
    return np.where(beyond, MAX_COST, squared), np.log(np.linalg.det(total))
