"""Objects that a perception system tracks."""

from enum import Enum

from pydantic import Field

from stucksolver.scene.base_model import FrozenModel


class ObjectKind(str, Enum):
    """Kind of an object; `unknown` if perception cannot determine it."""

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
"""Kinds that are soft by class: an empty bag, paper, cardboard. No other kind may ever be driven over."""
STATIC_KINDS = PASSABLE_KINDS | {
    ObjectKind.CONE,
    ObjectKind.BARRIER,
    ObjectKind.CROSSING_GATE,
    ObjectKind.DEBRIS,
    ObjectKind.PROP,
}


class Gesture(str, Enum):
    """Signal of a flagger."""

    NONE = "none"
    STOP = "stop"
    SLOW = "slow"
    GO = "go"


class TrackedObject(FrozenModel):
    """One tracked object. Pose and velocity are in the frame of the record that contains it.

    `x_m, y_m` is the center of the bounding box; `yaw_rad` is counter-clockwise from the x axis.
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
    """Time for which the object has been stationary (below 0.1 m/s) (s); 0 while it moves; None if not tracked."""
    moved_s_ago: float | None = None
    """Time since the object was last detected moving (s); None if it never was."""
    pushed: bool = False
    """True if the object moves only because the ego pushes it. It then counts as stationary at any velocity."""
    seen_for_s: float | None = None
    """Time for which the object has been tracked without a break (s)."""
    kind_confidence: float | None = Field(default=None, ge=0, le=1)
    """Probability that the kind is right; None if perception does not give one."""
    position_sd_m: float | None = Field(default=None, ge=0)
    """Standard deviation of the position in the worst direction (m); None if perception is exact."""
    across_sd_m: float | None = Field(default=None, ge=0)
    """Standard deviation of the position across the object's own axis (m); None if it equals `position_sd_m`."""
    hazard_lights: bool | None = None
    emergency_lights: bool | None = None
    brake_lights: bool | None = None
    door_open: bool | None = None
    """True if an open door is detected; False if none is; None if perception cannot determine it."""
    gesture: Gesture | None = None
    """Signal of a flagger; None for all other objects, and if perception cannot determine it."""
