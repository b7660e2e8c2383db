"""What is asked of the ego and of its world: the part of the `carla` client that a mirror must offer, too."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    import carla


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
