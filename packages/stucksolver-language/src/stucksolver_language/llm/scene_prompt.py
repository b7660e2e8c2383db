"""A scene as compact text: measured numbers, one object per line, nearest first."""

from __future__ import annotations

import json
import math

from stucksolver.scene import (
    CandidateWaypoint,
    LaneDirection,
    LaneKind,
    ObservedSign,
    Scene,
    SceneLane,
    SceneObject,
    SignWord,
    TrafficControl,
    ZoneKind,
)
from stucksolver.scene.objects import Gesture
from stucksolver_language.llm.attempt_text import failed_lines
from stucksolver_language.llm.work_zones import WorkZone, nearest_work_zone

MOST_CHARACTERS = 1300
"""Longest text of a scene without failed plans (characters). Dense numbers take two characters per token. Ours."""
LEAST_OBJECTS = 4
"""Number of nearest objects that are listed even if the text becomes longer than `MOST_CHARACTERS`. Ours."""
MOST_SIGNS = 4
"""Maximum number of signs in the prompt that belong to no object. Ours."""
SIGNALS = "signals-"
"""Prefix of the mark for a flagger's gesture."""
SAYS = "says-"
"""Prefix of the mark for a word on a sign, always one of `SignWord`."""


def scene_text(scene: Scene) -> str:
    """Return the scene as sent to the model, in m, s and m/s, left positive. Deterministic.

    If the text is too long, the farthest objects are omitted, and the text states their number.
    """
    head = [_ego(scene), "lanes (id relation type width line free_ahead/behind seen):"]
    head += [_lane(lane) for lane in scene.lanes if _matters(lane)]
    zone = nearest_work_zone(scene)
    head += _zones(scene, zone)
    controls, tail = _controls(scene) + _starts(scene), _guidance(scene)
    room = MOST_CHARACTERS - sum(len(line) + 1 for line in head + controls + tail)
    return "\n".join(head + _objects(scene, zone, room) + controls + failed_lines(scene) + tail)


def _zones(scene: Scene, work: WorkZone | None) -> list[str]:
    """Return junctions and other zones of the route, with the roads off it, and the work zone with its far end."""
    listed = {lane.id for lane in scene.lanes}
    roads = list(dict.fromkeys(w.lane_id for w in scene.waypoints if w.lane_id not in listed))
    lines = [f"{zone.kind.value} from {_n(zone.start_m)} to {_n(zone.end_m)} m" for zone in scene.zones]
    nearest = next((k for k, zone in enumerate(scene.zones) if zone.kind is ZoneKind.JUNCTION), None)
    if nearest is not None and roads:
        lines[nearest] += f", roads off the route: {' '.join(roads)}"
    if work is not None:
        right_m, left_m = work.edges_m
        first, last = work.objects[0].id, work.objects[-1].id
        lines.append(
            f"work_zone from {_n(work.start_m)} to {_n(work.end_m)} m, edges {_n(right_m)}..{_n(left_m)}, "
            f"{len(work.objects)} cones and barriers, first {first}, last {last}"
        )
    return ["zones:", *lines] if lines else []


def _controls(scene: Scene) -> list[str]:
    known = {o.id for o in scene.objects}
    signs = [_sign(sign) for sign in scene.signs if sign.object_id not in known][:MOST_SIGNS]
    lines = [*(_control(control) for control in scene.controls), *signs]
    return ["controls:", *lines] if lines else []


def _starts(scene: Scene) -> list[str]:
    """Return the route starts, one group per lane. Ids that begin with their lane's id are listed without it."""
    if not scene.waypoints:
        return []
    lanes = dict.fromkeys(w.lane_id for w in scene.waypoints)
    groups = [f"{lane} " + " ".join(_waypoint(w) for w in scene.waypoints if w.lane_id == lane) for lane in lanes]
    return ["route starts (lane, then ids; +20 is lane+20, 20 m ahead): " + "; ".join(groups)]


def _guidance(scene: Scene) -> list[str]:
    """Return the passenger's utterance as a JSON string, so that it cannot leave its quotes."""
    if scene.guidance is None:
        return []
    return [f"passenger says {scene.time_s - scene.guidance.time_s:.0f} s ago: {json.dumps(scene.guidance.text)}"]


