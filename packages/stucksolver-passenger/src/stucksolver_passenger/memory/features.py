"""Features that decide whether two scenes are similar: the obstacle, and the remaining options to pass it."""

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
from stucksolver.scene.base_model import FrozenModel

NEAR_M = 25.0
"""Distance within which an object holds the vehicle (m). The same bound as in the rules."""
PEOPLE_M = 15.0
"""Distance within which pedestrians count (m). The same clearance as in the rules."""
LIGHT_M = 20.0
"""Distance within which a traffic light holds the vehicle (m). The same bound as in the rules."""
BESIDE_M = 40.0
"""Length of the adjacent lane that is checked (m): about the distance to pass a car and return. Ours."""
BEHIND_M = -5.0
"""Longitudinal position of an object's near end, relative to the front bumper, from which it counts (m). Ours."""
STANDS_MPS = 0.5
"""Speed below which an object counts as stopped (m/s). The same bound as in the rules."""
ALIKE_SHARE = 0.75
"""Share of the soft features that must agree: five of six suffice, four of six do not. Ours."""
HARD = ("obstacle", "motion", "light")
"""Features in which two scenes must agree, because each value requires a different solution."""
SOFT = ("hazard_lights", "left", "right", "oncoming", "people", "detour")


class ObstacleMotion(str, Enum):
    """Motion of the obstacle along the route."""

    NONE = "none"
    STANDING = "standing"
    AWAY = "away"
    TOWARDS = "towards"
    ACROSS = "across"


class LaneState(str, Enum):
    """State of a lane adjacent to the ego."""

    NONE = "none"
    FREE = "free"
    BUSY = "busy"
    """The lane contains a vehicle or a pedestrian that will move on."""
    BLOCKED = "blocked"
    """The lane contains a static object, or a vehicle with hazard lights."""


class SceneFeatures(FrozenModel):
    """A scene without positions, times, images or names. It does not reveal where or with which person it occurred.

    Attributes:
        obstacle: Kind of the nearest object in the path, or `none`.
        light: State of the light ahead; `none` without one and for a green one, which holds no vehicle.
        people: True if a pedestrian, an animal or a cyclist is near ahead.
        detour: True if another road leads to the destination from here.
    """

    obstacle: str
    motion: ObstacleMotion
    light: str
    hazard_lights: bool
    left: LaneState
    right: LaneState
    oncoming: LaneState
    people: bool
    detour: bool


def features_of(scene: Scene) -> SceneFeatures:
    """Return the features of a scene."""
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


def similarity(first: SceneFeatures, second: SceneFeatures) -> float:
    """Return the similarity from 0 (nothing in common, or another obstacle) to 1 (all features agree)."""
    if any(getattr(first, name) != getattr(second, name) for name in HARD):
        return 0.0
    agreeing = [name for name in SOFT if getattr(first, name) == getattr(second, name)]
    return len(agreeing) / len(SOFT)


def alike(first: SceneFeatures, second: SceneFeatures) -> bool:
    """True if a solution from one scene counts in the other."""
    return similarity(first, second) >= ALIKE_SHARE


def _motion(lead: SceneObject | None) -> ObstacleMotion:
    if lead is None:
        return ObstacleMotion.NONE
    if abs(lead.speed_across_mps) > max(STANDS_MPS, abs(lead.speed_along_mps)):
        return ObstacleMotion.ACROSS
    if abs(lead.speed_along_mps) <= STANDS_MPS:
        return ObstacleMotion.STANDING
    return ObstacleMotion.AWAY if lead.speed_along_mps > 0.0 else ObstacleMotion.TOWARDS


def _light(scene: Scene) -> str:
    for control in scene.controls:
        ahead = control.applies is not False and -1.0 < control.distance_m < LIGHT_M
        light = control.kind is ControlKind.TRAFFIC_LIGHT and control.state not in (None, LightState.GREEN)
        if ahead and light and control.state is not None:
            return control.state.value
    return "none"


def _lane(scene: Scene, where: LaneRelation) -> LaneState:
    lane = next((item for item in scene.lanes if item.relation is where), None)
    if lane is None:
        return LaneState.NONE
    there = [o for o in scene.objects if o.lane_id == lane.id and _is_abreast_or_ahead(o)]
    if any(_stays(o) for o in there):
        return LaneState.BLOCKED
    return LaneState.BUSY if there else LaneState.FREE


def _is_abreast_or_ahead(o: SceneObject) -> bool:
    return o.gap_m is not None and BEHIND_M < o.gap_m < BESIDE_M


def _stays(o: SceneObject) -> bool:
    """True if waiting will not remove the object."""
    goes_on = o.kind in MOTOR_VEHICLES | VULNERABLE and not o.hazard_lights
    return not goes_on and abs(o.speed_along_mps) <= STANDS_MPS


def _detour(scene: Scene) -> bool:
    known = {lane.id for lane in scene.lanes}
    return any(w.reaches_destination and w.lane_id not in known for w in scene.waypoints)
