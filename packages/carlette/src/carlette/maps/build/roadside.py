"""Traffic lights, signs, markings and buildings at the roadside, as OpenDRIVE elements.

They are written as in CARLA's own towns. A light's post is next to its arm and is valid for no lane there. Each
connecting road refers to it at its start, which is where CARLA makes cars stop. Signs are at the end of their arm and
are valid for the incoming lanes. `orientation` is the direction of the face of a post. The lengths are ours.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import count
from xml.etree.ElementTree import Element, SubElement

from carlette.maps.build.junctions import Junction
from carlette.maps.build.plan import RoadsidePlot, StreetCrossing
from carlette.maps.build.streets import StreetEnd, StreetRoad, number

LIGHT, STOP, YIELD, LIMIT, PEDESTRIANS, RAILS = "1000001", "206", "205", "274", "133", "201"
_NAMES = {
    LIGHT: "Signal_3Light_Post01",
    STOP: "Sign_Stop",
    YIELD: "Sign_Yield",
    LIMIT: "Speed_Limit",
    PEDESTRIANS: "Sign_Pedestrians",
    RAILS: "Sign_LevelCrossing",
}
_POST_BEFORE_END_M = 1.5
"""Distance of a light's post before the end of its arm (m)."""
_BEHIND_CURB_M = 0.5
"""Distance of a post behind the curb (m)."""
_LIMIT_AFTER_M = 8.0
"""Distance of a speed sign after the start of a street (m)."""
_CROSSWALK_M = (2.0, 5.0)
"""Distances of a crosswalk's edges from the end of the arm (m)."""
_BEYOND_CURB_M = 1.0
"""Overlap of a crosswalk beyond the curb (m)."""
_STOP_LINE_M = 0.4
"""Width of a stop line (m)."""

Roadside = Iterator[tuple[int, str, Element]]
"""(road id, `objects` or `signals`, element)"""


def junction_roadside(
    junction: Junction, ids: count[int], controller_ids: count[int]
) -> tuple[list[Element], Roadside]:
    """Return the controllers of a junction's lights, and all objects at the junction."""
    lights = {arm: next(ids) for arm in junction.arms if arm.end.control == "light"}
    controllers = []
    for sequence, group in enumerate(_phases(junction)):
        controller = Element("controller", name=junction.node.name, id=str(next(controller_ids)))
        controller.set("sequence", str(sequence))
        for arm in group:
            SubElement(controller, "control", signalId=str(lights[arm]), type="")
        controllers.append(controller)
        entry = {"id": str(controller.get("id")), "type": "0", "sequence": str(sequence)}
        SubElement(junction.element, "controller", entry)
    return controllers, _at_arms(junction, lights, ids)


def street_roadside(road: StreetRoad, ids: count[int]) -> Roadside:
    """Return speed limits at both ends, crossings and buildings of a street."""
    for arm, lanes in ((road.first, road.first.outgoing), (road.last, road.last.outgoing)):
        driving = [position for position, lane in enumerate(lanes, 1) if lane.kind == "driving"]
        if driving:
            ends = arm.outgoing_id(driving[0]), arm.outgoing_id(driving[-1])
            place = _curb_position(arm, _LIMIT_AFTER_M, leaving=True)
            yield arm.road_id, "signals", _signal(LIMIT, next(ids), place, ends, road.street.section.limit_kmh)
    for crossing in road.street.crossings:
        yield from _crossing(road, crossing, ids)
    for block in road.street.blocks:
        yield road.first.road_id, "objects", _building(block, next(ids))


def _at_arms(junction: Junction, lights: Mapping[StreetEnd, int], ids: count[int]) -> Roadside:
    for arm in junction.arms:
        driving = [position for position, lane in enumerate(arm.incoming, 1) if lane.kind == "driving"]
        if junction.node.crosswalks and _has_sidewalk(arm):
            yield arm.road_id, "objects", _crosswalk_at(arm, next(ids))
        if not driving or arm.end.control == "none":
            continue
        ends = arm.incoming_id(driving[0]), arm.incoming_id(driving[-1])
        place = _curb_position(arm, _POST_BEFORE_END_M)
        if arm.end.control == "light":
            yield arm.road_id, "signals", _signal(LIGHT, lights[arm], place, (0, 0), -1.0, dynamic=True)
        else:
            kind = STOP if arm.end.control == "stop" else YIELD
            yield arm.road_id, "signals", _signal(kind, next(ids), place, ends)
        yield arm.road_id, "objects", _stop_line(arm, len(driving), next(ids))
    for road, arm in junction.roads:
        lane = road.find("lanes/laneSection/right/lane")
        if arm in lights and lane is not None and lane.get("type") == "driving":
            yield int(road.get("id", "")), "signals", _reference(lights[arm])


def _phases(junction: Junction) -> list[list[StreetEnd]]:
    """Return the groups of arms whose lights are green together."""
    groups: list[list[StreetEnd]] = []
    for arm in junction.arms:
        if arm.end.control != "light":
            continue
        for group in groups:
            if abs(math.remainder(arm.pose.yaw_rad - group[0].pose.yaw_rad, 2 * math.pi)) > math.radians(150):
                group.append(arm)
                break
        else:
            groups.append([arm])
    return groups


