"""Mirrors a world with left-hand traffic across the ego's direction, so that its traffic drives on the right.

The core assumes right-hand traffic. A stack on a road with left-hand traffic mirrors all data that it passes to the
solver (y and every angle change sign), and mirrors the paths that it gets back. Guard and reasoners then need no second
case. `RoadGeometry.mirrored` and `Scene.mirrored` record the mirror, and wherever words pass between the solver and
people, or a language model, the sides are swapped.

All functions are their own inverse. The ids of lanes, objects and waypoints stay the same.
"""

from __future__ import annotations

import re
from functools import lru_cache
from typing import TypeVar

from stucksolver.scene.frenet import RoadGeometryByKey
from stucksolver.scene.interpretation import DirectedSide, Interpretation
from stucksolver.scene.objects import TrackedObject
from stucksolver.scene.road import LaneStrip, RoadGeometry
from stucksolver.scene.scene import CandidateWaypoint, LaneRelation, Scene, SceneLane, SceneObject
from stucksolver.scene.surroundings import Surroundings

KEY_SUFFIX = " mirrored"
_OTHER = {"left": "right", "right": "left"}
_SIDES = re.compile(
    r"(?i:\b(?:on|to|from|towards?|at|past) (?:the|its|my|your|our|their) (left|right)\b(?! of way)"
    r"|\bside[ =:\"']+(left|right)\b"
    r"|\b(?:overtake|pass|lane) (left|right)\b(?! of way)"
    r"|\b(left|right)(?:most)? (?:hand |hand-)?(?:lane|edge|border|side|neighbor|shoulder)s?\b)"
)
"""Words that name a side, as opposed to "the right of way", "is right" or "has left"."""
Tracked = TypeVar("Tracked", bound=TrackedObject)


def mirrored_surroundings(surroundings: Surroundings) -> Surroundings:
    """Return the mirror image of the surroundings in their local frame: y -> -y (m), angles negative (rad)."""
    ego = surroundings.ego
    return surroundings.model_copy(
        update={
            "ego": ego.model_copy(update={"y_m": -ego.y_m, "yaw_rad": -ego.yaw_rad}),
            "objects": tuple(map(_object, surroundings.objects)),
            "road": _road(RoadGeometryByKey(surroundings.road)),
            "sensor_faults": tuple(map(with_sides_swapped, surroundings.sensor_faults)),
        }
    )


def mirrored_scene(scene: Scene) -> Scene:
    """Return the mirror image of a scene in the ego frame. The camera's image and the words of people stay."""
    offset_m = -scene.ego.lateral_offset_m
    return scene.model_copy(
        update={
            "mirrored": not scene.mirrored,
            "ego": scene.ego.model_copy(update={"lateral_offset_m": offset_m}),
            "objects": tuple(map(_scene_object, scene.objects)),
            "lanes": tuple(map(_scene_lane, scene.lanes)),
            "waypoints": tuple(map(mirrored_waypoint, scene.waypoints)),
            "signs": tuple(
                sign.model_copy(update={"bearing_rad": None if sign.bearing_rad is None else -sign.bearing_rad})
                for sign in scene.signs
            ),
            "route_command": _other_command(scene.route_command),
            "attempts": tuple(
                attempt.model_copy(update={"outcome": with_sides_swapped(attempt.outcome)})
                for attempt in scene.attempts
            ),
            "guidance": scene.guidance
            and scene.guidance.model_copy(
                update={"reading": scene.guidance.reading and mirrored_reading(scene.guidance.reading)}
            ),
        }
    )


def mirrored_waypoint(waypoint: CandidateWaypoint) -> CandidateWaypoint:
    """Return the mirror image of a candidate waypoint in the ego frame."""
    return waypoint.model_copy(update={"y_m": -waypoint.y_m})


def mirrored_reading(reading: Interpretation) -> Interpretation:
    """Return an interpretation with the other side, or the same one if it names no side."""
    if reading.side is None:
        return reading
    return reading.model_copy(update={"side": DirectedSide(_OTHER[reading.side.value])})


def mirrored_relation(relation: LaneRelation) -> LaneRelation:
    """Return the relation of a lane in the mirror."""
    return LaneRelation(_OTHER.get(relation.value, relation.value))


def with_sides_swapped(text: str) -> str:
    """Return a text with left and right swapped where they name a side: "on the left" becomes "on the right"."""
    return _SIDES.sub(_swapped, text)


def _swapped(match: re.Match[str]) -> str:
    whole, group = match.group(0), match.lastindex or 1
    begin, end = (place - match.start() for place in match.span(group))
    side = whole[begin:end]
    other = _OTHER[side.lower()]
    return whole[:begin] + (other.capitalize() if side[0].isupper() else other) + whole[end:]


@lru_cache(maxsize=4)
def _road(keyed: RoadGeometryByKey) -> RoadGeometry:
    road = keyed.road
    key = road.key.removesuffix(KEY_SUFFIX) if road.mirrored else road.key + KEY_SUFFIX
    return road.model_copy(
        update={
            "key": key,
            "mirrored": not road.mirrored,
            "reference": tuple((x_m, -y_m) for x_m, y_m in road.reference),
            "lanes": tuple(map(_strip, road.lanes)),
        }
    )


def _strip(lane: LaneStrip) -> LaneStrip:
    return lane.model_copy(update={"offset_m": tuple(-offset_m for offset_m in lane.offset_m)})


def _object(obj: Tracked) -> Tracked:
    return obj.model_copy(update={"y_m": -obj.y_m, "yaw_rad": -obj.yaw_rad, "vy_mps": -obj.vy_mps})


def _scene_object(obj: SceneObject) -> SceneObject:
    return _object(obj).model_copy(
        update={
            "lane": mirrored_relation(obj.lane),
            "left_edge_m": -obj.right_edge_m,
            "right_edge_m": -obj.left_edge_m,
            "speed_across_mps": -obj.speed_across_mps,
        }
    )


def _scene_lane(lane: SceneLane) -> SceneLane:
    return lane.model_copy(update={"relation": mirrored_relation(lane.relation)})


def _other_command(command: str | None) -> str | None:
    """Return a command of the route for the other side: `change_left` becomes `change_right`."""
    if command is None:
        return None
    return "_".join(_OTHER.get(word, word) for word in command.split("_"))
