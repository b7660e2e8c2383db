"""An ego and others on the demo town, placed by road, lane and arc length."""

from __future__ import annotations

from typing import Any

import carla
from towns import Place

from stucksolver.plan import CONTINUE, Directive
from stucksolver_carla.drivers.behavior import BehaviorDriver
from stucksolver_carla.stack import CarlaStack

TICK_S = 0.05
CAR = "vehicle.tesla.model3"


class Stage:
    """A world in lockstep and what was put into it."""

    def __init__(self, host: str, port: int) -> None:
        self.client = carla.Client(host, port)
        self.client.set_timeout(60.0)
        self.world = self.client.get_world()
        settings = self.world.get_settings()
        settings.synchronous_mode, settings.fixed_delta_seconds = True, TICK_S
        self.world.apply_settings(settings)
        self.world.tick()
        self.map = self.world.get_map()
        self.actors: list[Any] = []

    @property
    def now_s(self) -> float:
        return float(self.world.get_snapshot().timestamp.elapsed_seconds)

    def transform(self, place: Place, up: float = 0.2) -> Any:
        """Where an actor is put down on a lane."""
        transform = self.map.get_waypoint_xodr(*place).transform
        transform.location.z += up
        return transform

    def add(self, blueprint: str, place: Place, role: str | None = None, speed: float = 0.0) -> Any:
        """An actor; a vehicle given a speed (m/s) keeps it."""
        definition = self.world.get_blueprint_library().find(blueprint)
        if role is not None:
            definition.set_attribute("role_name", role)
        actor = self.world.spawn_actor(definition, self.transform(place))
        self.actors.append(actor)
        if speed:
            actor.enable_constant_velocity(carla.Vector3D(speed, 0.0, 0.0))
        return actor

    def ego(self, start: Place, end: Place) -> tuple[Any, CarlaStack]:
        """A car with its driver under way to another place, and the stack around both."""
        car = self.add(CAR, start, role="hero")
        self.ticks(2)
        self.driver = BehaviorDriver(car, carla_map=self.map)
        self.driver.set_destination(self.map.get_waypoint_xodr(*end).transform.location)
        return car, CarlaStack(car, self.driver, self.map)

    def ticks(self, count: int) -> None:
        for _ in range(count):
            self.world.tick()

    def light(self, road: int) -> Any:
        """The traffic light at the end of a road."""
        lights = self.world.get_actors().filter("*traffic_light*")
        return next(item for item in lights if any(w.road_id == road for w in item.get_stop_waypoints()))

    def drive(self, car: Any, stack: CarlaStack, seconds: float, directive: Directive = CONTINUE) -> list[Any]:
        """Perform a directive for a while; the status of every tick."""
        found = []
        for _ in range(round(seconds / TICK_S)):
            found.append(stack.status())
            car.apply_control(stack.perform(directive))
            self.world.tick()
        return found

    def clear(self) -> None:
        """Take everything off the stage and let the lights run."""
        # The client takes an actor that no frame has shown yet for dead, and does not destroy it.
        self.world.tick()
        for actor in self.actors:
            actor.destroy()
        self.actors.clear()
        for light in self.world.get_actors().filter("*traffic_light*"):
            light.freeze(False)
        self.world.tick()
