"""A driver in this process with the solver in another: facts go out on each tick, orders come back."""

from __future__ import annotations

import math
import sys
from typing import Any

from stucksolver_bridge.agent_driver import AgentDriver
from stucksolver_bridge.client_base import Listener, SolverClient
from stucksolver_bridge.directive_validation import malformed_reason
from stucksolver_bridge.lease import CONTINUE, STAND, JsonLease
from stucksolver_bridge.solver_process import ANSWER_LIMIT_S, TICK_S, SolverProcess
from stucksolver_bridge.world_data import WorldData, waypoints_at

UNKNOWN: dict[str, Any] = {"kind": "unknown"}
AT_REST_MPS = 0.1
SILENT = "the solver is silent: the vehicle performs the fallback that was proven safe"
DONE_M, DONE_S = 2.0, 0.5
"""A path counts as driven this distance, plus this time of travel, before its end, so that the agent need not stop."""


class RecoveryClient(SolverClient):
    """Call `run_step` on each tick. Every order is valid for half a second of ticks.

    If the solver falls silent or ends, its proven fallback is performed, and then the driver decides by itself.

    Args:
        driver: The driver, with its route.
        carla_map: The driver's map.
        carla: The `carla` module.
        settings: Settings of the solver (`stucksolver_carla.sidecar.Settings`).
        python: See `SolverProcess`.
        path: See `SolverProcess`.
        on_event: Called with every event of the solver.
        answer_limit_s: See `SolverProcess`.
        tick_s: See `SolverProcess`.

    Raises:
        SolverError: The solver does not start.
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
        answer_limit_s: float = ANSWER_LIMIT_S,
        tick_s: float = TICK_S,
    ) -> None:
        super().__init__(on_event)
        self._driver = driver
        self._carla = carla
        self._map = carla_map
        self._vehicle = driver.vehicle
        self._lights_before: Any = None
        self._lease = JsonLease()
        self._begun = CONTINUE
        """The last directive that was given to the driver."""
        self._again = False
        """True if an answer of the solver was lost, so that it must send everything again."""
        self._refused: str | None = None
        self._facts = WorldData(self._vehicle, carla_map)
        self.directive: dict[str, Any] = CONTINUE
        """The directive that is being performed, in its JSON form."""
        opening = self._facts.opening(driver.route, driver.acceleration_mps2)
        hello = {"settings": settings, "carla": opening}
        self.solver = SolverProcess(python, hello, path, answer_limit_s=answer_limit_s, tick_s=tick_s)

    def run_step(self) -> Any:
        """Return this tick's `carla.VehicleControl`, not applied.

        Raises `SolverError` if the world waits and the solver does not answer within its limit.
        """
        time_s: float | None = None
        if self.solver.alive:
            tick = self._with_words(self._facts.tick())
            time_s = tick.get("time")
            if self._again or self._lease.expired:
                tick["again"] = True
            answer = self.solver.step(tick, self._facts.give)
            if answer is not None:
                self._take(answer, time_s)
        if not self.solver.alive:
            self._lease.expire()
        self._perform(time_s)
        return self._driver.run_step()

    # ---- what the solver says

    def _take(self, answer: dict[str, Any], time_s: float | None) -> None:
        """Perform all of an answer or nothing of it. If it is malformed, stop."""
        wrong = malformed_reason(answer)
        if wrong is None:
            try:
                self._obey(answer)
            except Exception as error:  # noqa: BLE001 - of whatever type, it must not end the agent's own loop
                wrong, self._begun = f"{type(error).__name__}: {error}", UNKNOWN
        if wrong is not None:
            self._stand(wrong, time_s)
            return
        for event in answer.get("events", ()):
            self._tell(event)

    def _obey(self, answer: dict[str, Any]) -> None:
        told = answer.get("directive")
        for name, order in answer.get("orders", ()):
            self._order(name, order)
        self._lease.renew(told, self.solver.late_ticks)
        if told is not None:
            self._begun, self._again = self._lease.order, False

    def _order(self, name: str, order: Any) -> None:
        if name == "follow":
            self._driver.follow(order["path"], order["reverse"], frozenset(order["ignore"]))
        elif name == "hold":
            self._driver.hold(order)
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
        else:
            raise ValueError(f"{name} is an order for another kind of vehicle")

    def _stand(self, wrong: str, time_s: float | None) -> None:
        """Stop, and wait until an order comes that can be performed. The fault is reported once."""
        self._again = True
        if self._refused is None:
            self._refused = f"an order cannot be performed: {wrong}"
            print(f"stucksolver: {self._refused}; the vehicle stands still", file=sys.stderr, flush=True)
            self._tell({"time_s": time_s, "kind": "order_refused", "text": self._refused, "verdict": None})
        if self._begun is self._lease.order and "path" in self._begun and self._lease.no_stop_at(*self._place()):
            # The vehicle may not stop here, so the proven path is finished first.
            self._lease.expire()
        else:
            self._lease.renew(STAND)

    # ---- what is performed

    def _perform(self, time_s: float | None) -> None:
        """Give the driver the lease's directive if it differs from the one that is being performed."""
        before = self._lease.expired
        self.directive = self._due()
        if self._lease.expired and not before:
            self._tell({"time_s": time_s, "kind": "order_expired", "text": SILENT, "verdict": None})
        if self.directive is not self._begun:
            self._begun = self.directive
            if self.directive["kind"] == "execute":
                self._driver.hold(self.directive.get("brake_mps2"))
            else:
                self._driver.release()
        gone = self._lease.expired or not self.solver.alive
        if gone and self.directive["kind"] == "continue" and self._lights_before is not None:
            self._set_lights(self._lights_before)
            self._lights_before = None

    def _due(self) -> dict[str, Any]:
        if self._lease.order["kind"] != "execute":
            return self._lease.order
        velocity = self._vehicle.get_velocity()
        speed = math.hypot(velocity.x, velocity.y)
        left_m = self._driver.path_left_m
        done = left_m < DONE_M + DONE_S * speed
        return self._lease.tick(*self._place(), path_is_done=done, at_rest=speed < AT_REST_MPS)

    def _place(self) -> tuple[float, float]:
        """Return the vehicle's position in the frame of a directive's path: y to the left."""
        place = self._vehicle.get_location()
        return float(place.x), -float(place.y)

    def _set_lights(self, state: int) -> None:
        self._vehicle.set_light_state(self._carla.VehicleLightState(state))
