"""Traffic lights and stop signs of a map, with the lanes that they govern."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Collection
from dataclasses import dataclass
from typing import Any
from xml.etree import ElementTree

from carlette.geometry import Box, Pose, Rotation, Vector, wrap_degrees
from carlette.opendrive.document import id_as_read
from carlette.opendrive.road_network import RoadNetwork

_TRIGGERS: dict[str, tuple[tuple[float, float, float], ...]] = {
    "Town04": (
        (189.93, -169.58, 0.3),
        (198.84, -180.40, 91.3),
        (201.95, -163.35, 271.3),
        (212.05, -172.95, 180.3),
        (245.63, -246.14, 359.6),
        (255.20, -258.51, 90.2),
        (258.63, -237.08, 270.2),
        (267.72, -249.80, 179.6),
    ),
}
"""Centers of trigger volumes on their lanes by town (m, CARLA's frame), and the lanes' yaw (degrees).

They are the `stop_sign_centers_np` of fail2drive (MIT), in its `toolbox/carla_map_data`. Town10HD's three are in
its file.
"""


def unlisted_stops(town: str, listed: int) -> tuple[tuple[float, float, float], ...]:
    """Return x, y (m) and yaw (degrees) of the stop signs of `town` in addition to the `listed` ones of its file.

    Empty if the file contains stop signs itself: then it is another version of the town.
    """
    return () if listed else _TRIGGERS.get(town.removesuffix("_Opt"), ())


_SPAWNED = {
    "Town01": """375 377 376 390 392 391 384 385 386 367 368 366 374 372 373 395 394 393 383 381 361 362 382 389 387
        388 379 378 380 364 363 365 371 370 369 360""",
    "Town02": "464 463 462 472 471 473 465 466 467 470 469 468 458 457 456 477 478 459 460 461 476 475 474 479",
    "Town04": """1623 1622 1625 1617 1616 1614 1645 1646 1643 1632 1633 1631 1630 1635 1628 1634 1636 1610 1627 1609
        1626 1608 1607 1644 1638 1637 1639 1642 1640 1641 1612 1629 1613 1611 1620 1619 1618 1615 1621 1624 1649 1648
        1647""",
    "Town10HD": "960 959 943 944 958 957 950 952 951 961 945 962 953 954 949",
}


def spawn_order(town: str, lights: Collection[str]) -> dict[str, int]:
    """Return each signal id's position in the order in which CARLA spawns the town's lights.

    Empty if the town is not one of CARLA's, or if `lights` (those of the file's controllers) lacks one of them: then
    the file is another map of the same name.
    """
    spawned = _SPAWNED.get(town.removesuffix("_Opt"), "").split()
    return {item: place for place, item in enumerate(spawned)} if set(spawned) <= set(lights) else {}


LIGHT_TYPE, STOP_TYPE = "1000001", "206"
ACTOR_TYPES = {LIGHT_TYPE: "traffic.traffic_light", STOP_TYPE: "traffic.stop", "205": "traffic.yield"}
"""Actor type by OpenDRIVE type of signal. CARLA's maps use the German numbers."""
BOX_HALF_DEPTH_M = 2.0
"""Half length of a trigger box along its lanes (m). Ours."""
BOX_HALF_HEIGHT_M = 2.0
"""Half height of a trigger box (m). Ours."""
ROAD_END_M = 0.01
"""Distance before the end of a road at which a signal at the very end is looked up (m). Ours.

The end itself has no waypoint.
"""
BEYOND_EDGE_M = 0.7
"""Distance of an unlisted sign's post beyond its lane's edge (m). Ours."""
BACK_FROM_JUNCTION_M = 2.5
"""Distance of the center of a trigger box before the junction (m). Ours."""


@dataclass(frozen=True)
class SignalPhase:
    """Position of a light in a cycle."""

    group: str
    """The junction of its cycle, or the light itself if no controller contains it."""
    phase: int = 0
    """Its position in the cycle. Lights of one phase are green together."""
    alone: bool = False
    """True if no controller contains the light. Then it changes independently, and stays red longer."""


