"""The assignment of detections to tracks."""

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
"""Squared Mahalanobis distance in x, y. Wide (7 standard deviations), since detectors are at times twice as wrong
as assumed. Two bodies are kept apart by the joint assignment, and because bodies cannot overlap: `reach_m`.
"""
OTHER_GROUP = 36.0
"""Cost of a detection of another group: a cyclist detected once as a car stays one object."""
NEVER = 1e6
INSIDE = 0.9
"""Share of a box within which there can be no second center."""
WALKER_SHARE = 0.5
"""A person yields to another object only if its score is below this share of the other's: people stand close to
bicycles and barriers, and losing one is worst.
"""
SAME_THING_M = 0.5
"""Two things whose middles are this near are one, found once here and once there."""
SAME_PLACE_M = 0.35
"""Nor can there be one this near."""
SWEEPS_S = 0.5
"""The network sees the sweeps of this time."""
TAIL_BESIDE_M = 0.5
"""How far beside the way of a vehicle its tail draws a thing: by a cone's width."""
DRIVES_MPS = 2.0
"""The tail of a slower vehicle is as short as a thing."""


def assign(bodies: list[TrackState], seen: NoisyDetections) -> list[tuple[int, int]]:
    """Return pairs (body, detection) of least total distance, each used once.

    Centers are compared after the tracks were predicted with their velocity (Yin, Zhou, Krähenbühl, "Center-based 3D
    Object Detection and Tracking", 2021), by Mahalanobis distance (Chiu et al., "Probabilistic 3D Multi-Object
    Tracking", 2020). The assignment is solved jointly (Weng et al., "AB3DMOT", 2020). The cost is the negative
    log-likelihood: without the determinant, a hidden track of unknown position would take the detections of others.
    """
    from scipy.optimize import linear_sum_assignment  # type: ignore[import-untyped]

    if not bodies or not len(seen):
        return []
    squared, spread = _distances(bodies, seen)
    allowed = squared <= GATE
    rows, columns = linear_sum_assignment(np.where(allowed, squared + spread, NEVER))
    return [(int(i), int(j)) for i, j in zip(rows, columns, strict=True) if allowed[i, j]]


def inside_another(bodies: list[TrackState], x: float, y: float) -> bool:
    """True if a place lies in the box of one of these bodies. Then there is no second object of any kind."""
    for body in bodies:
        cos, sin = np.cos(body.x[3]), np.sin(body.x[3])
        dx, dy = x - body.x[0], y - body.x[1]
        if abs(dx * cos + dy * sin) < body.size[0] / 2 and abs(dy * cos - dx * sin) < body.size[1] / 2:
            return True
    return False


def in_track_wake(bodies: list[TrackState], x: float, y: float) -> bool:
    """True if one of these bodies drives past a place, or did in the last sweeps.

    The network sees the sweeps of half a second at once: what drives past has a tail of returns. A cone beside it is
    then found once more, or drawn toward the tail. Where something has just driven, no thing stands.
    """
    for body in bodies:
        speed = float(np.hypot(body.x[4], body.x[5]))
        if not WHEELED[body.label] or body.motion is not MotionState.MOVING or speed < DRIVES_MPS:
            continue
        cos, sin = body.x[4] / speed, body.x[5] / speed
        dx, dy = x - body.x[0], y - body.x[1]
        behind, beside = -(dx * cos + dy * sin), abs(dy * cos - dx * sin)
        if (
            -body.size[0] / 2 < behind < body.size[0] / 2 + speed * SWEEPS_S
            and beside < body.size[1] / 2 + TAIL_BESIDE_M
        ):
            return True
    return False


def near_same_class(bodies: list[TrackState], thing: TrackState) -> bool:
    """True if a thing is where one of these bodies is a thing of the same label."""
    x, y = thing.x[:2]
    return thing.group.lifeless and any(
        body.label == thing.label and np.hypot(body.x[0] - x, body.x[1] - y) < SAME_THING_M for body in bodies
    )


def suppress_duplicates(detections: Detections) -> NDArray[np.int64]:
    """Return the indices of the detections whose center is not in the box of a better one of any label.

    The detector compares detections only within one group of labels: a parked bicycle is a `two_wheeler` and a weaker
    `barrier` at once. Nobody walks inside a car, and no cone stands in one.
    """
    order = np.argsort(-detections.score, kind="stable")
    center, size, yaw = detections.center[order], detections.size[order], detections.yaw[order]
    dx, dy = (center[None, :, axis] - center[:, None, axis] for axis in (0, 1))
    cos, sin = np.cos(yaw)[:, None], np.sin(yaw)[:, None]
    along, across = np.abs(dx * cos + dy * sin), np.abs(dy * cos - dx * sin)
    inside = (along < INSIDE * size[:, None, 0] / 2) & (across < INSIDE * size[:, None, 1] / 2)
    taken = inside | (np.hypot(dx, dy) < SAME_PLACE_M)
    walks = detections.label[order] == LABELS.index("pedestrian")
    taken &= ~walks[None] | (detections.score[order][None] < WALKER_SHARE * detections.score[order][:, None])
    kept = np.ones(len(order), np.bool_)
    for i in range(len(order)):
        if kept[i]:
            kept[i + 1 :] &= ~taken[i, i + 1 :]
    return np.asarray(order[kept], np.int64)


def _distances(bodies: list[TrackState], seen: NoisyDetections) -> tuple[Floats, Floats]:
    """Return two arrays (bodies, detections): the squared Mahalanobis distances plus the cost of another group (NEVER
    beyond reach), and the logarithm of the determinant of their covariance.
    """
    at = np.array([body.x[:2] for body in bodies])
    covariance = np.array([body.p[:2, :2] for body in bodies])
    groups = np.array([GROUP_OF_LABEL[body.label] for body in bodies])
    reach = np.array([body.group.reach_m for body in bodies])
    reach = reach + np.minimum(reach, 2.0 * np.sqrt(covariance.trace(axis1=1, axis2=2) / 2.0))
    off = seen.z[None, :, :2] - at[:, None]
    whole = covariance[:, None] + seen.noise[None, :, :2, :2]
    squared: Floats = np.einsum("ijk,ijkl,ijl->ij", off, np.linalg.inv(whole), off)
    squared = squared + OTHER_GROUP * (groups[:, None] != GROUP_OF_LABEL[seen.label][None])
    beyond: NDArray[np.bool_] = np.hypot(off[..., 0], off[..., 1]) > reach[:, None]
    return np.where(beyond, NEVER, squared), np.log(np.linalg.det(whole))
