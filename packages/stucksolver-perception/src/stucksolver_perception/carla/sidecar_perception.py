"""A vehicle in another process with its own perception: perception, its driver and the solver's stack run here."""

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
"""The vehicle stands this long until its pose is accurate, as before each drive of an evaluation."""
DRIVERS = {"behavior": BehaviorDriver, "planner": PlannerDriver}
WAITS = [0.0, 0.0, 1.0, False, False]
"""The fields of a control: throttle, steering, brake, reverse, hand brake."""
Order = tuple[str, Any]


class SidecarPerception(RemoteStack):
    """A stack with its own perception. Raises `RigError`, `WeightsError` or `SensorError` when created, and
    `UnusableError` from `begin`.

    `looks`: a reasoner uses the camera's image.
    """

    def __init__(
        self, opening: Mapping[str, Any], settings: SessionSettings, ask: Callable[[str], Any], looks: bool
    ) -> None:
        rig = rig_of(opening["sensors"], load_rig(settings.rig or SHIPPED))
        self._settings, self._looks = settings, looks
        self._orders: list[Order] = []
        self._events: list[dict[str, Any]] = []
        self._world = _World(opening)
        ego: Any = _Ego(self._world, opening, self._orders)
        source = SharedMeasurements(opening, rig, ask, self._world, settings.seed)
        self.eyes = EgoPerception(ego, self._world.get_map(), rig, paced=settings.clock != "wall", source=source)
        self._route = [RoutePoint(*point) for point in waypoints_at(self._world.get_map(), opening["route"])]
        self._stack: CarlaStack | None = None
        self._ticks = 0
        self._wrong: tuple[str, ...] = ()

    def begin(self, tick: Mapping[str, Any]) -> bool:
        """Take a tick; False as long as the vehicle's position is not known well enough."""
        self._world.turn_to(tick)
        try:
            self.eyes.tick()
        except SensorError as error:
            raise UnusableError(str(error)) from error
        self._tell_faults()
        self._ticks += 1
        if self._stack is None and self._ticks > SETTLE_TICKS:
            self._stack = self._made()
        return self._stack is not None

    def status(self, tick: Mapping[str, Any]) -> Status:
        """Return the status, from the estimated pose."""
        return self._driven.status()

    def surroundings(self) -> Surroundings:
        """Return the surroundings as perceived."""
        return self._driven.surroundings()

    def scene(self, seen: Surroundings) -> Scene | None:
        """Return the scene for reasoners."""
        return None if self._stack is None else self._stack.scene(seen)

    def perform(self, directive: Directive) -> list[Order]:
        """Return this tick's control, which brakes if the vehicle is blind, and the other orders."""
        return self._given(self.eyes.checked(self._driven.perform(directive)))

    def waiting(self) -> list[Order]:
        """Return the orders before the vehicle can drive."""
        return [("control", WAITS)]

    def forget(self) -> None:
        """Do nothing: the other side keeps nothing, since each tick has its own control."""

    def events(self) -> list[dict[str, Any]]:
        """Return what happened to the sensors since the last call."""
        told, self._events = self._events, []
        return told

    def close(self) -> None:
        """End the drive."""
        self.eyes.close()

    @property
    def _driven(self) -> CarlaStack:
        assert self._stack is not None
        return self._stack

    def _made(self) -> CarlaStack:
        ego, carla_map = self.eyes.vehicle, self._world.get_map()
        driver = DRIVERS[self._settings.driver](ego, self._settings.behavior, carla_map=carla_map)  # type: ignore[arg-type]
        driver.set_route(self._route)
        return CarlaStack(ego, driver, carla_map, camera=self.eyes.camera() if self._looks else None)

    def _given(self, control: Any) -> list[Order]:
        told = [float(control.throttle), float(control.steer), float(control.brake)]
        orders, self._orders[:] = list(self._orders), []
        return [*orders, ("control", [*told, bool(control.reverse), bool(control.hand_brake)])]

    def _tell_faults(self) -> None:
        """Report failing sensors, once for each change."""
        wrong = (*self.eyes.health.faults, *(("nothing has been seen for too long",) if self._is_blind else ()))
        if wrong != self._wrong:
            text = "; ".join(wrong) or "all sensors work again"
            self._events.append({"time_s": self.eyes.now_s, "kind": "perception", "text": text, "verdict": None})
        self._wrong = wrong

    @property
    def _is_blind(self) -> bool:
        return self._stack is not None and self.eyes.blind