def _curb_position(arm: StreetEnd, before_end_m: float, leaving: bool = False) -> dict[str, str]:
    """Return the attributes of a position at the right curb, facing traffic that approaches or leaves the node."""
    forward = arm.at_end is not leaving
    lanes = arm.outgoing if leaving else arm.incoming
    t = sum(lane.width_m for lane in lanes if lane.kind != "sidewalk") + _BEHIND_CURB_M
    return {
        "s": number(arm.station(before_end_m)),
        "t": number(-t if forward else t),
        "hOffset": number(0.0 if forward else math.pi),
        "orientation": "-" if forward else "+",
    }


def _signal(
    kind: str,
    signal_id: int,
    place: Mapping[str, str],
    lanes: tuple[int, int],
    value: float = -1.0,
    dynamic: bool = False,
) -> Element:
    element = Element("signal", {"name": _NAMES[kind], "id": str(signal_id), **place})
    element.attrib.update(zOffset="0.0", roll="0.0", pitch="0.0", dynamic="yes" if dynamic else "no")
    element.attrib.update(country="OpenDRIVE", type=kind, subtype="-1", value=number(value), text="")
    if kind == LIMIT:
        # The German catalog numbers speed signs 274-30 and so on. CARLA creates signs only for these subtypes.
        element.attrib.update(subtype=f"{value:g}", unit="km/h")
    element.attrib.update(height="1.16" if dynamic else "2.5", width="0.525" if dynamic else "0.8")
    SubElement(element, "validity", fromLane=str(min(lanes)), toLane=str(max(lanes)))
    return element


def _reference(light_id: int) -> Element:
    """Return the reference that makes lane -1 of a connecting road obey a light at the road's start."""
    element = Element("signalReference", id=str(light_id), s="0.0", t="0.0", orientation="-")
    SubElement(element, "validity", fromLane="-1", toLane="-1")
    return element


def _crosswalk_at(arm: StreetEnd, object_id: int) -> Element:
    """Return a crosswalk from curb to curb, just inside the junction.

    Cars that stop at the junction's edge are not on it.
    """
    ahead = 1 if arm.at_end else -1
    near_m, far_m = (ahead * distance for distance in _CROSSWALK_M)
    return _crosswalk(arm, arm.station(0.0), (near_m, far_m), object_id)


def _crosswalk(arm: StreetEnd, s: float, along_m: tuple[float, float], object_id: int) -> Element:
    section = arm.street.section
    right = sum(lane.width_m for lane in section.right if lane.kind != "sidewalk") + _BEYOND_CURB_M
    left = sum(lane.width_m for lane in section.left if lane.kind != "sidewalk") + _BEYOND_CURB_M
    element = _object("ContinentalCrosswalk", "crosswalk", object_id, s, 0.0)
    element.attrib.update(width=number(abs(along_m[1] - along_m[0])), length=number(left + right))
    outline = SubElement(element, "outline")
    near, far = along_m
    for u, v in ((near, -right), (far, -right), (far, left), (near, left), (near, -right)):
        SubElement(outline, "cornerLocal", u=number(u), v=number(v), z="0.0")
    return element


def _stop_line(arm: StreetEnd, lanes: int, object_id: int) -> Element:
    """Paint across the lanes that come in, at their end."""
    side = -1 if arm.at_end else 1
    width_m = sum(lane.width_m for lane in arm.incoming[:lanes])
    element = _object("StopLine", "roadMark", object_id, arm.station(_STOP_LINE_M / 2), side * width_m / 2)
    element.attrib.update(length=number(_STOP_LINE_M), width=number(width_m))
    return element


def _crossing(road: StreetRoad, crossing: StreetCrossing, ids: count[int]) -> Roadside:
    """Yield a crosswalk or rails in mid-street, with a sign before them in each direction."""
    arm, rails = road.first, crossing.kind == "rails"
    if rails:
        element = _object("LevelCrossing", "railroad", next(ids), crossing.at_m, 0.0)
        element.attrib.update(length="3.0", width=number(2 * road.street.section.half_width_m()))
        yield arm.road_id, "objects", element
    else:
        yield arm.road_id, "objects", _crosswalk(arm, crossing.at_m, (-1.5, 1.5), next(ids))
    for item, lanes in ((road.last, road.last.incoming), (road.first, road.first.incoming)):
        driving = [position for position, lane in enumerate(lanes, 1) if lane.kind == "driving"]
        if driving:
            ahead_m = road.length_m - crossing.at_m if item.at_end else crossing.at_m
            place = _curb_position(item, ahead_m + 6.0)
            ends = item.incoming_id(driving[0]), item.incoming_id(driving[-1])
            yield arm.road_id, "signals", _signal(RAILS if rails else PEDESTRIANS, next(ids), place, ends)


def _building(block: RoadsidePlot, object_id: int) -> Element:
    element = _object(block.name, "building", object_id, block.at_m, block.t_m)
    element.attrib.update(length=number(block.length_m), width=number(block.width_m), height=number(block.height_m))
    return element


def _object(name: str, kind: str, object_id: int, s: float, t: float) -> Element:
    element = Element("object", id=str(object_id), name=name, type=kind, s=number(s), t=number(t))
    element.attrib.update(zOffset="0.0", hdg="0.0", roll="0.0", pitch="0.0", orientation="none")
    return element


def _has_sidewalk(arm: StreetEnd) -> bool:
    return any(lane.kind == "sidewalk" for lane in (*arm.incoming, *arm.outgoing))
