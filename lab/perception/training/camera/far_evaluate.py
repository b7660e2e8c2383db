"""Checks the far detector on held-out images: recall, precision and ranges. It makes the card and a page of tables."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lab.perception.training.camera.far_data import MARGIN_ROWS, Strips
from stucksolver_perception.camera.far_detector import FarDetections, decode
from stucksolver_perception.camera.far_range import RangeModel, logs_of, ranges_of
from stucksolver_perception.camera.horizon_strip import LABELS, look_of
from stucksolver_perception.measurements import Floats, Pixels

BIN_M = 25.0
"""Width of a bin of ranges (m)."""
BINS = tuple(BIN_M * k for k in range(1, 10))
"""Bin edges of the ranges for which recall is reported: 25 to 225 m."""
SEEN_SHARE = 0.7
"""Visible share from which boxes count for the recall. Ours.

The others count neither as missed nor as false. Those from `far_data.LEAST_SHARE` on are counted separately,
see `check_part`.
"""
LEAST_SCORE = 0.05
"""Height of a peak below which it is ignored. Ours."""
PRECISION = 0.95
"""Required precision for vehicles beyond 40 m. Ours; the threshold is the lowest that reaches it."""
FROM_M, TO_M = 40.0, 200.0
"""Range of distances for precision and threshold (m)."""
FAR_PX = 45.0
"""Height below which a car is beyond 40 m (px)."""
LEAST_SLACK_PX = 4.0
"""Least tolerance of a right detection (px). Ours."""
SLACK = 0.5
"""Tolerance of a right detection: its bottom center is within this share of the box's sides, or `LEAST_SLACK_PX`.

Ours.
"""
LOOK_S = 0.75
"""Time below which two images of a drive show the same scene (s). Ours."""
BRIGHTNESS_SHARES, CONTRAST_SHARES = (1 / 3, 2 / 3), (1 / 3, 2 / 3)
"""Quantiles that divide held-out images into classes by look; each class has its own recall. Ours."""
LEAST_FITTED = 12
"""Minimum number of detections for the fit of a label's size. Ours.

