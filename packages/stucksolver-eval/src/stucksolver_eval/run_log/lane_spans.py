"""Finds the lanes of all types of an OpenDRIVE map near a region.

`carla.Map` contains driving lanes only. Sidewalks, shoulders, parking and biking lanes come from its text.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple
from xml.etree import ElementTree

import carla
import shapely

from carlette.opendrive.document import id_as_read, number_as_read, parse

_HALF_ROAD_M = 30.0
"""Largest distance of a lane from its road's reference line (m). Ours."""


class LaneSpan(NamedTuple):
    """A lane within one lane section, from `start_s` to `end_s` of its road (m)."""

    road_id: int
    lane_id: int
    kind: str
    """OpenDRIVE lane type: `driving`, `shoulder`, `sidewalk`, ..."""
    start_s: float
    end_s: float
    draws_center: bool
    """True if the road's center line, which both sides share, is drawn with this lane."""


def lane_spans(carla_map: carla.Map, region: shapely.Polygon) -> Iterator[LaneSpan]:
    """Yield all lanes of the roads that may touch the region (right-handed frame, m)."""
    for road in parse(carla_map.to_opendrive()).iterfind("road"):
        if _may_touch(road, region):
            yield from _spans(road)


def _may_touch(road: ElementTree.Element, region: shapely.Polygon) -> bool:
    """Return True if any piece of the reference line starts close enough to reach the region."""
    for geometry in road.iterfind("planView/geometry"):
        start = shapely.Point(_number(geometry, "x"), _number(geometry, "y"))
        if region.distance(start) <= _number(geometry, "length") + _HALF_ROAD_M:
            return True
    return False


def _spans(road: ElementTree.Element) -> Iterator[LaneSpan]:
    sections = road.findall("lanes/laneSection")
    starts = [_number(section, "s") for section in sections]
    for section, (start_s, end_s) in zip(sections, pairwise([*starts, _number(road, "length")]), strict=True):
        lanes = {number_as_read(lane.get("id")): lane.get("type", "none") for lane in section.iterfind("*/lane")}
        lanes.pop(0, None)
        innermost = min(lanes, key=lambda lane_id: (abs(lane_id), lane_id), default=0)
        for lane_id, kind in lanes.items():
            if end_s - start_s > 0.01:
                yield LaneSpan(id_as_read(road.get("id")), lane_id, kind, start_s, end_s, lane_id == innermost)


def _number(element: ElementTree.Element, name: str) -> float:
    return float(element.get(name, "0"))
