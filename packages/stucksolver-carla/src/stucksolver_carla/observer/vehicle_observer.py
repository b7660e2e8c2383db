"""Observes a running vehicle: detects, reasons, checks and records. It never acts, ticks, or changes a setting.

With sensor-based perception, it attaches passive sensors to the vehicle.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stucksolver.ladder import Ladder
from stucksolver.record import Recorder
from stucksolver.scene import Status
from stucksolver.solver import Event, EventKind, StuckSolver
from stucksolver_carla.observer.observed_stack import ObservedStack
from stucksolver_carla.perception_interface import EgoPerception, SensorError, sensor_perception

if TYPE_CHECKING:
    import carla

TICK_LIMIT_S = 10.0
"""Time without a tick after which the world counts as stopped (s). Ours."""
WARM_UP_TICKS = 20
"""Number of ticks of sensor data before the first step, so that the pose is accurate. Ours."""


class VehicleNotFoundError(RuntimeError):
    """The observed vehicle does not exist, or cannot be observed. The message gives the reason."""


def find_vehicle(world: carla.World, role: str) -> Any:
    """Return the vehicle with a role name.

    Raises:
        VehicleNotFoundError: No vehicle has this role.
    """
    vehicles = list(world.get_actors().filter("vehicle.*"))
    matches = [vehicle for vehicle in vehicles if vehicle.attributes.get("role_name") == role]
    if not matches:
        roles = sorted({vehicle.attributes.get("role_name", "") for vehicle in vehicles} - {""})
        available = f"roles: {', '.join(roles)}" if roles else "there are no vehicles with a role"
        raise VehicleNotFoundError(f"no vehicle has the role {role!r}; {available}; see --role")
    return matches[0]


class VehicleObserver:
    """One vehicle under observation. Call `step` repeatedly; it waits for the next tick of another client.

    Raises:
        VehicleNotFoundError: The vehicle does not exist.
    """

    def __init__(
        self,
        world: carla.World,
        role: str,
        ladder: Ladder,
        out: Path | None,
        on_event: Callable[[Event], None],
        sensors: bool = False,
    ) -> None:
        self._world = world
        # A new client has no actors before the next tick.
        self._await_tick()
        self._vehicle = find_vehicle(world, role)
        self._ego_perception = self._open_perception() if sensors else None
        self._stack = ObservedStack(self._vehicle if self._ego_perception is None else self._ego_perception.vehicle)
        self._recorder = None if out is None else Recorder(out)
        self._on_event = on_event
        self.solver = StuckSolver(
            self._stack.scene,
            ladder=ladder,
            clock="wall",
            on_event=self._handle_event,
            record=self._recorder,
            observe_only=True,
        )
        self.state = "driving"
        self.interventions = 0
        self._decision_text: str | None = None

    def step(self) -> Status:
        """Observe one tick.

        Raises:
            VehicleNotFoundError: The vehicle no longer exists, or the world has stopped.
        """
        self._await_tick()
        if not self._vehicle.is_alive:
            raise VehicleNotFoundError("the observed vehicle no longer exists")
        if self._ego_perception is not None:
            self._ego_perception.tick()
        status = self._stack.status()
        self.solver.step(status, self._stack.surroundings)
        if status.speed_mps > self._moving_mps:
            self.state = "driving"
        elif self._decision_text is not None:
            self.state = self._decision_text
        return status

    @property
    def files(self) -> list[Path]:
        """Files of all records that were started."""
        return [] if self._recorder is None else self._recorder.files

    def close(self) -> None:
        """End the observation.

        Raises:
            RecordError: A record could not be written.
        """
        self.solver.close()
        self._close_perception()
        if self._recorder is not None:
            self._recorder.close()
            if self._recorder.error is not None:
                raise self._recorder.error

    def abort(self) -> None:
        """End a failed observation: the record of an open intervention stays incomplete."""
        self.solver.close()
        self._close_perception()
        if self._recorder is not None:
            self._recorder.break_off()

    def _open_perception(self) -> EgoPerception:
        """Attach the sensors and wait until the pose is accurate.

        Raises:
            VehicleNotFoundError: The sensors give no data.
        """
        try:
            ego_perception = sensor_perception().open(self._vehicle, self._world.get_map(), paced=False)
        except SensorError as error:
            raise VehicleNotFoundError(str(error)) from error
        try:
            for _ in range(WARM_UP_TICKS):
                self._await_tick()
                ego_perception.tick()
        except SensorError as error:
            ego_perception.close()
            raise VehicleNotFoundError(str(error)) from error
        return ego_perception

    def _close_perception(self) -> None:
        if self._ego_perception is not None:
            self._ego_perception.close()

    def _await_tick(self) -> None:
        try:
            self._world.wait_for_tick(TICK_LIMIT_S)
        except RuntimeError as error:
            raise VehicleNotFoundError(
                f"the world has not advanced for {TICK_LIMIT_S:g} s, or its server has stopped: {error}"
            ) from error

    @property
    def _moving_mps(self) -> float:
        return self.solver.detector_settings.v_min_mps

    def _handle_event(self, event: Event) -> None:
        if event.intervention is not None:
            self.interventions = max(self.interventions, event.intervention)
        if event.kind is EventKind.DECIDED and event.decision is not None:
            self._decision_text = _state_text(event)
        elif event.kind is EventKind.CLOSED or event.kind is EventKind.CANCELLED:
            self._decision_text = None
        self._on_event(event)


def _state_text(event: Event) -> str:
    """Return a decision with its verdict as the text of the progress line."""
    if event.waiting:
        return f"legitimate wait: {event.text}"
    if event.verdict is None:
        return f"stuck; no plan: {event.text}"
    return f"stuck; plan: {event.text}; guard: {event.verdict}"
