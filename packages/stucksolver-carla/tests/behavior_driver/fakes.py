"""A world without a server: a kinematic bicycle and boxes on a real `carla.Map`, with just what the driver asks."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import carla

TICK_S = 0.05
STEER_LOCK_RAD = math.radians(42.0)
WHEELBASE_M = 2.9
HALF_SIZE_M = (2.35, 1.0, 0.75)
STEER_LAG_S = 0.1


def box(half_x: float, half_y: float, half_z: float) -> Any:
    """A bounding box standing on its actor's origin."""
    return carla.BoundingBox(carla.Location(z=half_z), carla.Vector3D(half_x, half_y, half_z))


@dataclass
class FakeActor:
    """A box that moves straight on at constant velocity."""

    world: FakeWorld
    id: int
    type_id: str
    x: float
    y: float
    yaw: float
    """Radians."""
    speed: float = 0.0
    bounding_box: Any = field(default_factory=lambda: box(*HALF_SIZE_M))
    z: float = 0.0
    parent: Any = None
    state: Any = None
    stops: list[Any] = field(default_factory=list)

    def get_transform(self) -> Any:
        return carla.Transform(carla.Location(self.x, self.y, self.z), carla.Rotation(yaw=math.degrees(self.yaw)))

    def get_location(self) -> Any:
        return self.get_transform().location

    def get_velocity(self) -> Any:
        return carla.Vector3D(self.speed * math.cos(self.yaw), self.speed * math.sin(self.yaw), 0.0)

    def get_world(self) -> FakeWorld:
        return self.world

    def get_stop_waypoints(self) -> list[Any]:
        return self.stops

    def advance(self) -> None:
        self.x += self.speed * math.cos(self.yaw) * TICK_S
        self.y += self.speed * math.sin(self.yaw) * TICK_S


@dataclass
class FakeCar(FakeActor):
    """The ego: a bicycle whose origin is the body's center, with a lag in the steering."""

    throttle: float = 0.0
    brake: float = 0.0
    steer: float = 0.0
    wheel: float = 0.0
    yaw_rate: float = 0.0
    acceleration: float = 0.0
    speed_limit: float = 50.0

    def apply_control(self, control: Any) -> None:
        self.throttle, self.brake, self.steer = control.throttle, control.brake, control.steer

    def get_angular_velocity(self) -> Any:
        return carla.Vector3D(0.0, 0.0, math.degrees(self.yaw_rate))

    def get_velocity(self) -> Any:
        course = self.yaw + self._slip()
        return carla.Vector3D(self.speed * math.cos(course), self.speed * math.sin(course), 0.0)

    def get_physics_control(self) -> Any:
        wheels = [SimpleNamespace(max_steer_angle=a, position=carla.Vector3D()) for a in (70.0, 70.0, 0.0, 0.0)]
        return SimpleNamespace(wheels=wheels)

    def get_speed_limit(self) -> float:
        return self.speed_limit

    def is_at_traffic_light(self) -> bool:
        return False

    def _slip(self) -> float:
        return math.atan(0.5 * math.tan(self.wheel))

    def advance(self) -> None:
        before = self.speed
        self.wheel += (self.steer * STEER_LOCK_RAD - self.wheel) * min(TICK_S / STEER_LAG_S, 1.0)
        drag = 0.1 + 0.002 * self.speed**2
        self.speed = max(self.speed + (5.0 * self.throttle - 8.0 * self.brake - drag) * TICK_S, 0.0)
        slip = self._slip()
        self.x += self.speed * math.cos(self.yaw + slip) * TICK_S
        self.y += self.speed * math.sin(self.yaw + slip) * TICK_S
        self.yaw_rate = self.speed / (WHEELBASE_M / 2.0) * math.sin(slip)
        self.yaw += self.yaw_rate * TICK_S
        self.acceleration = (self.speed - before) / TICK_S


class ActorList(list[Any]):
    """The part of `carla.ActorList` the driver uses."""

    def filter(self, pattern: str) -> ActorList:
        return ActorList(actor for actor in self if pattern.strip("*") in actor.type_id)


class FakeWorld:
    """Actors on a map, moved by `tick`."""

    def __init__(self, carla_map: Any = None) -> None:
        self.map = carla_map
        self.actors: list[FakeActor] = []
        self.listed = 0

    def add(self, type_id: str, x: float, y: float, yaw: float = 0.0, **extra: Any) -> FakeActor:
        actor = FakeActor(self, len(self.actors) + 1, type_id, x, y, yaw, **extra)
        self.actors.append(actor)
        return actor

    def add_ego(self, x: float, y: float, yaw: float = 0.0, speed: float = 0.0) -> FakeCar:
        car = FakeCar(self, len(self.actors) + 1, "vehicle.tesla.model3", x, y, yaw, speed)
        self.actors.append(car)
        return car

    def get_map(self) -> Any:
        return self.map

    def get_actors(self, ids: list[int] | None = None) -> ActorList:
        self.listed += 1
        return ActorList(actor for actor in self.actors if ids is None or actor.id in ids)

    def get_snapshot(self) -> FakeSnapshot:
        return FakeSnapshot(self.actors)

    def tick(self) -> None:
        for actor in self.actors:
            actor.advance()


class FakeSnapshot:
    """Iterable of actors, findable by id."""

    timestamp = SimpleNamespace(delta_seconds=TICK_S)

    def __init__(self, actors: list[FakeActor]) -> None:
        self._actors = {actor.id: actor for actor in actors}

    def __iter__(self) -> Any:
        return iter(self._actors.values())

    def find(self, actor_id: int) -> FakeActor | None:
        return self._actors.get(actor_id)
