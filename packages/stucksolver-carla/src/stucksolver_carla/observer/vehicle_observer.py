"""Watches a running car: detects, reasons, checks, records. It never acts, ticks, or changes a setting.

With `sensors` it attaches passive sensors to the car and perceives the world by these.
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
"""A world without a tick for this long counts as stopped (s)."""
LOOKING_TICKS = 20
"""Ticks of sensor data before the first look, so that the pose is good."""


class VehicleNotFoundError(RuntimeError):
    """The observed car is missing. The message says what is there."""


def find_car(world: carla.World, role: str) -> Any:
    """Return the vehicle with a role name.

    Raises:
        NoSuchCar: There is none.
    """
    cars = list(world.get_actors().filter("vehicle.*"))
    found = [car for car in cars if car.attributes.get("role_name") == role]
    if not found:
        roles = sorted({car.attributes.get("role_name", "") for car in cars} - {""})
        there = f"there are: {', '.join(roles)}" if roles else "there are no vehicles"
        raise VehicleNotFoundError(f"no vehicle has the role {role!r}; {there}: see --role")
    return found[0]


class VehicleObserver:
    """One car under observation. Call `look` repeatedly; it waits for the next tick of another client.

    Raises:
        NoSuchCar: The car is not there.
    """

    def __init__(
        self,
        world: carla.World,
        role: str,
        ladder: Ladder,
        out: Path | None,
        heard: Callable[[Event], None],
        sensors: bool = False,
    ) -> None:
        self._world = world
        # A new client knows of nobody before the next tick.
        self._await_tick()
        self._car = find_car(world, role)
        self._eyes = self._open_eyes() if sensors else None
        self._stack = ObservedStack(self._car if self._eyes is None else self._eyes.vehicle)
        self._recorder = None if out is None else Recorder(out)
        self._heard = heard
        self.solver = StuckSolver(
            self._stack.scene,
            ladder=ladder,
            clock="wall",
            on_event=self._hear,
            record=self._recorder,
            observe_only=True,
        )
        self.state = "driving"
        self.interventions = 0
        self._decided: str | None = None

    def look(self) -> Status:
        """Observe one tick.

        Raises:
            NoSuchCar: The car is gone, or the world has stopped.
        """
        self._await_tick()
        if not self._car.is_alive:
            raise VehicleNotFoundError("the observed car is gone")
        if self._eyes is not None:
            self._eyes.tick()
        status = self._stack.status()
        self.solver.step(status, self._stack.surroundings)
        if status.speed_mps > self._moving_mps:
            self.state = "driving"
        elif self._decided is not None:
            self.state = self._decided
        return status

    @property
    def files(self) -> list[Path]:
        """The records begun so far."""
        return [] if self._recorder is None else self._recorder.files

    def close(self) -> None:
        """End the observation.

        Raises:
            RecordError: A record could not be written.
        """
        self.solver.close()
        self._shut_eyes()
        if self._recorder is not None:
            self._recorder.close()
            if self._recorder.error is not None:
                raise self._recorder.error

    def break_off(self) -> None:
        """End a failed observation: the record of an open intervention stays incomplete."""
        self.solver.close()
        self._shut_eyes()
        if self._recorder is not None:
            self._recorder.break_off()

    def _open_eyes(self) -> EgoPerception:
        """Wait until there is a pose.

        Raises:
            NoSuchCar: The sensors give no data.
        """
        try:
            eyes = sensor_perception().open(self._car, self._world.get_map(), paced=False)
        except SensorError as error:
            raise VehicleNotFoundError(str(error)) from error
        try:
            for _ in range(LOOKING_TICKS):
                self._await_tick()
                eyes.tick()
        except SensorError as error:
            eyes.close()
            raise VehicleNotFoundError(str(error)) from error
        return eyes

    def _shut_eyes(self) -> None:
        if self._eyes is not None:
            self._eyes.close()

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

    def _hear(self, event: Event) -> None:
        if event.intervention is not None:
            self.interventions = max(self.interventions, event.intervention)
        if event.kind is EventKind.DECIDED and event.decision is not None:
            self._decided = _in_words(event)
        elif event.kind is EventKind.CLOSED or event.kind is EventKind.CANCELLED:
            self._decided = None
        self._heard(event)


def _in_words(event: Event) -> str:
    """Return a decision with its verdict in one line."""
    if event.waiting:
        return f"waits: {event.text}"
    if event.verdict is None:
        return f"stuck; no plan: {event.text}"
    return f"stuck; would {event.text}: {event.verdict}"