@dataclass(frozen=True)
class Signal:
    """One traffic light or stop sign.

    The actor's x axis runs across the governed lanes, and the box's x extent covers exactly those lanes:
    clients sample stop waypoints along it.
    """

    id: str
    type: str
    pose: Pose
    box: Box
    """Trigger volume in the frame of `pose`."""
    turn: SignalPhase
    """Time at which a light turns green; meaningless for a sign."""


def read_signals(roads: RoadNetwork, root: ElementTree.Element) -> list[Signal]:
    """Return the signals that govern at least one driving lane, one for each id, in the order of the file.

    They are followed, without an id, by the stop signs of the town that its file does not contain. As in CARLA, a light
    on a junction's road without a controller is omitted.
    """
    turns = _turns(root, roads.file.name)
    missing = _unnamed_in_junctions(root, turns)
    lengths = {id_as_read(road.get("id")): float(road.get("length") or 0.0) for road in root.iter("road")}
    governed = _governed_lanes(roads, lengths)
    signals = []
    for key in _signal_ids(root):
        lanes = governed.get(key, [])
        if lanes and key[1] not in missing:
            signals.append(_signal(key, lanes, turns.get(key[1]), roads))
    stops = sum(signal.type == STOP_TYPE for signal in signals)
    return signals + [_unlisted(roads, *place) for place in unlisted_stops(roads.file.name, stops)]


def _unlisted(roads: RoadNetwork, x: float, y: float, yaw: float) -> Signal:
    """Return a stop sign at the right edge of the lane at a position, facing traffic with that yaw."""
    lane = roads.map.get_waypoint(roads.carla.Location(x, y, 0.0))
    across = wrap_degrees(yaw + 90.0)
    half_m = lane.lane_width / 2
    aside = Vector(math.cos(math.radians(across)), math.sin(math.radians(across)))
    edge_m = half_m + BEYOND_EDGE_M
    pose = Pose(Vector(x + edge_m * aside.x, y + edge_m * aside.y, lane.transform.location.z), Rotation(yaw=across))
    box = Box(Vector(-edge_m), Vector(half_m, BOX_HALF_DEPTH_M, BOX_HALF_HEIGHT_M))
    return Signal("", STOP_TYPE, pose, box, SignalPhase(""))


def _signal_ids(root: ElementTree.Element) -> list[tuple[str, str]]:
    found = [(item.get("type", ""), item.get("id", "")) for item in root.iter("signal")]
    return [key for key in dict.fromkeys(found) if key[0] in ACTOR_TYPES]


def _turns(root: ElementTree.Element, town: str) -> dict[str, SignalPhase]:
    """Return each signal id's turn. The phases of a junction are its controllers that contain a light.

    As in CARLA's `TrafficLightManager`, only the controller with the lowest id contains a light.
    """
    lights = {
        item.get("id", ""): {control.get("signalId", "") for control in item.findall("control")}
        for item in root.findall("controller")
    }
    holder = {
        light: min(item for item in lights if light in lights[item]) for held in lights.values() for light in held
    }
    order = spawn_order(town, holder)
    turns: dict[str, SignalPhase] = {}
    for junction in root.iter("junction"):
        here = [item.get("id", "") for item in junction.findall("controller")]
        phases = [sorted(light for light in lights.get(item, ()) if holder[light] == item) for item in here]
        phases = sorted(filter(None, phases), key=lambda phase: min(order.get(light, len(order)) for light in phase))
        for place, phase in enumerate(phases):
            turns |= {light: SignalPhase(junction.get("id", ""), place) for light in phase if light not in turns}
    return turns


def _unnamed_in_junctions(root: ElementTree.Element, turns: dict[str, SignalPhase]) -> set[str]:
    """Return the lights of a junction's own roads without a turn. CARLA does not spawn them (Town10HD has two)."""
    inside = [road for road in root.iter("road") if road.get("junction", "-1") != "-1"]
    lights = {item.get("id", "") for road in inside for item in road.iter("signal") if item.get("type") == LIGHT_TYPE}
    return lights - set(turns)