def _objects(scene: Scene, work: WorkZone | None, room: int) -> list[str]:
    if not scene.objects:
        return ["objects: none"]
    head = "objects (id kind lane gap edges_right..left speed_along/across stood_for length*width*height marks):"
    lines = [head]
    listed = [o for o in scene.objects if work is None or o.id not in work.middle_ids]
    for o in sorted(listed, key=_importance):
        line = _object(o, [sign.word for sign in scene.signs if sign.object_id == o.id])
        if len(lines) > LEAST_OBJECTS and sum(len(x) + 1 for x in lines) + len(line) > room:
            break
        lines.append(line)
    left_out = len(listed) + 1 - len(lines)
    return [*lines, f"and {left_out} more, farther"] if left_out else lines


def _importance(o: SceneObject) -> float:
    """Sort key: nearest first, objects in the path before others."""
    return abs(o.gap_m or 0.0) * (0.5 if o.in_path else 1.0)


def _matters(lane: SceneLane) -> bool:
    """True for lanes that the ego may use. Excludes sidewalks and nondrivable lanes at the far side of the road."""
    other_side = lane.direction is LaneDirection.OPPOSITE and lane.kind is not LaneKind.DRIVING
    return lane.kind is not LaneKind.SIDEWALK and not other_side


def _ego(scene: Scene) -> str:
    ego = scene.ego
    parts = [
        f"ego: {_n(ego.speed_mps)} m/s, below {_n(3.6 * ego.immobilized_below_mps)} km/h for {_n(ego.stopped_for_s)} s",
        f"progress in 20 s {_n(ego.progress_20s_m)} m",
        f"lane {ego.lane_id or 'none'} offset {_n(ego.lateral_offset_m)}",
        "at destination" if ego.at_destination else f"{_n(ego.distance_to_destination_m)} m to destination",
        f"size {_n(ego.length_m)}x{_n(ego.width_m)}",
        f"limit {_n(scene.speed_limit_mps)} m/s",
    ]
    if scene.route_command:
        parts.append(f"route: {scene.route_command}")
    return ", ".join(parts)


def _lane(lane: SceneLane) -> str:
    enter = "" if lane.may_enter or lane.relation.value == "ego" else " no-entry-by-markings"
    return (
        f"{lane.id} {lane.relation.value} {lane.kind.value} {_n(lane.width_m)} "
        f"{lane.line.value} {_n(lane.free_ahead_m)}/{_n(lane.free_behind_m)} {_n(lane.sight_ahead_m)}{enter}"
    )


def _object(o: SceneObject, words: list[SignWord]) -> str:
    marks = [
        word
        for word, on in (
            ("in-path", o.in_path),
            ("hazard-lights", o.hazard_lights),
            ("emergency-lights", o.emergency_lights),
            ("brake-lights", o.brake_lights),
            ("door-open", o.door_open),
        )
        if on
    ]
    if o.gesture is not None and o.gesture is not Gesture.NONE:
        marks.append(f"{SIGNALS}{o.gesture.value}")
    marks += [_says(word) for word in words]
    line = (
        f"{o.id} {o.kind.value} {o.lane.value} {_n(o.gap_m)} {_n(o.right_edge_m)}..{_n(o.left_edge_m)} "
        f"{_n(o.speed_along_mps)}/{_n(o.speed_across_mps)} {_n(o.stationary_s)} "
        f"{_n(o.length_m)}*{_n(o.width_m)}*{_n(o.height_m)}"
    )
    return " ".join([line, *marks])


def _control(control: TrafficControl) -> str:
    applies = {True: "applies", False: "not for us", None: "applies?"}[control.applies]
    state = f" {control.state.value}" if control.state else ""
    return f"{control.kind.value}{state} {_n(control.distance_m)} m {applies}"


def _says(word: SignWord) -> str:
    return SAYS + word.value.replace("_", "-")


def _sign(sign: ObservedSign) -> str:
    bearing = None if sign.bearing_rad is None else math.degrees(sign.bearing_rad)
    return f"sign {_says(sign.word)} {_n(sign.distance_m)} m at {_n(bearing)} deg"


def _waypoint(w: CandidateWaypoint) -> str:
    reach = {True: "reaches destination", False: "dead end", None: ""}[w.reaches_destination]
    length = "" if w.route_length_m is None else f"{_n(w.route_length_m)} m"
    name = w.id.removeprefix(w.lane_id)
    place = "" if name == f"+{_n(w.distance_m)}" else f"at {_n(w.distance_m)}"
    return " ".join(x for x in (name, place, reach, length) if x)


def _n(value: float | None) -> str:
    """Format a number with at most one decimal, or `?` if it is unknown."""
    if value is None:
        return "?"
    text = f"{value:.1f}"
    return "0" if text in ("0.0", "-0.0") else text.removesuffix(".0")
