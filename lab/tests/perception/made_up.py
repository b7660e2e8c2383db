"""Small made-up detections and objects."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lab.perception.evaluation.metrics.clear_mot import TrackedFrame
from lab.perception.evaluation.metrics.matching import TruthObjects
from stucksolver_perception.measurements import Detections

CAR, PEDESTRIAN = 0, 3


def detections(*places: tuple[float, float, float], label: int = CAR, yaw: float = 0.0) -> Detections:
    """Boxes of 4 x 2 x 1.5 m at (x, y) with a score each."""
    n = len(places)
    rows = np.array(places, float).reshape(n, 3)
    center = np.column_stack([rows[:, :2], np.zeros(n)])
    size = np.tile([4.0, 2.0, 1.5], (n, 1))
    return Detections(0.0, np.full(n, label), rows[:, 2], center, size, np.full(n, yaw), np.zeros((n, 2)))


def reals(*places: tuple[float, float], label: int = CAR, counted: Sequence[bool] | None = None) -> TruthObjects:
    """Boxes of the same size at (x, y)."""
    n = len(places)
    center = np.column_stack([np.array(places, float).reshape(n, 2), np.zeros(n)])
    seen = np.ones(n, np.bool_) if counted is None else np.array(counted, np.bool_)
    size = np.tile([4.0, 2.0, 1.5], (n, 1))
    return TruthObjects(np.full(n, label), center, size, np.zeros(n), np.zeros((n, 2)), seen, np.arange(n))


def frame(
    objects: dict[int, float], tracks: dict[int, float], scores: dict[int, float] | None = None, unseen: int = -1
) -> TrackedFrame:
    """Objects and tracks on a line: their x by their id. `unseen`: the object that is not counted."""
    told = {} if scores is None else scores
    return TrackedFrame(
        np.array(list(objects), np.int64),
        np.array([(x, 0.0) for x in objects.values()], float).reshape(-1, 2),
        np.array([obj != unseen for obj in objects], np.bool_),
        np.array(list(tracks), np.int64),
        np.array([(x, 0.0) for x in tracks.values()], float).reshape(-1, 2),
        np.array([told.get(track, 1.0) for track in tracks], float),
    )
