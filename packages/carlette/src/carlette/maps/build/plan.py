"""The plan of a map: nodes at which streets meet, and the streets between them, in the right-handed map frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from carlette.maps.build.sections import CrossSection
from carlette.maps.reference_lines import Pose2D

Control = Literal["light", "stop", "yield", "none"]


@dataclass(frozen=True)
class JunctionNode:
    """A junction. Its streets begin `reach_m` from its center, and it is flat."""

    name: str
    x: float
    y: float
    z: float = 0.0
    reach_m: float = 19.0
    crosswalks: bool = True


@dataclass(frozen=True)
class End:
    """The end of a street at a node."""

    node: str
    bearing_deg: float
    """The direction from the node's center along the street, counterclockwise from the x axis."""
    control: Control = "none"
    """Traffic control for this street at the node."""
    left_m: float = 0.0
    """Lateral offset of the street's line from the node's center (m), to the left when looking along the bearing."""
    reach_m: float | None = None
    """Replaces the node's own value if set."""
    ramp: bool = False
    """True for a ramp, which meets the outermost lane of a motorway in any direction."""


@dataclass(frozen=True)
class StreetCrossing:
    """A crosswalk, `at_m` along the street; `level` makes it a level crossing, with its signs."""

    at_m: float
    kind: Literal["crosswalk", "rails"] = "crosswalk"


@dataclass(frozen=True)
class RoadsidePlot:
    """A building or open area next to the street."""

    name: str
    at_m: float
    t_m: float
    length_m: float = 40.0
    width_m: float = 20.0
    height_m: float = 8.0


@dataclass(frozen=True)
class PlannedStreet:
    """A street from one node to another through given poses."""

    name: str
    start: End
    end: End
    section: CrossSection
    via: tuple[Pose2D, ...] = ()
    heights: tuple[tuple[float, float], ...] = ()
    """(share of the length, height in meters) between the two nodes' own heights. The street is level at each."""
    crossings: tuple[StreetCrossing, ...] = ()
    blocks: tuple[RoadsidePlot, ...] = ()


class PlanError(ValueError):
    """A plan is inconsistent. The message names the street and the remedy."""


@dataclass(frozen=True)
class Plan:
    """A whole map. Raises `PlanError` if a street ends at no node or two nodes share a name."""

    name: str
    nodes: Sequence[JunctionNode]
    streets: Sequence[PlannedStreet]

    def __post_init__(self) -> None:
        names = [node.name for node in self.nodes]
        twins = {name for name in names if names.count(name) > 1}
        if twins:
            raise PlanError(f"duplicate node in map '{self.name}': {min(twins)}. Give each its own name")
        for street in self.streets:
            for end in (street.start, street.end):
                if end.node not in names:
                    raise PlanError(
                        f"unknown node: '{end.node}' at the end of '{street.name}'. Add it or correct the name"
                    )
