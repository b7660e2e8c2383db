"""Turning round on the road."""

from __future__ import annotations

from pydantic import NonNegativeFloat, PositiveFloat

from stucksolver.scene.base_model import FrozenModel


class TurningPolicy(FrozenModel):
    """A turn in several legs. Read by `turning`."""

    edge_m: NonNegativeFloat = 0.15
    """Distance of every corner of the body from the edges of the road: `LanePolicy.drivable_tolerance_m`, but inwards,
    since the corners swing out in a turn.
    """
    error_m: PositiveFloat = 0.35
    """The turn stops if the ego is further than this from the proven leg: the gaps cover this and `error_rad`."""
    error_rad: PositiveFloat = 0.2
    """It also stops at a larger heading error than this."""
    shifts_s: NonNegativeFloat = 1.5
    """Time between two legs, to change gear and to check the next leg. Ours."""
    slowest_mps: PositiveFloat = 0.6
    """Lowest average speed of a leg, stops and starts included. Measured on carlette: 0.65 to 0.8 m/s if 1.4 m/s was
    requested.
    """
