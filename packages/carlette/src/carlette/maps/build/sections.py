"""Cross-sections: the lanes of a street, their widths, and the markings between them. The widths are ours."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

LaneKind = Literal["driving", "parking", "biking", "restricted", "shoulder", "sidewalk", "median"]
LANE_M = 3.5
PARKING_M = 2.6
BIKING_M = 1.9
BUS_M = 3.3
CURB_STRIP_M = 0.5
SIDEWALK_M = 2.5


@dataclass(frozen=True)
class LaneMarking:
    """A line between two lanes. A broken line permits lane changes, all others forbid them."""

    paint: Literal["broken", "solid", "solid solid", "curb", "none"]
    color: Literal["white", "yellow"] = "white"
    between_directions: bool = False
    """True for the center line of a two-way street. Route planners must never change lanes across it, broken or not."""

    @property
    def change(self) -> str:
        """OpenDRIVE's `laneChange`."""
        return "both" if self.paint == "broken" and not self.between_directions else "none"


@dataclass(frozen=True)
class LaneSpec:
    """One lane, with the line on its outer side."""

    kind: LaneKind
    width_m: float
    mark: LaneMarking


@dataclass(frozen=True)
class CrossSection:
    """Lanes on both sides of the reference line, outward. Driving lanes come first on each side."""

    name: str
    right: tuple[LaneSpec, ...]
    left: tuple[LaneSpec, ...]
    center: LaneMarking
    limit_kmh: float
    kind: Literal["town", "rural", "motorway"] = "town"

    def half_width_m(self) -> float:
        """Return the distance from the reference line to the outer drivable edge, on the wider side (m)."""
        return max(sum(lane.width_m for lane in side if lane.kind != "sidewalk") for side in (self.left, self.right))


NONE = LaneMarking("none")
BROKEN = LaneMarking("broken")
SOLID = LaneMarking("solid")
CURB = LaneMarking("curb")
PASSING = LaneMarking("broken", "yellow", between_directions=True)
NO_PASSING = LaneMarking("solid", "yellow", between_directions=True)
DIVIDED = LaneMarking("solid solid", "yellow", between_directions=True)

SIDEWALK = LaneSpec("sidewalk", SIDEWALK_M, NONE)
CURB_STRIP = LaneSpec("shoulder", CURB_STRIP_M, CURB)
PARKING = LaneSpec("parking", PARKING_M, CURB)
BIKING = LaneSpec("biking", BIKING_M, CURB)
BUS = LaneSpec("restricted", BUS_M, CURB)


def lanes(count: int, edge: LaneMarking, *outer_lanes: LaneSpec) -> tuple[LaneSpec, ...]:
    """Return one side: driving lanes with broken lines between them, then `edge`, then the lanes `beside`."""
    inner = tuple(LaneSpec("driving", LANE_M, BROKEN) for _ in range(count - 1))
    return (*inner, LaneSpec("driving", LANE_M, edge), *outer_lanes)


def two_way(name: str, side: tuple[LaneSpec, ...], center: LaneMarking, limit_kmh: float) -> CrossSection:
    """Return a section with the same lanes in both directions."""
    return CrossSection(name, side, side, center, limit_kmh)


SLOW_STREET = two_way("school street", lanes(1, NONE, CURB_STRIP, SIDEWALK), NO_PASSING, 30)
PARKING_STREET = two_way("parking street", lanes(1, NONE, PARKING, SIDEWALK), PASSING, 40)
BIKE_STREET = two_way("bicycle street", lanes(1, SOLID, BIKING, SIDEWALK), PASSING, 40)
AVENUE = two_way("avenue", lanes(2, SOLID, CURB_STRIP, SIDEWALK), DIVIDED, 50)
BUS_AVENUE = two_way("bus avenue", lanes(2, SOLID, BUS, SIDEWALK), DIVIDED, 50)
ONE_WAY = CrossSection(
    "one-way street", lanes(2, NONE, PARKING, SIDEWALK), (LaneSpec("shoulder", CURB_STRIP_M, CURB), SIDEWALK), SOLID, 30
)
RING_LANE_M = 5.0
RING = CrossSection(
    "roundabout",
    (LaneSpec("driving", RING_LANE_M, NONE), CURB_STRIP, SIDEWALK),
    (LaneSpec("shoulder", CURB_STRIP_M, CURB),),
    SOLID,
    30,
)

_VERGE = LaneSpec("shoulder", 1.5, NONE)
_HARD_SHOULDER = LaneSpec("shoulder", 3.0, NONE)
_INNER_EDGE = (LaneSpec("shoulder", 1.0, NONE),)
RURAL = CrossSection("main road", lanes(1, SOLID, _VERGE), lanes(1, SOLID, _VERGE), PASSING, 70, "rural")
RURAL_BENDS = CrossSection("bends", lanes(1, SOLID, _VERGE), lanes(1, SOLID, _VERGE), NO_PASSING, 50, "rural")
LANE_ROAD = CrossSection("side road", lanes(1, NONE, _VERGE), lanes(1, NONE, _VERGE), PASSING, 50, "rural")
NARROW_M = 2.1
"""Width of a lane on which two cars cannot pass each other (m)."""
_NARROW = (LaneSpec("driving", NARROW_M, NONE), LaneSpec("shoulder", 0.4, NONE))
NARROW = CrossSection("narrow lane", _NARROW, _NARROW, LaneMarking("none", between_directions=True), 30, "rural")
VILLAGE = two_way("village street", lanes(1, NONE, PARKING, SIDEWALK), PASSING, 40)
MOTORWAY = CrossSection("motorway", lanes(3, SOLID, _HARD_SHOULDER), _INNER_EDGE, SOLID, 90, "motorway")
MOTORWAY_WITH_AUXILIARY = CrossSection("motorway", lanes(4, SOLID, _HARD_SHOULDER), _INNER_EDGE, SOLID, 90, "motorway")
RAMP = CrossSection("ramp", lanes(1, SOLID, _VERGE), _INNER_EDGE, SOLID, 50, "motorway")
SLOW_RAMP = CrossSection("slow ramp", lanes(1, SOLID, _VERGE), _INNER_EDGE, SOLID, 30, "motorway")
