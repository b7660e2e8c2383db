"""Movements through junctions: entry, exit, turn, traffic control, and conflicting movements."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

import carla

from stucksolver_bridge.traffic_side import drives_on_left
from stucksolver_eval.sites.lane_walk import Town, turn_deg

Turn = Literal["left", "straight", "right"]
Control = Literal["light", "stop", "yield", "none"]
ArmSide = Literal["left", "opposite", "right"]

_TURN_DEG = 35.0
"""Change of heading from which a movement is a turn (degrees). Ours."""
_ARM_TOLERANCE_DEG = 35.0
"""Tolerance of an arm's direction (degrees). Ours."""
_ARM_MIN_M = 90.0
"""Shortest arm of a junction (m). Shorter ones belong to roundabouts. Ours."""
_WIDE_M = 3.0
"""Smallest width of a lane (m).

Narrower ones belong to two-way roads on which two cars cannot pass each other. Ours.
"""
_SIGN_WITHIN_M = 12.0
"""Largest distance of a sign before the junction (m). Ours."""
_LIGHT_TYPE = "1000001"
"""OpenDRIVE's type of a traffic light."""
_LIGHT_WITHIN_M = 12.0
"""Largest distance of a light before the junction (m). Ours."""
_HEADING_DEG: dict[ArmSide, float] = {"left": 90.0, "opposite": 180.0, "right": -90.0}
"""Heading of traffic from each side relative to the ego's (degrees, clockwise); mirrored in left-hand traffic."""


@dataclass(frozen=True)
class JunctionMovement:
    """The path of one lane through a junction."""

    junction_id: int
    entry: carla.Waypoint
    """The last waypoint before the junction."""
    inside: carla.Waypoint
    """The first waypoint in it."""
    exit: carla.Waypoint
    """The first waypoint after it."""
    turn: Turn
    control: Control
    arms: int
    """Number of roads of the junction."""
    town: Town

    @property
    def key(self) -> str:
        """Key of the movement on its map."""
        return f"{self.entry.road_id}/{self.entry.lane_id}-{self.exit.road_id}/{self.exit.lane_id}"


def movements(town: Town) -> list[JunctionMovement]:
    """Return all movements of cars through junctions with wide and long enough arms, ordered by id."""
    found = []
    for ways in _by_junction(town):
        wide = [way for way in ways if min(way.entry.lane_width, way.exit.lane_width) >= _WIDE_M]
        if not any(_is_short(town, item.entry) or _is_short(town, item.exit) for item in wide):
            found.extend(wide)
    return found


def roundabouts(town: Town) -> Iterator[list[JunctionMovement]]:
    """Yield paths through roundabouts as movements at the nodes of the ring: in, around, and out at another arm."""
    ways = [item for junction in _by_junction(town) for item in junction]
    for enter in ways:
        if _is_short(town, enter.entry) or not _is_short(town, enter.exit):
            continue
        chain = [enter]
        while True:
            ahead = [way for way in ways if way.entry.road_id == chain[-1].exit.road_id]
            yield from ([*chain, out] for out in ahead if not _is_short(town, out.exit))
            inside_ring = [obj for obj in ahead if _is_short(town, obj.exit)]
            if inside_ring[0].junction_id == enter.junction_id:
                break
            chain.append(inside_ring[0])


def arm(mine: JunctionMovement, side: ArmSide, others: list[JunctionMovement]) -> list[JunctionMovement]:
    """Return the movements that enter the same junction from a side."""
    return [
        other
        for other in others
        if other.junction_id == mine.junction_id
        and other.town is mine.town
        and abs(math.remainder(_turn_deg(mine.entry, other.entry) - _HEADING_DEG[side], 360.0)) < _ARM_TOLERANCE_DEG
    ]


def straight(of: list[JunctionMovement]) -> list[JunctionMovement]:
    """Return the movements that go straight on."""
    return [item for item in of if item.turn == "straight"]


def _ways(junction: Any, number: int, town: Town) -> Iterator[JunctionMovement]:
    pairs = junction.get_waypoints(carla.LaneType.Driving)
    ends = [(begin, begin.previous(1.0), end.next(1.0)) for begin, end in pairs]
    known = [(begin, before[0], after[0]) for begin, before, after in ends if before and after]
    arms = len({item.road_id for _, before, after in known for item in (before, after)})
    for begin, before, after in sorted(known, key=lambda item: (item[0].road_id, item[0].lane_id)):
        yield JunctionMovement(number, before, begin, after, _turn(before, after), _control(before), arms, town)


def _turn_deg(first: Any, second: Any) -> float:
    """Return the change of heading (degrees), positive toward the side of the road's edge; the right by default."""
    return -turn_deg(first, second) if drives_on_left(first) else turn_deg(first, second)


def _turn(before: Any, after: Any) -> Turn:
    angle_deg = _turn_deg(before, after)
    if abs(angle_deg) < _TURN_DEG:
        return "straight"
    return "right" if angle_deg > 0 else "left"


def _control(entry: carla.Waypoint) -> Control:
    if entry.get_landmarks_of_type(_LIGHT_WITHIN_M, _LIGHT_TYPE):
        return "light"
    back = entry.previous(_SIGN_WITHIN_M / 2)
    if not back:
        return "none"
    for kind, name in (("206", "stop"), ("205", "yield")):
        if any(landmark.road_id == entry.road_id for landmark in back[0].get_landmarks_of_type(_SIGN_WITHIN_M, kind)):
            return "stop" if name == "stop" else "yield"
    return "none"


def _by_junction(town: Town) -> Iterator[list[JunctionMovement]]:
    junctions = {
        w.get_junction().id: w.get_junction() for pair in town.map.get_topology() for w in pair if w.is_junction
    }
    for number in sorted(junctions):
        yield list(_ways(junctions[number], number, town))


def _is_short(town: Town, waypoint: carla.Waypoint) -> bool:
    """Return True if the waypoint is on an arm between the nodes of a roundabout."""
    return town.lengths_m[waypoint.road_id] < _ARM_MIN_M
