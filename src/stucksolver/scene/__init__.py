"""What the solver is told."""

from stucksolver.scene.objects import MOTOR_VEHICLES, STATIC_KINDS, VULNERABLE, ObjectKind, TrackedObject
from stucksolver.scene.road import (
    LaneDirection,
    LaneKind,
    LaneStrip,
    LineKind,
    RoadGeometry,
    Zone,
    ZoneKind,
)
from stucksolver.scene.scene import (
    AvailableBehavior,
    CameraImage,
    CandidateWaypoint,
    Guidance,
    LaneRelation,
    PastAttempt,
    Scene,
    SceneEgo,
    SceneLane,
    SceneObject,
)
from stucksolver.scene.status import Status
from stucksolver.scene.surroundings import (
    ControlKind,
    EgoState,
    LaneSight,
    LightState,
    Surroundings,
    TrafficControl,
    VehicleLimits,
)

__all__ = [
    "MOTOR_VEHICLES",
    "STATIC_KINDS",
    "VULNERABLE",
    "AvailableBehavior",
    "CameraImage",
    "CandidateWaypoint",
    "ControlKind",
    "EgoState",
    "Guidance",
    "LaneDirection",
    "LaneKind",
    "LaneRelation",
    "LaneSight",
    "LaneStrip",
    "LightState",
    "LineKind",
    "ObjectKind",
    "PastAttempt",
    "RoadGeometry",
    "Scene",
    "SceneEgo",
    "SceneLane",
    "SceneObject",
    "Status",
    "Surroundings",
    "TrackedObject",
    "TrafficControl",
    "VehicleLimits",
    "Zone",
    "ZoneKind",
]
