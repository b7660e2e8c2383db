"""Speed limits of roads and lanes."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from xml.etree import ElementTree

DEFAULT_KMH = 30.0
"""CARLA's own default where a map says nothing."""

_KMH = {"mph": 1.609344, "km/h": 1.0, "kmh": 1.0, "m/s": 3.6}


@dataclass(frozen=True)
class SpeedLimits:
    """Limits along each road, with those of single lanes on top."""

    roads: dict[int, list[tuple[float, float]]]
    """Road id to (s, km/h), by s."""
    lanes: dict[tuple[int, int], list[tuple[float, float]]]
    """(road id, lane id) to (s, km/h), by s."""

    def at(self, road: int, lane: int, s: float) -> float:
        """The limit in km/h; always above zero."""
        for steps in (self.lanes.get((road, lane)), self.roads.get(road)):
            limit = _step(steps, s) if steps else None
            if limit is not None:
                return limit
        return DEFAULT_KMH


def read_speed_limits(root: ElementTree.Element) -> SpeedLimits:
    """All limits of a map; a connecting road without one inherits that of the road before it."""
    roads: dict[int, list[tuple[float, float]]] = {}
    lanes: dict[tuple[int, int], list[tuple[float, float]]] = {}
    before: dict[int, int] = {}
    for road in root.iter("road"):
        road_id = int(road.get("id", "0"))
        steps = [(float(one.get("s", "0")), kmh(one.find("speed"))) for one in road.findall("type")]
        roads[road_id] = sorted((s, limit) for s, limit in steps if limit is not None)
        predecessor = road.find("link/predecessor[@elementType='road']")
        if predecessor is not None:
            before[road_id] = int(predecessor.get("elementId", "-1"))
        for section in road.iter("laneSection"):
            _read_lanes(road_id, section, lanes)
    for road_id, steps_here in list(roads.items()):
        inherited = roads.get(before.get(road_id, -1))
        if not steps_here and inherited:
            roads[road_id] = [(0.0, inherited[-1][1])]
    return SpeedLimits(roads, lanes)


def _read_lanes(
    road_id: int, section: ElementTree.Element, lanes: dict[tuple[int, int], list[tuple[float, float]]]
) -> None:
    start = float(section.get("s", "0"))
    for lane in section.iter("lane"):
        for speed in lane.findall("speed"):
            limit = kmh(speed)
            if limit is not None:
                steps = lanes.setdefault((road_id, int(lane.get("id", "0"))), [])
                steps.append((start + float(speed.get("sOffset", "0")), limit))


def kmh(speed: ElementTree.Element | None) -> float | None:
    """The limit of a `<speed>` element in km/h; None where it states none ("no limit", "undefined", 0)."""
    if speed is None:
        return None
    try:
        limit = float(speed.get("max", "")) * _KMH.get(speed.get("unit", "m/s"), 3.6)
    except ValueError:
        return None
    return limit if limit > 0 else None


def _step(steps: list[tuple[float, float]], s: float) -> float | None:
    index = bisect_right(steps, (s, float("inf"))) - 1
    return steps[max(index, 0)][1]
