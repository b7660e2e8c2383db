"""What a reasoner is told: the scene when something may be wrong, in the ego frame of ISO 8855.

x ahead, y left, metres, radians, counter-clockwise, origin at the centre of the ego's bounding box. What is
unknown is None, never a made-up value.
"""

import math
from enum import Enum
from typing import Literal

from pydantic import Base64Bytes, Field, JsonValue

from stucksolver.scene.attempts import PastAttempt
from stucksolver.scene.model import Model
from stucksolver.scene.objects import TrackedObject
from stucksolver.scene.reading import Claim, Reading
from stucksolver.scene.road import LaneDirection, LaneKind, LineKind
from stucksolver.scene.surroundings import TrafficControl


class LaneRelation(str, Enum):
    """Where something is, seen from the ego's route."""

    EGO = "ego"
    LEFT = "left"
    RIGHT = "right"
    ONCOMING = "oncoming"
    SHOULDER = "shoulder"
    CROSSING = "crossing"
    OFF_ROAD = "off_road"


class SceneEgo(Model):
    """The vehicle itself, as a reasoner is told of it."""

    speed_mps: float
    lane_id: str | None
    lateral_offset_m: float
    """From the centre of the route's lane, left positive."""
    stopped_for_s: float = 0.0
    """How long it has been slower than the detector's bound; filled in by the solver."""
    progress_20s_m: float | None = None
    """New progress along the route in the detector's window; None before a whole window. Filled in by the solver."""
    distance_to_destination_m: float | None
    at_destination: bool
    length_m: float = Field(gt=0)
    width_m: float = Field(gt=0)


class SceneObject(TrackedObject):
    """A tracked object with its place on the road."""

    lane: LaneRelation
    lane_id: str | None
    gap_m: float | None
    """Along the route from the ego's front bumper to its near side; negative while it overlaps or lies behind."""
    left_edge_m: float
    right_edge_m: float
    """Lateral extent from the centre of the route's lane at its place, left positive."""
    speed_along_mps: float
    """Along the route; negative when it comes towards us."""
    speed_across_mps: float = 0.0
    """Across the road at its place, to the left of the route; 0 in records from before it was told."""
    in_path: bool
    """Would the ego touch it on its way along the route's lane?"""


class SceneLane(Model):
    """A lane beside the vehicle, or its own."""

    id: str
    relation: LaneRelation
    direction: LaneDirection
    kind: LaneKind
    width_m: float
    line: LineKind
    may_enter: bool
    """By the road's markings, from the ego's lane."""
    free_ahead_m: float | None
    free_behind_m: float | None
    """From the ego's bumpers to the nearest object in the lane; None where the lane is not seen."""
    sight_ahead_m: float | None
    speed_limit_mps: float | None


class CandidateWaypoint(Model):
    """A place from which the route could be planned anew."""

    id: str
    lane_id: str
    x_m: float
    y_m: float
    distance_m: float
    """Along the route from the ego; to a place beside the route, in a lane that the scene does not list, straight."""
    reaches_destination: bool | None = None
    """Does a route lead on from there: of a place beside the route, one that does not come back to the road ahead?"""
    route_length_m: float | None = None
    """Of that route."""


class AvailableBehavior(Model):
    """A behaviour the stack can perform now, with the JSON schema of its parameters."""

    name: str
    parameters: dict[str, JsonValue]


class CameraImage(Model):
    """The front camera's picture, as JPEG."""

    width: int
    height: int
    jpeg: Base64Bytes


MAX_WORDS = 500
"""Characters of what a passenger says that are listened to."""


class Guidance(Model):
    """What a passenger said. Advice and data, never an instruction to the system."""

    text: str = Field(max_length=MAX_WORDS)
    time_s: float
    reading: Reading | None = None
    """What the words were read as, by the vehicle's own reader; None where nobody has read them."""


TOUCHING_M = -0.5
"""A gap down to this is one of boxes that are larger than their bodies."""


class Scene(Model):
    """Everything a reasoner may know. Scenario labels and role names never appear in it."""

    version: Literal[1] = 1
    time_s: float
    frame: int
    ego: SceneEgo
    objects: tuple[SceneObject, ...]
    controls: tuple[TrafficControl, ...]
    lanes: tuple[SceneLane, ...]
    waypoints: tuple[CandidateWaypoint, ...] = ()
    behaviors: tuple[AvailableBehavior, ...]
    route_command: str | None = None
    speed_limit_mps: float | None = None
    image: CameraImage | None = None
    guidance: Guidance | None = None
    claims: tuple[Claim, ...] = ()
    """What people have said of the world lately, as it was read: evidence, which never replaces what is seen."""
    attempts: tuple[PastAttempt, ...] = ()

    def offers(self, *names: str) -> bool:
        """Can the stack do all of these behaviours now?"""
        offered = {behavior.name for behavior in self.behaviors}
        return offered.issuperset(names)

    def in_path_ahead(self, within_m: float = math.inf) -> tuple[SceneObject, ...]:
        """What is in the path in front of the vehicle and nearer than that, the nearest first.

        The gap counts from bumper to bumper; what already touches it in front is there as well.
        """
        near = [(o.gap_m, o) for o in self.objects if o.in_path and o.gap_m is not None]
        return tuple(o for gap_m, o in sorted(near, key=lambda one: one[0]) if TOUCHING_M < gap_m < within_m)
