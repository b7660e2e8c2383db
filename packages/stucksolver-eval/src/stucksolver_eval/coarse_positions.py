"""Finds places so far from a map's origin that the client's positions are too coarse for any plan."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from stucksolver.scene.plausibility import FURTHEST_M

if TYPE_CHECKING:
    import carla


def coarse_positions(waypoints: Sequence[carla.Waypoint]) -> str:
    """Return why no plan can be checked along these waypoints, and the remedy; empty if plans can be checked.

    The client's positions are float32: 5,000 km from the origin they come in steps of half a meter.
    """
    places = [waypoint.transform.location for waypoint in (waypoints[0], waypoints[-1])]
    farthest_m = max(max(abs(place.x), abs(place.y)) for place in places)
    if farthest_m <= FURTHEST_M:
        return ""
    step_m = float(np.spacing(np.float32(farthest_m)))
    return (
        f"coordinates of {farthest_m:.3g} m, where the client's positions come in steps of {step_m:g} m: no plan can "
        f"be checked beyond {FURTHEST_M:g} m. Subtract an offset from the map's coordinates"
    )
