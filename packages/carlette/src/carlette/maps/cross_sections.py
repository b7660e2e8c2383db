"""Cross-sections of the demo town's roads: lanes, widths and paint. The widths are ours."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from scenariogeneration import xodr

LANE_M = 3.5
SHOULDER_M = 0.5
SIDEWALK_M = 2.5
PAINT_M = 0.125

_WHITE = xodr.RoadMarkColor.white
_YELLOW = xodr.RoadMarkColor.yellow


def paint(kind: xodr.RoadMarkType, color: xodr.RoadMarkColor = _WHITE, *, change: bool = False) -> xodr.RoadMark:
    """Return a painted line; `change` permits lane changes across it to vehicles of the same direction."""
    across = xodr.LaneChange.both if change else xodr.LaneChange.none
    return xodr.RoadMark(kind, width=PAINT_M, color=color, laneChange=across)


@dataclass(frozen=True)
class RoadCrossSection:
    """The cross-section of a road: the same lanes on both sides of its center line."""

    lanes_each_way: int
    speed_mph: int
    center: Callable[[], xodr.RoadMark]
    edge: Callable[[], xodr.RoadMark]
    """Marking between the outermost driving lane and the shoulder."""

    @property
    def half_width_m(self) -> float:
        """Distance from the center line to the curb (m)."""
        return self.lanes_each_way * LANE_M + SHOULDER_M


# CARLA's towns forbid "lane changes" across a center line in the laneChange attribute even where its broken paint
# permits overtaking. Route planners use the attribute to switch lanes, and they would switch into oncoming traffic.
STREET = RoadCrossSection(
    lanes_each_way=1,
    speed_mph=30,
    center=lambda: paint(xodr.RoadMarkType.broken, _YELLOW),
    edge=lambda: paint(xodr.RoadMarkType.none),
)
AVENUE = RoadCrossSection(
    lanes_each_way=2,
    speed_mph=40,
    center=lambda: paint(xodr.RoadMarkType.solid_solid, _YELLOW),
    edge=lambda: paint(xodr.RoadMarkType.solid),
)


def two_way_lanes(profile: RoadCrossSection, *, before: bool, after: bool) -> xodr.Lanes:
    """Return both sides of a road. `before` and `after` are true if a road of the same profile joins there."""
    center = xodr.Lane(lane_type=xodr.LaneType.none)
    center.add_roadmark(profile.center())
    section = xodr.LaneSection(0, center)
    for side in (section.add_left_lane, section.add_right_lane):
        sign = 1 if side == section.add_left_lane else -1
        for position, lane in enumerate(_one_side(profile), start=1):
            if before:
                lane.add_link("predecessor", sign * position)
            if after:
                lane.add_link("successor", sign * position)
            side(lane)
    return xodr.Lanes().add_lanesection(section)


def connecting_lanes(links: list[tuple[int, int]]) -> xodr.Lanes:
    """Return the lanes of a road inside a junction: one driving lane, and at the curb a shoulder and a sidewalk.

    `links` has the incoming and the outgoing lane id for each of them, from the driving lane outward.
    """
    center = xodr.Lane(lane_type=xodr.LaneType.none)
    center.add_roadmark(paint(xodr.RoadMarkType.none))
    section = xodr.LaneSection(0, center)
    lanes = (_lane(xodr.LaneType.driving, LANE_M, paint(xodr.RoadMarkType.none)), *_curb_side())
    for lane, (incoming, outgoing) in zip(lanes, links, strict=False):
        lane.add_link("predecessor", incoming)
        lane.add_link("successor", outgoing)
        section.add_right_lane(lane)
    return xodr.Lanes().add_lanesection(section)


def _one_side(profile: RoadCrossSection) -> list[xodr.Lane]:
    """Return the lanes of one side, from the center line outward."""
    inner = [
        _lane(xodr.LaneType.driving, LANE_M, paint(xodr.RoadMarkType.broken, change=True))
        for _ in range(profile.lanes_each_way - 1)
    ]
    return [*inner, _lane(xodr.LaneType.driving, LANE_M, profile.edge()), *_curb_side()]


def _curb_side() -> tuple[xodr.Lane, xodr.Lane]:
    shoulder = _lane(xodr.LaneType.shoulder, SHOULDER_M, paint(xodr.RoadMarkType.curb))
    sidewalk = _lane(xodr.LaneType.sidewalk, SIDEWALK_M, paint(xodr.RoadMarkType.none))
    return shoulder, sidewalk


def _lane(kind: xodr.LaneType, width_m: float, mark: xodr.RoadMark) -> xodr.Lane:
    lane = xodr.Lane(lane_type=kind, a=width_m)
    lane.add_roadmark(mark)
    return lane