With fewer, it uses the vehicles' factors and a wide deviation.
"""
WIDE_SIGMA = 0.4
"""That deviation (of the log of the range)."""
FALLBACK_SIZE = (7.5, -0.5, -0.5)
"""Factors of the size model without a fit."""


@dataclass(frozen=True, eq=False)
class _Matched:
    """Detections of one image and its ground truth."""

    found: FarDetections
    truth: NDArray[np.int64]
    """(n,): index of the box matched to each detection, -1 for none, -2 for a detection that is not judged."""
    boxes: NDArray[np.float32]
    drive: int


@dataclass(frozen=True, eq=False)
class _Rows:
    """One row per box that should have been found."""

    label: NDArray[np.int64]
    distance: Floats
    drive: NDArray[np.int64]
    picture: NDArray[np.int64]
    actor: NDArray[np.int64]
    look: NDArray[np.int64]
    hit: NDArray[np.bool_]

    def subset(self, which: NDArray[np.bool_]) -> _Rows:
        """Return some of the rows."""
        return _Rows(**{name: getattr(self, name)[which] for name in self.__dataclass_fields__})


Run = Callable[[Pixels], tuple[NDArray[np.float32], NDArray[np.float32]]]
"""A network: from a strip (`STRIP_ROWS`, width, 3) to its two outputs, see `far_net.ExportedFarNet`."""


def check(run: Run, strips: Strips, threshold: float | None = None) -> dict[str, Any]:
    """Return the card's metrics: threshold, recall by range and look, precision, and the fit of ranges.

    Without a `threshold`, the one that the constants above define is chosen.
    """
    pictures = [_match(found, strips.boxes[k], int(strips.drive[k])) for k, found in enumerate(_found(run, strips))]
    threshold = _threshold(pictures) if threshold is None else threshold
    pictures = [
        _match(picture.found.part(picture.found.score >= threshold), picture.boxes, picture.drive)
        for picture in pictures
    ]
    looks = np.array([picture.found.look for picture in pictures])
    edges = {
        "brightness": [float(np.quantile(looks[:, 0], share)) for share in BRIGHTNESS_SHARES],
        "contrast": [float(np.quantile(looks[:, 1], share)) for share in CONTRAST_SHARES],
    }
    rows = _rows(pictures, look_classes(looks, edges))
    count = (len(BRIGHTNESS_SHARES) + 1) * (len(CONTRAST_SHARES) + 1)
    return {
        "threshold": threshold,
        "bins_m": list(BINS),
        "look_edges": edges,
        "recall": {
            name: [_counts(rows.subset((rows.label == k) & (rows.look == look))) for look in range(count)]
            for k, name in enumerate(LABELS)
        },
        "repeated_miss": _repeated(rows, strips.time_s),
        "precision": _precision(pictures, strips),
        "towards_right": _towards(pictures),
        "range": _ranges(pictures, strips),
        "tables": _tables(rows, strips.about),
    }


def check_part(run: Run, strips: Strips, card: dict[str, Any]) -> dict[str, Any]:
    """Return the card's metrics for vehicles that are partly covered by something nearer.

    They are the recall by range and look, and the misses that a second image repeats. Threshold and classes of look are
    those of the card.
    """
    threshold = float(card["threshold"])
    found = [detections.part(detections.score >= threshold) for detections in _found(run, strips)]
    pictures = [_match(detections, strips.boxes[k], int(strips.drive[k])) for k, detections in enumerate(found)]
    looks = look_classes(np.array([picture.found.look for picture in pictures]), card["look_edges"])
    rows = _rows(pictures, looks, _in_part)
    rows = rows.subset(rows.label == 0)
    count = (len(BRIGHTNESS_SHARES) + 1) * (len(CONTRAST_SHARES) + 1)
    return {
        "recall": [_counts(rows.subset(rows.look == look)) for look in range(count)],
        "repeated_miss": _repeated(rows, strips.time_s),
        "tables": {name: table for name, table in _tables(rows, strips.about).items() if name.startswith("vehicle")},
        "pictures": len(strips),
    }


def look_classes(looks: Floats, edges: dict[str, list[float]]) -> NDArray[np.int64]:
    """Return class (n,) of each image's look (n, 2). Brightness is the major part of the index."""
    bright = np.searchsorted(edges["brightness"], looks[:, 0])
    contrast = np.searchsorted(edges["contrast"], looks[:, 1])
    return np.asarray(bright * (len(edges["contrast"]) + 1) + contrast, np.int64)


def written(card: dict[str, Any]) -> str:
    """Return the card's tables as a Markdown page."""
    lines = ["# Far detector on held-out images", "", f"threshold {card['threshold']:.3f}", ""]
    lines += _recall_table(card["tables"])
    lines.append("| precision, by estimated range | " + " | ".join(_share(item) for item in card["precision"]) + " |")
    range_fit = card["range"]
    lines += ["", f"front or rear correct: {card['towards_right']}; missed again 0.5 s later: {card['repeated_miss']}"]
    lines += [f"range: {range_fit['said']}", ""]
    return "\n".join(lines)


def written_part(card: dict[str, Any]) -> str:
    """Return the card's table of partly visible vehicles as Markdown."""
    part = card["part"]
    return "\n".join([*_recall_table(part["tables"]), "", f"missed again 0.5 s later: {part['repeated_miss']}", ""])


def _recall_table(tables: dict[str, Sequence[Sequence[int]]]) -> list[str]:
    bins = " | ".join(f"{a:.0f}-{b:.0f} m" for a, b in pairwise(BINS))
    head = [f"| recall (number of boxes) | {bins} |", "|---" * len(BINS) + "|"]
    return head + [
        f"| {name} | " + " | ".join(_share(count) for count in counts) + " |" for name, counts in tables.items()
    ]


