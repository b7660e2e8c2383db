"""Data that the guard reads on every tick while a plan is pending or running."""

from enum import Enum

from pydantic import Field

from stucksolver.scene.base_model import FrozenModel
from stucksolver.scene.objects import TrackedObject
from stucksolver.scene.road import RoadGeometry


class LightState(str, Enum):
    """State of a traffic light."""

    RED = "red"
    YELLOW = "yellow"
    GREEN = "green"
    OFF = "off"
    UNKNOWN = "unknown"


class ControlKind(str, Enum):
    """Kind of a traffic control that requires a vehicle to stop at a line."""

    TRAFFIC_LIGHT = "traffic_light"
    STOP_SIGN = "stop_sign"


class TrafficControl(FrozenModel):
    """Traffic light or stop sign ahead on the route."""

    kind: ControlKind
    distance_m: float
    """Distance along the route from the ego's front bumper to the stop line (m); negative after passing it."""
    applies: bool | None
    """True if the control governs the ego's lane and direction; None if unknown."""
    state: LightState | None = None
    """State of a traffic light; None for a sign."""


class VehicleLimits(FrozenModel):
    """Limits of the vehicle that the guard assumes."""

    wheelbase_m: float = 2.9
    min_turn_radius_m: float = 6.0
    comfort_acceleration_mps2: float = 1.5
    comfort_braking_mps2: float = 3.0
    max_braking_mps2: float = 6.0
    max_lateral_acceleration_mps2: float = 2.5
    measured_acceleration_mps2: float | None = Field(default=None, gt=0)
    """Measured acceleration from rest, less its spread (m/s²); None if it was not measured."""


class EgoState(FrozenModel):
    """Ego in the local frame. `x_m, y_m` is the center of its bounding box."""

    x_m: float
    y_m: float
    yaw_rad: float
    speed_mps: float = Field(description="along the heading; negative in reverse")
    length_m: float = Field(gt=0)
    width_m: float = Field(gt=0)
    limits: VehicleLimits = VehicleLimits()
    position_sd_m: float | None = Field(default=None, ge=0)
    """Standard deviation of the position across the road (m); None if localization is exact."""


class LaneSight(FrozenModel):
    """Visible length of a lane along the reference line, from the ego's center ahead and behind (m)."""

    lane_id: str
    ahead_m: float
    behind_m: float


class Surroundings(FrozenModel):
    """Output of perception for one tick, in the local frame of its `road`."""

    frame: int
    """Number of the sensor data: equal for equal data, different for new data."""
    time_s: float
    """Time of the sensor data on the clock of `Status.time_s` (s). If it is behind that clock, it counts as an age."""
    age_s: float = 0.0
    """Age of the sensor data when the stack passes them to the solver (s)."""
    sensor_faults: tuple[str, ...] = ()
    """Failed sensors, each in a few words for people, if the stack reports them as the reason for missing data."""
    ego: EgoState
    objects: tuple[TrackedObject, ...]
    controls: tuple[TrafficControl, ...] = ()
    sight: tuple[LaneSight, ...] = ()
    """Sight distances. A lane without an entry counts as not visible."""
    road: RoadGeometry
