"""Runs perception, driver and stack of a vehicle in another process, which sends the measurements of its sensors."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import SimpleNamespace
from typing import Any

import carla

from stucksolver.plan.directive import Directive
from stucksolver.scene import Scene, Status, Surroundings
from stucksolver_bridge.world_data import waypoint_at, waypoints_at
from stucksolver_carla.drivers.behavior import BehaviorDriver, RoutePoint
from stucksolver_carla.drivers.planner import PlannerDriver
from stucksolver_carla.perception_interface import SensorError
from stucksolver_carla.remote_stack import RemoteStack, UnusableError
from stucksolver_carla.session_settings import SessionSettings
from stucksolver_carla.sidecar.mirrored_world import MirrorSign
from stucksolver_carla.stack import CarlaStack
from stucksolver_perception.carla import EgoPerception
from stucksolver_perception.carla.declared_sensors import rig_of
from stucksolver_perception.carla.shared_measurements import SharedMeasurements
from stucksolver_perception.rig import SHIPPED, load_rig

SETTLE_TICKS = 10
"""Number of ticks for which the vehicle waits until its pose is accurate, as before each run of an evaluation. Ours."""
DRIVERS = {"behavior": BehaviorDriver, "planner": PlannerDriver}
"""The drivers by their names in the settings."""
WAIT_CONTROL = [0.0, 0.0, 1.0, False, False]
"""The control while the vehicle waits: throttle, steering, brake, reverse, hand brake."""
Order = tuple[str, Any]


class SidecarPerception(RemoteStack):
    """A stack with sensor-based perception. `uses_image`: True if a reasoner uses the camera's image.

    The constructor raises `RigError`, `NetworkFileError` or `SensorError`, and `begin` raises `UnusableError`.
    """

    def __init__(
        self, opening: Mapping[str, Any], settings: SessionSettings, ask: Callable[[str], Any], uses_image: bool
    ) -> None:
        rig = rig_of(opening["sensors"], load_rig(settings.rig or SHIPPED))
        self._settings, self._uses_image = settings, uses_image
        self._orders: list[Order] = []
        self._events: list[dict[str, Any]] = []
        self._world = _World(opening)
        ego: Any = _Ego(self._world, opening, self._orders)
        source = SharedMeasurements(opening, rig, ask, self._world, settings.seed)
        self.perception = EgoPerception(ego, self._world.get_map(), rig, paced=settings.clock != "wall", source=source)
        self._route = [RoutePoint(*point) for point in waypoints_at(self._world.get_map(), opening["route"])]
        self._stack: CarlaStack | None = None
        self._ticks = 0
        self._reported_faults: tuple[str, ...] = ()

    def begin(self, tick: Mapping[str, Any]) -> bool:
        """Start a tick. Return False until the vehicle's pose is accurate."""
        self._world.start_tick(tick)
        try:
            self.perception.tick()
        except SensorError as error:
            raise UnusableError(str(error)) from error
        self._report_faults()
        self._ticks += 1
        if self._stack is None and self._ticks > SETTLE_TICKS:
            self._stack = self._make_stack()
        return self._stack is not None

    def status(self, tick: Mapping[str, Any]) -> Status:
        """Return the status, from the estimated pose."""
        return self._ready_stack.status()

    def surroundings(self) -> Surroundings:
        """Return the perceived surroundings."""
        return self._ready_stack.surroundings()

    def scene(self, surroundings: Surroundings) -> Scene | None:
        """Return the scene for reasoners."""
        return None if self._stack is None else self._stack.scene(surroundings)

    def in_map_frame(self, directive: Directive) -> Directive:
        """Return the directive with its path in the map's frame."""
        return self._ready_stack.in_map_frame(directive)

    def perform(self, directive: Directive) -> list[Order]:
        """Return this tick's control, which brakes if the newest result is too old, and the other orders."""
        return self._take_orders(self.perception.checked(self._ready_stack.perform(directive)))

    def waiting(self) -> list[Order]:
        """Return the orders until the vehicle can drive: the brake."""
        return [("control", WAIT_CONTROL)]

    def forget(self) -> None:
        """Do nothing, because each tick has its own control."""

    def events(self) -> list[dict[str, Any]]:
        """Return the sensor events since the last call."""
        values, self._events = self._events, []
        return values

    def close(self) -> None:
        """Close the perception."""
        self.perception.close()

    @property
    def _ready_stack(self) -> CarlaStack:
        assert self._stack is not None
        return self._stack

    def _make_stack(self) -> CarlaStack:
        ego, carla_map = self.perception.vehicle, self._world.get_map()
        driver = DRIVERS[self._settings.driver](ego, self._settings.behavior, carla_map=carla_map)  # type: ignore[arg-type]
        driver.set_route(self._route)
        return CarlaStack(ego, driver, carla_map, camera=self.perception.camera() if self._uses_image else None)

    def _take_orders(self, control: Any) -> list[Order]:
        values = [float(control.throttle), float(control.steer), float(control.brake)]
        orders, self._orders[:] = list(self._orders), []
        return [*orders, ("control", [*values, bool(control.reverse), bool(control.hand_brake)])]

    def _report_faults(self) -> None:
        """Report sensor faults, once for each change."""
        faults = (*self.perception.health.faults, *(("no result for too long",) if self._is_blind else ()))
        if faults != self._reported_faults:
            text = "; ".join(faults) or "all sensors work again"
            self._events.append({"time_s": self.perception.now_s, "kind": "perception", "text": text, "verdict": None})
        self._reported_faults = faults

    @property
    def _is_blind(self) -> bool:
        return self._stack is not None and self.perception.blind