def _share(counts: Sequence[int]) -> str:
    return f"{counts[0] / counts[1]:.3f} ({counts[1]})" if counts[1] else "-"


def _found(run: Run, strips: Strips) -> list[FarDetections]:
    found = []
    for k, rgb in enumerate(strips.rgb):
        strip = np.ascontiguousarray(rgb[MARGIN_ROWS:-MARGIN_ROWS])
        peaks, rest = run(strip)
        top = int(strips.top[k]) + MARGIN_ROWS
        found.append(decode(peaks, rest, float(strips.time_s[k]), top, LEAST_SCORE, look_of(strip)))
    return found


def _match(found: FarDetections, boxes: NDArray[np.float32], drive: int) -> _Matched:
    """Match detections, highest score first, to the nearest free box of their label within reach."""
    boxes = boxes[~np.isnan(boxes[:, 0])]
    column, row = (boxes[:, 1] + boxes[:, 3]) / 2.0, boxes[:, 4]
    reach_x = np.maximum(SLACK * (boxes[:, 3] - boxes[:, 1]), LEAST_SLACK_PX)
    reach_y = np.maximum(SLACK * (boxes[:, 4] - boxes[:, 2]), LEAST_SLACK_PX)
    free, truth = np.ones(len(boxes), bool), np.full(len(found), -1)
    for k in range(len(found)):
        off = np.hypot((found.column[k] - column) / reach_x, (found.row[k] - row) / reach_y)
        own = np.where(free & (boxes[:, 0] == found.label[k]), off, np.inf)
        if len(own) and own.min() <= 1.0:
            truth[k] = int(own.argmin())
            free[truth[k]] = False
        elif _unjudged(found, k, boxes, off):
            truth[k] = -2
    return _Matched(found, truth, boxes, drive)


def _unjudged(found: FarDetections, k: int, boxes: NDArray[np.float32], off: Floats) -> bool:
    """True if an unmatched detection lies on an object that is excluded from the loss."""
    x, y = found.column[k], found.row[k] - found.height[k] / 2.0
    within = (boxes[:, 1] - 2 < x) & (x < boxes[:, 3] + 2) & (boxes[:, 2] - 2 < y) & (y < boxes[:, 4] + 2)
    return bool(np.any((boxes[:, 0] < 0) & (within | (off <= 1.0))))


def _judged(boxes: NDArray[np.float32]) -> NDArray[np.bool_]:
    return np.asarray((boxes[:, 0] >= 0) & (boxes[:, 5] >= SEEN_SHARE))


def _in_part(boxes: NDArray[np.float32]) -> NDArray[np.bool_]:
    return np.asarray((boxes[:, 0] >= 0) & (boxes[:, 5] < SEEN_SHARE))


def _threshold(pictures: Sequence[_Matched]) -> float:
    scores, right = [np.zeros(0)], [np.zeros(0, bool)]
    for picture in pictures:
        far = (picture.found.label == 0) & (picture.truth != -2) & (picture.found.height < FAR_PX)
        scores.append(picture.found.score[far])
        right.append(picture.truth[far] >= 0)
    score, good = np.concatenate(scores), np.concatenate(right)
    order = np.argsort(-score)
    precise = np.cumsum(good[order]) / np.arange(1, len(order) + 1) >= PRECISION
    if not precise.any():
        return 0.9
    return float(np.clip(score[order][np.flatnonzero(precise)[-1]], 0.1, 0.9))


