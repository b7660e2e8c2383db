"""Small made-up drives: a road, and boxes whose sides a LiDAR would hit."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from stucksolver.scene import ObjectKind
from stucksolver_perception.measurements import Floats, LidarSweep, Singles
from stucksolver_perception.recording import KINDS, Recorded, RecordingWriter, Truth
from stucksolver_perception.rig import load_rig

TICK_S = 0.05
SHAPES = {
    ObjectKind.CAR: (4.5, 1.9, 1.5),
    ObjectKind.TRUCK: (8.0, 2.5, 3.2),
    ObjectKind.PEDESTRIAN: (0.6, 0.6, 1.8),
    ObjectKind.CONE: (0.4, 0.4, 0.7),
    ObjectKind.PROP: (1.0, 1.0, 1.0),
}


def drive(folder: Path, seed: int, ticks: int = 24, bodies: int = 14, per_body: int = 60, ground: int = 1500) -> None:
    """Writes a recording: our vehicle drives along a curve among boxes, some of which move."""
    random = np.random.default_rng(seed)
    kinds = [list(SHAPES)[i] for i in random.integers(0, len(SHAPES), bodies)]
    sizes = np.array([SHAPES[kind] for kind in kinds])
    places = random.uniform(-30, 40, (bodies, 2))
    places[np.hypot(*places.T) < 6] += 12
    yaws, speeds = random.uniform(-math.pi, math.pi, bodies), random.choice([0.0, 5.0], bodies)
    velocities = speeds[:, None] * np.stack([np.cos(yaws), np.sin(yaws)], axis=1)
    writer = RecordingWriter(folder, load_rig(), {"town": "made_up", "seed": seed})
    for tick in range(ticks):
        time_s = tick * TICK_S
        pose = np.array([8.0 * time_s, 0.3 * time_s, 0.0, 0.1 + 0.1 * time_s, 0.0, 0.0, 8.0, 0.1, 0.0])
        middle = np.concatenate([places + velocities * time_s, sizes[:, 2:] / 2], axis=1)
        boxes = np.concatenate([middle, yaws[:, None], sizes, velocities], axis=1)
        points = np.concatenate([_ground(random, ground), _hits(random, boxes, pose, per_body)]).astype(np.float32)
        writer.add(_recorded(time_s, pose, points, kinds, boxes))
    writer.close()


def _recorded(time_s: float, pose: Floats, points: Singles, kinds: list[ObjectKind], boxes: Floats) -> Recorded:
    count = len(boxes)
    truth = Truth(
        np.arange(count) + 1,
        np.array([KINDS.index(kind) for kind in kinds]),
        boxes,
        *(np.full(count, -1) for _ in range(4)),
        ("made.up",) * count,
    )
    sweep = LidarSweep(time_s, points)
    return Recorded(time_s, pose, sweep, np.zeros(7), np.zeros(3), 8.0, truth, None, None, None)


def _ground(random: np.random.Generator, count: int) -> Floats:
    far, way = random.uniform(3, 45, count), random.uniform(-math.pi, math.pi, count)
    return np.stack([far * np.cos(way), far * np.sin(way), np.zeros(count), np.full(count, 0.3)], axis=1)


def _hits(random: np.random.Generator, boxes: Floats, pose: Floats, each: int) -> Floats:
    """Points on the sides of boxes, as the vehicle at `pose` measures them."""
    inside = random.uniform(-0.5, 0.5, (len(boxes), each, 3))
    side = random.integers(0, 2, (len(boxes), each))
    np.put_along_axis(inside, side[..., None], np.sign(random.uniform(-1, 1, (*side.shape, 1))) * 0.5, axis=2)
    local = inside * boxes[:, None, 4:7]
    cos, sin = np.cos(boxes[:, 3])[:, None], np.sin(boxes[:, 3])[:, None]
    x = boxes[:, 0, None] + cos * local[..., 0] - sin * local[..., 1] - pose[0]
    y = boxes[:, 1, None] + sin * local[..., 0] + cos * local[..., 1] - pose[1]
    z = boxes[:, 2, None] + local[..., 2]
    c, s = math.cos(pose[3]), math.sin(pose[3])
    return np.stack([c * x + s * y, c * y - s * x, z, np.full_like(x, 0.6)], axis=2).reshape(-1, 4)
