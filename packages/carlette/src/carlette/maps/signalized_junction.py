"""Signalized junctions: connecting roads, and a light with its own phase and a crosswalk for each arm."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from xml.etree.ElementTree import Element

from scenariogeneration import xodr

from carlette.maps import opendrive_objects
from carlette.maps.cross_sections import LANE_M, connecting_lanes
from carlette.maps.reference_lines import Pose2D, connect
from carlette.maps.road_chains import RoadEnd, road_along

_LIGHT_ID, _CONTROLLER_ID, _CROSSWALK_ID = 50, 60, 70
_STRAIGHT_RAD = math.radians(30)
"""Change of heading up to which a movement is straight on (rad). Ours."""


@dataclass
class SignalisedJunction:
    """A junction with its parts. The ids count up from the junction's own."""

    number: int
    arms: list[RoadEnd]
    roads: list[xodr.Road] = field(default_factory=list)
    element: xodr.Junction = field(init=False)
    _lit_by: list[tuple[int, RoadEnd]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.element = xodr.Junction(f"junction{self.number}", self.number)
        for incoming in self.arms:
            for outgoing in self.arms:
                if outgoing is not incoming:
                    self._join(incoming, outgoing)

    def roadside(self) -> Iterator[tuple[int, str, Element]]:
        """Yield the objects and markings of the roads: (road id, `objects` or `signals`, element)."""
        for place, arm in enumerate(self.arms):
            yield arm.road.id, "objects", opendrive_objects.crosswalk(arm, self.number + _CROSSWALK_ID + place)
            yield arm.road.id, "signals", opendrive_objects.light(arm, self._light_id(arm))
        for road_id, arm in self._lit_by:
            yield road_id, "signals", opendrive_objects.light_reference(self._light_id(arm))

    def controllers(self) -> Iterator[tuple[Element, Element]]:
        """Yield each arm's controller, and the junction's entry for it."""
        for sequence, arm in enumerate(self.arms):
            number = self.number + _CONTROLLER_ID + sequence
            entry = opendrive_objects.controller_entry(number, sequence)
            yield opendrive_objects.controller(number, sequence, self._light_id(arm)), entry

    def _light_id(self, arm: RoadEnd) -> int:
        return self.number + _LIGHT_ID + self.arms.index(arm)

    def _join(self, incoming: RoadEnd, outgoing: RoadEnd) -> None:
        turn_rad = _turn_rad(incoming, outgoing)
        for lane_in, lane_out in _lane_pairs(incoming, outgoing, turn_rad):
            at_curb = self._at_curb(incoming, lane_in, turn_rad)
            links = [
                (incoming.incoming(lane_in + extra), outgoing.outgoing(lane_out + extra))
                for extra in range(3 if at_curb else 1)
            ]
            start = incoming.pose.moved(0, -LANE_M * (lane_in - 1))
            end = outgoing.pose.reversed().moved(0, -LANE_M * (lane_out - 1))
            road = self._connecting_road(start, end, connecting_lanes(links))
            road.add_type(xodr.RoadType.town, speed=incoming.profile.speed_mph, speed_unit="mph")
            _link(road.add_predecessor, incoming)
            _link(road.add_successor, outgoing)
            self._lit_by.append((road.id, incoming))
            self._connect(incoming.road.id, road.id, [pair[0] for pair in links])

    def _connecting_road(self, start: Pose2D, end: Pose2D, lanes: xodr.Lanes) -> xodr.Road:
        number = self.number + 1 + len(self.roads)
        segments = connect(start, end)
        self.roads.append(road_along(number, self.element.name, start, segments, lanes, self.number))
        return self.roads[-1]

    def _connect(self, incoming_road: int, connecting_road: int, lanes_in: list[int]) -> None:
        connection = xodr.Connection(incoming_road, connecting_road, xodr.ContactPoint.start)
        for position, lane_in in enumerate(lanes_in, start=1):
            connection.add_lanelink(lane_in, -position)
        self.element.add_connection(connection)

    def _at_curb(self, incoming: RoadEnd, lane_in: int, turn_rad: float) -> bool:
        """True if no other movement is between this one and the curb."""
        turns = [_turn_rad(incoming, other) for other in self.arms if other is not incoming]
        return turn_rad == min(turns) and lane_in == incoming.profile.lanes_each_way


def _turn_rad(incoming: RoadEnd, outgoing: RoadEnd) -> float:
    return math.remainder(outgoing.pose.yaw_rad + math.pi - incoming.pose.yaw_rad, 2 * math.pi)


def _lane_pairs(incoming: RoadEnd, outgoing: RoadEnd, turn_rad: float) -> Iterator[tuple[int, int]]:
    """Yield positions of lanes that a movement joins: left turns inside, right turns outside, straight on all."""
    lanes_in, lanes_out = incoming.profile.lanes_each_way, outgoing.profile.lanes_each_way
    if turn_rad > _STRAIGHT_RAD:
        yield 1, 1
    elif turn_rad < -_STRAIGHT_RAD:
        yield lanes_in, lanes_out
    else:
        for position in range(1, min(lanes_in, lanes_out) + 1):
            yield position, position


def _link(add: Callable[..., object], arm: RoadEnd) -> None:
    point = xodr.ContactPoint.end if arm.at_end else xodr.ContactPoint.start
    add(xodr.ElementType.road, arm.road.id, point)
