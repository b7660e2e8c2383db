"""A site on a map for one scenario, with the route past it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from stucksolver_eval.routes import Parameter
from stucksolver_eval.sites.lane_walk import Path, Town

if TYPE_CHECKING:
    import carla


@dataclass(frozen=True)
class Site:
    """A site with its route. `path` is the whole route, `marks` are the few waypoints in its XML."""

    town: Town
    group: str
    """The road or junction. Routes of one type go to different groups if possible."""
    place: str
    """Key of the site on its map."""
    path: Path
    marks: tuple[Any, ...]
    trigger: carla.Waypoint
    free_m: int = 0
    """Length of lane from the trigger to the next junction."""
    positions: Mapping[str, Any] = field(default_factory=dict)
    """Waypoints for the scenario's parameters."""
    fixed: Mapping[str, Parameter] = field(default_factory=dict)
    """Parameters that follow from the site."""
