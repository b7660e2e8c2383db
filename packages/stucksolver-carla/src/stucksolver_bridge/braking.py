"""Computes the brake pedal position for an ordered deceleration, without numpy.

The effect of the pedal differs between vehicles by a factor of three, so it is estimated from tick to tick.
"""

from __future__ import annotations

FULL_MPS2 = 12.0
"""First guess of the deceleration at full pedal (m/s²). It is low: a wrong guess then brakes too hard at first, not too
little. Ours."""
MIN_MPS2 = 0.3
"""Lower bound of the wanted and the measured deceleration (m/s²): below it, the brakes have not taken effect yet.
Ours."""
MAX_CHANGE = 1.6
"""Maximum factor by which the pedal position changes per tick. Ours."""
CATCH_UP_1PS = 2.0
"""Additional deceleration (m/s²) for each m/s above the planned speed at this tick. Ours."""
STOPPED_MPS = 0.1
"""Speed below which the vehicle counts as stopped (m/s). Ours."""
HOLD_BRAKE = 0.7
"""Pedal position that holds the vehicle at rest, and that brakes without an ordered deceleration. Ours."""


class Braking:
    """One stop with a deceleration of `brake_mps2`; None applies the pedal position that holds the vehicle at rest."""

    def __init__(self, brake_mps2: float | None, speed_mps: float) -> None:
        self._brake_mps2 = brake_mps2
        self._due_mps = self._last_mps = speed_mps
        self._pedal = 0.0

    def step(self, speed_mps: float, dt_s: float) -> float:
        """Return the pedal position (0 to 1) at this speed; `dt_s` is the time since the last step."""
        if self._brake_mps2 is None or speed_mps < STOPPED_MPS:
            return HOLD_BRAKE
        if self._pedal == 0.0:
            self._pedal = min(self._brake_mps2 / FULL_MPS2, 1.0)
            return self._pedal
        self._due_mps -= self._brake_mps2 * dt_s
        wanted_mps2 = self._brake_mps2 + CATCH_UP_1PS * (speed_mps - self._due_mps)
        measured_mps2 = (self._last_mps - speed_mps) / dt_s
        self._last_mps = speed_mps
        # The square root damps the change, because the deceleration measured now results from earlier pedal positions.
        change = (max(wanted_mps2, MIN_MPS2) / max(measured_mps2, MIN_MPS2)) ** 0.5
        change = min(max(change, 1.0 / MAX_CHANGE), MAX_CHANGE)
        self._pedal = min(self._pedal * change, 1.0)
        return self._pedal
