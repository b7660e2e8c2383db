"""Mirrors a CARLA world over a bridge: vehicle, world, lights and driver for `CarlaStack`, without a client.

The map is read offline from the OpenDRIVE text. All other data are raw numbers that are requested on first use.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from types import SimpleNamespace
from typing import Any

import carla

from stucksolver_bridge.world_data import route_places, waypoint_at, waypoints_at
from stucksolver_carla.drivers.behavior import DrivePoint, RoutePoint
from stucksolver_carla.drivers.behavior.routing import trace_route

Ask = Callable[[str], Any]
Order = tuple[str, Any]


class MirrorActor:
    """An actor on one tick. `row`: x, y, z, pitch, yaw, roll, vx, vy, vz in CARLA's world frame and units."""

    def __init__(self, actor_id: int, row: Sequence[float]) -> None:
        self.id = actor_id
        self._row = row

    def get_transform(self) -> Any:
        """Return the `carla.Transform` of this tick."""
        x, y, z, pitch, yaw, roll = self._row[:6]
        return carla.Transform(carla.Location(x=x, y=y, z=z), carla.Rotation(pitch=pitch, yaw=yaw, roll=roll))

    def get_location(self) -> Any:
        """Return the `carla.Location` of this tick."""
        return carla.Location(*self._row[:3])

    def get_velocity(self) -> Any:
        """Return the velocity of this tick as a `carla.Vector3D` (m/s)."""
        return carla.Vector3D(*self._row[6:9])


class MirrorWorld:
    """The counterpart of `carla.World`: snapshots, actors and lights."""

    def __init__(self, opening: dict[str, Any], ask: Ask) -> None:
        self._ask = ask
        self.map = carla.Map(opening["map"], opening["xodr"])
        self._descriptions: dict[int, Any] = {}
        self._actors: dict[int, MirrorActor] = {}
        self._states: dict[str, str] = {}
        self._is_current = False
        self.time_s, self.frame = 0.0, 0
        self._lights = [MirrorLight(self, str(i), places) for i, places in opening["lights"]]
        self._signs = [MirrorSign(*sign) for sign in opening["stop_signs"]]
        self._ego: MirrorVehicle | None = None

    def set_ego(self, ego: MirrorVehicle) -> None:
        """Set the ego, whose pose comes with every tick."""
        self._ego = ego

    def start_tick(self, tick: dict[str, Any]) -> None:
        """Start another tick. Its actors are requested on first use."""
        self._set_tick(tick)
        self._is_current = False

    def _set_tick(self, tick: dict[str, Any]) -> None:
        self.time_s, self.frame = float(tick["time"]), int(tick["frame"])
        if self._ego is not None:
            self._ego.start_tick(tick)

    # ---- methods of carla.World

    def get_map(self) -> Any:
        """Return the `carla.Map`, created in this process from the stack's OpenDRIVE text."""
        return self.map

    def get_snapshot(self) -> MirrorSnapshot:
        """Return the snapshot of this tick."""
        return MirrorSnapshot(self)

    def get_actors(self, ids: Sequence[int] | None = None) -> Any:
        """Return actors by id, or a list of the static ones to be filtered."""
        if ids is None:
            return SimpleNamespace(filter=self._standing)
        return [self._descriptions[i] for i in ids if i in self._descriptions]

    def _standing(self, pattern: str) -> list[Any]:
        kinds: dict[str, list[Any]] = {"traffic_light": [*self._lights], "traffic.stop": [*self._signs]}
        return kinds.get(pattern.strip("*"), [])

    def get_vehicles_light_states(self) -> dict[int, int]:
        """Return the light states of all vehicles by id; asks the other side."""
        return {int(i): state for i, state in (self._ask("vehicle_lights") or {}).items()}

    # ---- requested once per tick

    def actors(self) -> dict[int, MirrorActor]:
        """Return the moving actors of this tick, by id."""
        self.request_actors()
        return self._actors

    def light_state(self, light: str) -> Any:
        """Return the `carla.TrafficLightState` of a light by name; Unknown if the stack has not reported it."""
        self.request_actors()
        name = self._states.get(light, "Unknown")
        return getattr(carla.TrafficLightState, name, carla.TrafficLightState.Unknown)

    def request_actors(self) -> None:
        """Request the actors, once per tick. If the answer is from a later tick, the world is set to that tick."""
        if self._is_current:
            return
        self._is_current = True
        data = self._ask("actors")
        self._actors = {int(row[0]): MirrorActor(int(row[0]), row[1:]) for row in data["at"]}
        self._descriptions = {i: description for i, description in self._descriptions.items() if i in self._actors}
        self._descriptions.update({int(i): _actor(int(i), description) for i, description in data["new"].items()})
        self._states = data["states"]
        self._set_tick(data["tick"])


