"""The part of the `carla` client that is used for the ego, its world and its perception. A mirror must offer it,
too.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Protocol

from stucksolver.scene import EgoState, LaneSight, ObservedSign, TrackedObject
from stucksolver.scene.frenet import RoadFrame

if TYPE_CHECKING:
    import carla

    from stucksolver_carla.stack.contact import EgoFootprint


class WorldSource(Protocol):
    """The part of `carla.World` that is read."""

    def get_map(self) -> Any:
        """The `carla.Map`."""

    def get_snapshot(self) -> Any:
        """The `carla.WorldSnapshot` of this tick: the pose and velocity of every actor."""

    def get_actors(self, ids: Sequence[int] = ..., /) -> Any:
        """The actors with these ids, or all."""

    def get_vehicles_light_states(self) -> Any:
        """Lamps by vehicle id, as bits of `carla.VehicleLightState`."""


class EgoVehicle(Protocol):
    """The part of `carla.Vehicle` that is read, and its lights, which are also set."""

    @property
    def id(self) -> int:
        """Its actor id."""

    @property
    def bounding_box(self) -> carla.BoundingBox:
        """Its bounding box, in its own frame."""

    def get_world(self) -> Any:
        """The world, as in `WorldSource`."""

    def get_location(self) -> carla.Location:
        """Location of its origin."""

    def get_transform(self) -> carla.Transform:
        """Location and rotation."""

    def get_velocity(self) -> carla.Vector3D:
        """Its velocity in the world frame (m/s)."""

    def get_speed_limit(self) -> float:
        """Speed limit (km/h); 0 if none is known."""

    def get_light_state(self) -> Any:
        """A `carla.VehicleLightState`."""

    def set_light_state(self, light_state: Any, /) -> None:
        """Switch its lamps."""


class TrackedObjectSource(Protocol):
    """Tracks the objects around the ego: `Tracker` from the client, a sensed vehicle's from its sensors."""

    @property
    def pushes(self) -> bool:
        """True if the ego pushed something at the last look."""

    def watch(self, ego: EgoFootprint, now_s: float) -> object:
        """Look around and note who moves by itself; cheap."""

    def update(self, ego: EgoFootprint, now_s: float) -> tuple[TrackedObject, ...]:
        """Return everything within range of the ego, in the local frame."""

    def read_lights(self, now_s: float) -> None:
        """Refresh the lamps of all vehicles."""


class LaneSightSource(Protocol):
    """Says how far lanes are seen on one road geometry."""

    def of_lanes(self, ego: EgoState, ego_s: float, objects: tuple[TrackedObject, ...]) -> tuple[LaneSight, ...]:
        """Return, for each driving lane beside the ego, the length seen without a break, ahead and behind."""


class EgoPerceptionSource(Protocol):
    """What a vehicle with its own sensors provides."""

    perception: str
    """Name of the perception in records and results."""

    @property
    def position_sd_m(self) -> float:
        """Standard deviation of the ego's position in the worst direction (m)."""

    @property
    def signs(self) -> tuple[ObservedSign, ...]:
        """Words that were read on signs while the ego has been standing."""

    @property
    def why_blind(self) -> tuple[str, ...]:
        """Why nothing new is seen, as it was when that began; empty while the ego sees."""

    def age_s(self, now_s: float) -> float:
        """Age of the newest result's data (s)."""

    def tracker(self) -> TrackedObjectSource:
        """The tracked objects for the solver."""

    def sight_lines(self, frame: RoadFrame) -> LaneSightSource:
        """Says how far lanes are seen."""
