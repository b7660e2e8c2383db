"""Streets as OpenDRIVE roads, and the arms at the nodes at their ends."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from xml.etree.ElementTree import Element, SubElement

from carlette.maps.build.plan import End, JunctionNode, PlannedStreet
from carlette.maps.build.sections import CrossSection, LaneMarking, LaneSpec
from carlette.maps.reference_lines import Pose2D, Segment, end_of, lead

PAINT_M = 0.125
"""Width of a painted line (m). Ours."""


@dataclass(frozen=True)
class StreetEnd:
    """The end of a street at a node."""

    street: PlannedStreet
    road_id: int
    length_m: float
    at_end: bool
    """True if the road ends at the node, False if it starts there."""
    end: End
    pose: Pose2D
    """The end of the reference line, directed into the node."""

    @property
    def incoming(self) -> tuple[LaneSpec, ...]:
        """Lanes into the node, from the reference line outwards."""
        return self.street.section.right if self.at_end else self.street.section.left

    @property
    def outgoing(self) -> tuple[LaneSpec, ...]:
        """Lanes out of the node, from the reference line outwards."""
        return self.street.section.left if self.at_end else self.street.section.right

    def incoming_id(self, position: int) -> int:
        """Return OpenDRIVE's id of a lane into the node; positions count from 1 at the reference line."""
        return -position if self.at_end else position

    def outgoing_id(self, position: int) -> int:
        """Return OpenDRIVE's id of a lane out of the node."""
        return -self.incoming_id(position)

    def station(self, before_end_m: float) -> float:
        """Return the road's s at this distance before the node (m)."""
        return self.length_m - before_end_m if self.at_end else before_end_m


@dataclass(frozen=True)
class StreetRoad:
    """A street's road with its two arms."""

    street: PlannedStreet
    element: Element
    length_m: float
    first: StreetEnd
    last: StreetEnd


def build_street(
    street: PlannedStreet, road_id: int, nodes: Mapping[str, JunctionNode], junction_ids: Mapping[str, int]
) -> StreetRoad:
    """Return the road of a street; its links name the junctions at its nodes."""
    start, end = nodes[street.start.node], nodes[street.end.node]
    first, last = _pose(start, street.start), _pose(end, street.end)
    segments = _line([first.reversed(), *street.via, last])
    length_m = sum(segment.length_m for segment in segments)
    element = road_element(road_id, street.name, first.reversed(), segments)
    link = SubElement(element, "link")
    SubElement(link, "predecessor", elementType="junction", elementId=str(junction_ids[start.name]))
    SubElement(link, "successor", elementType="junction", elementId=str(junction_ids[end.name]))
    complete_road(element, street.section.kind, street.section.limit_kmh, _heights(street, start, end, length_m))
    _add_lanes(element, street.section)
    arms = (
        StreetEnd(street, road_id, length_m, at_end, where, pose)
        for at_end, where, pose in ((False, street.start, first), (True, street.end, last))
    )
    return StreetRoad(street, element, length_m, *arms)


def road_element(road_id: int, name: str, start: Pose2D, segments: Iterable[Segment], junction: int = -1) -> Element:
    """Return a road with its plan view and nothing else yet."""
    pieces = list(segments)
    length_m = sum(item.length_m for item in pieces)
    road = Element("road", name=name, length=number(length_m), id=str(road_id), junction=str(junction))
    view = Element("planView")
    s = 0.0
    for index, piece in enumerate(pieces):
        pose = end_of(start, pieces[:index])
        at = {"s": s, "x": pose.x, "y": pose.y, "hdg": math.remainder(pose.yaw_rad, 2 * math.pi)}
        geometry = SubElement(view, "geometry", {key: number(value) for key, value in at.items()})
        geometry.set("length", number(piece.length_m))
        if piece.curvature:
            SubElement(geometry, "arc", curvature=number(piece.curvature))
        else:
            SubElement(geometry, "line")
        s += piece.length_m
    road.append(view)
    return road


def complete_road(road: Element, kind: str, limit_kmh: float, heights: list[tuple[float, float]]) -> None:
    """Add type, speed limit and elevation ((s, z) knots, level at each) around the plan view, in schema order."""
    kinds = Element("type", s="0", type=kind)
    SubElement(kinds, "speed", max=f"{limit_kmh:g}", unit="km/h")
    view = road.find("planView")
    assert view is not None
    place = list(road).index(view)
    road.remove(view)
    link = road.find("link")
    if link is not None:
        road.remove(link)
        road.insert(0, link)
        place = 1
    road.insert(place, kinds)
    road.append(view)
    profile = SubElement(road, "elevationProfile")
    for (s0, z0), (s1, z1) in pairwise([*heights, (math.inf, heights[-1][1])]):
        c, d = _ease(z0, z1, s1 - s0)
        SubElement(profile, "elevation", s=number(s0), a=number(z0), b="0", c=c, d=d)
    SubElement(road, "lateralProfile")


def lane_element(lane_id: int, kind: str, width: tuple[float, float], length_m: float, mark: LaneMarking) -> Element:
    """Return a lane whose width changes smoothly from the first value to the second (m), without a kink at the ends."""
    lane = Element("lane", id=str(lane_id), type=kind, level="false")
    c, d = _ease(width[0], width[1], length_m)
    SubElement(lane, "width", sOffset="0", a=number(width[0]), b="0", c=c, d=d)
    lane.append(mark_element(mark))
    return lane


def mark_element(mark: LaneMarking) -> Element:
    """Return a lane's outer line."""
    what = {"type": mark.paint, "weight": "standard", "color": mark.color, "laneChange": mark.change}
    return Element("roadMark", {"sOffset": "0", "width": number(PAINT_M), **what})


def number(value: float) -> str:
    """Round to 10 nanometers, since the last bits of a sine differ between machines."""
    return repr(round(float(value), 8) + 0.0)


def _ease(first: float, last: float, length: float) -> tuple[str, str]:
    """Return the coefficients c and d of the cubic from one value to another that is level at both ends."""
    change = last - first
    c, d = (3 * change / length**2, -2 * change / length**3) if change else (0.0, 0.0)
    return repr(round(c, 15) + 0.0), repr(round(d, 15) + 0.0)


def _pose(node: JunctionNode, end: End) -> Pose2D:
    reach_m = node.reach_m if end.reach_m is None else end.reach_m
    return Pose2D(node.x, node.y, math.radians(end.bearing_deg)).moved(reach_m, end.left_m).reversed()


def _line(poses: list[Pose2D]) -> list[Segment]:
    return [segment for pose, next_one in pairwise(poses) for segment in lead(pose, next_one)]


def _heights(
    street: PlannedStreet, start: JunctionNode, end: JunctionNode, length_m: float
) -> list[tuple[float, float]]:
    inner = [(share * length_m, z) for share, z in street.heights]
    return [(0.0, start.z), *inner, (length_m, end.z)]


def _add_lanes(road: Element, section: CrossSection) -> None:
    holder = SubElement(SubElement(road, "lanes"), "laneSection", s="0")
    sides = {"left": list(enumerate(section.left, 1))[::-1]}
    sides["right"] = [(-i, lane) for i, lane in enumerate(section.right, 1)]
    for side in ("left", "center", "right"):
        if side != "center" and not sides[side]:
            continue
        group = SubElement(holder, side)
        if side == "center":
            center = SubElement(group, "lane", id="0", type="none", level="false")
            center.append(mark_element(section.center))
            continue
        for lane_id, lane in sides[side]:
            group.append(lane_element(lane_id, lane.kind, (lane.width_m, lane.width_m), 1.0, lane.mark))
