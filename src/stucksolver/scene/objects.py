"""Objects that a perception system tracks."""

from enum import Enum

from pydantic import Field

from stucksolver.scene.model import Model


class ObjectKind(str, Enum):
    """What an object is; `unknown` where perception cannot tell."""

    CAR = "car"
    VAN = "van"
    TRUCK = "truck"
    BUS = "bus"
    EMERGENCY = "emergency"
    MOTORCYCLE = "motorcycle"
    BICYCLE = "bicycle"
    PEDESTRIAN = "pedestrian"
    ANIMAL = "animal"
    CONE = "cone"
    BARRIER = "barrier"
    DEBRIS = "debris"
    PROP = "prop"
    UNKNOWN = "unknown"


MOTOR_VEHICLES = frozenset(
    {
        ObjectKind.CAR,
        ObjectKind.VAN,
        ObjectKind.TRUCK,
        ObjectKind.BUS,
        ObjectKind.EMERGENCY,
        ObjectKind.MOTORCYCLE,
    }
)
VULNERABLE = frozenset({ObjectKind.PEDESTRIAN, ObjectKind.BICYCLE, ObjectKind.ANIMAL})
"""Vulnerable road users: passed with a wider clearance."""
STATIC_KINDS = frozenset({ObjectKind.CONE, ObjectKind.BARRIER, ObjectKind.DEBRIS, ObjectKind.PROP})


class TrackedObject(Model):
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
    """For how long it has been seen standing (below 0.1 m/s); 0 while it moves; None where not tracked."""
    moved_s_ago: float | None = None
    """Since when it has not been seen moving, None if it never was."""
    hazard_lights: bool | None = None
    brake_lights: bool | None = None
