"""A driver in this process with the solver in another: facts go out each tick, orders come back."""

from __future__ import annotations

from typing import Any, Callable

from stucksolver_bridge.agent_driver import AgentDriver
from stucksolver_bridge.facts import Facts, waypoints_at
from stucksolver_bridge.process import SolverProcess

Listener = Callable[[dict], None]  # type: ignore[type-arg]


class Recovery:
    """Call `run_step` each tick. When the solver dies the driver decides by itself in that same tick.

    `settings`: of the solver (`stucksolver.stacks.sidecar.Settings`). `python`: see `SolverProcess`.
    `carla_map`: that of the driver. Raises `SolverError`.
    """

    def __init__(
        self,
        driver: AgentDriver,
        carla_map: Any,
        carla: Any,
        settings: dict[str, Any],
        python: str,
        path: str | None = None,
        on_event: Listener | None = None,
    ) -> None:
        self._driver = driver
        self._carla = carla
        self._map = carla_map
        self._vehicle = driver.vehicle
        self._on_event = on_event
        self._said: list[str] = []
        self._lights_before: Any = None
        self._facts = Facts(self._vehicle, carla_map)
        self.directive: dict[str, Any] = {"kind": "continue"}
        opening = self._facts.opening(driver.route, driver.acceleration_mps2)
        self.solver = SolverProcess(python, {"settings": settings, "carla": opening}, path)

    def run_step(self) -> Any:
        """This tick's `carla.VehicleControl`, not applied."""
        if self.solver.alive:
            tick = self._facts.tick()
            if self._said:
                tick["say"] = self._said.pop(0)
            answer = self.solver.step(tick, self._facts.give)
            if answer is None:
                self._let_go()
            else:
                self._obey(answer)
        return self._driver.run_step()

    @property
    def fault(self) -> str | None:
        """Why the solver is gone; None while it is there."""
        return self.solver.fault

    def say(self, text: str) -> None:
        """A passenger's words."""
        self._said.append(text)

    def close(self) -> None:
        self.solver.close()

    def _let_go(self) -> None:
        self.directive = {"kind": "continue"}
        self._driver.release()
        if self._lights_before is not None:
            self._set_lights(self._lights_before)
            self._lights_before = None

    def _obey(self, answer: dict[str, Any]) -> None:
        self.directive = answer.get("directive", self.directive)
        for name, order in answer.get("orders", ()):
            if name == "follow":
                ignore = frozenset(int(i) for i in order["ignore"])
                self._driver.follow(order["path"], order["reverse"], ignore)
            elif name == "hold":
                self._driver.hold()
            elif name == "release":
                self._driver.release()
            elif name == "route":
                plan = waypoints_at(self._map, order)
                if len(plan) > 1:
                    self._driver.set_plan(plan)
            elif name == "lights":
                if self._lights_before is None:
                    self._lights_before = int(self._vehicle.get_light_state())
                self._set_lights(order)
        for event in answer.get("events", ()):
            if self._on_event is not None:
                self._on_event(event)

    def _set_lights(self, state: int) -> None:
        self._vehicle.set_light_state(self._carla.VehicleLightState(state))
