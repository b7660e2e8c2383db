"""Connects a vehicle with a process in which its driver, perception and solver all run.

This end sends the sensor data and receives a control for each tick. It has no driver: if no control comes, the vehicle
brakes. Python 3.7, standard library only; `carla` is passed in.
"""

from __future__ import annotations

import sys
from typing import Any, Mapping, Sequence

from stucksolver_bridge.client_base import Listener, SolverClient
from stucksolver_bridge.directive_validation import malformed_reason
from stucksolver_bridge.in_process_planner import route_beyond
from stucksolver_bridge.sensor_data import SensorData
from stucksolver_bridge.solver_process import ANSWER_LIMIT_S, TICK_S, SolverError, SolverProcess

CONTROL_TICKS = 4
"""Time for which the last control is applied while the next one is late (ticks; 0.2 s at 20 Hz). Then the vehicle
brakes. Ours."""

Sensors = Sequence[Mapping[str, Any]]


class SensorClient(SolverClient):
    """A vehicle that is driven by the solver's process. Call `run_step` with each tick's data, and `close` at the end.

    Args:
        vehicle: The ego.
        carla_map: The map.
        carla: The `carla` module.
        settings: Settings of the solver (`stucksolver_carla.sidecar.Settings`); `perception` is set here.
        sensors: The sensors as the agent declares them.
        plan: Pairs of waypoint and road option.
        python: See `SolverProcess`.
        path: See `SolverProcess`.
        on_event: Called with every event of the solver.
        answer_limit_s: See `SolverProcess`.
        tick_s: See `SolverProcess`.

    Raises:
        SolverError: The sensors, their calibration or the weights do not fit together.
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
        self._sensor_data = SensorData(vehicle, carla_map, sensors)
        self._last_control: list[Any] | None = None
        """The last control: throttle, steering, brake, reverse, hand brake."""
        self._control_ticks = 0
        """Number of ticks since that control came."""
        self._reject_reported = False
        self._has_driven = False
        """True after the first control."""
        hello = {
            "settings": {**settings, "perception": "sensors"},
            "sensed": self._sensor_data.opening(route_beyond(plan)),
        }
        try:
            self.solver = SolverProcess(
                python,
                hello,
                path,
                answer_limit_s=answer_limit_s,
                tick_s=tick_s,
                inherited=(self._sensor_data.frames.fd,),
            )
        except SolverError:
            self._sensor_data.close()
            raise

    def run_step(self, input_data: Mapping[str, Any]) -> Any:
        """Return this tick's `carla.VehicleControl`, not applied.

        Raises `SolverError` if the world waits and the solver does not answer within its limit, and if the solver ends
        before its first control, for example because the data are not from the declared sensors.
        """
        self._control_ticks += 1
        self._sensor_data.take_in(input_data)
        if self.solver.alive:
            tick = self._with_utterance(self._sensor_data.tick())
            answer = self.solver.step(tick, self._sensor_data.give)
            if answer is not None:
                self._perform_answer(answer, tick["time"])
        if not self.solver.alive and not self._has_driven:
            self.close()
            raise SolverError(str(self.fault))
        return self._control()

    def close(self) -> None:
        """End the solver's process, and free the memory shared with it."""
        super().close()
        self._sensor_data.close()

    def _perform_answer(self, answer: dict[str, Any], time_s: float) -> None:
        """Perform all of an answer, or brake if any part of it is malformed."""
        reason = malformed_reason(answer)
        if reason is not None:
            self._last_control = None
            if not self._reject_reported:
                self._reject_reported = True
                print(f"stucksolver: invalid answer of the solver: {reason}; the vehicle brakes", file=sys.stderr)
                self._emit({"time_s": time_s, "kind": "order_refused", "text": reason, "verdict": None})
            return
        for name, order in answer.get("orders", ()):
            if name == "control":
                self._last_control, self._control_ticks = list(order), 0
                self._has_driven = True
            elif name == "lights":
                self._vehicle.set_light_state(self._carla.VehicleLightState(order))
        for event in answer.get("events", ()):
            self._emit(event)

    def _control(self) -> Any:
        if self._last_control is None or self._control_ticks > CONTROL_TICKS or not self.solver.alive:
            return self._carla.VehicleControl(throttle=0.0, brake=1.0)
        throttle, steer, brake, reverse, hand_brake = self._last_control
        return self._carla.VehicleControl(
            throttle=throttle, steer=steer, brake=brake, reverse=reverse, hand_brake=hand_brake
        )
