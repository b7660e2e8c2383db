"""Connects a run to the passenger's page."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from stucksolver.plan import Directive
from stucksolver_eval.passenger.live_view import LiveView, Pictures
from stucksolver_eval.passenger.real_time_pacer import RealTimePacer
from stucksolver_eval.scenario_context import ScenarioContext
from stucksolver_passenger.gateway import PassengerGateway

if TYPE_CHECKING:
    from stucksolver_eval.systems.solver_system import SolverSystem


@dataclass(frozen=True)
class PassengerSpec:
    """Connection to the passenger server.

    Attributes:
        address: The server's address file.
        vehicle: The car's id on the server.
        name: The car's name on the page.
    """

    address: Path
    vehicle: str
    name: str


class PassengerPage:
    """Serves the page from the start of a run to its end, and slows the run down to real time."""

    def __init__(self, spec: PassengerSpec, setting: ScenarioContext, arm: SolverSystem) -> None:
        self._spec, self._arm = spec, arm
        self._desk = desk = PassengerGateway(spec.address)
        arm.listen(desk.ear(spec.vehicle))
        self._seat = desk.add(spec.vehicle, arm.solver, spec.name)
        self._view = LiveView(desk, spec.vehicle, setting.world, setting.hero)
        self._view.show_scenery(setting.map, setting.route)
        self._pictures = Pictures(lambda jpeg: desk.show_picture(spec.vehicle, jpeg), setting.hero)
        self._pace = RealTimePacer(setting.dt_s)

    def tick(self, time_s: float, directive: Directive | None) -> None:
        """Update the page after the system's step, then sleep until the next tick is due. `time_s`: since the start."""
        status = self._arm.stack.status()
        self._seat.tick(status, self._arm.stack.scene)
        self._view.tick(time_s, status.speed_mps, directive)
        self._pace.wait()

    def close(self) -> None:
        """End the ride. The page stays open."""
        self._pictures.close()
        self._seat.end()
        self._desk.leave(self._spec.vehicle)
        self._desk.close()
