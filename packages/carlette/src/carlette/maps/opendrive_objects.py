"""Traffic lights, their controllers and crosswalks, as OpenDRIVE elements.

They are written as in CARLA's own towns: the light's post is next to the arm and is valid for no lane there. Each
connecting road refers to it at its start, which is where CARLA makes cars stop. (The library can write neither
controllers nor several references to one light, so these elements are made here.) The lengths are ours.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from xml.etree.ElementTree import Element, SubElement

from carlette.maps.road_chains import RoadEnd

LIGHT_TYPE = "1000001"
_POST_BEFORE_END_M = 1.5
"""Distance of a light's post before the end of its arm (m)."""
_POST_BEHIND_CURB_M = 0.5
"""Distance of a post behind the curb (m)."""
_CROSSWALK_M = (2.0, 5.0)
"""Distances of a crosswalk's edges from the end of the arm (m)."""
_BEYOND_CURB_M = 1.0
"""Overlap of a crosswalk beyond the curb (m)."""


def light(arm: RoadEnd, light_id: int) -> Element:
    """Return the post at the right curb of an arm. `orientation` is the direction of its face, as in CARLA's towns."""
    side = -1 if arm.at_end else 1
    post = {
        "name": "Signal_3Light_Post01",
        "id": light_id,
        "s": _station(arm, _POST_BEFORE_END_M),
        "t": side * (arm.profile.half_width_m + _POST_BEHIND_CURB_M),
        "zOffset": 0.0,
        "hOffset": 0.0 if arm.at_end else math.pi,
        "roll": 0.0,
        "pitch": 0.0,
        "orientation": "-" if arm.at_end else "+",
        "dynamic": "yes",
        "country": "OpenDRIVE",
        "type": LIGHT_TYPE,
        "subtype": "-1",
        "value": -1.0,
        "text": "",
        "height": 1.16,
        "width": 0.525,
    }
    element = _element("signal", post)
    element.append(_element("validity", {"fromLane": 0, "toLane": 0}))
    return element


def light_reference(light_id: int) -> Element:
    """Return the reference that makes lane -1 of a connecting road obey a light at the road's start."""
    element = _element("signalReference", {"id": light_id, "s": 0.0, "t": 0.0, "orientation": "-"})
    element.append(_element("validity", {"fromLane": -1, "toLane": -1}))
    return element


def controller(number: int, sequence: int, light_id: int) -> Element:
    """Return the controller of one light, for the top level of the document."""
    element = _element("controller", {"name": f"ctrl{number}", "id": number, "sequence": sequence})
    element.append(_element("control", {"signalId": light_id, "type": ""}))
    return element


def controller_entry(number: int, sequence: int) -> Element:
    """Return a junction's entry for a controller: its position in the cycle."""
    return _element("controller", {"id": number, "type": 0, "sequence": sequence})


def crosswalk(arm: RoadEnd, number: int) -> Element:
    """Return a crosswalk from curb to curb, just inside the junction. Cars that stop at its edge are not on it."""
    ahead = 1 if arm.at_end else -1
    near_m, far_m = (ahead * distance for distance in _CROSSWALK_M)
    half_m = arm.profile.half_width_m + _BEYOND_CURB_M
    place = {
        "id": number,
        "name": "ContinentalCrosswalk",
        "type": "crosswalk",
        "s": _station(arm, 0.0),
        "t": 0.0,
        "zOffset": 0.0,
        "hdg": 0.0,
        "roll": 0.0,
        "pitch": 0.0,
        "orientation": "+",
        "width": abs(far_m - near_m),
        "length": 2 * half_m,
    }
    element = _element("object", place)
    outline = SubElement(element, "outline")
    for u, v in ((near_m, -half_m), (far_m, -half_m), (far_m, half_m), (near_m, half_m), (near_m, -half_m)):
        outline.append(_element("cornerLocal", {"u": u, "v": v, "z": 0.0}))
    return element


def _station(arm: RoadEnd, before_end_m: float) -> float:
    """Return the road's s at this distance before the junction."""
    length_m: float = arm.road.planview.get_total_length()
    return length_m - before_end_m if arm.at_end else before_end_m


def _element(tag: str, attributes: Mapping[str, object]) -> Element:
    return Element(tag, {key: str(value) for key, value in attributes.items()})