def _governed_lanes(roads: RoadNetwork, lengths: dict[int, float]) -> dict[tuple[str, str], list[Any]]:
    """Return waypoints just before each signal, one for each lane that it governs."""
    lanes: dict[tuple[str, str], dict[tuple[int, int], Any]] = defaultdict(dict)
    for kind in ACTOR_TYPES:
        for landmark in roads.map.get_all_landmarks_of_type(kind):
            end_m = lengths.get(landmark.road_id, 0.0) - ROAD_END_M
            for waypoint in _landmark_lanes(roads, landmark, max(0.0, min(landmark.s, end_m))):
                before = _approach(waypoint)
                lanes[kind, landmark.id].setdefault((before.road_id, before.lane_id), before)
    return {key: list(value.values()) for key, value in lanes.items()}


def _landmark_lanes(roads: RoadNetwork, landmark: Any, s: float) -> list[Any]:
    """Return waypoints at `s` of the landmark's road on the driving lanes that it is valid for."""
    found = []
    for first, last in landmark.get_lane_validities():
        for lane in range(min(first, last), max(first, last) + 1):
            waypoint = roads.map.get_waypoint_xodr(landmark.road_id, lane, s) if lane else None
            if waypoint is not None and waypoint.lane_type == roads.carla.LaneType.Driving:
                found.append(waypoint)
    return found


def _approach(waypoint: Any) -> Any:
    """Return the position on the lane to the signal, before its junction."""
    while waypoint.is_junction:
        before = waypoint.previous(1.0)
        if not before or before[0].transform.location.distance(waypoint.transform.location) < 0.01:
            return waypoint
        waypoint = before[0]
    back = waypoint.previous(BACK_FROM_JUNCTION_M - 0.5)
    return back[0] if back and not back[0].is_junction else waypoint


def _signal(key: tuple[str, str], lanes: list[Any], turn: SignalPhase | None, roads: RoadNetwork) -> Signal:
    kind, signal_id = key
    yaw = lanes[0].transform.rotation.yaw
    across = wrap_degrees(yaw + 90.0)
    middle, half_width_m = _span(lanes, across)
    landmark = next(item for item in roads.map.get_all_landmarks_of_type(kind) if item.id == signal_id)
    pole = landmark.transform.location
    pose = Pose(Vector(pole.x, pole.y, middle.z), Rotation(yaw=across))
    box = Box(_into_frame(middle, pose), Vector(half_width_m, BOX_HALF_DEPTH_M, BOX_HALF_HEIGHT_M))
    return Signal(signal_id, kind, pose, box, turn or SignalPhase(f"signal {signal_id}", alone=True))


def _span(lanes: list[Any], across_deg: float) -> tuple[Vector, float]:
    """Return the middle of the governed lanes and half their width along `across_deg`."""
    unit = (math.cos(math.radians(across_deg)), math.sin(math.radians(across_deg)))
    first = lanes[0].transform.location
    low, high = math.inf, -math.inf
    for lane in lanes:
        place = lane.transform.location
        offset = (place.x - first.x) * unit[0] + (place.y - first.y) * unit[1]
        low, high = min(low, offset - lane.lane_width / 2), max(high, offset + lane.lane_width / 2)
    shift = (low + high) / 2
    return Vector(first.x + shift * unit[0], first.y + shift * unit[1], first.z), (high - low) / 2


def _into_frame(point: Vector, pose: Pose) -> Vector:
    yaw = math.radians(pose.rotation.yaw)
    dx, dy = point.x - pose.location.x, point.y - pose.location.y
    cos, sin = math.cos(yaw), math.sin(yaw)
    return Vector(dx * cos + dy * sin, dy * cos - dx * sin, point.z - pose.location.z)
