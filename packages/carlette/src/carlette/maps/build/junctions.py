"""Junctions: a road inside them for every lane of every movement."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count
from xml.etree.ElementTree import Element, SubElement

from carlette.maps.build.plan import JunctionNode
from carlette.maps.build.sections import CURB, NONE, LaneSpec
from carlette.maps.build.streets import StreetEnd, complete_road, lane_element, mark_element, road_element
from carlette.maps.reference_lines import Pose2D, lead

_STRAIGHT_RAD = math.radians(30)
"""Change of heading up to which a movement is straight on (rad). Ours."""


@dataclass(frozen=True)
class LaneMovement:
    """One lane's path through a junction."""

    incoming: StreetEnd
    lane_in: int
    outgoing: StreetEnd
    lane_out: int
    at_curb: bool
    """True if no other movement is between it and the curb."""


@dataclass(frozen=True)
class Junction:
    """A node's junction element and the roads in it, each with the arm where it starts."""

    node: JunctionNode
    arms: list[StreetEnd]
    element: Element
    roads: list[tuple[Element, StreetEnd]]


def build_junction(node: JunctionNode, junction_id: int, arms: list[StreetEnd], road_ids: count[int]) -> Junction:
    """Return all connecting roads of a node."""
    element = Element("junction", id=str(junction_id), name=node.name)
    roads = []
    for movement in _movements(arms):
        road_id = next(road_ids)
        road, links = _connecting_road(node, movement, road_id, junction_id)
        roads.append((road, movement.incoming))
        connection = SubElement(
            element,
            "connection",
            id=str(len(roads) - 1),
            incomingRoad=str(movement.incoming.road_id),
            connectingRoad=str(road_id),
            contactPoint="start",
        )
        for position, lane_in in enumerate(links, 1):
            if lane_in is not None:
                SubElement(connection, "laneLink", {"from": str(lane_in), "to": str(-position)})
    return Junction(node, arms, element, roads)


def turn_rad(incoming: StreetEnd, outgoing: StreetEnd) -> float:
    """Return the turn from `incoming` to `outgoing` (rad), positive to the left."""
    return math.remainder(outgoing.pose.yaw_rad + math.pi - incoming.pose.yaw_rad, 2 * math.pi)


def _movements(arms: list[StreetEnd]) -> Iterator[LaneMovement]:
    for incoming in arms:
        last_in = _driving(incoming.incoming)
        exits = [arm for arm in arms if arm is not incoming and _driving(arm.outgoing)]
        for outgoing in exits:
            rightmost = turn_rad(incoming, outgoing) == min(turn_rad(incoming, exit) for exit in exits)
            for lane_in, lane_out in _lane_pairs(incoming, outgoing):
                yield LaneMovement(incoming, lane_in, outgoing, lane_out, rightmost and lane_in == last_in)
            yield from _bicycles(incoming, outgoing)


def _lane_pairs(incoming: StreetEnd, outgoing: StreetEnd) -> Iterator[tuple[int, int]]:
    """Yield the positions of lanes that a movement joins: left turns inside, right turns outside, straight on all.

    Ramps leave from and lead to the outermost lane.
    """
    lanes_in, lanes_out = _driving(incoming.incoming), _driving(outgoing.outgoing)
    turn = turn_rad(incoming, outgoing)
    if not lanes_in or not lanes_out:
        return
    if incoming.end.ramp or outgoing.end.ramp or turn < -_STRAIGHT_RAD:
        yield lanes_in, lanes_out
    elif turn > _STRAIGHT_RAD:
        yield 1, 1
    else:
        for position in range(1, min(lanes_in, lanes_out) + 1):
            yield position, position


def _bicycles(incoming: StreetEnd, outgoing: StreetEnd) -> Iterator[LaneMovement]:
    lane_in, lane_out = _position(incoming.incoming, "biking"), _position(outgoing.outgoing, "biking")
    if lane_in and lane_out and abs(turn_rad(incoming, outgoing)) <= _STRAIGHT_RAD:
        yield LaneMovement(incoming, lane_in, outgoing, lane_out, False)


def _connecting_road(
    node: JunctionNode, movement: LaneMovement, road_id: int, junction_id: int
) -> tuple[Element, list[int | None]]:
    """Return the road and, for each of its lanes, the incoming lane's id (None where the lane only fills a gap)."""
    incoming, outgoing = movement.incoming, movement.outgoing
    start = _inner_edge(incoming.pose, incoming.incoming, movement.lane_in)
    end = _inner_edge(outgoing.pose.reversed(), outgoing.outgoing, movement.lane_out)
    segments = lead(start, end)
    length_m = sum(segment.length_m for segment in segments)
    road = road_element(road_id, node.name, start, segments, junction_id)
    link = SubElement(road, "link")
    for tag, arm in (("predecessor", incoming), ("successor", outgoing)):
        point = "end" if arm.at_end else "start"
        SubElement(link, tag, elementType="road", elementId=str(arm.road_id), contactPoint=point)
    street = incoming.street
    complete_road(road, street.section.kind, street.section.limit_kmh, [(0.0, node.z)])
    holder = SubElement(SubElement(road, "lanes"), "laneSection", s="0")
    center = SubElement(SubElement(holder, "center"), "lane", id="0", type="none", level="false")
    center.append(mark_element(NONE))
    right = SubElement(holder, "right")
    links: list[int | None] = []
    for position, (lane, widths, ends) in enumerate(_lanes(movement), 1):
        item = lane_element(-position, lane.kind, widths, length_m, lane.mark)
        if ends:
            lane_links = Element("link")
            SubElement(lane_links, "predecessor", id=str(incoming.incoming_id(ends[0])))
            SubElement(lane_links, "successor", id=str(outgoing.outgoing_id(ends[1])))
            item.insert(0, lane_links)
        links.append(incoming.incoming_id(ends[0]) if ends else None)
        right.append(item)
    return road, links


def _lanes(movement: LaneMovement) -> Iterator[tuple[LaneSpec, tuple[float, float], tuple[int, int] | None]]:
    """Yield lanes of a connecting road with their widths at both ends and the positions that they join."""
    lanes_in, lanes_out = movement.incoming.incoming, movement.outgoing.outgoing
    ends = movement.lane_in, movement.lane_out
    first, last = lanes_in[ends[0] - 1], lanes_out[ends[1] - 1]
    yield LaneSpec(first.kind, first.width_m, NONE), (first.width_m, last.width_m), ends
    walks = _position(lanes_in, "sidewalk"), _position(lanes_out, "sidewalk")
    if movement.at_curb and walks[0] and walks[1]:
        gaps = (
            sum(lane.width_m for lane in lanes_in[ends[0] : walks[0] - 1]),
            sum(lane.width_m for lane in lanes_out[ends[1] : walks[1] - 1]),
        )
        yield LaneSpec("shoulder", gaps[0], CURB), gaps, None
        walk = lanes_in[walks[0] - 1]
        yield walk, (walk.width_m, lanes_out[walks[1] - 1].width_m), (walks[0], walks[1])


def _inner_edge(pose: Pose2D, lanes: tuple[LaneSpec, ...], position: int) -> Pose2D:
    return pose.moved(0.0, -sum(lane.width_m for lane in lanes[: position - 1]))


def _driving(lanes: tuple[LaneSpec, ...]) -> int:
    return sum(lane.kind == "driving" for lane in lanes)


def _position(lanes: tuple[LaneSpec, ...], kind: str) -> int:
    """Return the position of the first lane of a kind; 0 without one."""
    return next((position for position, lane in enumerate(lanes, 1) if lane.kind == kind), 0)
