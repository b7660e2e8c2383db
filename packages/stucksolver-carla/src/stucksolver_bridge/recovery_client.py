"""Connects a driver in this process with the solver in another one: world data go out, directives come back."""

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
"""Placeholder for the driver's directive after an error in the middle of an answer. It differs from every directive, so
the next one is passed to the driver in any case."""
STOPPED_MPS = 0.1
"""Speed below which the ego counts as stopped (m/s). Ours."""
NO_ANSWER = "no answer from the solver: the vehicle performs the fallback that the guard has checked"
DONE_M, DONE_S = 2.0, 0.5
"""Remaining length at which a path counts as driven: a constant part (m) and a part that grows with speed (s). So the
agent does not have to stop at the path's end. Ours."""


class RecoveryClient(SolverClient):
    """A driver whose directives come from the solver's process. Call `run_step` on each tick.

    Every directive is valid for half a second of ticks. If the solver stops answering, the fallback of its last
    directive is performed, and then the driver continues without the solver.

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
        self._performed = CONTINUE
        """The last directive that was passed to the driver."""
        self._needs_resend = False
        """True if an answer of the solver was rejected, so that it must send everything again."""
        self._reject_text: str | None = None
        self._world_data = WorldData(self._vehicle, carla_map)
        self.directive: dict[str, Any] = CONTINUE
        """The directive that is being performed, in its JSON form."""
        opening = self._world_data.opening(driver.route, driver.acceleration_mps2)
        hello = {"settings": settings, "carla": opening}
        self.solver = SolverProcess(python, hello, path, answer_limit_s=answer_limit_s, tick_s=tick_s)

    def run_step(self) -> Any:
        """Return this tick's `carla.VehicleControl`, not applied.

        Raises `SolverError` if the world waits and the solver does not answer within its limit.
        """
        time_s: float | None = None
        if self.solver.alive:
            tick = self._with_utterance(self._world_data.tick())
            time_s = tick.get("time")
            if self._needs_resend or self._lease.expired:
                tick["again"] = True
            answer = self.solver.step(tick, self._world_data.give)
            if answer is not None:
                self._perform_answer(answer, time_s)
        if not self.solver.alive:
            self._lease.expire()
        self._perform(time_s)
        return self._driver.run_step()

    # ---- answers of the solver

    def _perform_answer(self, answer: dict[str, Any], time_s: float | None) -> None:
        """Perform an answer. If any part of it is malformed, perform nothing of it and stop."""
        reason = malformed_reason(answer)
        if reason is None:
            try:
                self._perform_orders(answer)
            except Exception as error:  # noqa: BLE001 - no error may end the agent's control loop; the ego stops
                reason, self._performed = f"{type(error).__name__}: {error}", UNKNOWN
        if reason is not None:
            self._stop(reason, time_s)
            return
        for event in answer.get("events", ()):
            self._emit(event)

    def _perform_orders(self, answer: dict[str, Any]) -> None:
        directive = answer.get("directive")
        # The orders come first: if one fails, the lease is not renewed by this answer.
        for name, order in answer.get("orders", ()):
            self._perform_order(name, order)
        self._lease.renew(directive, self.solver.late_ticks)
        if directive is not None:
            self._performed, self._needs_resend = self._lease.order, False

    def _perform_order(self, name: str, order: Any) -> None:
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
            raise ValueError(f"the order {name} requires a vehicle with sensors")

    def _stop(self, reason: str, time_s: float | None) -> None:
        """Stop until a valid directive comes. The fault is reported once."""
        self._needs_resend = True
        if self._reject_text is None:
            self._reject_text = f"invalid answer of the solver: {reason}"
            print(f"stucksolver: {self._reject_text}; the vehicle stops", file=sys.stderr, flush=True)
            self._emit({"time_s": time_s, "kind": "order_refused", "text": self._reject_text, "verdict": None})
        follows_path = self._performed is self._lease.order and "path" in self._performed
        if follows_path and self._lease.no_stop_at(*self._path_position()):
            # The path forbids a stop here, so the checked path is finished first.
            self._lease.expire()
        else:
            self._lease.renew(STAND)

    # ---- the directive

    def _perform(self, time_s: float | None) -> None:
        """Pass the lease's directive to the driver if it differs from the one that is being performed."""
        was_expired = self._lease.expired
        self.directive = self._due_directive()
        if self._lease.expired and not was_expired:
            self._emit({"time_s": time_s, "kind": "order_expired", "text": NO_ANSWER, "verdict": None})
        if self.directive is not self._performed:
            self._performed = self.directive
            if self.directive["kind"] == "execute":
                self._driver.hold(self.directive.get("brake_mps2"))
            else:
                self._driver.release()
        is_silent = self._lease.expired or not self.solver.alive
        if is_silent and self.directive["kind"] == "continue" and self._lights_before is not None:
            self._set_lights(self._lights_before)
            self._lights_before = None

    def _due_directive(self) -> dict[str, Any]:
        if self._lease.order["kind"] != "execute":
            return self._lease.order
        velocity = self._vehicle.get_velocity()
        speed = math.hypot(velocity.x, velocity.y)
        left_m = self._driver.path_left_m
        done = left_m < DONE_M + DONE_S * speed
        return self._lease.tick(*self._path_position(), path_is_done=done, at_rest=speed < STOPPED_MPS)

    def _path_position(self) -> tuple[float, float]:
        """Return the ego's position in the frame of a directive's path: y to the left."""
        location = self._vehicle.get_location()
        return float(location.x), -float(location.y)

    def _set_lights(self, state: int) -> None:
        self._vehicle.set_light_state(self._carla.VehicleLightState(state))
