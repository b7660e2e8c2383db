"""`attach`: CARLA's BehaviorAgent, or a driver of ours, with StuckSolver beside it, used as before."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

import carla

from stucksolver.decision import CONTINUE, Directive
from stucksolver.scene import Scene, Surroundings
from stucksolver.solver import StuckSolver
from stucksolver.stacks.carla_stack import CarlaStack
from stucksolver.stacks.driver import BehaviorDriver, RoutePoint
from stucksolver_bridge import AgentDriver
from stucksolver_bridge.agent_driver import filled

if TYPE_CHECKING:
    from stucksolver.stacks.sensed import Eyes

Obstacles = bool | Callable[[], Iterable[Any]]


def attach(agent: Any, *, obstacles: Obstacles = True, eyes: Eyes | None = None, **solver: Any) -> AttachedAgent:
    """A BehaviorAgent (CARLA's `agents` package, 0.9.13 and later) that gets itself moving again.

    A driver of ours (`stucksolver.stacks.planner.PlannerDriver`) is taken as well.
    The agent may have a plan already, or be given one through what is returned. `obstacles`: it looks for vehicles
    and walkers only; True lists the standing things around it among the vehicles that it is shown, False does not, and
    a function returns what your perception has found (`stucksolver_bridge.shown.ShownWorld` says what is asked of
    them). `eyes` (`stucksolver.stacks.sensed.Eyes` on the agent's vehicle): the solver knows the world by sensors, and
    the vehicle brakes where they fail; the agent itself looks as it always does. All other arguments are those of
    `StuckSolver`.
    """
    return AttachedAgent(agent, obstacles, eyes, solver)


class AttachedAgent:
    """Has the agent's own methods; its decisions are replaced only while a plan runs."""

    def __init__(self, agent: Any, obstacles: Obstacles, eyes: Eyes | None, solver: dict[str, Any]) -> None:
        self.agent = agent
        self.driver: AgentDriver | BehaviorDriver = (
            agent if isinstance(agent, BehaviorDriver) else AgentDriver(agent, carla, obstacles)
        )
        self.directive: Directive | None = CONTINUE
        """What the solver said on the last tick; None where it said nothing."""
        self.fault: str | None = None
        """Why the solver is not asked any more; None while all is well."""
        self.solver = StuckSolver(self._scene, **solver)
        self._eyes = eyes
        self.perception = "privileged" if eyes is None else eyes.perception
        self._vehicle, self._map = agent._vehicle if eyes is None else eyes.vehicle, agent._map
        self._stack: CarlaStack | None = None
        self._take_plan()

    def run_step(self, debug: bool = False) -> Any:
        """This tick's `carla.VehicleControl`, not applied."""
        if self._eyes is None:
            return self._step(debug)
        self._eyes.tick()
        return self._eyes.checked(self._step(debug))

    def _step(self, debug: bool) -> Any:
        if self._stack is None:
            return self.driver.run_step() if self.driver is self.agent else self.agent.run_step(debug)
        self.directive = self._asked(self._stack)
        return self._stack.perform(self.directive)

    def _asked(self, stack: CarlaStack) -> Directive | None:
        """What the solver says; None once it has failed. The agent's own loop is not ended by us."""
        if self.fault is not None:
            return None
        try:
            return self.solver.step(stack.status(), stack.surroundings)
        except Exception as error:  # noqa: BLE001 - of whatever type, it must not end the agent's own loop
            self.fault = f"{type(error).__name__}: {error}"
            end = "its last directive ends as proven, then the agent drives by itself"
            print(f"stucksolver: the solver has failed ({self.fault}); {end}", file=sys.stderr, flush=True)
            traceback.print_exc()
            return None

    def set_destination(self, end_location: carla.Location, start_location: carla.Location | None = None) -> None:
        """As the agent's own."""
        self.driver.release()
        self.agent.set_destination(end_location, start_location)
        self._take_plan()

    def set_global_plan(self, plan: Any, stop_waypoint_creation: bool = True, clean_queue: bool = True) -> None:
        """As the agent's own."""
        self.driver.release()
        if isinstance(self.driver, BehaviorDriver):
            self.driver.set_route([RoutePoint(*point) for point in filled(plan)])
        else:
            self.agent.set_global_plan(plan, stop_waypoint_creation, clean_queue)
        self._take_plan()

    def done(self) -> bool:
        """As the agent's own; never while a plan runs."""
        return self.driver.done()

    def guide(self, text: str) -> None:
        """A passenger's words."""
        self.solver.guide(text)

    def close(self) -> None:
        """The drive is over."""
        self.solver.close()

    def __getattr__(self, name: str) -> Any:
        return getattr(self.agent, name)

    def _take_plan(self) -> None:
        """The agent has another plan, or its first."""
        if isinstance(self.driver, AgentDriver):
            self.driver.note_plan()
        if not self.driver.route:
            return
        if self._stack is None:
            self._stack = CarlaStack(self._vehicle, self.driver, self._map)
        else:
            self._stack.take_route()

    def _scene(self, seen: Surroundings) -> Scene | None:
        return None if self._stack is None else self._stack.scene(seen)
