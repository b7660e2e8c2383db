"""Road around the ego: lanes along one reference line, read once per intervention.

All geometry is in the *local frame*: right-handed, meters, fixed during an intervention, with an origin that the stack
chooses. The reference line is the center of the lanes that the route follows, so a lane is a lateral offset from it.
"""

from enum import Enum

from pydantic import Field, model_validator

from stucksolver.scene.base_model import FrozenModel


class LaneKind(str, Enum):
    """Use of a lane."""

    DRIVING = "driving"
    BIKING = "biking"
    PARKING = "parking"
    SHOULDER = "shoulder"
    SIDEWALK = "sidewalk"


class LaneDirection(str, Enum):
    """Direction of travel relative to the route."""

    SAME = "same"
    OPPOSITE = "opposite"


class LineKind(str, Enum):
    """Painted line, as it applies to a vehicle on the route's side."""

    BROKEN = "broken"
    SOLID = "solid"
    KERB = "kerb"
    NONE = "none"


class ZoneKind(str, Enum):
    """Kind of a zone."""

    JUNCTION = "junction"
    CROSSWALK = "crosswalk"
    LEVEL_CROSSING = "level_crossing"
    KEEP_CLEAR = "keep_clear_area"
    """Stretch of a street that is marked to be kept clear, as in front of a fire station."""


class LaneStrip(FrozenModel):
    """Lane along the reference line, sampled at the stations of that line.

    Sample `i` belongs to reference sample `start + i`. Offsets are those of the lane's center (m), left positive.
    """

    id: str
    kind: LaneKind
    direction: LaneDirection
    start: int = Field(ge=0)
    offset_m: tuple[float, ...] = Field(min_length=1)
    width_m: tuple[float, ...] = Field(min_length=1)
    line: tuple[LineKind, ...] = Field(min_length=1)
    """Lines between this lane and its neighbor nearer to the route (own lane: `none`)."""
    speed_limit_mps: float | None = None

    @model_validator(mode="after")
    def _same_length(self) -> "LaneStrip":
        if not len(self.offset_m) == len(self.width_m) == len(self.line):
            raise ValueError(f"lane {self.id}: offset_m, width_m and line must have one value for each station")
        return self


class Zone(FrozenModel):
    """Stretch of the route with its own rules, between two arc lengths along the route (m)."""

    kind: ZoneKind
    start_m: float
    end_m: float


class RoadGeometry(FrozenModel):
    """Lanes and zones along a stretch of the route, ahead of and behind the ego."""

    key: str
    """Key that changes whenever the geometry does, so that derived values can be cached."""
    spacing_m: float = Field(gt=0)
    reference: tuple[tuple[float, float], ...] = Field(min_length=2)
    """(x, y) of a point every `spacing_m`, in the direction of travel (m)."""
    lanes: tuple[LaneStrip, ...]
    zones: tuple[Zone, ...] = ()
    route_start_m: float = 0.0
    """Arc length along the whole route at the first sample (m). All arc lengths count from the start of the route."""
    destination_m: float | None = None
    """Arc length of the destination (m); None if it is beyond this stretch."""
    mirrored: bool = False
    """True on a road with left-hand traffic, whose whole local frame is mirrored (see `scene/mirror.py`)."""

    @model_validator(mode="after")
    def _lanes_lie_beside_it(self) -> "RoadGeometry":
        for lane in self.lanes:
            if lane.start + len(lane.offset_m) > len(self.reference):
                raise ValueError(f"lane {lane.id} has stations beyond the reference line's {len(self.reference)}")
        return self
