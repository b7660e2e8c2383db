"""Measures the acceleration of the vehicle from rest under its own driver, so that proofs need not assume it."""

from __future__ import annotations

import statistics
from collections import deque

from stucksolver.scene import Status, Surroundings

REST_MPS = 0.1
"""Speed below which the vehicle counts as stopped (m/s). Ours."""
LAUNCHED_MPS = 3.0
"""Speed at which a launch is over (m/s): about the speed that a plan needs to enter a lane."""
EASES_MPS = 0.05
"""Loss of speed above which a launch does not count (m/s): other traffic holds the vehicle up. Ours."""
FEWEST, KEPT = 2, 8
"""Least number of launches for a measurement, and number of last launches that are stored. Ours."""
LEAST_MPS2 = 0.1
"""Least value of a measurement (m/s²): below it the launches differ too much. Ours."""
SPREADS = 2.0
"""Number of standard deviations below the mean at which the measured value is taken. Ours."""


class LaunchAcceleration:
    """Measurement of launches: from rest to `LAUNCHED_MPS` without losing speed.

    The vehicle may set off slowly behind a lead. Therefore the slower half of the launches does not count, as long as
    two launches remain.
    """

    def __init__(self) -> None:
        self._found: deque[float] = deque(maxlen=KEPT)
        self._begun_s: float | None = None
        self._quickest_mps = 0.0

    def update(self, status: Status, *, own: bool) -> None:
        """Update the measurement with the status of a tick.

        Args:
            status: Time (s) and speed (m/s).
            own: True if the stack's own driver has driven since the last tick. A plan bounds the speed, so its launches
                do not count.
        """
        if not own:
            self._begun_s = None
        elif status.speed_mps < REST_MPS:
            self._begun_s, self._quickest_mps = status.time_s, 0.0
        elif self._begun_s is not None:
            self._follow(status, self._begun_s)

    def _follow(self, status: Status, begun_s: float) -> None:
        if status.speed_mps < self._quickest_mps - EASES_MPS:
            self._begun_s = None
            return
        self._quickest_mps = max(self._quickest_mps, status.speed_mps)
        if status.speed_mps >= LAUNCHED_MPS and status.time_s > begun_s:
            self._found.append(status.speed_mps / (status.time_s - begun_s))
            self._begun_s = None

    @property
    def acceleration_mps2(self) -> float | None:
        """Reliable acceleration from rest (m/s²): the mean less its spread; None if not measured yet."""
        if len(self._found) < FEWEST:
            return None
        quicker = sorted(self._found, reverse=True)[: max(FEWEST, (len(self._found) + 1) // 2)]
        reliable = statistics.mean(quicker) - SPREADS * statistics.stdev(quicker)
        return reliable if reliable > LEAST_MPS2 else None

    def with_measured_acceleration(self, seen: Surroundings) -> Surroundings:
        """Return the surroundings with the measurement among the vehicle's limits, for the guard and the record."""
        measured = self.acceleration_mps2
        if measured is None:
            return seen
        limits = seen.ego.limits.model_copy(update={"measured_acceleration_mps2": round(measured, 3)})
        return seen.model_copy(update={"ego": seen.ego.model_copy(update={"limits": limits})})