class _World:
    """The part of `carla.World` that `EgoPerception` and `SensedWorld` use: time, and the map's static objects."""

    def __init__(self, opening: Mapping[str, Any]) -> None:
        self._map = carla.Map(opening["map"], opening["xodr"])
        self._lights = [_Light(self._map, told) for told in opening["lights"]]
        self._signs = [MirrorSign(*sign) for sign in opening["stop_signs"]]
        self.limit_kmh, self.lamps = 0.0, 0
        self.time_s, self._delta_s, self._frame = 0.0, 0.05, 0
        self.turn_to(opening["tick"])

    def turn_to(self, tick: Mapping[str, Any]) -> None:
        """Start another tick."""
        self.time_s, self._frame = float(tick["time"]), int(tick["frame"])
        self._delta_s = float(tick["delta"])
        self.limit_kmh, self.lamps = float(tick["limit"]), int(tick["lamps"])

    def get_map(self) -> Any:
        """Return the `carla.Map`, created here from the other side's OpenDRIVE."""
        return self._map

    def get_snapshot(self) -> Any:
        """Return time and frame of this tick."""
        stamp = SimpleNamespace(elapsed_seconds=self.time_s, delta_seconds=self._delta_s)
        return SimpleNamespace(frame=self._frame, timestamp=stamp)

    def get_actors(self) -> Any:
        """Return the map's static objects, to be filtered."""
        kinds: dict[str, Sequence[Any]] = {"traffic_light": self._lights, "traffic.stop": self._signs}
        return SimpleNamespace(filter=lambda pattern: list(kinds.get(pattern.strip("*"), ())))


class _Light:
    """The counterpart of `carla.TrafficLight`: its position, stop lines and heads, but not its state."""

    def __init__(self, carla_map: carla.Map, told: Mapping[str, Any]) -> None:
        self._map, self._stops = carla_map, told["stops"]
        self.id = int(told["id"])
        x, y, z, pitch, yaw, roll = told["at"]
        self._at = carla.Transform(carla.Location(x, y, z), carla.Rotation(pitch=pitch, yaw=yaw, roll=roll))
        self.trigger_volume = _box(told["volume"])
        self._heads = []
        for head in told["heads"]:
            box = _box(head[:6])
            box.rotation = carla.Rotation(yaw=head[6])
            self._heads.append(box)

    def get_stop_waypoints(self) -> list[Any]:
        """Waypoints of its stop lines that lie on a road."""
        found = (waypoint_at(self._map, place) for place in self._stops)
        return [waypoint for waypoint in found if waypoint is not None]

    def get_light_boxes(self) -> list[Any]:
        """Return the boxes of its heads in the world."""
        return self._heads

    def get_transform(self) -> Any:
        """Return its transform."""
        return self._at


class _Ego:
    """The part of `carla.Vehicle` that a vehicle knows by itself: size, wheels, lamps and limit, but no pose or
    motion.
    """

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
        """Return the world that it is in."""
        return self._world

    def get_location(self) -> Any:
        """Return the start of its route: only the road's height there is used, which is known like the route."""
        return carla.Location(0.0, 0.0, self._height_m)

    def get_physics_control(self) -> Any:
        """Wheels and axles."""
        return self._physics

    def get_speed_limit(self) -> float:
        """Return the lane's speed limit (km/h)."""
        return self._world.limit_kmh

    def get_light_state(self) -> Any:
        """Its own lamps."""
        return carla.VehicleLightState(self._world.lamps)

    def set_light_state(self, state: Any, /) -> None:
        """Order lamps; they are set with the answer to this tick."""
        self._orders.append(("lights", int(state)))


def _box(numbers: Sequence[float]) -> Any:
    """Return a `carla.BoundingBox` from its center and half sizes."""
    return carla.BoundingBox(carla.Location(*numbers[:3]), carla.Vector3D(*numbers[3:6]))