def _rows(
    pictures: Sequence[_Matched],
    look: NDArray[np.int64],
    counts: Callable[[NDArray[np.float32]], NDArray[np.bool_]] = _judged,
) -> _Rows:
    columns: list[tuple[Any, ...]] = []
    for k, picture in enumerate(pictures):
        hit = np.zeros(len(picture.boxes), bool)
        hit[picture.truth[picture.truth >= 0]] = True
        counted = counts(picture.boxes)
        for box, found in zip(picture.boxes[counted], hit[counted], strict=True):
            columns.append((int(box[0]), float(box[6]), picture.drive, k, int(box[8]), int(look[k]), bool(found)))
    table = list(zip(*columns, strict=True)) or [()] * 7
    kinds = (np.int64, np.float64, np.int64, np.int64, np.int64, np.int64, np.bool_)
    return _Rows(*(np.array(column, kind) for column, kind in zip(table, kinds, strict=True)))


def _counts(rows: _Rows) -> list[list[int]]:
    """Return the number of found boxes, and of all boxes, for each bin."""
    place = np.digitize(rows.distance, BINS) - 1
    return [[int(rows.hit[place == k].sum()), int((place == k).sum())] for k in range(len(BINS) - 1)]


def _repeated(rows: _Rows, time_s: Floats) -> list[int]:
    """Return vehicles missed in two consecutive images of a scene, and all that were missed in the first."""
    known = {
        (int(d), int(a), int(p)): bool(h)
        for d, a, p, h in zip(rows.drive, rows.actor, rows.picture, rows.hit, strict=True)
    }
    far = rows.subset((rows.label == 0) & (rows.distance > FROM_M) & (rows.distance < TO_M) & ~rows.hit)
    again = total = 0
    for drive, actor, picture in zip(far.drive, far.actor, far.picture, strict=True):
        following = known.get((int(drive), int(actor), int(picture) + 1))
        if following is None or time_s[picture + 1] - time_s[picture] > LOOK_S:
            continue
        total += 1
        again += not following
    return [again, total]


def _precision(pictures: Sequence[_Matched], strips: Strips) -> list[list[int]]:
    """Return correct vehicle detections, and all, by the range estimated from their height."""
    counts = np.zeros((len(BINS) - 1, 2), int)
    for picture in pictures:
        mine = (picture.found.label == 0) & (picture.truth != -2)
        away = strips.rig.focal_px * 1.6 / np.maximum(picture.found.height[mine], 1.0)
        for k, right in zip(np.digitize(away, BINS) - 1, picture.truth[mine] >= 0, strict=True):
            if 0 <= k < len(counts):
                counts[k] += (int(right), 1)
    return [[int(a), int(b)] for a, b in counts]


def _towards(pictures: Sequence[_Matched]) -> list[int]:
    """Return vehicles found beyond `FROM_M` with a visible front or rear: rightly classified, and all."""
    right = total = 0
    for picture in pictures:
        for k in np.flatnonzero((picture.truth >= 0) & (picture.found.label == 0)):
            box = picture.boxes[picture.truth[k]]
            if box[7] >= 0 and box[6] > FROM_M:
                total += 1
                right += bool((picture.found.towards[k] > 0.5) == (box[7] > 0.5))
    return [right, total]


def _tables(rows: _Rows, about: Sequence[tuple[str, str]]) -> dict[str, list[list[int]]]:
    towns, weathers = (np.array([item[k] for item in about])[rows.drive] for k in (0, 1))
    tables = {name: _counts(rows.subset(rows.label == k)) for k, name in enumerate(LABELS)}
    vehicle = rows.label == 0
    tables |= {f"vehicle, {name}": _counts(rows.subset(vehicle & (towns == name))) for name in sorted(set(towns))}
    return tables | {
        f"vehicle, {name}": _counts(rows.subset(vehicle & (weathers == name))) for name in sorted(set(weathers))
    }


