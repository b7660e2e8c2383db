"""Roads outside junctions: a chain of them between two junctions, and the arms at each."""

from __future__ import annotations

from dataclasses import dataclass

from scenariogeneration import xodr

from carlette.maps.cross_sections import RoadCrossSection, two_way_lanes
from carlette.maps.reference_lines import Pose2D, Segment, end_of


@dataclass(frozen=True)
class RoadEnd:
    """The end of a road at a junction."""

    road: xodr.Road
    at_end: bool
    """True if the road ends at the junction, False if it starts there."""
    pose: Pose2D
    """The end of the reference line, directed into the junction."""
    profile: RoadCrossSection

    def incoming(self, position: int) -> int:
        """Return the id of the `position`-th lane into the junction, counted from the center line."""
        return -position if self.at_end else position

    def outgoing(self, position: int) -> int:
        """Return the id of the `position`-th lane out of the junction, counted from the center line."""
        return -self.incoming(position)


@dataclass(frozen=True)
class RoadChain:
    """Consecutive roads with the same name."""

    roads: list[xodr.Road]
    first: RoadEnd
    last: RoadEnd


def chain(
    name: str,
    ids: range,
    start: Pose2D,
    segments: list[Segment],
    profile: RoadCrossSection,
    junctions: tuple[int, int],
) -> RoadChain:
    """Return one road for each segment, linked end to start, between the junctions with the two ids."""
    roads = []
    for index, (road_id, segment) in enumerate(zip(ids, segments, strict=True)):
        is_first, is_last = index == 0, index == len(segments) - 1
        lanes = two_way_lanes(profile, before=not is_first, after=not is_last)
        road = road_along(road_id, name, end_of(start, segments[:index]), [segment], lanes)
        road.add_type(xodr.RoadType.town, speed=profile.speed_mph, speed_unit="mph")
        if is_first:
            road.add_predecessor(xodr.ElementType.junction, junctions[0])
        else:
            road.add_predecessor(xodr.ElementType.road, road_id - 1, xodr.ContactPoint.end)
        if is_last:
            road.add_successor(xodr.ElementType.junction, junctions[1])
        else:
            road.add_successor(xodr.ElementType.road, road_id + 1, xodr.ContactPoint.start)
        roads.append(road)
    first = RoadEnd(roads[0], False, start.reversed(), profile)
    return RoadChain(roads, first, RoadEnd(roads[-1], True, end_of(start, segments), profile))


def road_along(
    road_id: int, name: str, start: Pose2D, segments: list[Segment], lanes: xodr.Lanes, junction: int = -1
) -> xodr.Road:
    """Return a flat road along the segments. `junction` is the id of its junction."""
    line = xodr.PlanView(start.x, start.y, start.yaw_rad)
    for segment in segments:
        if segment.curvature:
            line.add_geometry(xodr.Arc(segment.curvature, length=segment.length_m))
        else:
            line.add_geometry(xodr.Line(segment.length_m))
    line.adjust_geometries()
    road = xodr.Road(road_id, line, lanes, road_type=junction, name=name)
    road.add_elevation(0, 0, 0, 0, 0)
    return road
