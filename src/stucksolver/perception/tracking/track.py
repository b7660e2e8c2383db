"""What is known about one object at one moment."""

from __future__ import annotations

from dataclasses import dataclass

from stucksolver.perception.measurements import Floats


@dataclass(frozen=True, eq=False)
class Track:
    """One object at `time_s`, in the local frame; `x_m, y_m, z_m` is the middle of its box."""

    id: int
    """Stays the same as long as the object is followed; never given twice by one tracker."""
    time_s: float
    label: int
    """Index into `stucksolver.perception.labels.LABELS`: the label with the most votes."""
    label_confidence: float
    """Share of the votes that this label has, 0 to 1; a few votes never give certainty."""
    confidence: float
    """Probability that there is such an object at all, by hits, misses and their scores."""
    x_m: float
    y_m: float
    z_m: float
    yaw_rad: float
    vx_mps: float
    vy_mps: float
    """Velocity over ground along the axes of the local frame; exactly 0 while the object is held to stand."""
    length_m: float
    width_m: float
    height_m: float
    covariance: Floats
    """(5, 5) of x, y (m), yaw (rad), vx, vy (m/s)."""
    first_seen_s: float
    last_seen_s: float
    """When a detection was last assigned to it."""
    hits: int
    """Number of detections assigned to it."""
    hidden: bool
    """It was not detected at the last look, and could not have been: it is remembered."""
    standing_since_s: float | None
    """None while it moves, and as long as that is not decided."""
    moved_at_s: float | None
    """When it was last seen moving; None if it never was."""

    @property
    def stationary_s(self) -> float:
        """For how long it has stood; 0 while it moves or is undecided. Standing objects that are hidden count on."""
        return 0.0 if self.standing_since_s is None else max(0.0, self.time_s - self.standing_since_s)

    @property
    def moved_s_ago(self) -> float | None:
        """Since when it has not been seen moving; None if it never was."""
        return None if self.moved_at_s is None else max(0.0, self.time_s - self.moved_at_s)

    @property
    def seen_for_s(self) -> float:
        """For how long it has been followed."""
        return max(0.0, self.time_s - self.first_seen_s)
