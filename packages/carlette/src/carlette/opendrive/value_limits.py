"""Bounds on the numbers of a map, checked before the client's library gets them.

That library accepts NaN as a coordinate, walks along a road of 10^15 m for hours, and visits every lane in a sign's
range. So each number must be a number, and within its bounds. The bounds are ours.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from xml.etree import ElementTree

from carlette.errors import MapError

FARTHEST_M = 4e7
"""Bound on the positions of reference lines (m): all projected coordinates on Earth are within it."""
LARGEST_M = 1e6
"""Bound on other lengths (m)."""
LONGEST_ROAD_M = 1e5
"""Longest road (m)."""
LONGEST_OF_ALL_M = 5e6
"""Total length of all roads (m). The server samples them every few meters."""
WIDEST_M = 100.0
"""Width of a lane at the start of each of its stretches (m)."""
MOST_LANE = 1000
"""Largest lane number."""
SHARPEST_PER_M = 100.0
"""Curvature (1/m). Connecting roads may turn almost on the spot, but no tighter."""

_POSITIONS = dict.fromkeys(("x", "y"), FARTHEST_M)
_LENGTHS = dict.fromkeys(("z", "s", "t", "u", "v", "sOffset", "zOffset", "length"), LARGEST_M)
_ANGLES = dict.fromkeys(("hdg", "pitch", "roll", "hOffset"), 1e4)
_CURVES = dict.fromkeys(("curvature", "curvStart", "curvEnd"), SHARPEST_PER_M)
_POLYNOMIALS = dict.fromkeys(("aU", "bU", "cU", "dU", "aV", "bV", "cV", "dV", "a", "b", "c", "d"), LARGEST_M)
_BOUNDS = _POSITIONS | _LENGTHS | _ANGLES | _CURVES | _POLYNOMIALS
"""Largest magnitude of each attribute, in any element."""
_OF_ELEMENTS = {
    ("road", "length"): LONGEST_ROAD_M,
    ("geometry", "length"): LONGEST_ROAD_M,
    ("width", "a"): WIDEST_M,
    ("lane", "id"): MOST_LANE,
    ("validity", "fromLane"): MOST_LANE,
    ("validity", "toLane"): MOST_LANE,
}
"""Tighter bounds, and those of attributes that are numbers only in these elements."""
_LOOSE = dict.fromkeys(("width", "height", "radius", "value", "max"), LARGEST_M)
"""Attributes that may be words, such as `undefined`. As numbers they have bounds, too."""
_UNREAD = frozenset(("header", "userData", "dataQuality", "include"))
"""Elements whose numbers neither the library nor the server uses, such as the header's offset."""


def check_bounds(root: ElementTree.Element, source: str) -> None:
    """Raise `MapError`, naming element and attribute, for a value that is not a number or is out of bounds."""
    for element in _read_elements(root):
        for name, text in element.attrib.items():
            most = _OF_ELEMENTS.get((element.tag, name)) or _BOUNDS.get(name)
            if most is not None or name in _LOOSE:
                _check(element.tag, name, text, most or _LOOSE[name], name in _LOOSE, source)
    total_m = 0.0
    for road in root.iterfind("road"):
        if road.find("planView/geometry") is None:
            raise MapError(f"map '{source}': road {road.get('id', '')[:40]} has no <geometry>; give each road its line")
        total_m += float(road.get("length") or 0.0)
    if total_m > LONGEST_OF_ALL_M:
        raise MapError(
            f"map '{source}' has {total_m / 1e3:,.0f} km of roads; at most {LONGEST_OF_ALL_M / 1e3:,.0f} are served"
        )


def _read_elements(root: ElementTree.Element) -> Iterator[ElementTree.Element]:
    stack = [root]
    while stack:
        element = stack.pop()
        yield element
        # A name with a prefix is none of OpenDRIVE's.
        stack += [child for child in reversed(element) if child.tag not in _UNREAD and ":" not in child.tag]


def _check(tag: str, name: str, text: str, most: float, may_be_word: bool, source: str) -> None:
    if not text:
        return
    try:
        value = float(text)
    except ValueError:
        # The comparison below rejects NaN, and so text that is not a number.
        if may_be_word:
            return
        value = math.nan
    # NaN compares false with every number, so this form rejects it.
    if not abs(value) <= most:
        raise MapError(
            f"map '{source}': <{tag}> has {name}=\"{text[:40]}\"; give a number of at most {most:g} either way"
        )
