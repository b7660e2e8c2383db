"""What makes two scenes alike: a few features that say what blocks the way and which ways are left."""

from __future__ import annotations

from enum import Enum

from stucksolver.scene import (
    MOTOR_VEHICLES,
    VULNERABLE,
    ControlKind,
    LaneRelation,
    LightState,
    Scene,
    SceneObject,
)
from stucksolver.scene.model import Model

NEAR_M = 25.0
"""What stands farther ahead does not hold the vehicle up; the rules' own bound."""
PEOPLE_M = 15.0
"""People nearer than this count; the rules' own clearance."""
LIGHT_M = 20.0
"""A light farther ahead than this does not hold the vehicle up; the rules' own bound."""
BESIDE_M = 40.0
"""So far ahead a lane beside is looked at: about what it takes to pass a car and come back."""
BEHIND_M = -5.0
"""What has its near side farther behind the front bumper than a car's length is not in the way."""
STANDS_MPS = 0.5
"""Slower than this something stands; the rules' own bound."""
ALIKE_SHARE = 0.75
"""Of the soft features so many must agree: five of six do, four of six do not."""
HARD = ("obstacle", "motion", "light")
"""Features in which two scenes must agree: each asks for another solution."""
SOFT = ("hazard_lights", "left", "right", "oncoming", "people", "detour")


class Motion(str, Enum):
    """What the obstacle does, seen along the route."""

    NONE = "none"
    STANDING = "standing"
    AWAY = "away"
    TOWARDS = "towards"
    ACROSS = "across"


class LaneState(str, Enum):
    """What a lane beside offers."""

    NONE = "none"
    FREE = "free"
    BUSY = "busy"
    """A vehicle or a person is in it, who will go on."""
    BLOCKED = "blocked"
    """Something is in it that stays there: a thing, or a vehicle with hazard lights."""


class SceneFeatures(Model):
    """A scene without places, times, pictures or names: nothing in it tells where or with whom it was.

    `obstacle`: kind of the nearest thing in the path, `none` without one. `light`: state of the light ahead, `none`
    without one and for a green one, which holds nobody up. `people`: is a person, an animal or a cyclist near ahead?
    `detour`: does another road lead to the destination from here?
    """

    obstacle: str
    motion: Motion
    light: str
    hazard_lights: bool
    left: LaneState
    right: LaneState
    oncoming: LaneState
    people: bool
    detour: bool


def features_of(scene: Scene) -> SceneFeatures:
    """The features of a scene."""
    lead = next(iter(scene.in_path_ahead(NEAR_M)), None)
    return SceneFeatures(
        obstacle="none" if lead is None else lead.kind.value,
        motion=_motion(lead),
        light=_light(scene),
        hazard_lights=lead is not None and bool(lead.hazard_lights),
        left=_lane(scene, LaneRelation.LEFT),
        right=_lane(scene, LaneRelation.RIGHT),
        oncoming=_lane(scene, LaneRelation.ONCOMING),
        people=any(o.kind in VULNERABLE and 0.0 < (o.gap_m or 0.0) < PEOPLE_M for o in scene.objects),
        detour=_detour(scene),
    )


def similarity(one: SceneFeatures, other: SceneFeatures) -> float:
    """From 0 (nothing in common, or another obstacle) to 1 (all features agree)."""
    if any(getattr(one, name) != getattr(other, name) for name in HARD):
        return 0.0
    agreeing = [name for name in SOFT if getattr(one, name) == getattr(other, name)]
    return len(agreeing) / len(SOFT)


def alike(one: SceneFeatures, other: SceneFeatures) -> bool:
    """Does what was learned in one scene count in the other?"""
    return similarity(one, other) >= ALIKE_SHARE


def _motion(lead: SceneObject | None) -> Motion:
    if lead is None:
        return Motion.NONE
    if abs(lead.speed_across_mps) > max(STANDS_MPS, abs(lead.speed_along_mps)):
        return Motion.ACROSS
    if abs(lead.speed_along_mps) <= STANDS_MPS:
        return Motion.STANDING
    return Motion.AWAY if lead.speed_along_mps > 0.0 else Motion.TOWARDS


def _light(scene: Scene) -> str:
    for control in scene.controls:
        ahead = control.applies is not False and -1.0 < control.distance_m < LIGHT_M
        light = control.kind is ControlKind.TRAFFIC_LIGHT and control.state not in (None, LightState.GREEN)
        if ahead and light and control.state is not None:
            return control.state.value
    return "none"


def _lane(scene: Scene, where: LaneRelation) -> LaneState:
    lane = next((one for one in scene.lanes if one.relation is where), None)
    if lane is None:
        return LaneState.NONE
    there = [o for o in scene.objects if o.lane_id == lane.id and _beside(o)]
    if any(_stays(o) for o in there):
        return LaneState.BLOCKED
    return LaneState.BUSY if there else LaneState.FREE


def _beside(o: SceneObject) -> bool:
    return o.gap_m is not None and BEHIND_M < o.gap_m < BESIDE_M


def _stays(o: SceneObject) -> bool:
    """Will it be there however long one waits?"""
    goes_on = o.kind in MOTOR_VEHICLES | VULNERABLE and not o.hazard_lights
    return not goes_on and abs(o.speed_along_mps) <= STANDS_MPS


def _detour(scene: Scene) -> bool:
    known = {lane.id for lane in scene.lanes}
    return any(w.reaches_destination and w.lane_id not in known for w in scene.waypoints)
