"""A ride past a parked car on a running server, with the real client, driver and stack.

As a program it is killed in the middle of a plan: `python ride.py HOST PORT FOLDER`.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import carla

from stucksolver import CONTINUE, StuckSolver, Surroundings
from stucksolver.record import Recorder
from stucksolver.solver import Event, EventKind
from stucksolver_carla.drivers.behavior import BehaviorDriver
from stucksolver_carla.stack import CarlaStack
from stucksolver_eval.scenarios.families.street import into_gear
from stucksolver_eval.streets.finder import choose_street

DT_S = 0.05
LENGTH_M = 170


class Ride:
    """An ego behind a parked car. `take` an ego that is there already, or put both into an empty world."""

    def __init__(self, host: str, port: int) -> None:
        self.client = carla.Client(host, port)
        self.client.set_timeout(60.0)
        self.world = self.client.get_world()
        settings = self.world.get_settings()
        settings.synchronous_mode, settings.fixed_delta_seconds = True, DT_S
        self.world.apply_settings(settings)
        self.map = self.world.get_map()
        self.site = choose_street(self.map, "one_lane", 1, LENGTH_M)
        self.told: list[Event] = []

    def place(self) -> None:
        """Spawn the ego and the parked car."""
        self.ego = self._spawn("vehicle.lincoln.mkz_2020", self.site.start, "hero")
        parked = self._spawn("vehicle.tesla.model3", self.site.obstacle, "scenario")
        parked.apply_control(carla.VehicleControl(hand_brake=True))
        for _ in range(10):
            self.world.tick()
        self._seat()

    def take(self) -> None:
        """Drive on with the ego that is there."""
        cars = self.world.get_actors().filter("vehicle.*")
        self.ego = next(car for car in cars if car.attributes["role_name"] == "hero")
        self._seat()

    def _seat(self) -> None:
        driver = BehaviorDriver(self.ego, carla_map=self.map)
        driver.set_destination(self.site.destination.transform.location)
        self.stack = CarlaStack(self.ego, driver, self.map)

    def _spawn(self, blueprint: str, waypoint: Any, role: str) -> Any:
        definition = self.world.get_blueprint_library().find(blueprint)
        definition.set_attribute("role_name", role)
        transform = waypoint.transform
        transform.location.z += 0.3
        actor = self.world.spawn_actor(definition, transform)
        into_gear(actor)
        return actor

    def drive(
        self,
        seconds: float,
        *,
        look: Callable[[Surroundings], Surroundings | None] = lambda surroundings: surroundings,
        every_tick: Callable[[], None] = lambda: None,
        **options: Any,
    ) -> None:
        """Until the destination or the time is up; `look` may spoil what the solver sees."""
        usual = {"clock": "lockstep", "ladder": "evaluation", "on_event": self.told.append}
        with StuckSolver(self.stack.scene, **(usual | options)) as solver:
            for _ in range(round(seconds / DT_S)):
                status = self.stack.status()
                if status.at_destination:
                    return
                directive = solver.step(status, lambda: look(self.stack.surroundings()))
                self.ego.apply_control(self.stack.perform(directive))
                self.world.tick()
                every_tick()

    def alone(self, seconds: float) -> None:
        """The driver without a solver."""
        for _ in range(round(seconds / DT_S)):
            self.ego.apply_control(self.stack.perform(CONTINUE))
            self.world.tick()

    def kinds(self) -> list[EventKind]:
        return [event.kind for event in self.told]

    def texts(self, kind: EventKind) -> list[str]:
        return [event.text for event in self.told if event.kind is kind]

    def clear(self) -> None:
        """Take every vehicle away, and forget what was told."""
        self.told.clear()
        for car in self.world.get_actors().filter("vehicle.*"):
            car.destroy()
        self.world.tick()


def main(host: str, port: str, folder: str) -> None:
    ride = Ride(host, int(port))
    ride.place()
    under_way = 0

    def die_under_way() -> None:
        nonlocal under_way
        under_way += EventKind.STARTED in ride.kinds()
        if under_way * DT_S > 2.0:
            os.kill(os.getpid(), signal.SIGKILL)

    ride.drive(60.0, every_tick=die_under_way, record=Recorder(Path(folder)))


if __name__ == "__main__":
    main(*sys.argv[1:])
