"""Change of a detector's errors between frames: the noise that a tracker must assume.

A constant position error does not look like motion, but a changing error does. Therefore errors of the same object are
also compared one frame apart and one second apart.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from lab.perception.evaluation.metrics.matching import Matches, TruthObjects, match
from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.measurements import Detections, Floats

RINGS_M = ((0.0, 15.0), (15.0, 30.0), (30.0, 60.0))
"""Ranges of distances from the ego (m)."""
WITHIN_M = 2.0
"""Distance of a match (m)."""
LOOKS_IN_SECOND = 10
"""Number of frames per second."""
MOVES_MPS = 1.0
"""Speed from which an object counts as moving (m/s)."""
SURE = 0.5
"""Score from which a detection counts as confident."""
MOST = 0.683
"""Share of errors below the reported numbers: for a normal distribution, those within one standard deviation."""
_ALONG, _ACROSS, _YAW, _FLIPPED, _V_ALONG, _V_ACROSS, _SPEED = range(7)


@dataclass(frozen=True)
class LabelNoise:
    """Noise of one label in one range; None if unknown. Pairs are along and across the object's axis."""

    objects: int
    recall: float | None
    """Share of objects found in one frame, with any score."""
    false_per_look: float
    """False positives per frame."""
    sure_false_per_look: float
    """False positives per frame with a score of at least `SURE`."""
    jitter_m: tuple[float | None, float | None]
    """Position noise between consecutive frames, from second differences (m)."""
    drift_m: tuple[float | None, float | None]
    """Change of the position error within a second (m)."""
    yaw_rad: float | None
    """Heading error modulo half a turn (rad)."""
    flipped: float | None
    """Share of headings that point backwards."""
    standing_mps: tuple[float | None, float | None]
    """Velocity error of stopped objects (m/s)."""
    moving_mps: tuple[float | None, float | None]
    """Velocity error of moving objects (m/s)."""


def detector_noise(
    drives: Sequence[tuple[Sequence[Detections], Sequence[TruthObjects]]],
) -> Mapping[tuple[float, float], Mapping[str, LabelNoise]]:
    """Return the noise by range and label. Each drive has detections and objects of consecutive frames at 10 Hz."""
    tables: dict[tuple[float, float], dict[str, LabelNoise]] = {ring: {} for ring in RINGS_M}
    looks = sum(len(found) for found, _ in drives)
    for label, name in enumerate(LABELS):
        matched = [match(found, reals, label, WITHIN_M) for found, reals in drives]
        errors = [_errors(matches, *drive) for matches, drive in zip(matched, drives, strict=True)]
        for ring in RINGS_M:
            tables[ring][name] = _noise(matched, errors, ring, looks)
    return tables


def _noise(
    matched: Sequence[Matches], errors: Sequence[dict[tuple[int, int], Floats]], ring: tuple[float, float], looks: int
) -> LabelNoise:
    inside = [matches.between(*ring) for matches in matched]
    objects = sum(len(matches.real_range_m) for matches in inside)
    wrong = np.concatenate([matches.score[~matches.right] for matches in inside])
    here = [_in_ring(known, ring) for known in errors]
    rows = np.array([row[:7] for known in here for row in known.values()]).reshape(-1, 7)
    second = _differences(errors, here, (1.0, -2.0, 1.0), 1) / math.sqrt(6.0)
    later = _differences(errors, here, (1.0, -1.0), LOOKS_IN_SECOND)
    moves = rows[:, _SPEED] > MOVES_MPS
    stands = rows[:, _SPEED] < 0.1
    return LabelNoise(
        objects=objects,
        recall=len(rows) / objects if objects else None,
        false_per_look=len(wrong) / looks if looks else 0.0,
        sure_false_per_look=float((wrong >= SURE).sum()) / looks if looks else 0.0,
        jitter_m=(_most(second[:, _ALONG]), _most(second[:, _ACROSS])),
        drift_m=(_most(later[:, _ALONG]), _most(later[:, _ACROSS])),
        yaw_rad=_most(rows[:, _YAW]),
        flipped=float(rows[:, _FLIPPED].mean()) if len(rows) else None,
        standing_mps=(_most(rows[stands, _V_ALONG]), _most(rows[stands, _V_ACROSS])),
        moving_mps=(_most(rows[moves, _V_ALONG]), _most(rows[moves, _V_ACROSS])),
    )


def _errors(
    matched: Matches, found: Sequence[Detections], reals: Sequence[TruthObjects]
) -> dict[tuple[int, int], Floats]:
    """Return the seven values of a true positive and its distance, shape (8,), by (object id, frame)."""
    errors = {}
    for row in np.flatnonzero(matched.right).tolist():
        look, j, k = int(matched.sample[row]), int(matched.detection[row]), int(matched.real[row])
        detected, real = found[look], reals[look]
        c, s = math.cos(real.yaw[k]), math.sin(real.yaw[k])
        turned = np.array([[c, s], [-s, c]])
        off = turned @ (detected.center[j, :2] - real.center[k, :2])
        sped = turned @ (detected.velocity[j] - real.velocity[k])
        yaw = math.remainder(float(detected.yaw[j] - real.yaw[k]), math.tau)
        half = math.remainder(yaw, math.pi)
        speed = float(np.hypot(*real.velocity[k]))
        values = (*off, half, float(abs(yaw) > math.pi / 2), *sped, speed, float(matched.range_m[row]))
        errors[int(real.identity[k]), look] = np.array(values)
    return errors


def _in_ring(known: dict[tuple[int, int], Floats], ring: tuple[float, float]) -> dict[tuple[int, int], Floats]:
    return {key: row for key, row in known.items() if ring[0] <= row[-1] < ring[1]}


def _differences(
    errors: Sequence[dict[tuple[int, int], Floats]],
    here: Sequence[dict[tuple[int, int], Floats]],
    weights: tuple[float, ...],
    apart: int,
) -> Floats:
    """Return weighted sums of an object's errors in frames that are `apart` frames from each other, shape (n, 8)."""
    sums = []
    for known, wanted in zip(errors, here, strict=True):
        for identity, look in wanted:
            earlier = [known.get((identity, look - apart * back)) for back in range(len(weights))]
            rows = [weight * row for weight, row in zip(weights, earlier, strict=True) if row is not None]
            if len(rows) == len(weights):
                sums.append(np.sum(rows, axis=0))
    return np.array(sums).reshape(-1, 8)


def _most(values: Floats) -> float | None:
    return float(np.quantile(np.abs(values), MOST)) if len(values) else None
