"""Objects that a perception system tracks."""

from enum import Enum

from pydantic import Field

from stucksolver.scene.base_model import FrozenModel


class ObjectKind(str, Enum):
    """What an object is; `unknown` where perception cannot tell."""

    CAR = "car"
    VAN = "van"
    TRUCK = "truck"
    BUS = "bus"
    SCHOOL_BUS = "school_bus"
    EMERGENCY = "emergency"
    MOTORCYCLE = "motorcycle"
    BICYCLE = "bicycle"
    PEDESTRIAN = "pedestrian"
    FLAGGER = "flagger"
    ANIMAL = "animal"
    CONE = "cone"
    BARRIER = "barrier"
    CROSSING_GATE = "crossing_gate"
    BAG = "bag"
    LITTER = "litter"
    DEBRIS = "debris"
    PROP = "prop"
    UNKNOWN = "unknown"


MOTOR_VEHICLES = frozenset(
    {
        ObjectKind.CAR,
        ObjectKind.VAN,
        ObjectKind.TRUCK,
        ObjectKind.BUS,
        ObjectKind.SCHOOL_BUS,
        ObjectKind.EMERGENCY,
        ObjectKind.MOTORCYCLE,
    }
)
VEHICLES = MOTOR_VEHICLES | {ObjectKind.BICYCLE}
ON_FOOT = frozenset({ObjectKind.PEDESTRIAN, ObjectKind.FLAGGER, ObjectKind.ANIMAL})
"""Kinds that may step onto the road from a standstill."""
VULNERABLE = ON_FOOT | {ObjectKind.BICYCLE}
"""Vulnerable road users: passed with a wider clearance."""
TWO_WHEELED = frozenset({ObjectKind.MOTORCYCLE, ObjectKind.BICYCLE})
PASSABLE_KINDS = frozenset({ObjectKind.BAG, ObjectKind.LITTER})
"""Soft by class: an empty bag, paper, cardboard. Nothing else may ever be driven over."""
STATIC_KINDS = PASSABLE_KINDS | {
    ObjectKind.CONE,
    ObjectKind.BARRIER,
    ObjectKind.CROSSING_GATE,
    ObjectKind.DEBRIS,
    ObjectKind.PROP,
}


class Gesture(str, Enum):
    """What a flagger signals."""

    NONE = "none"
    STOP = "stop"
    SLOW = "slow"
    GO = "go"


class TrackedObject(FrozenModel):
    """One object. Pose and velocity are in the frame of the record that holds it.

    `x_m, y_m` is the centre of the bounding box; `yaw_rad` is counter-clockwise from the x axis.
    """

    id: str
    kind: ObjectKind
    x_m: float
    y_m: float
    yaw_rad: float
    vx_mps: float
    vy_mps: float
    length_m: float = Field(gt=0)
    width_m: float = Field(gt=0)
    height_m: float = Field(gt=0)
    stationary_s: float | None = None
    """How long it has been seen stationary (below 0.1 m/s) (s); 0 while it moves; None if this is not tracked."""
    moved_s_ago: float | None = None
    """Time since it was last seen moving (s); None if it never was."""
    pushed: bool = False
    """True if it moves only because the ego pushes it. It then counts as stationary, whatever its velocity."""
    seen_for_s: float | None = None
    """How long it has been tracked without a break (s)."""
    kind_confidence: float | None = Field(default=None, ge=0, le=1)
    """Probability that the kind is right; None if perception does not give one."""
    position_sd_m: float | None = Field(default=None, ge=0)
    """Standard deviation of its position in the worst direction (m); None if perception is exact."""
    across_sd_m: float | None = Field(default=None, ge=0)
    """The same across its own axis (m); None: as in the worst direction."""
    hazard_lights: bool | None = None
    emergency_lights: bool | None = None
    brake_lights: bool | None = None
    door_open: bool | None = None
    """True if an open door of it is seen; False if none is; None if perception cannot tell."""
    gesture: Gesture | None = None
    """What a flagger signals; None for all others, and where perception cannot tell."""
