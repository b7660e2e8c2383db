"""Cross-sections: the lanes of a street, their widths, and the markings between them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

LaneKind = Literal["driving", "parking", "biking", "restricted", "shoulder", "sidewalk", "median"]
LANE_M = 3.5
PARKING_M = 2.6
BIKING_M = 1.9
BUS_M = 3.3
KERB_STRIP_M = 0.5
SIDEWALK_M = 2.5


@dataclass(frozen=True)
class Mark:
    """A line between two lanes. A broken line permits lane changes, all others forbid them."""

    paint: Literal["broken", "solid", "solid solid", "curb", "none"]
    color: Literal["white", "yellow"] = "white"
    between_directions: bool = False
    """The centre line of a two-way street: route planners must never change lanes across it, broken or not."""

    @property
    def change(self) -> str:
        """OpenDRIVE's `laneChange`."""
        return "both" if self.paint == "broken" and not self.between_directions else "none"


@dataclass(frozen=True)
class Lane:
    """One lane, with the line on its outer side."""

    kind: LaneKind
    width_m: float
    mark: Mark


@dataclass(frozen=True)
class Section:
    """Lanes on both sides of the reference line, from there outwards. Driving lanes come first on each side."""

    name: str
    right: tuple[Lane, ...]
    left: tuple[Lane, ...]
    centre: Mark
    limit_kmh: float
    kind: Literal["town", "rural", "motorway"] = "town"

    def half_width_m(self) -> float:
        """Distance from the reference line to the outer edge of what wheels may touch, on the wider side (m)."""
        return max(sum(lane.width_m for lane in side if lane.kind != "sidewalk") for side in (self.left, self.right))


NONE = Mark("none")
BROKEN = Mark("broken")
SOLID = Mark("solid")
KERB = Mark("curb")
PASSING = Mark("broken", "yellow", between_directions=True)
NO_PASSING = Mark("solid", "yellow", between_directions=True)
DIVIDED = Mark("solid solid", "yellow", between_directions=True)

SIDEWALK = Lane("sidewalk", SIDEWALK_M, NONE)
KERB_STRIP = Lane("shoulder", KERB_STRIP_M, KERB)
PARKING = Lane("parking", PARKING_M, KERB)
BIKING = Lane("biking", BIKING_M, KERB)
BUS = Lane("restricted", BUS_M, KERB)


def lanes(count: int, edge: Mark, *beside: Lane) -> tuple[Lane, ...]:
    """One side: driving lanes with broken lines between them, `edge` beyond the last one, then the lanes `beside`."""
    inner = tuple(Lane("driving", LANE_M, BROKEN) for _ in range(count - 1))
    return (*inner, Lane("driving", LANE_M, edge), *beside)


def two_way(name: str, side: tuple[Lane, ...], centre: Mark, limit_kmh: float) -> Section:
    """Return a section with the same lanes in both directions."""
    return Section(name, side, side, centre, limit_kmh)


SLOW_STREET = two_way("school street", lanes(1, NONE, KERB_STRIP, SIDEWALK), NO_PASSING, 30)
PARKING_STREET = two_way("parking street", lanes(1, NONE, PARKING, SIDEWALK), PASSING, 40)
BIKE_STREET = two_way("bicycle street", lanes(1, SOLID, BIKING, SIDEWALK), PASSING, 40)
AVENUE = two_way("avenue", lanes(2, SOLID, KERB_STRIP, SIDEWALK), DIVIDED, 50)
BUS_AVENUE = two_way("bus avenue", lanes(2, SOLID, BUS, SIDEWALK), DIVIDED, 50)
ONE_WAY = Section(
    "one-way street", lanes(2, NONE, PARKING, SIDEWALK), (Lane("shoulder", KERB_STRIP_M, KERB), SIDEWALK), SOLID, 30
)
RING_LANE_M = 5.0
RING = Section(
    "roundabout",
    (Lane("driving", RING_LANE_M, NONE), KERB_STRIP, SIDEWALK),
    (Lane("shoulder", KERB_STRIP_M, KERB),),
    SOLID,
    30,
)

_VERGE = Lane("shoulder", 1.5, NONE)
_HARD_SHOULDER = Lane("shoulder", 3.0, NONE)
_INNER_EDGE = (Lane("shoulder", 1.0, NONE),)
RURAL = Section("main road", lanes(1, SOLID, _VERGE), lanes(1, SOLID, _VERGE), PASSING, 70, "rural")
RURAL_BENDS = Section("bends", lanes(1, SOLID, _VERGE), lanes(1, SOLID, _VERGE), NO_PASSING, 50, "rural")
LANE_ROAD = Section("side road", lanes(1, NONE, _VERGE), lanes(1, NONE, _VERGE), PASSING, 50, "rural")
NARROW_M = 2.1
"""Two cars cannot pass each other on two such lanes."""
_NARROW = (Lane("driving", NARROW_M, NONE), Lane("shoulder", 0.4, NONE))
NARROW = Section("narrow lane", _NARROW, _NARROW, Mark("none", between_directions=True), 30, "rural")
VILLAGE = two_way("village street", lanes(1, NONE, PARKING, SIDEWALK), PASSING, 40)
MOTORWAY = Section("motorway", lanes(3, SOLID, _HARD_SHOULDER), _INNER_EDGE, SOLID, 90, "motorway")
MOTORWAY_WITH_AUXILIARY = Section("motorway", lanes(4, SOLID, _HARD_SHOULDER), _INNER_EDGE, SOLID, 90, "motorway")
RAMP = Section("ramp", lanes(1, SOLID, _VERGE), _INNER_EDGE, SOLID, 50, "motorway")
SLOW_RAMP = Section("slow ramp", lanes(1, SOLID, _VERGE), _INNER_EDGE, SOLID, 30, "motorway")
