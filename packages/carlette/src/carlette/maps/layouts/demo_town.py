"""The demo town. Written with scenariogeneration (the extra `maps`).

It is a ring of two lanes each way and a street of one lane each way across it:

```
    ring north
  +------------+
 J100        J200      signalized T-junctions
  +--street----+
  |            |
  +------------+
    ring south
```

There are no dead ends, so traffic can drive around forever.
"""

from __future__ import annotations

import math
import re
from xml.etree import ElementTree

from scenariogeneration import xodr

from carlette.maps.cross_sections import AVENUE, STREET
from carlette.maps.reference_lines import Pose2D, Segment, arc, end_of
from carlette.maps.road_chains import RoadChain, chain
from carlette.maps.signalized_junction import SignalisedJunction

GEO_REFERENCE = (
    "+proj=tmerc +lat_0=0 +lon_0=0 +k=1 +x_0=0 +y_0=0 +datum=WGS84 +units=m "
    "+geoidgrids=egm96_15.gtx +vunits=m +no_defs "
)
_WEST, _EAST = 100, 200
_REACH_M = 18.0
"""Distance from the center of a junction to the start of its arms (m). Ours."""
_CORNER_M = 40.0
"""Radius of the ring's corners (m). Ours."""
_NORTH_M = 190.0
"""Position of the ring's northern side (m). Ours."""
_SOUTH_M = -150.0
"""Position of the ring's southern side (m). Ours."""
_STREET = [Segment(220.0), arc(500.0, math.radians(10)), Segment(220.0)]
_DECIMALS = 9
"""Number of decimals in the file (nanometers): the last bits of a sine differ between machines."""


def town_xml() -> str:
    """Return the whole town as OpenDRIVE 1.4 text."""
    chains = _layout()
    junctions = [
        SignalisedJunction(_WEST, [way.first for way in chains]),
        SignalisedJunction(_EAST, [way.last for way in chains]),
    ]
    town = xodr.OpenDrive("demo_town", revMinor="4", geo_reference=GEO_REFERENCE)
    for road in [*(road for way in chains for road in way.roads), *(r for j in junctions for r in j.roads)]:
        town.add_road(road)
    for junction in junctions:
        town.add_junction(junction.element)
    root = town.get_element()
    _complete_header(root, chains)
    _add_roadside(root, junctions)
    _add_controllers(root, junctions)
    for element in root.iter():
        element.attrib.update({key: _rounded(value) for key, value in element.attrib.items()})
    ElementTree.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def _layout() -> list[RoadChain]:
    """Return the ring's two halves and the street, each from the western junction to the eastern one."""
    street_start = Pose2D(_REACH_M, 0.0, 0.0)
    east = end_of(street_start, _STREET).moved(_REACH_M)
    top_m = east.x - 2 * _CORNER_M
    right, left = arc(_CORNER_M, -math.pi / 2), arc(_CORNER_M, math.pi / 2)
    rise_m, fall_m = _NORTH_M - _CORNER_M, -_SOUTH_M - _CORNER_M
    north = [
        Segment(rise_m - _REACH_M),
        right,
        Segment(top_m),
        right,
        Segment(rise_m - east.y - _REACH_M),
    ]
    south = [
        Segment(fall_m - _REACH_M),
        left,
        Segment(top_m),
        left,
        Segment(fall_m + east.y - _REACH_M),
    ]
    ends = (_WEST, _EAST)
    return [
        chain("Ring north", range(1, 6), Pose2D(0, _REACH_M, math.pi / 2), north, AVENUE, ends),
        chain("Mill Street", range(11, 14), street_start, _STREET, STREET, ends),
        chain("Ring south", range(21, 26), Pose2D(0, -_REACH_M, -math.pi / 2), south, AVENUE, ends),
    ]


def _complete_header(root: ElementTree.Element, chains: list[RoadChain]) -> None:
    """Replace the time of day with a constant, and add the town's extent."""
    header = root[0]
    east = chains[0].last.pose.x
    curb_m = AVENUE.half_width_m
    extent = {
        "north": _NORTH_M + curb_m,
        "south": _SOUTH_M - curb_m,
        "east": east + curb_m,
        "west": -curb_m,
    }
    header.attrib.update({key: str(value) for key, value in extent.items()})
    header.attrib.update({"version": "1", "date": "2024-01-01T00:00:00", "vendor": "StuckSolver"})


def _add_roadside(root: ElementTree.Element, junctions: list[SignalisedJunction]) -> None:
    """Add crosswalks, lights and references to them to the roads that they belong to."""
    roads = {road.get("id"): road for road in root.findall("road")}
    for road_id, group, element in (item for junction in junctions for item in junction.roadside()):
        road = roads[str(road_id)]
        parent = road.find(group)
        (ElementTree.SubElement(road, group) if parent is None else parent).append(element)


def _add_controllers(root: ElementTree.Element, junctions: list[SignalisedJunction]) -> None:
    """Add one phase for each arm. The controllers are between the roads and the junctions."""
    place = len(root.findall("road")) + 1
    for junction, element in zip(junctions, root.findall("junction"), strict=True):
        for controller, entry in junction.controllers():
            root.insert(place, controller)
            place += 1
            element.append(entry)


def _rounded(text: str) -> str:
    if not re.fullmatch(r"-?\d+(\.\d+)?(e[+-]?\d+)?", text) or text.lstrip("-").isdigit():
        return text
    value = round(float(text), _DECIMALS)
    return repr(value + 0.0)
