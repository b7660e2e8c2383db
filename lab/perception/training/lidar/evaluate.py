"""Evaluates a network on held-out windows and calibrates its scores."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray

from lab.perception.training.lidar.batches import WindowStore
from lab.perception.training.lidar.data import IGNORED
from lab.perception.training.lidar.loss import MOVING_MPS
from lab.perception.training.lidar.net import PillarNet, strongest
from lab.perception.training.lidar.pillars import pillars
from stucksolver_perception.lidar.decode import Calibration, decode
from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.measurements import Detections, Floats

NEAR_M = 2.0
"""Distance to a body of its label below which a detection is right (m), as in nuScenes."""
AROUND_IGNORED_M = 1.0
"""Distance to an ignored body below which a detection is ignored, too (m). Ours."""
LEAST_SCORE = 0.1
"""Calibrated score below which the shipped detector drops detections. Ours."""
RAW = Calibration((1.0,) * len(LABELS), (0.0,) * len(LABELS), (0.01,) * len(LABELS))
"""The identity calibration."""
PRIOR_STRENGTH = 4.0
"""Strength of the prior toward the identity calibration, as a number of detections. Ours."""


@dataclass(frozen=True, eq=False)
class ScoredDetections:
    """All detections of one label, strongest first."""

    score: Floats
    right: NDArray[np.bool_]
    errors: Floats
    """(right detections, 5): distance (m), yaw error (rad), velocity error (m/s), volume ratio, true speed (m/s)."""
    bodies: int
    """Number of bodies that should have been found."""


def predicted(net: PillarNet, store: WindowStore, batch: int = 8) -> list[Detections]:
    """Return detections in each window, with uncalibrated scores."""
    net.eval()
    found: list[Detections] = []
    with torch.no_grad():
        for first in range(0, len(store), batch):
            which = torch.arange(first, min(first + batch, len(store)), device=store.device)
            part = store.batch(which, vary=False)
            heat, box = net(*pillars(part.points, part.window, net.grid), len(which))
            for i in range(len(which)):
                logit, label, cell, values = (item.cpu().numpy() for item in strongest(heat[i : i + 1], box[i : i + 1]))
                found.append(decode(logit, label, cell, values, 0.0, RAW, net.grid))
    return found


def judged(found: Sequence[Detections], store: WindowStore) -> list[ScoredDetections]:
    """Return the right detections of each label: greedy matching by score, as in nuScenes (Caesar et al. 2020)."""
    boxes, labels = store.boxes.cpu().numpy().astype(np.float64), store.labels.cpu().numpy()
    return [_judged_label(label, found, boxes, labels) for label in range(len(LABELS))]


def _judged_label(
    label: int, found: Sequence[Detections], boxes: Floats, labels: NDArray[np.int64]
) -> ScoredDetections:
    parts = [(i, k) for i, detections in enumerate(found) for k in np.flatnonzero(detections.label == label).tolist()]
    parts.sort(key=lambda part: -found[part[0]].score[part[1]])
    taken: set[tuple[int, int]] = set()
    score, right, errors = [], [], []
    for i, k in parts:
        item = found[i]
        away = np.hypot(boxes[i, :, 0] - item.center[k, 0], boxes[i, :, 1] - item.center[k, 1])
        open_to = [m for m in np.flatnonzero((labels[i] == label) & (away < NEAR_M)).tolist() if (i, m) not in taken]
        if open_to:
            best = min(open_to, key=lambda m: float(away[m]))
            taken.add((i, best))
            errors.append(_errors(item, k, boxes[i, best], float(away[best])))
        elif _beside_ignored(item.center[k], boxes[i][labels[i] == IGNORED]):
            continue
        score.append(float(item.score[k]))
        right.append(bool(open_to))
    bodies = int((labels == label).sum())
    return ScoredDetections(np.array(score), np.array(right, bool), np.array(errors).reshape(-1, 5), bodies)


def _errors(detections: Detections, k: int, box: Floats, away: float) -> tuple[float, ...]:
    yaw = abs((detections.yaw[k] - box[6] + np.pi) % (2 * np.pi) - np.pi)
    speed = float(np.hypot(*(detections.velocity[k] - box[7:9])))
    return away, float(yaw), speed, float(np.prod(detections.size[k]) / np.prod(box[3:6])), float(np.hypot(*box[7:9]))


def _beside_ignored(middle: Floats, ignored: Floats) -> bool:
    dx, dy = middle[0] - ignored[:, 0], middle[1] - ignored[:, 1]
    cos, sin = np.cos(ignored[:, 6]), np.sin(ignored[:, 6])
    along, across = np.abs(cos * dx + sin * dy), np.abs(cos * dy - sin * dx)
    half = ignored[:, 3:5] / 2 + AROUND_IGNORED_M
    return bool(((along < half[:, 0]) & (across < half[:, 1])).any())


def average_precision(of: ScoredDetections) -> float:
    """Return the area under the precision-recall curve; precision at a recall is the best at that recall or higher."""
    if not of.bodies or not len(of.score):
        return 0.0
    hits = np.cumsum(of.right)
    precision = np.maximum.accumulate((hits / np.arange(1, len(hits) + 1))[::-1])[::-1]
    return float((precision * of.right).sum() / of.bodies)


def mean_average_precision(all_labels: Sequence[ScoredDetections]) -> float:
    """Return the mean average precision over the labels that have bodies."""
    counted = [average_precision(label) for label in all_labels if label.bodies]
    return sum(counted) / max(1, len(counted))


def calibrated(all_labels: Sequence[ScoredDetections]) -> Calibration:
    """Return slope and shift that turn a logit into the probability that the detection is right (Platt 1999)."""
    fits = [_platt(label.score, label.right) for label in all_labels]
    return Calibration(
        tuple(slope for slope, _ in fits), tuple(shift for _, shift in fits), (LEAST_SCORE,) * len(all_labels)
    )


def _platt(score: Floats, right: NDArray[np.bool_]) -> tuple[float, float]:
    """Return the logistic regression on the logit (Newton's method), regularized toward slope 1 and shift 0."""
    share = np.clip(score, 1e-6, 1.0 - 1e-6)
    inputs = np.stack([np.log(share / (1.0 - share)), np.ones(len(share))], axis=1).reshape(-1, 2)
    prior = np.array([1.0, 0.0])
    fit = prior.copy()
    for _ in range(30):
        predicted_p = 1.0 / (1.0 + np.exp(-np.clip(inputs @ fit, -30, 30)))
        slope = inputs.T @ (predicted_p - right) + PRIOR_STRENGTH * (fit - prior)
        bend = (inputs * (predicted_p * (1.0 - predicted_p))[:, None]).T @ inputs + PRIOR_STRENGTH * np.eye(2)
        fit = fit - np.linalg.solve(bend, slope)
    # A negative slope would reverse the order of detections.
    return max(0.1, float(fit[0])), float(fit[1])


def report(all_labels: Sequence[ScoredDetections]) -> list[dict[str, float | str]]:
    """Return one row per label: AP at 2 m, bodies, and errors of right detections (medians and 90th percentiles)."""
    rows: list[dict[str, float | str]] = []
    for name, label in zip(LABELS, all_labels, strict=True):
        row: dict[str, float | str] = {"label": name, "bodies": label.bodies, "ap": round(average_precision(label), 4)}
        row["recall"] = round(float(label.right.sum()) / max(1, label.bodies), 4)
        if len(label.errors):
            middle, high = np.median(label.errors, axis=0), np.quantile(label.errors, 0.9, axis=0)
            row |= {"away_m": round(middle[0], 3), "away_90_m": round(high[0], 3), "yaw_rad": round(middle[1], 3)}
            row |= {"velocity_mps": round(middle[2], 3), "velocity_90_mps": round(high[2], 3)}
            moving = label.errors[label.errors[:, 4] > MOVING_MPS]
            row["moving"] = len(moving)
            if len(moving):
                row["velocity_of_moving_mps"] = round(float(np.median(moving[:, 2])), 3)
        rows.append(row)
    return rows
