"""Data that scoring reads from a recording: poses, true boxes in the vehicle frame, and visible objects."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from lab.perception.evaluation.metrics.matching import ANY_LABEL, Indices, TruthObjects
from stucksolver.scene import ObjectKind
from stucksolver_perception.lidar_labels import LABEL_OF_KIND, LARGE_EMERGENCY_M
from stucksolver_perception.measurements import Floats, PoseEstimate, Singles
from stucksolver_perception.recording import KINDS, Recorded, Recording
from stucksolver_perception.vehicle_frame import boxes_in_body, into_vehicle

LEAST_POINTS = 3
"""Number of points in the last LiDAR revolution below which an object is not counted. Ours."""
TURN_S = 0.075
"""Age up to which points belong to the last revolution (s), at CARLA's 20 ticks per second."""
LEAST_WIDE_PX, LEAST_HIGH_PX = 6, 4
"""Size of the visible pixels below which an actor is not counted in images (px). Ours."""
_GROW_M = 0.1
"""Enlargement of boxes (m). Ours; older points of a moving body lie slightly outside."""
GAP_S = 0.11
"""Time between two ticks above which a recording has a gap (s)."""
LOOK_EVERY = 2
"""Number of ticks per frame of perception: ten frames per second."""
_EVERY_ID = 65536
"""Number of ids in a mask of 16 bits."""


def true_pose(tick: Recorded) -> PoseEstimate:
    """Return the true pose as an estimate with zero covariance."""
    x, y, z, yaw, _, _, speed, rate, _ = (float(item) for item in tick.pose)
    return PoseEstimate(tick.time_s, x, y, z, yaw, speed, rate, np.zeros((4, 4)))


def looks_of(recording: Recording) -> Iterator[tuple[Recorded, ...]]:
    """Yield the ticks of each frame of perception: those since the one before; the last one is its own tick."""
    ticks: list[Recorded] = []
    for number, tick in enumerate(recording):
        ticks.append(tick)
        if number % LOOK_EVERY == 0:
            yield tuple(ticks)
            ticks = []


def label_of(kind: ObjectKind, length_m: float) -> int:
    """Return the index into `LABELS` for a kind of object, or -1 if it has no label."""
    if kind is ObjectKind.EMERGENCY and length_m > LARGE_EMERGENCY_M:
        return LABEL_OF_KIND[ObjectKind.TRUCK]
    return LABEL_OF_KIND.get(kind, ANY_LABEL)


def true_labels(tick: Recorded) -> Indices:
    """Return the label index of each object of a tick, shape (n,)."""
    kinds, lengths = tick.truth.kind.tolist(), tick.truth.boxes[:, 4].tolist()
    return np.array([label_of(KINDS[k], length) for k, length in zip(kinds, lengths, strict=True)], np.int64)


def reals_of(tick: Recorded, points: Singles) -> TruthObjects:
    """Return the objects of a tick in its vehicle frame. `points`, shape (n, 5), are the detector's input."""
    pose, truth = true_pose(tick), tick.truth
    boxes = into_vehicle(truth.boxes[:, [0, 1, 2, 4, 5, 6, 3]], pose)
    recent = points[points[:, 4] <= TURN_S, :3]
    c, s = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
    vx, vy = truth.boxes[:, 7], truth.boxes[:, 8]
    return TruthObjects(
        label=true_labels(tick),
        center=boxes[:, :3],
        size=boxes[:, 3:6],
        yaw=boxes[:, 6],
        velocity=np.stack([vx * c + vy * s, vy * c - vx * s], axis=1),
        counted=points_in(boxes, recent) >= LEAST_POINTS,
        identity=truth.actor_id,
    )


def points_in(boxes: Floats, points: Singles) -> Indices:
    """Return the number of points in each box, shape (m,).

    Args:
        boxes: Shape (m, 7): x, y, z, length, width, height (m), yaw (rad).
        points: Shape (n, 3): x, y, z (m) in the same frame.
    """
    counts = np.zeros(len(boxes), np.int64)
    for i, (x, y, z, length, width, height, yaw) in enumerate(boxes.tolist()):
        near = points[np.abs(points[:, 0] - x) + np.abs(points[:, 1] - y) < length + width + 2.0 * _GROW_M]
        dx, dy, dz = near[:, 0] - x, near[:, 1] - y, near[:, 2] - z
        c, s = math.cos(yaw), math.sin(yaw)
        ahead, left = np.abs(dx * c + dy * s), np.abs(dy * c - dx * s)
        inside = (ahead < length / 2.0 + _GROW_M) & (left < width / 2.0 + _GROW_M) & (np.abs(dz) < height / 2.0)
        counts[i] = int(inside.sum())
    return counts


def body_boxes(tick: Recorded) -> Floats:
    """Return the objects' boxes in the frame of the ego's body, shape (n, 7); it pitches and rolls with the camera."""
    return in_body(tick, tick.truth.boxes[:, [0, 1, 2, 4, 5, 6, 3]])


def in_body(tick: Recorded, boxes: Floats) -> Floats:
    """Transform boxes from the local frame to that of the ego's body; columns start with x, y, z and end with yaw."""
    return boxes_in_body(tick.pose, boxes)


def visible_rectangles(tick: Recorded) -> dict[int, tuple[int, int, int, int]]:
    """Return left, top, right, bottom (px) of each actor's visible pixels, if large enough, by mask id."""
    if tick.instances is None:
        return {}
    mask = tick.instances
    rows, columns = np.nonzero(mask)
    ids, which = np.unique(mask[rows, columns], return_inverse=True)
    edges = np.full((4, len(ids)), 10**6, np.int64)
    for k, values in enumerate((columns, rows, -columns, -rows)):
        np.minimum.at(edges[k], which, values)
    found = {}
    for actor, left, top, right, bottom in zip(ids.tolist(), *edges.tolist(), strict=True):
        rectangle = (left, top, 1 - right, 1 - bottom)
        if rectangle[2] - left >= LEAST_WIDE_PX and rectangle[3] - top >= LEAST_HIGH_PX:
            found[int(actor)] = rectangle
    return found


def mask_id(actor_id: int) -> int:
    """Return an actor's id in the mask, which has 16 bits."""
    return actor_id % _EVERY_ID


def is_continuous(recording: Recording) -> bool:
    """True if a recording has no gaps, so that objects can be tracked."""
    if not recording.files:
        return False
    times = np.array([tick.time_s for tick in recording.stretch(recording.files[0])])
    return bool(len(times) > 1 and np.diff(times).max() < GAP_S)
