"""The data that the guard reads on every tick while a plan is pending or running."""

from enum import Enum

from pydantic import Field

from stucksolver.scene.base_model import FrozenModel
from stucksolver.scene.objects import TrackedObject
from stucksolver.scene.road import RoadGeometry


class LightState(str, Enum):
    """What a traffic light shows."""

    RED = "red"
    YELLOW = "yellow"
    GREEN = "green"
    OFF = "off"
    UNKNOWN = "unknown"


class ControlKind(str, Enum):
    """What requires a vehicle to stop at a line."""

    TRAFFIC_LIGHT = "traffic_light"
    STOP_SIGN = "stop_sign"


class TrafficControl(FrozenModel):
    """A traffic light or sign ahead on the route."""

    kind: ControlKind
    distance_m: float
    """Distance along the route from the ego's front bumper to its stop line (m); negative once passed."""
    applies: bool | None
    """True if it governs the ego's lane and direction; None if unknown."""
    state: LightState | None = None
    """Set only for a light."""


class VehicleLimits(FrozenModel):
    """The vehicle's limits that the guard assumes."""

    wheelbase_m: float = 2.9
    min_turn_radius_m: float = 6.0
    comfort_acceleration_mps2: float = 1.5
    comfort_braking_mps2: float = 3.0
    max_braking_mps2: float = 6.0
    max_lateral_acceleration_mps2: float = 2.5
    measured_acceleration_mps2: float | None = Field(default=None, gt=0)
    """Acceleration from rest that the vehicle has shown, less its spread (m/s²); None if it was not measured."""


class EgoState(FrozenModel):
    """The ego in the local frame. `x_m, y_m` is the centre of its bounding box."""

    x_m: float
    y_m: float
    yaw_rad: float
    speed_mps: float = Field(description="along the heading; negative in reverse")
    length_m: float = Field(gt=0)
    width_m: float = Field(gt=0)
    limits: VehicleLimits = VehicleLimits()
    position_sd_m: float | None = Field(default=None, ge=0)
    """Standard deviation of its position across the road (m); None if localisation is exact."""


class LaneSight(FrozenModel):
    """How far a lane is *seen* along the reference line, from the ego's centre ahead and behind (m)."""

    lane_id: str
    ahead_m: float
    behind_m: float


class Surroundings(FrozenModel):
    """The output of perception for one tick, in the local frame of its `road`."""

    frame: int
    """Number of the sensor data: another one for new data, the same for the same data."""
    time_s: float
    """Time of the sensor data, on the clock of `Status.time_s` (s). Behind that clock, it counts as an age."""
    age_s: float = 0.0
    """Age of the sensor data when the stack hands them over (s)."""
    sensor_faults: tuple[str, ...] = ()
    """Why nothing new is seen, if the stack knows: each failed sensor, in a few words for people."""
    ego: EgoState
    objects: tuple[TrackedObject, ...]
    controls: tuple[TrafficControl, ...] = ()
    sight: tuple[LaneSight, ...] = ()
    """Lanes that are not listed are not seen at all."""
    road: RoadGeometry
