"""Names what is wrong with a map that the client's library fails on, because the library itself only crashes.

The library decides whether a map can be used, in a trial (`carlette.world.map_trial`). This module explains.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator
from itertools import pairwise
from xml.etree import ElementTree

import numpy as np

from carlette.opendrive.document import id_as_read, number_as_read

COARSE_M = 1e6
"""Coordinates above which clients receive positions in steps of more than 6 cm (m)."""
_LONGEST_ID = 40
"""Maximum number of characters of an id in a message. Ours."""
_FIRST_AT_ZERO = ("planView/geometry", "lanes/laneOffset", "elevationProfile/elevation")
"""Elements that the library requires at the start of a road, if there are any."""
_ORIGIN = re.compile(r"\+(lat_0|lon_0)=(\S*)")
_NUMERIC = re.compile(r"[-+]?\.?[0-9]")
_SHAPES = ("line", "arc", "spiral", "poly3", "paramPoly3")


def find_faults(root: ElementTree.Element) -> list[str]:
    """Return the faults of a document, each with its road or junction and the remedy.

    Faults on which the library fails come first. It tolerates the others, with roads that end or overlap.
    """
    roads = {id_as_read(road.get("id")): road for road in root.iterfind("road")}
    found = [*_georeference(root), *(fault for road in roads.values() for fault in _road_faults(road))]
    found += _lane_links(roads)
    found += _junctions(root, roads)
    found += _signals(root)
    found += _tolerated(root, roads)
    return list(dict.fromkeys(found))


def explain(root: ElementTree.Element) -> str:
    """Return the first fault of a document, and how many more there are."""
    return _first(find_faults(root)) or "check its roads, lanes and links"


def warning_of(root: ElementTree.Element) -> str:
    """Return what is doubtful in a document that the library accepts, in one line; empty if nothing is."""
    return _first([*find_faults(root), *_coarse(root)])


def _first(faults: list[str]) -> str:
    return (faults or [""])[0] + (f" (and {len(faults) - 1} more)" if len(faults) > 1 else "")


def _coarse(root: ElementTree.Element) -> Iterator[str]:
    places = [float(item.get(key) or 0.0) for item in root.iterfind("road/planView/geometry") for key in ("x", "y")]
    farthest = max(map(abs, places), default=0.0)
    if farthest > COARSE_M:
        step = float(np.spacing(np.float32(farthest)))
        yield (
            f"its coordinates reach {farthest:.3g} m, where clients receive positions in steps of {step:g} m "
            "(float32); subtract an offset from them"
        )


def _georeference(root: ElementTree.Element) -> Iterator[str]:
    for name, text in _ORIGIN.findall(root.findtext("header/geoReference", "")):
        if not _NUMERIC.match(text):
            yield f"its geoReference has +{name}={text[:_LONGEST_ID]}; give a number"


def _road_faults(road: ElementTree.Element) -> Iterator[str]:
    name = _name(road)
    if not float(road.get("length") or 0.0) > 0.0:
        yield f'{name} has length="{road.get("length", "")}"; give it a length above 0'
    for path in _FIRST_AT_ZERO:
        first = road.find(path)
        key = path.rpartition("/")[2]
        if first is not None and float(first.get("s") or 0.0) > 0.0:
            yield f"{name}: the first <{key}> is at s={first.get('s')}; add one at s=0"
    for geometry in road.iterfind("planView/geometry"):
        if not len(geometry) or geometry[0].tag not in _SHAPES:
            yield f"{name}: a <geometry> has no shape; give it a <line/> or another one"
        elif geometry[0].tag == "arc" and not float(geometry[0].get("curvature") or 0.0):
            yield f"{name}: an <arc> has the curvature 0, where the carla library computes no position; write <line/>"
    for section in road.iterfind("lanes/laneSection"):
        yield from _section_faults(name, section)


def _section_faults(name: str, section: ElementTree.Element) -> Iterator[str]:
    sides = {side: section.findall(f"{side}/lane") for side in ("left", "center", "right")}
    if not sides["center"] and any(sides.values()):
        yield f"{name}: a <laneSection> has no center lane; add lane 0"
    for side, sign in (("left", 1), ("right", -1)):
        numbers = sorted(abs(number_as_read(lane.get("id"))) for lane in sides[side])
        gap = next((a + 1 for a, b in pairwise([0, *numbers]) if b - a > 1), None)
        if gap is not None:
            yield f"{name} has lane {sign * numbers[-1]} but no lane {sign * gap}; number its lanes without gaps"
    for lane in (*sides["left"], *sides["right"]):
        widths = lane.findall("width")
        if widths and float(widths[0].get("sOffset") or 0.0) > 0.0:
            at = widths[0].get("sOffset")
            yield f"{name}, lane {lane.get('id')}: the first <width> is at sOffset={at}; add one at sOffset=0"


def _lane_links(roads: dict[int, ElementTree.Element]) -> Iterator[str]:
    """Yield links of lanes to lanes that the next section or road does not have."""
    for road in roads.values():
        sections = road.findall("lanes/laneSection")
        for number, section in enumerate(sections):
            for way, step in (("predecessor", -1), ("successor", 1)):
                inside = 0 <= number + step < len(sections)
                other = sections[number + step] if inside else _next_section(road, way, roads)
                if other is not None:
                    where = _name(road) if inside else f"{_name(road)} to road {_linked(road, way)}"
                    yield from _dangling(where, section, way, other)


def _dangling(where: str, section: ElementTree.Element, way: str, other: ElementTree.Element) -> Iterator[str]:
    known = {lane.get("id") for lane in other.iterfind("*/lane")}
    for lane in section.iterfind("*/lane"):
        link = lane.find(f"link/{way}")
        if link is not None and link.get("id") not in known:
            linked = link.get("id", "")[:_LONGEST_ID]
            yield f"{where}: lane {lane.get('id')} has the {way} {linked}, which does not exist; correct the link"


def _next_section(
    road: ElementTree.Element, way: str, roads: dict[int, ElementTree.Element]
) -> ElementTree.Element | None:
    link = road.find(f"link/{way}")
    if link is None or link.get("elementType", "road") != "road":
        return None
    other = roads.get(id_as_read(link.get("elementId")))
    sections = [] if other is None else other.findall("lanes/laneSection")
    return sections[-1 if link.get("contactPoint") == "end" else 0] if sections else None


def _linked(road: ElementTree.Element, way: str) -> str:
    link = road.find(f"link/{way}")
    return "" if link is None else link.get("elementId", "")[:_LONGEST_ID]


def _junctions(root: ElementTree.Element, roads: dict[int, ElementTree.Element]) -> Iterator[str]:
    known = {junction.get("id", "") for junction in root.iterfind("junction")}
    numbers = {id_as_read(item) for item in known}
    for junction in root.iterfind("junction"):
        name = f"junction {junction.get('id', '')[:_LONGEST_ID]}"
        for connection in junction.iterfind("connection"):
            if connection.get("connectingRoad") is None and connection.get("linkedRoad") is not None:
                yield f"{name} links roads directly, which the carla library cannot load; give it connecting roads"
            elif id_as_read(connection.get("connectingRoad")) not in roads:
                missing = connection.get("connectingRoad", "")[:_LONGEST_ID]
                yield f"{name} connects by road {missing}, which does not exist; add that road or remove the connection"
    for road in roads.values():
        of = road.get("junction", "").strip()
        if not of and 0 not in numbers:
            yield f'{_name(road)} has no junction attribute; write junction="-1" on roads outside of junctions'
        elif of != "-1" and id_as_read(of) not in numbers:
            yield f"{_name(road)} belongs to junction {of[:_LONGEST_ID]}, which does not exist; add that junction"


def _signals(root: ElementTree.Element) -> Iterator[str]:
    known = {signal.get("id", "") for signal in root.iterfind("road/signals/signal")}
    for road in root.iterfind("road"):
        for reference in road.iterfind("signals/signalReference"):
            if reference.get("id", "") not in known:
                name = reference.get("id", "")[:_LONGEST_ID]
                yield f"{_name(road)} refers to signal {name}, which does not exist; add that signal"


def _tolerated(root: ElementTree.Element, roads: dict[int, ElementTree.Element]) -> Iterator[str]:
    yield from _same_ids(root.iterfind("road"))
    numbers = {id_as_read(junction.get("id")) for junction in root.iterfind("junction")}
    for road in roads.values():
        for way in ("predecessor", "successor"):
            link = road.find(f"link/{way}")
            if link is None:
                continue
            kind = link.get("elementType", "road")
            if id_as_read(link.get("elementId")) not in (numbers if kind == "junction" else roads):
                yield f"{_name(road)} has the {way} {kind} {_linked(road, way)}, which does not exist; correct the link"
        for lane in road.iterfind("lanes/laneSection/*/lane"):
            if lane.get("type") == "driving" and lane.find("width") is None and number_as_read(lane.get("id")):
                instead = "; the carla library reads no <border>" if lane.find("border") is not None else ""
                yield f"{_name(road)}, lane {lane.get('id')} has no <width>{instead}; give it one"


def _same_ids(roads: Iterable[ElementTree.Element]) -> Iterator[str]:
    names = [road.get("id", "")[:_LONGEST_ID] for road in roads]
    for number, count in Counter(map(id_as_read, names)).items():
        if count > 1:
            alike = ", ".join([f"'{name}'" for name in names if id_as_read(name) == number][:3])
            yield f"the carla library reads the ids {alike} of {count} roads as {number}; give each its own number"


def _name(road: ElementTree.Element) -> str:
    return f"road {road.get('id', '')[:_LONGEST_ID]}"
