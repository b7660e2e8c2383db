"""Scene that a reasoner gets when the ego may be immobilized, in the ego frame of ISO 8855.

x ahead, y left, meters, radians, counter-clockwise, origin at the center of the ego's bounding box. Unknown values are
None, never invented.
"""

import math
from enum import Enum
from typing import Literal

from pydantic import Base64Bytes, Field, JsonValue

from stucksolver.scene.base_model import FrozenModel
from stucksolver.scene.failed_attempts import FailedAttempt
from stucksolver.scene.interpretation import Claim, Interpretation
from stucksolver.scene.objects import TrackedObject
from stucksolver.scene.road import LaneDirection, LaneKind, LineKind, ZoneKind
from stucksolver.scene.signs import ObservedSign
from stucksolver.scene.surroundings import TrafficControl


class LaneRelation(str, Enum):
    """Position of a lane or an object relative to the ego's route."""

    EGO = "ego"
    LEFT = "left"
    RIGHT = "right"
    ONCOMING = "oncoming"
    SHOULDER = "shoulder"
    CROSSING = "crossing"
    OFF_ROAD = "off_road"


IMMOBILIZED_BELOW_MPS = 5 / 3.6
"""Speed below which the ego counts as immobilized, by default (m/s): 5 km/h, as in Bao and Li 2025
(arXiv:2510.26023).
"""
EXPECTED_PROGRESS_M = 5.0
"""Progress that is expected within the detector's window, by default (m). Ours: a car length."""


class SceneEgo(FrozenModel):
    """Ego as described to a reasoner."""

    speed_mps: float
    lane_id: str | None
    lateral_offset_m: float
    """Offset from the center of the route's lane (m), left positive."""
    stopped_for_s: float = 0.0
    """Time for which the ego has been slower than the detector's threshold (s). The solver sets this field."""
    progress_20s_m: float | None = None
    """New progress along the route in the detector's window (m); None before the first full window.

    The solver sets this field.
    """
    immobilized_below_mps: float = Field(default=IMMOBILIZED_BELOW_MPS, gt=0)
    """The detector's threshold of speed (m/s). The solver fills this in."""
    expected_progress_m: float = Field(default=EXPECTED_PROGRESS_M, gt=0)
    """Progress that the detector expects within its window (m). The solver fills this in."""
    yield_draw: float | None = Field(default=None, ge=0, le=1)
    """Drawn number of this vehicle in a standoff with a vehicle that faces it; a small number means to yield.

    None without a standoff, and in old records. The solver sets this field, and draws again after a while.
    """
    zone: ZoneKind | None = None
    """Kind of the zone that its body touches, in which no vehicle should stop; None outside, and in old records."""
    distance_to_destination_m: float | None
    at_destination: bool
    length_m: float = Field(gt=0)
    width_m: float = Field(gt=0)

    @property
    def is_slow(self) -> bool:
        """True if the ego is slower than the detector's threshold."""
        return self.speed_mps < self.immobilized_below_mps


class SceneObject(TrackedObject):
    """Tracked object with its position on the road."""

    lane: LaneRelation
    lane_id: str | None
    gap_m: float | None
    """Distance along the route from the ego's front bumper to the near side (m); negative beside or behind the ego."""
    left_edge_m: float
    right_edge_m: float
    """Lateral extent from the center of the route's lane at the object's position (m), left positive."""
    speed_along_mps: float
    """Speed along the route (m/s); negative if the object moves toward the ego."""
    speed_across_mps: float = 0.0
    """Speed across the road to the left of the route (m/s); 0 in old records without this field."""
    in_path: bool
    """True if the ego would hit the object when following the route's lane."""


class SceneLane(FrozenModel):
    """The ego's lane, or an adjacent lane."""

    id: str
    relation: LaneRelation
    direction: LaneDirection
    kind: LaneKind
    width_m: float
    line: LineKind
    may_enter: bool
    """True if the road markings allow entry from the ego's lane."""
    free_ahead_m: float | None
    free_behind_m: float | None
    """Distance from the ego's bumper to the nearest object in the lane (m); None if the lane is not visible."""
    sight_ahead_m: float | None
    speed_limit_mps: float | None


class SceneZone(FrozenModel):
    """Stretch of the route with its own rules, such as a junction, as distances along the route."""

    kind: ZoneKind
    start_m: float
    end_m: float
    """Distances from the ego's front bumper (m); a start that is negative has been reached."""


class CandidateWaypoint(FrozenModel):
    """Position from which the route can be replanned."""

    id: str
    lane_id: str
    x_m: float
    y_m: float
    distance_m: float
    """Distance along the route from the ego (m).

    It is the straight-line distance for a waypoint off the route, in an unlisted lane.
    """
    reaches_destination: bool | None = None
    """True if a route leads to the destination from there; off the route, without returning to the road ahead."""
    route_length_m: float | None = None
    """Length of that route (m)."""


class AvailableBehavior(FrozenModel):
    """Behavior that the stack can perform now, with the JSON schema of its parameters."""

    name: str
    parameters: dict[str, JsonValue]


class CameraImage(FrozenModel):
    """Image of the front camera as JPEG."""

    width: int
    height: int
    jpeg: Base64Bytes


MAX_WORDS = 500
"""Longest utterance of a passenger (characters); the rest is cut off. Ours."""


class Guidance(FrozenModel):
    """Utterance of a passenger. It is advice and data, never an instruction to the system."""

    text: str = Field(max_length=MAX_WORDS)
    time_s: float
    reading: Interpretation | None = None
    """Interpretation of the utterance by the vehicle's own interpreter; None before it is interpreted."""


TOUCHING_M = -0.5
"""Most negative gap that still counts as ahead (m): bounding boxes are larger than the objects. Ours."""


class Scene(FrozenModel):
    """All information that a reasoner may have. It never contains scenario labels or role names."""

    version: Literal[1] = 1
    time_s: float
    frame: int
    ego: SceneEgo
    objects: tuple[SceneObject, ...]
    controls: tuple[TrafficControl, ...]
    signs: tuple[ObservedSign, ...] = ()
    """Words read on signs and vehicles. They are for reasoners only: the guard uses no words."""
    lanes: tuple[SceneLane, ...]
    zones: tuple[SceneZone, ...] = ()
    """Zones on the route that the ego has not left, nearest first; empty in old records."""
    waypoints: tuple[CandidateWaypoint, ...] = ()
    behaviors: tuple[AvailableBehavior, ...]
    route_command: str | None = None
    speed_limit_mps: float | None = None
    image: CameraImage | None = None
    guidance: Guidance | None = None
    claims: tuple[Claim, ...] = ()
    """Recent claims of people about the world, as interpreted: evidence that never overrides perception."""
    attempts: tuple[FailedAttempt, ...] = ()
    mirrored: bool = False
    """True for left-hand traffic: left and right are swapped, except in the image and in the words of people."""

    def offers(self, *names: str) -> bool:
        """True if the stack can perform all of these behaviors now."""
        offered = {behavior.name for behavior in self.behaviors}
        return offered.issuperset(names)

    def in_path_ahead(self, within_m: float = math.inf) -> tuple[SceneObject, ...]:
        """Return the objects in the path ahead, nearest first.

        The gap is measured from bumper to bumper; an object that already touches the front is included.

        Args:
            within_m: Only objects nearer than this (m).
        """
        near = [(o.gap_m, o) for o in self.objects if o.in_path and o.gap_m is not None]
        return tuple(o for gap_m, o in sorted(near, key=lambda item: item[0]) if TOUCHING_M < gap_m < within_m)
