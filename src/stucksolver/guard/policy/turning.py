"""Turning round on the road."""

from __future__ import annotations

from pydantic import NonNegativeFloat, PositiveFloat

from stucksolver.scene.model import Model


class TurningPolicy(Model):
    """A turn in several legs. Read by `turning`."""

    edge_m: NonNegativeFloat = 0.15
    """Distance of every corner of the body from the road edges: `LanePolicy.drivable_tolerance_m`, but inwards,
    since a turn swings the corners out.
    """
    error_m: PositiveFloat = 0.35
    """Further from the proven leg, the turn stops: with `error_rad`, what the gaps of the plan cover."""
    error_rad: PositiveFloat = 0.2
    """Heading error at which it stops too."""
    shifts_s: NonNegativeFloat = 1.5
    """Time between two legs, to change gear and to look. Ours."""
    slowest_mps: PositiveFloat = 0.6
    """Lowest average speed of a leg, stops and starts included. Measured: 0.65 to 0.8 m/s at 1.4 m/s asked, on
    carlette.
    """
