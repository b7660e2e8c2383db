"""What is asked of the ego, its world and its eyes: the part of the `carla` client that a mirror must offer, too."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Protocol

from stucksolver.scene import EgoState, LaneSight, TrackedObject
from stucksolver.scene.frenet import RoadFrame

if TYPE_CHECKING:
    import carla

    from stucksolver.stacks.carla_stack.contact import Footprint


class GivesWorld(Protocol):
    """A `carla.World`, as far as it is read."""

    def get_map(self) -> Any:
        """The `carla.Map`."""

    def get_snapshot(self) -> Any:
        """The `carla.WorldSnapshot` of this tick: everybody's place and velocity."""

    def get_actors(self, ids: Sequence[int] = ..., /) -> Any:
        """The actors with these ids, or all."""

    def get_vehicles_light_states(self) -> Any:
        """Lamps by vehicle id, as bits of `carla.VehicleLightState`."""


class EgoVehicle(Protocol):
    """A `carla.Vehicle`, as far as it is read, and its lights, which are set."""

    @property
    def id(self) -> int:
        """Its actor id."""

    @property
    def bounding_box(self) -> carla.BoundingBox:
        """In its own frame."""

    def get_world(self) -> Any:
        """What `GivesWorld` says."""

    def get_location(self) -> carla.Location:
        """Of its origin."""

    def get_transform(self) -> carla.Transform:
        """Place and rotation."""

    def get_velocity(self) -> carla.Vector3D:
        """World frame, m/s."""

    def get_speed_limit(self) -> float:
        """km/h; 0 where none is known."""

    def get_light_state(self) -> Any:
        """A `carla.VehicleLightState`."""

    def set_light_state(self, light_state: Any, /) -> None:
        """Switch its lamps."""


class TracksObjects(Protocol):
    """Tells of the objects around the ego; `Tracker` by the client's word, a sensed vehicle's by its sensors."""

    @property
    def pushes(self) -> bool:
        """Did the ego push something along at the last look?"""

    def watch(self, ego: Footprint, now_s: float) -> object:
        """Look around and note who moves by itself; cheap."""

    def update(self, ego: Footprint, now_s: float) -> tuple[TrackedObject, ...]:
        """Everything within range of the ego, in the local frame."""

    def read_lights(self, now_s: float) -> None:
        """Refresh the lamps of all vehicles."""


class SeesLanes(Protocol):
    """Tells how far lanes are seen, on one road geometry."""

    def of_lanes(self, ego: EgoState, ego_s: float, objects: tuple[TrackedObject, ...]) -> tuple[LaneSight, ...]:
        """For each driving lane beside the ego: the length seen without a break, ahead and behind."""


class OwnEyes(Protocol):
    """What a vehicle brings that sees by its own sensors."""

    perception: str
    """What records and results say of it."""

    @property
    def position_sd_m(self) -> float:
        """Standard deviation of the ego's place, in whichever direction it is largest."""

    def age_s(self, now_s: float) -> float:
        """Of the newest result's data."""

    def tracker(self) -> TracksObjects:
        """Objects for the solver."""

    def sight_lines(self, frame: RoadFrame) -> SeesLanes:
        """How far lanes are seen."""
