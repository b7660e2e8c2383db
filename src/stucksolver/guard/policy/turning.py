"""Turning round on the road."""

from __future__ import annotations

from pydantic import NonNegativeFloat, PositiveFloat

from stucksolver.scene.model import Model


class TurningPolicy(Model):
    """A turn in several legs. Read by `turning`."""

    edge_m: NonNegativeFloat = 0.15
    """Kept from the edges of the road by every corner of the body: `LanePolicy.drivable_tolerance_m`, to the other
    side, since a turn swings its corners out."""
    error_m: PositiveFloat = 0.35
    """Further from the leg that was proven, it ends by a stop: with `error_rad`, what the gaps of the layout cover."""
    error_rad: PositiveFloat = 0.2
    """Turned by more from it, too."""
    shifts_s: NonNegativeFloat = 1.5
    """Between two legs, to change gear and to look. Ours."""
    slowest_mps: PositiveFloat = 0.6
    """Legs are driven no slower, stops and starts included. Measured: 0.65 to 0.8 m/s at 1.4 m/s asked, on carlette."""
