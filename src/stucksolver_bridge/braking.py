"""The brake pedal for a deceleration that was ordered, without numpy.

What a pedal brings about differs between vehicles by a factor of three, so it is learnt from tick to tick.
"""

from __future__ import annotations

FULL_MPS2 = 12.0
"""First guess at what the whole pedal brings about; so low that what is wrong with it brakes too hard at first."""
LEAST_MPS2 = 0.3
"""Less is not measured: the brakes have not bitten yet."""
QUICKEST_CHANGE = 1.6
"""The pedal changes by this factor a tick at most."""
CATCH_UP_1PS = 2.0
"""So much more is braked (m/s²) for each m/s above the speed that it should be by now."""
STANDING_MPS = 0.1
STAND_BRAKE = 0.7


class Braking:
    """One stop. `brake_mps2`: how hard; None for as usual, which is the pedal that also holds the vehicle at rest."""

    def __init__(self, brake_mps2: float | None, speed_mps: float) -> None:
        self._brake_mps2 = brake_mps2
        self._due_mps = self._last_mps = speed_mps
        self._pedal = 0.0

    def step(self, speed_mps: float, dt_s: float) -> float:
        """The pedal, 0 to 1, at a speed, this long after the last step."""
        if self._brake_mps2 is None or speed_mps < STANDING_MPS:
            return STAND_BRAKE
        if self._pedal == 0.0:
            self._pedal = min(self._brake_mps2 / FULL_MPS2, 1.0)
            return self._pedal
        self._due_mps -= self._brake_mps2 * dt_s
        wanted = self._brake_mps2 + CATCH_UP_1PS * (speed_mps - self._due_mps)
        measured = (self._last_mps - speed_mps) / dt_s
        self._last_mps = speed_mps
        # The square root: what is measured now is of the pedal before.
        change = (max(wanted, LEAST_MPS2) / max(measured, LEAST_MPS2)) ** 0.5
        change = min(max(change, 1.0 / QUICKEST_CHANGE), QUICKEST_CHANGE)
        self._pedal = min(self._pedal * change, 1.0)
        return self._pedal