class _World:
    """The part of `carla.World` that `EgoPerception` and `PerceivedWorld` use: time, and the map's static objects."""

    def __init__(self, opening: Mapping[str, Any]) -> None:
        self._map = carla.Map(opening["map"], opening["xodr"])
        self._lights = [_Light(self._map, values) for values in opening["lights"]]
        self._signs = [MirrorSign(*sign) for sign in opening["stop_signs"]]
        self.limit_kmh, self.lamps = 0.0, 0
        self.time_s, self._delta_s, self._frame = 0.0, 0.05, 0
        self.start_tick(opening["tick"])

    def start_tick(self, tick: Mapping[str, Any]) -> None:
        """Start another tick."""
        self.time_s, self._frame = float(tick["time"]), int(tick["frame"])
        self._delta_s = float(tick["delta"])
        self.limit_kmh, self.lamps = float(tick["limit"]), int(tick["lamps"])

    def get_map(self) -> Any:
        """Return the `carla.Map`, created in this process from the stack's OpenDRIVE text."""
        return self._map

    def get_snapshot(self) -> Any:
        """Return time and frame of this tick."""
        stamp = SimpleNamespace(elapsed_seconds=self.time_s, delta_seconds=self._delta_s)
        return SimpleNamespace(frame=self._frame, timestamp=stamp)

    def get_actors(self) -> Any:
        """Return the map's static objects, with a filter."""
        kinds: dict[str, Sequence[Any]] = {"traffic_light": self._lights, "traffic.stop": self._signs}
        return SimpleNamespace(filter=lambda pattern: list(kinds.get(pattern.strip("*"), ())))


class _Light:
    """The counterpart of `carla.TrafficLight`, with position, stop lines and heads, but without a state."""

    def __init__(self, carla_map: carla.Map, values: Mapping[str, Any]) -> None:
        self._map, self._stop_positions = carla_map, values["stops"]
        self.id = int(values["id"])
        x, y, z, pitch, yaw, roll = values["at"]
        self._transform = carla.Transform(carla.Location(x, y, z), carla.Rotation(pitch=pitch, yaw=yaw, roll=roll))
        self.trigger_volume = _box(values["volume"])
        self._heads = []
        for head in values["heads"]:
            box = _box(head[:6])
            box.rotation = carla.Rotation(yaw=head[6])
            self._heads.append(box)

    def get_stop_waypoints(self) -> list[Any]:
        """Return the waypoints of the light's stop lines that lie on a road."""
        waypoints = (waypoint_at(self._map, position) for position in self._stop_positions)
        return [waypoint for waypoint in waypoints if waypoint is not None]

    def get_light_boxes(self) -> list[Any]:
        """Return the boxes of the light's heads in the world frame."""
        return self._heads

    def get_transform(self) -> Any:
        """Return the light's transform."""
        return self._transform


class _Ego:
    """The part of `carla.Vehicle` without pose and motion: size, wheels, lamps and speed limit."""

    def __init__(self, world: _World, opening: Mapping[str, Any], orders: list[Order]) -> None:
        self._world, self._orders = world, orders
        self._height_m = float(opening["height"])
        self.id = int(opening["id"])
        self.bounding_box = _box(opening["box"])
        wheels = [
            SimpleNamespace(position=carla.Vector3D(*item[:3]), max_steer_angle=item[3]) for item in opening["wheels"]
        ]
        self._physics = SimpleNamespace(wheels=wheels)

    def get_world(self) -> _World:
        """Return the vehicle's world."""
        return self._world

    def get_location(self) -> Any:
        """Return a location at the height of the route's start. Only the height is used; it comes with the route."""
        return carla.Location(0.0, 0.0, self._height_m)

    def get_physics_control(self) -> Any:
        """Return wheels and axles."""
        return self._physics

    def get_speed_limit(self) -> float:
        """Return the lane's speed limit (km/h)."""
        return self._world.limit_kmh

    def get_light_state(self) -> Any:
        """Return the vehicle's lamps."""
        return carla.VehicleLightState(self._world.lamps)

    def set_light_state(self, state: Any, /) -> None:
        """Order a light state. The bridge sets it with the answer to this tick."""
        self._orders.append(("lights", int(state)))


def _box(numbers: Sequence[float]) -> Any:
    """Return a `carla.BoundingBox` from its center and half sizes."""
    return carla.BoundingBox(carla.Location(*numbers[:3]), carla.Vector3D(*numbers[3:6]))