def _ranges(pictures: Sequence[_Matched], strips: Strips) -> dict[str, Any]:
    """Return the range model, fitted to every other drive and measured on the rest."""
    model = _fitted(pictures, strips, lambda drive: drive % 2 == 0)
    found, distance, _ = _pairs(pictures, strips, lambda drive: drive % 2 == 1)
    summary = "not measured: there is only one drive"
    if len(found):
        range_m, sigma_m = ranges_of(found, strips.rig, model)
        off = np.abs(range_m - distance)
        far = (distance >= 60.0) & (found.label == 0)
        covered, twice = (float(np.mean(off <= k * sigma_m)) for k in (1, 2))
        relative = float(np.median(off[far] / distance[far])) if far.any() else float("nan")
        summary = (
            f"{covered:.3f} within one standard deviation, {twice:.3f} within two, of {len(found)} in drives that "
            f"were not fitted to; median error beyond 60 m {100 * relative:.1f} %"
        )
    return {
        "row_bias_px": model.row_bias_px,
        "row_sigma_px": model.row_sigma_px,
        "row_noise_px": model.row_noise_px,
        "size": [list(item) for item in model.size],
        "size_sigma": list(model.size_sigma),
        "half_length_m": list(model.half_length_m),
        "inflation": model.inflation,
        "said": summary,
    }


def _fitted(pictures: Sequence[_Matched], strips: Strips, chosen: Callable[[int], bool]) -> RangeModel:
    found, distance, edge = _pairs(pictures, strips, chosen)
    half_length = (2.3, 1.0, 0.2)
    scale = strips.rig.focal_px * strips.rig.mount.z_m
    flat = strips.rig.height_px / 2.0 + scale / np.maximum(distance - np.array(half_length)[found.label], 5.0)
    off = found.row - flat
    bias = float(np.median(off)) if len(off) else 0.0
    row_sigma = max(float(np.quantile(np.abs(off - bias), 0.683)) if len(off) else 10.0, 0.5)
    noise = max(float(np.quantile(np.abs(found.row - edge), 0.683)) if len(edge) else 4.0, 0.3)
    size: list[tuple[float, float, float]] = []
    sigma: list[float] = []
    for label in range(len(LABELS)):
        own = (found.label == label) & (distance > 25.0)
        if own.sum() < LEAST_FITTED:
            size.append(size[0] if size else FALLBACK_SIZE)
            sigma.append(WIDE_SIGMA)
            continue
        logs, wanted = logs_of(found.part(own)), np.log(distance[own])
        factors = np.linalg.lstsq(logs, wanted, rcond=None)[0]
        size.append((float(factors[0]), float(factors[1]), float(factors[2])))
        sigma.append(max(float(np.quantile(np.abs(logs @ factors - wanted), 0.683)), 0.02))
    model = RangeModel(bias, row_sigma, noise, tuple(size), tuple(sigma), half_length, 1.0)
    if not len(found):
        return model
    range_m, sigma_m = ranges_of(found, strips.rig, model)
    return replace(model, inflation=max(float(np.quantile(np.abs(range_m - distance) / sigma_m, 0.683)), 1.0))


def _pairs(
    pictures: Sequence[_Matched], strips: Strips, chosen: Callable[[int], bool]
) -> tuple[FarDetections, Floats, Floats]:
    """Return detections in some drives that match a judged box, with their true distances and lower edges.

    The distances are those from the camera.
    """
    parts, distances, edges = [], [], []
    for picture in pictures:
        if not chosen(picture.drive):
            continue
        right = picture.truth >= 0
        right[right] &= _judged(picture.boxes)[picture.truth[right]]
        parts.append(picture.found.part(right))
        distances.append(picture.boxes[picture.truth[right], 6] - strips.rig.mount.x_m)
        edges.append(picture.boxes[picture.truth[right], 4])
    names = ("column", "row", "width", "height", "score", "label", "towards")
    empty = {name: np.zeros(0, np.int64 if name == "label" else np.float64) for name in names}
    joined = {name: np.concatenate([empty[name], *(getattr(part, name) for part in parts)]) for name in names}
    distance, edge = (np.concatenate([np.zeros(0), *item]).astype(np.float64) for item in (distances, edges))
    return FarDetections(0.0, **joined, look=np.zeros(2)), distance, edge
