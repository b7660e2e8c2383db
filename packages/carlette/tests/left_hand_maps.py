"""The mirror image of a generated map: the same streets with left-hand traffic."""

from __future__ import annotations

from xml.etree import ElementTree

NEGATED = {
    "geometry": ("y", "hdg"),
    "arc": ("curvature",),
    "signal": ("t", "hOffset"),
    "signalReference": ("t",),
    "object": ("t", "hdg"),
    "cornerLocal": ("v",),
    "lane": ("id",),
    "laneLink": ("from", "to"),
    "validity": ("fromLane", "toLane"),
}
"""Attributes that change sign. Generated maps have lines and arcs only, and no lateral profile."""


def left_hand(opendrive: str) -> str:
    """Return a map mirrored at the x axis, with the rule of left-hand traffic."""
    root = ElementTree.fromstring(opendrive)
    for road in root.iter("road"):
        road.set("rule", "LHT")
    for element in root.iter():
        for name in NEGATED.get(element.tag, ()):
            element.set(name, _negated(element.get(name, "0")))
    for lane in root.iter("lane"):
        for link in (*lane.iterfind("link/predecessor"), *lane.iterfind("link/successor")):
            link.set("id", _negated(link.get("id", "0")))
    for section in root.iter("laneSection"):
        _swap_sides(section)
    return ElementTree.tostring(root, encoding="unicode")


def _swap_sides(section: ElementTree.Element) -> None:
    """Put the lanes that were left of the reference line to its right, and the other way round."""
    found = {name: section.find(name) for name in ("left", "right")}
    center = section.find("center")
    for side in filter(lambda item: item is not None, found.values()):
        section.remove(side)
    for name, other in (("left", "right"), ("right", "left")):
        side = found[other]
        if side is None:
            continue
        side.tag = name
        side[:] = sorted(side, key=lambda lane: -int(lane.get("id", "0")))
        section.insert(list(section).index(center) + (name == "right"), side)


def _negated(number: str) -> str:
    return number.removeprefix("-") if number.startswith("-") or float(number) == 0.0 else f"-{number}"
