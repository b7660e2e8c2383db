"""Defines a track: one object at one time."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from stucksolver_perception.measurements import Floats, PoseEstimate
from stucksolver_perception.tracking.motion_groups import GROUP_OF_LABEL, GROUPS
from stucksolver_perception.tracking.motion_prediction import transition
from stucksolver_perception.vehicle_frame import into_vehicle

TRACK_STATE = np.array([0, 1, 3, 4, 5])
"""Indices of the filter's state x, y, z, yaw, vx, vy in `Track.covariance`."""


@dataclass(frozen=True, eq=False)
class Track:
    """One object at `time_s`, in the local frame; `x_m, y_m, z_m` is the center of its box."""

    id: int
    """Constant while the object is tracked. One tracker never uses it twice."""
    time_s: float
    label: int
    """Index into `stucksolver_perception.lidar_labels.LABELS`: the label with the most votes."""
    label_confidence: float
    """Share of the votes for this label, 0 to 1; with few votes it is below 1."""
    confidence: float
    """Probability that the object exists, from detections, misses and scores."""
    x_m: float
    y_m: float
    z_m: float
    yaw_rad: float
    vx_mps: float
    vy_mps: float
    """Velocity over ground along the axes of the local frame; exactly 0 while the object is stationary."""
    length_m: float
    width_m: float
    height_m: float
    covariance: Floats
    """(5, 5): covariance of x, y (m), yaw (rad), vx, vy (m/s)."""
    first_seen_s: float
    """Time of the first detection (s)."""
    last_seen_s: float
    """Time of the last detection (s)."""
    hits: int
    """Number of detections."""
    hidden: bool
    """True if the object was not detected in the last cycle, and could not be."""
    standing_since_s: float | None
    """Time since which the object is stationary (s); None while it moves or is undecided."""
    moved_at_s: float | None
    """Time of the last cycle in which the object moved (s); None if it never did."""

    def predict_to(self, time_s: float) -> Track:
        """Return the track predicted to a later time (s). For an earlier time, return the track itself."""
        elapsed_s = time_s - self.time_s
        if elapsed_s <= 0.0:
            return self
        f, q = transition(
            GROUPS[GROUP_OF_LABEL[self.label]], self.standing_since_s is not None, elapsed_s, self.yaw_rad
        )
        f, q = f[np.ix_(TRACK_STATE, TRACK_STATE)], q[np.ix_(TRACK_STATE, TRACK_STATE)]
        return replace(
            self,
            time_s=time_s,
            x_m=self.x_m + self.vx_mps * elapsed_s,
            y_m=self.y_m + self.vy_mps * elapsed_s,
            covariance=f @ self.covariance @ f.T + q,
        )

    @property
    def stationary_s(self) -> float:
        """Time since the object is stationary (s), also while it is hidden; 0 while it moves or is undecided."""
        return 0.0 if self.standing_since_s is None else max(0.0, self.time_s - self.standing_since_s)

    @property
    def moved_s_ago(self) -> float | None:
        """Time since the object last moved (s); None if it never did."""
        return None if self.moved_at_s is None else max(0.0, self.time_s - self.moved_at_s)

    @property
    def tracked_for_s(self) -> float:
        """Time since the first detection (s)."""
        return max(0.0, self.time_s - self.first_seen_s)


def boxes_of(tracks: Iterable[Track], pose: PoseEstimate) -> Floats:
    """Return (n, 7): x, y, z, length, width, height (m), yaw (rad) of tracks, in the vehicle frame at `pose`."""
    rows = [(t.x_m, t.y_m, t.z_m, t.length_m, t.width_m, t.height_m, t.yaw_rad) for t in tracks]
    return into_vehicle(np.array(rows, np.float64).reshape(-1, 7), pose)
