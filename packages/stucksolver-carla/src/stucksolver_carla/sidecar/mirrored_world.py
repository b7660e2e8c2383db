"""A CARLA world mirrored over a bridge: vehicle, world, lights and driver for `CarlaStack`, without a client.

The map is read offline from the OpenDRIVE text; everything else comes as raw facts, requested when they are needed.
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
    """The pose and motion of an actor on one tick: x, y, z, pitch, yaw, roll, vx, vy, vz in CARLA's units."""

    def __init__(self, actor_id: int, row: Sequence[float]) -> None:
        self.id = actor_id
        self._row = row

    def get_transform(self) -> Any:
        """`carla.Transform` of this tick."""
        x, y, z, pitch, yaw, roll = self._row[:6]
        return carla.Transform(carla.Location(x=x, y=y, z=z), carla.Rotation(pitch=pitch, yaw=yaw, roll=roll))

    def get_location(self) -> Any:
        """`carla.Location` of this tick."""
        return carla.Location(*self._row[:3])

    def get_velocity(self) -> Any:
        """`carla.Vector3D` of this tick (m/s)."""
        return carla.Vector3D(*self._row[6:9])


class MirrorWorld:
    """Snapshots, actors and lights."""

    def __init__(self, opening: dict[str, Any], ask: Ask) -> None:
        self._ask = ask
        self.map = carla.Map(opening["map"], opening["xodr"])
        self._kinds: dict[int, Any] = {}
        self._at: dict[int, MirrorActor] = {}
        self._states: dict[str, str] = {}
        self._fresh = False
        self.time_s, self.frame = 0.0, 0
        self._lights = [MirrorLight(self, str(i), places) for i, places in opening["lights"]]
        self._signs = [MirrorSign(*sign) for sign in opening["stop_signs"]]
        self._ego: MirrorVehicle | None = None

    def carries(self, ego: MirrorVehicle) -> None:
        """The ego, which every tick reports."""
        self._ego = ego

    def turn_to(self, tick: dict[str, Any]) -> None:
        """Start another tick; what is around is requested when it is needed."""
        self._note(tick)
        self._fresh = False

    def _note(self, tick: dict[str, Any]) -> None:
        self.time_s, self.frame = float(tick["time"]), int(tick["frame"])
        if self._ego is not None:
            self._ego.turn_to(tick)

    # ---- as carla.World has them

    def get_map(self) -> Any:
        """Return the `carla.Map`, created here from the other side's OpenDRIVE."""
        return self.map

    def get_snapshot(self) -> MirrorSnapshot:
        """Return the snapshot of this tick."""
        return MirrorSnapshot(self)

    def get_actors(self, ids: Sequence[int] | None = None) -> Any:
        """Return actors by id, or a list of the static ones to be filtered."""
        if ids is None:
            return SimpleNamespace(filter=self._standing)
        return [self._kinds[i] for i in ids if i in self._kinds]

    def _standing(self, pattern: str) -> list[Any]:
        kinds: dict[str, list[Any]] = {"traffic_light": [*self._lights], "traffic.stop": [*self._signs]}
        return kinds.get(pattern.strip("*"), [])

    def get_vehicles_light_states(self) -> dict[int, int]:
        """Return the light states of all vehicles by id; asks the other side."""
        return {int(i): state for i, state in (self._ask("vehicle_lights") or {}).items()}

    # ---- asked for once a tick

    def actors(self) -> dict[int, MirrorActor]:
        """The moving actors of this tick, by id."""
        self.look()
        return self._at

    def light_state(self, light: str) -> Any:
        """Return the `carla.TrafficLightState` of a light by name; Unknown if the other side has not reported it."""
        self.look()
        name = self._states.get(light, "Unknown")
        return getattr(carla.TrafficLightState, name, carla.TrafficLightState.Unknown)

    def look(self) -> None:
        """Ask what is around, once per tick. If the answer is of a later tick, everything is set to that tick."""
        if self._fresh:
            return
        self._fresh = True
        told = self._ask("actors")
        self._at = {int(row[0]): MirrorActor(int(row[0]), row[1:]) for row in told["at"]}
        self._kinds = {i: kind for i, kind in self._kinds.items() if i in self._at}
        self._kinds.update({int(i): _actor(int(i), kind) for i, kind in told["new"].items()})
        self._states = told["states"]
        self._note(told["tick"])


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
        """Waypoints of its stop lines that lie on a road."""
        found = [waypoint_at(self._world.map, place) for place in self._places]
        return [waypoint for waypoint in found if waypoint is not None]

    def get_state(self) -> Any:
        """`carla.TrafficLightState` of this tick."""
        return self._world.light_state(self._name)


