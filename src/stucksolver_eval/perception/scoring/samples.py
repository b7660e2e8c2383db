"""What scoring needs of a recording: poses, true boxes in the vehicle frame, and who could be seen at all."""

from __future__ import annotations

import math

import numpy as np

from stucksolver.perception.frames import into_vehicle
from stucksolver.perception.labels import LABEL_OF_KIND, LARGE_EMERGENCY_M
from stucksolver.perception.measurements import Floats, PoseEstimate, Singles
from stucksolver.perception.recording import KINDS, Recorded, Recording
from stucksolver.perception.rig import Mount
from stucksolver.scene import ObjectKind
from stucksolver_eval.perception.metrics.matching import ANY_LABEL, Indices, Reals

LEAST_POINTS = 3
"""Of the last turn of the LiDAR; whoever has fewer is not counted."""
TURN_S = 0.075
"""Points up to this age are those of the last turn, at CARLA's 20 ticks a second."""
LEAST_WIDE_PX, LEAST_HIGH_PX = 6, 4
"""Of an actor's pixels; what shows less is not counted in pictures."""
_GROW_M = 0.1
"""A moving body's older points lie a little beside its box."""
GAP_S = 0.11
_EVERY_ID = 65536


def true_pose(tick: Recorded) -> PoseEstimate:
    """The truth in the form of an estimate."""
    x, y, z, yaw, _, _, speed, rate, _ = (float(one) for one in tick.pose)
    return PoseEstimate(tick.time_s, x, y, z, yaw, speed, rate, np.zeros((4, 4)))


def label_of(kind: ObjectKind, length_m: float) -> int:
    """Index into `LABELS`, -1 for what has none."""
    if kind is ObjectKind.EMERGENCY and length_m > LARGE_EMERGENCY_M:
        return LABEL_OF_KIND[ObjectKind.TRUCK]
    return LABEL_OF_KIND.get(kind, ANY_LABEL)


def true_labels(tick: Recorded) -> Indices:
    """Of all bodies of a tick."""
    kinds, lengths = tick.truth.kind.tolist(), tick.truth.boxes[:, 4].tolist()
    return np.array([label_of(KINDS[k], length) for k, length in zip(kinds, lengths, strict=True)], np.int64)


def reals_of(tick: Recorded, points: Singles) -> Reals:
    """The bodies of a tick in its vehicle frame; `points` (n, 5) are those that the detector is given."""
    pose, truth = true_pose(tick), tick.truth
    boxes = into_vehicle(truth.boxes[:, [0, 1, 2, 4, 5, 6, 3]], pose)
    recent = points[points[:, 4] <= TURN_S, :3]
    c, s = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
    vx, vy = truth.boxes[:, 7], truth.boxes[:, 8]
    return Reals(
        label=true_labels(tick),
        center=boxes[:, :3],
        size=boxes[:, 3:6],
        yaw=boxes[:, 6],
        velocity=np.stack([vx * c + vy * s, vy * c - vx * s], axis=1),
        counted=points_in(boxes, recent) >= LEAST_POINTS,
        identity=truth.actor_id,
    )


def points_in(boxes: Floats, points: Singles) -> Indices:
    """How many of `points` (n, 3) each of `boxes` (m, 7) has: x, y, z, length, width, height, yaw, one frame."""
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
    """(n, 7): the bodies in the frame of the vehicle's body, which is pitched and rolled as the camera is."""
    return in_body(tick, tick.truth.boxes[:, [0, 1, 2, 4, 5, 6, 3]])


def in_body(tick: Recorded, boxes: Floats) -> Floats:
    """Boxes of the local frame, x, y, z first and the yaw last, in the frame of the vehicle's body."""
    x, y, z, yaw, pitch, roll = (float(one) for one in tick.pose[:6])
    turn = Mount(
        x_m=0, y_m=0, z_m=0, yaw_deg=math.degrees(yaw), pitch_deg=math.degrees(pitch), roll_deg=math.degrees(roll)
    ).to_vehicle()[:3, :3]
    moved: Floats = boxes.copy()
    moved[:, :3] = (boxes[:, :3] - (x, y, z)) @ turn
    moved[:, -1] = boxes[:, -1] - yaw
    return moved


def seen_rectangles(tick: Recorded) -> dict[int, tuple[int, int, int, int]]:
    """Left, top, right, bottom (px) of the pixels of each actor that shows enough, by its id in the mask."""
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
    """An actor's id as the mask has it."""
    return actor_id % _EVERY_ID


def is_continuous(recording: Recording) -> bool:
    """Has it every tick, so that things can be followed?"""
    if not recording.files:
        return False
    times = np.array([tick.time_s for tick in recording.stretch(recording.files[0])])
    return bool(len(times) > 1 and np.diff(times).max() < GAP_S)
