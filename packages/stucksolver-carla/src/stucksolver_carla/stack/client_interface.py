"""Defines the part of the `carla` client that is used for the ego, its world and its perception."""

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
        """Return the `carla.Map`."""

    def get_snapshot(self) -> Any:
        """Return the `carla.WorldSnapshot` of this tick: the pose and velocity of every actor."""

    def get_actors(self, ids: Sequence[int] = ..., /) -> Any:
        """Return the actors with these ids, or all."""

    def get_vehicles_light_states(self) -> Any:
        """Return the lamps by vehicle id, as bits of `carla.VehicleLightState`."""


class EgoVehicle(Protocol):
    """The part of `carla.Vehicle` that is read, and its lights, which are also set."""

    @property
    def id(self) -> int:
        """The ego's actor id."""

    @property
    def bounding_box(self) -> carla.BoundingBox:
        """The ego's bounding box, in the actor's frame."""

    def get_world(self) -> Any:
        """Return the world, as in `WorldSource`."""

    def get_location(self) -> carla.Location:
        """Return the location of the actor's origin."""

    def get_transform(self) -> carla.Transform:
        """Return location and rotation."""

    def get_velocity(self) -> carla.Vector3D:
        """Return the velocity in the world frame (m/s)."""

    def get_speed_limit(self) -> float:
        """Return the speed limit (km/h); 0 without one."""

    def get_light_state(self) -> Any:
        """Return the `carla.VehicleLightState`."""

    def set_light_state(self, light_state: Any, /) -> None:
        """Switch the ego's lamps."""


class TrackedObjectSource(Protocol):
    """Tracks the objects around the ego: `Tracker` from the client, a sensor-based tracker from its sensors."""

    @property
    def pushes(self) -> bool:
        """True if the ego pushed an object at the last update."""

    def watch(self, ego: EgoFootprint, now_s: float) -> object:
        """Update which objects move by themselves. The call is cheap."""

    def update(self, ego: EgoFootprint, now_s: float) -> tuple[TrackedObject, ...]:
        """Return all objects within range of the ego, in the local frame."""

    def read_lights(self, now_s: float) -> None:
        """Read the lamps of all vehicles."""


class LaneSightSource(Protocol):
    """Computes the sight distances of lanes on one road geometry."""

    def of_lanes(self, ego: EgoState, ego_s: float, objects: tuple[TrackedObject, ...]) -> tuple[LaneSight, ...]:
        """Return the uninterrupted sight distances ahead and behind, for each driving lane next to the ego."""


class EgoPerceptionSource(Protocol):
    """The part of sensor-based perception that describes the ego to the solver."""

    perception: str
    """Name of the perception in records and results."""

    @property
    def position_sd_m(self) -> float:
        """Standard deviation of the ego's position in the worst direction (m)."""

    @property
    def signs(self) -> tuple[ObservedSign, ...]:
        """Words read on signs since the ego stopped."""

    @property
    def why_blind(self) -> tuple[str, ...]:
        """Sensor faults at the time when perception stopped giving results; empty while it gives them."""

    def age_s(self, now_s: float) -> float:
        """Return the age of the newest result's data (s)."""

    def tracker(self) -> TrackedObjectSource:
        """Return a tracker of the objects for the solver."""

    def sight_lines(self, frame: RoadFrame) -> LaneSightSource:
        """Return the source of sight distances for one road."""