class MirrorSign:
    """The counterpart of `carla.TrafficSign`: its transform, and its trigger box in its own frame."""

    def __init__(self, stands: Sequence[float], middle: Sequence[float], half: Sequence[float]) -> None:
        self._place = MirrorActor(0, stands)
        self.trigger_volume = carla.BoundingBox(carla.Location(*middle), carla.Vector3D(*half))

    def get_transform(self) -> Any:
        """`carla.Transform`; signs do not move."""
        return self._place.get_transform()


class MirrorVehicle(MirrorActor):
    """The ego. Setting its lights becomes an order."""

    def __init__(self, world: MirrorWorld, opening: dict[str, Any], ask: Ask, orders: list[Order]) -> None:
        super().__init__(int(opening["id"]), opening["tick"]["ego"])
        self._world, self._ask, self._orders = world, ask, orders
        self.bounding_box = carla.BoundingBox(carla.Location(), carla.Vector3D(*opening["extent"]))
        self._limit = float(opening["tick"]["limit"])
        world.carries(self)

    def turn_to(self, tick: dict[str, Any]) -> None:
        """Take the vehicle's part of a tick."""
        self._row, self._limit = tick["ego"], float(tick["limit"])

    def get_world(self) -> MirrorWorld:
        """Return the world that it is in."""
        return self._world

    def get_speed_limit(self) -> float:
        """km/h, as CARLA has it."""
        return self._limit

    def get_light_state(self) -> Any:
        """`carla.VehicleLightState`; asks the other side."""
        return carla.VehicleLightState(int(self._ask("light_state") or 0))

    def set_light_state(self, state: Any) -> None:
        """Order lights; they are set with the answer to this tick."""
        self._orders.append(("lights", int(state)))


class MirrorDriver:
    """A `Driver` whose commands become orders for the driver on the other side."""

    def __init__(self, world: MirrorWorld, ego: MirrorVehicle, opening: dict[str, Any], orders: list[Order]) -> None:
        self._world, self._ego, self._orders = world, ego, orders
        self.acceleration_mps2 = float(opening["acceleration"])
        self.route: Sequence[RoutePoint] = [RoutePoint(*point) for point in waypoints_at(world.map, opening["route"])]

    def set_destination(self, destination: Any, start: Any | None = None) -> None:
        """Plan a route here and order the other side's driver to take it."""
        origin = self._ego.get_location() if start is None else start
        self.route = trace_route(self._world.map, origin, destination)
        self._orders.append(("route", route_places(self.route)))

    def follow(self, path: Sequence[DrivePoint], reverse: bool = False, ignore: Collection[int] = frozenset()) -> None:
        """Order a path to be driven."""
        order = {"path": [list(point) for point in path], "reverse": reverse, "ignore": sorted(ignore)}
        self._orders.append(("follow", order))

    def hold(self, brake_mps2: float | None = None) -> None:
        """Order a stop, with a deceleration (m/s²) if one is given."""
        self._orders.append(("hold", brake_mps2))

    def release(self) -> None:
        """Hand the vehicle back to its own driver."""
        self._orders.append(("release", None))

    def run_step(self) -> None:
        """Not used: the pedals are on the other side."""

    def done(self) -> bool:
        """Always False: the other side knows when its route ends."""
        return False


def _actor(actor_id: int, kind: dict[str, Any]) -> Any:
    box = carla.BoundingBox(carla.Location(*kind["offset"]), carla.Vector3D(*kind["extent"]))
    box.rotation = carla.Rotation(yaw=kind["yaw"])
    return SimpleNamespace(
        id=actor_id, type_id=kind["type"], attributes=kind["attributes"], parent=None, bounding_box=box
    )
