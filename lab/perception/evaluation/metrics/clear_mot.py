"""CLEAR MOT: accuracy of tracks.

Bernardin and Stiefelhagen, "Evaluating Multiple Object Tracking Performance: The CLEAR MOT Metrics" (2008). An object
keeps its track as long as that is near. The others are assigned so that the sum of distances is smallest.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lab.perception.evaluation.metrics.matching import Flags, Indices
from stucksolver_perception.measurements import Floats

_FAR = 1e6
"""Cost of an impossible assignment (m)."""


@dataclass(frozen=True, eq=False)
class TrackedFrame:
    """Objects and tracks of one label at one time; positions on the ground in a fixed frame (m)."""

    object_id: Indices
    object_xy: Floats
    """Shape (n, 2)."""
    counted: Flags
    """Shape (n,): False for objects that are hardly visible; they count neither as misses nor as false positives."""
    track_id: Indices
    track_xy: Floats
    """Shape (m, 2)."""
    score: Floats
    """Shape (m,): score of each track, the same in all its frames."""

    def at_least(self, score: float) -> TrackedFrame:
        """Return the frame without tracks below a score."""
        is_counted = self.score >= score
        tracks = (self.track_id[is_counted], self.track_xy[is_counted], self.score[is_counted])
        return TrackedFrame(self.object_id, self.object_xy, self.counted, *tracks)


@dataclass(frozen=True)
class MotCounts:
    """Counts summed over frames."""

    objects: int = 0
    """Number of objects."""
    misses: int = 0
    """Number of objects without a track."""
    false_positives: int = 0
    """Number of tracks without an object."""
    switches: int = 0
    """Number of changes of an object's track."""
    matches: int = 0
    """Number of objects with a track."""
    distance_m: float = 0.0
    """Sum of distances over all matches (m)."""

    @property
    def mota(self) -> float | None:
        """Tracking accuracy, at most 1 and negative if there are more errors than objects; None without objects."""
        errors = self.misses + self.false_positives + self.switches
        return 1.0 - errors / self.objects if self.objects else None

    @property
    def motp_m(self) -> float | None:
        """Tracking precision: mean distance of a track to its object (m); None without matches."""
        return self.distance_m / self.matches if self.matches else None

    @property
    def recall(self) -> float | None:
        """Share of the objects that have a track; None without objects."""
        return 1.0 - self.misses / self.objects if self.objects else None

    def __add__(self, other: MotCounts) -> MotCounts:
        return MotCounts(
            self.objects + other.objects,
            self.misses + other.misses,
            self.false_positives + other.false_positives,
            self.switches + other.switches,
            self.matches + other.matches,
            self.distance_m + other.distance_m,
        )


def clear_mot(frames: Sequence[TrackedFrame], within_m: float) -> MotCounts:
    """Count over the frames of one drive in order of time. Tracks farther than `within_m` (m) match no object."""
    last: dict[int, int] = {}
    """The last track of each object."""
    total = MotCounts()
    for frame in frames:
        pairs = assign(frame, last, within_m)
        followed = np.zeros(len(frame.object_id), np.bool_)
        switches, distance, matches = 0, 0.0, 0
        for i, j, away in pairs:
            known, track = int(frame.object_id[i]), int(frame.track_id[j])
            followed[i] = True
            if frame.counted[i]:
                switches += last.get(known, track) != track
                distance, matches = distance + away, matches + 1
            last[known] = track
        total += MotCounts(
            objects=int(frame.counted.sum()),
            misses=int((frame.counted & ~followed).sum()),
            false_positives=len(frame.track_id) - len(pairs),
            switches=switches,
            matches=matches,
            distance_m=distance,
        )
    return total


def assign(frame: TrackedFrame, last: dict[int, int], within_m: float) -> list[tuple[int, int, float]]:
    """Return matched (object index, track index, distance in m). `last` is each object's last track."""
    from scipy.optimize import linear_sum_assignment  # type: ignore[import-untyped]

    away = np.linalg.norm(frame.object_xy[:, None, :] - frame.track_xy[None, :, :], axis=2)
    where = {int(track): j for j, track in enumerate(frame.track_id)}
    pairs: list[tuple[int, int, float]] = []
    for i, known in enumerate(frame.object_id.tolist()):
        j = where.get(last.get(known, -1), -1)
        if j >= 0 and away[i, j] < within_m and all(j != other for _, other, _ in pairs):
            pairs.append((i, j, float(away[i, j])))
    objects = np.setdiff1d(np.arange(away.shape[0]), [i for i, _, _ in pairs])
    tracks = np.setdiff1d(np.arange(away.shape[1]), [j for _, j, _ in pairs])
    if len(objects) and len(tracks):
        left = np.where(away[np.ix_(objects, tracks)] < within_m, away[np.ix_(objects, tracks)], _FAR)
        for i, j in zip(*linear_sum_assignment(left), strict=True):
            if left[i, j] < _FAR:
                pairs.append((int(objects[i]), int(tracks[j]), float(left[i, j])))
    return pairs
