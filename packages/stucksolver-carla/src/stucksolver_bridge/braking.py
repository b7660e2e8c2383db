"""The brake pedal position for an ordered deceleration, without numpy.

The effect of the pedal differs between vehicles by a factor of three, so it is learned from tick to tick.
"""

from __future__ import annotations

FULL_MPS2 = 12.0
"""First guess of the deceleration at full pedal. It is low, so that a wrong guess brakes too hard at first."""
LEAST_MPS2 = 0.3
"""Smaller decelerations count as this one: the brakes have not taken effect yet."""
QUICKEST_CHANGE = 1.6
"""The pedal position changes by at most this factor per tick."""
CATCH_UP_1PS = 2.0
"""Additional deceleration (m/s²) for each m/s above the speed that the vehicle should have by now."""
STANDING_MPS = 0.1
STAND_BRAKE = 0.7


class Braking:
    """One stop with a deceleration of `brake_mps2`; None takes the pedal position that also holds it at rest."""

    def __init__(self, brake_mps2: float | None, speed_mps: float) -> None:
        self._brake_mps2 = brake_mps2
        self._due_mps = self._last_mps = speed_mps
        self._pedal = 0.0

    def step(self, speed_mps: float, dt_s: float) -> float:
        """Return the pedal position (0 to 1) at this speed; `dt_s` is the time since the last step."""
        if self._brake_mps2 is None or speed_mps < STANDING_MPS:
            return STAND_BRAKE
        if self._pedal == 0.0:
            self._pedal = min(self._brake_mps2 / FULL_MPS2, 1.0)
            return self._pedal
        self._due_mps -= self._brake_mps2 * dt_s
        wanted = self._brake_mps2 + CATCH_UP_1PS * (speed_mps - self._due_mps)
        measured = (self._last_mps - speed_mps) / dt_s
        self._last_mps = speed_mps
        # The square root, because the deceleration measured now still results from the previous pedal position.
        change = (max(wanted, LEAST_MPS2) / max(measured, LEAST_MPS2)) ** 0.5
        change = min(max(change, 1.0 / QUICKEST_CHANGE), QUICKEST_CHANGE)
        self._pedal = min(self._pedal * change, 1.0)
        return self._pedal