class MirrorSnapshot:
    """The counterpart of `carla.WorldSnapshot`."""

    def __init__(self, world: MirrorWorld) -> None:
        self._world = world
        self.frame = world.frame
        self.timestamp = SimpleNamespace(elapsed_seconds=world.time_s)

    def __iter__(self) -> Iterator[MirrorActor]:
        return iter(self._world.actors().values())

    def find(self, actor_id: int) -> MirrorActor | None:
        """Return an actor of this tick; None if it no longer exists."""
        return self._world.actors().get(actor_id)


class MirrorLight:
    """The counterpart of `carla.TrafficLight`."""

    def __init__(self, world: MirrorWorld, name: str, places: Sequence[Sequence[Any]]) -> None:
        self._world, self._name, self._places = world, name, places

    def get_stop_waypoints(self) -> list[Any]:
        """Return the waypoints of the light's stop lines that lie on a road."""
        waypoints = [waypoint_at(self._world.map, position) for position in self._places]
        return [waypoint for waypoint in waypoints if waypoint is not None]

    def get_state(self) -> Any:
        """Return the `carla.TrafficLightState` of this tick."""
        return self._world.light_state(self._name)


class MirrorSign:
    """The counterpart of `carla.TrafficSign`: its transform, and its trigger box in its own frame."""

    def __init__(self, pose: Sequence[float], center: Sequence[float], half: Sequence[float]) -> None:
        self._pose = MirrorActor(0, pose)
        self.trigger_volume = carla.BoundingBox(carla.Location(*center), carla.Vector3D(*half))

    def get_transform(self) -> Any:
        """Return the `carla.Transform`, which is constant."""
        return self._pose.get_transform()


class MirrorVehicle(MirrorActor):
    """The ego. `set_light_state` becomes an order for the stack."""

    def __init__(self, world: MirrorWorld, opening: dict[str, Any], ask: Ask, orders: list[Order]) -> None:
        super().__init__(int(opening["id"]), opening["tick"]["ego"])
        self._world, self._ask, self._orders = world, ask, orders
        self.bounding_box = carla.BoundingBox(carla.Location(), carla.Vector3D(*opening["extent"]))
        self._limit = float(opening["tick"]["limit"])
        world.set_ego(self)

    def start_tick(self, tick: dict[str, Any]) -> None:
        """Set the ego's pose, motion and speed limit from a tick."""
        self._row, self._limit = tick["ego"], float(tick["limit"])

    def get_world(self) -> MirrorWorld:
        """Return the ego's world."""
        return self._world

    def get_speed_limit(self) -> float:
        """Return the speed limit (km/h), as in CARLA."""
        return self._limit

    def get_light_state(self) -> Any:
        """Return the `carla.VehicleLightState`, which is requested from the stack."""
        return carla.VehicleLightState(int(self._ask("light_state") or 0))

    def set_light_state(self, state: Any) -> None:
        """Order a light state. The stack sets it with the answer to this tick."""
        self._orders.append(("lights", int(state)))


class MirrorDriver:
    """A `Driver` whose method calls become orders for the driver in the stack's process."""

    def __init__(self, world: MirrorWorld, ego: MirrorVehicle, opening: dict[str, Any], orders: list[Order]) -> None:
        self._world, self._ego, self._orders = world, ego, orders
        self.acceleration_mps2 = float(opening["acceleration"])
        self.route: Sequence[RoutePoint] = [RoutePoint(*point) for point in waypoints_at(world.map, opening["route"])]

    def set_destination(self, destination: Any, start: Any | None = None) -> None:
        """Plan a route in this process and order it for the stack's driver."""
        origin = self._ego.get_location() if start is None else start
        self.route = trace_route(self._world.map, origin, destination)
        self._orders.append(("route", route_places(self.route)))

    def follow(self, path: Sequence[DrivePoint], reverse: bool = False, ignore: Collection[int] = frozenset()) -> None:
        """Order a path."""
        order = {"path": [list(point) for point in path], "reverse": reverse, "ignore": sorted(ignore)}
        self._orders.append(("follow", order))

    def hold(self, brake_mps2: float | None = None) -> None:
        """Order a stop; a `brake_mps2` of None brakes as usual."""
        self._orders.append(("hold", brake_mps2))

    def release(self) -> None:
        """Order the hand-back of the ego to its driver."""
        self._orders.append(("release", None))

    def run_step(self) -> None:
        """Do nothing: the stack's driver computes the controls."""

    def done(self) -> bool:
        """Return False: the stack's driver detects the end of its route."""
        return False


def _actor(actor_id: int, description: dict[str, Any]) -> Any:
    box = carla.BoundingBox(carla.Location(*description["offset"]), carla.Vector3D(*description["extent"]))
    box.rotation = carla.Rotation(yaw=description["yaw"])
    return SimpleNamespace(
        id=actor_id, type_id=description["type"], attributes=description["attributes"], parent=None, bounding_box=box
    )
