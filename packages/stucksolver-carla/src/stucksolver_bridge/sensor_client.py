"""A vehicle whose driver, perception and solver all run in the solver's process.

This side sends the sensor data and gets a control for each tick. It has no driver of its own: if no control comes, the
vehicle brakes. Python 3.7, standard library only; `carla` is passed in.
"""

from __future__ import annotations

import sys
from typing import Any, Mapping, Sequence

from stucksolver_bridge.client_base import Listener, SolverClient
from stucksolver_bridge.directive_validation import malformed_reason
from stucksolver_bridge.in_process_planner import route_beyond
from stucksolver_bridge.sensor_data import SensorData
from stucksolver_bridge.solver_process import ANSWER_LIMIT_S, TICK_S, SolverError, SolverProcess

KEPT_TICKS = 4
"""While the next control is late, the last one is kept this long (0.2 s at 20 Hz); then the vehicle brakes."""

Sensors = Sequence[Mapping[str, Any]]


class SensorClient(SolverClient):
    """Call `run_step` with each tick's data, and `close` at the end.

    `settings`: those of the solver (`stucksolver_carla.sidecar.Settings`); `perception` is set here. `sensors`: as the
    agent declares them. `plan`: pairs of waypoint and road option. `python`, `path`, `answer_limit_s`, `tick_s`: see
    `SolverProcess`. Raises `SolverError` if the sensors, their calibration or the weights do not fit together.
    """

    def __init__(
        self,
        vehicle: Any,
        carla_map: Any,
        carla: Any,
        settings: Mapping[str, Any],
        sensors: Sensors,
        plan: Sequence[Any],
        python: str,
        path: str | None = None,
        on_event: Listener | None = None,
        answer_limit_s: float = ANSWER_LIMIT_S,
        tick_s: float = TICK_S,
    ) -> None:
        super().__init__(on_event)
        self._vehicle, self._carla = vehicle, carla
        self._facts = SensorData(vehicle, carla_map, sensors)
        self._told: list[Any] | None = None
        """The last control: throttle, steering, brake, reverse, hand brake."""
        self._age = 0
        """How many ticks ago it came."""
        self._refused = False
        self._drove = False
        hello = {
            "settings": {**settings, "perception": "sensors"},
            "sensed": self._facts.opening(route_beyond(plan)),
        }
        try:
            self.solver = SolverProcess(
                python, hello, path, answer_limit_s=answer_limit_s, tick_s=tick_s, inherited=(self._facts.frames.fd,)
            )
        except SolverError:
            self._facts.close()
            raise

    def run_step(self, input_data: Mapping[str, Any]) -> Any:
        """Return this tick's `carla.VehicleControl`, not applied.

        Raises `SolverError` if the world waits and the solver does not answer within its limit, and if the first data
        are not from the declared sensors.
        """
        self._age += 1
        self._facts.take_in(input_data)
        if self.solver.alive:
            tick = self._with_words(self._facts.tick())
            answer = self.solver.step(tick, self._facts.give)
            if answer is not None:
                self._take(answer, tick["time"])
        if not self.solver.alive and not self._drove:
            self.close()
            raise SolverError(str(self.fault))
        return self._control()

    def close(self) -> None:
        """End the solver's process, and free the memory shared with it."""
        super().close()
        self._facts.close()

    def _take(self, answer: dict[str, Any], time_s: float) -> None:
        """Perform all of an answer, or brake if any part of it is malformed."""
        wrong = malformed_reason(answer)
        if wrong is not None:
            self._told = None
            if not self._refused:
                self._refused = True
                print(f"stucksolver: an order cannot be performed: {wrong}; the vehicle brakes", file=sys.stderr)
                self._tell({"time_s": time_s, "kind": "order_refused", "text": wrong, "verdict": None})
            return
        for name, order in answer.get("orders", ()):
            if name == "control":
                self._told, self._age = list(order), 0
                self._drove = True
            elif name == "lights":
                self._vehicle.set_light_state(self._carla.VehicleLightState(order))
        for event in answer.get("events", ()):
            self._tell(event)

    def _control(self) -> Any:
        if self._told is None or self._age > KEPT_TICKS or not self.solver.alive:
            return self._carla.VehicleControl(throttle=0.0, brake=1.0)
        throttle, steer, brake, reverse, hand_brake = self._told
        return self._carla.VehicleControl(
            throttle=throttle, steer=steer, brake=brake, reverse=reverse, hand_brake=hand_brake
        )
