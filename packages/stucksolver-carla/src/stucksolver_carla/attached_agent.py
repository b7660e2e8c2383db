"""Attaches StuckSolver to CARLA's BehaviorAgent, or to a built-in driver, behind the agent's own methods."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Callable, Iterable
from typing import Any

import carla

from stucksolver.plan import CONTINUE, Directive
from stucksolver.scene import Scene, Surroundings
from stucksolver.solver import StuckSolver
from stucksolver_bridge import AgentDriver
from stucksolver_bridge.agent_driver import densified_route
from stucksolver_carla.drivers.behavior import BehaviorDriver, RoutePoint
from stucksolver_carla.perception_interface import EgoPerception
from stucksolver_carla.stack import CarlaStack

Obstacles = bool | Callable[[], Iterable[Any]]


def attach(
    agent: Any, *, obstacles: Obstacles = True, eyes: EgoPerception | None = None, **solver: Any
) -> AttachedAgent:
    """Attach StuckSolver to a BehaviorAgent (CARLA's `agents` package, 0.9.13 and later).

    A built-in driver (`stucksolver_carla.drivers.planner.PlannerDriver`) is accepted as well. The agent may have a plan
    already, or get one through the returned object.

    Args:
        agent: The agent. By itself it reacts only to vehicles and walkers.
        obstacles: True adds the static objects around the ego to the vehicles that the agent gets; False does not. A
            function returns the objects of your perception (see
            `stucksolver_bridge.obstacle_exposure.ObstacleExposingWorld`).
        eyes: Perception of the agent's vehicle, such as `stucksolver_perception.carla.EgoPerception`. The solver then
            uses it, and the vehicle brakes if it fails. The agent itself still uses the client's ground truth.
        solver: All other arguments are those of `StuckSolver`.

    Returns:
        An object with the agent's own methods.
    """
    return AttachedAgent(agent, obstacles, eyes, solver)


class AttachedAgent:
    """The agent with the solver. It has the agent's own methods; a running plan replaces the agent's decisions."""

    def __init__(self, agent: Any, obstacles: Obstacles, eyes: EgoPerception | None, solver: dict[str, Any]) -> None:
        self.agent = agent
        self.driver: AgentDriver | BehaviorDriver = (
            agent if isinstance(agent, BehaviorDriver) else AgentDriver(agent, carla, obstacles)
        )
        self.directive: Directive | None = CONTINUE
        """The solver's directive on the last tick, in the map's frame; None without one."""
        self.fault: str | None = None
        """Reason why the solver is no longer called; None while it works."""
        self.solver = StuckSolver(self._scene, **solver)
        self._ego_perception = eyes
        self.perception = "privileged" if eyes is None else eyes.perception
        self._vehicle, self._map = agent._vehicle if eyes is None else eyes.vehicle, agent._map
        self._stack: CarlaStack | None = None
        self._read_plan()

    def run_step(self, debug: bool = False) -> Any:
        """Return this tick's `carla.VehicleControl`, not applied."""
        if self._ego_perception is None:
            return self._step(debug)
        self._ego_perception.tick()
        return self._ego_perception.checked(self._step(debug))

    def _step(self, debug: bool) -> Any:
        if self._stack is None:
            return self.driver.run_step() if self.driver is self.agent else self.agent.run_step(debug)
        directive = self._solver_directive(self._stack)
        self.directive = None if directive is None else self._stack.in_map_frame(directive)
        return self._stack.perform(directive)

    def _solver_directive(self, stack: CarlaStack) -> Directive | None:
        """Return the solver's directive; None after the solver has failed."""
        if self.fault is not None:
            return None
        try:
            return self.solver.step(stack.status(), stack.surroundings)
        except Exception as error:  # noqa: BLE001 - no error of the solver may end the agent's own control loop
            self.fault = f"{type(error).__name__}: {error}"
            end = "the fallback of its last directive is performed, then the agent drives by itself"
            print(f"stucksolver: the solver has failed ({self.fault}); {end}", file=sys.stderr, flush=True)
            traceback.print_exc()
            return None

    def set_destination(self, end_location: carla.Location, start_location: carla.Location | None = None) -> None:
        """Set the destination, as with the agent's own method."""
        self.driver.release()
        self.agent.set_destination(end_location, start_location)
        self._read_plan()

    def set_global_plan(self, plan: Any, stop_waypoint_creation: bool = True, clean_queue: bool = True) -> None:
        """Set the plan, as with the agent's own method."""
        self.driver.release()
        if isinstance(self.driver, BehaviorDriver):
            self.driver.set_route([RoutePoint(*point) for point in densified_route(plan)])
        else:
            self.agent.set_global_plan(plan, stop_waypoint_creation, clean_queue)
        self._read_plan()

    def done(self) -> bool:
        """Return True if the agent has finished its route; never True while a plan of the solver runs."""
        return self.driver.done()

    def guide(self, text: str) -> None:
        """Pass a passenger's utterance to the solver."""
        self.solver.guide(text)

    def close(self) -> None:
        """Close the solver."""
        self.solver.close()

    def __getattr__(self, name: str) -> Any:
        return getattr(self.agent, name)

    def _read_plan(self) -> None:
        """Read the agent's first or changed plan."""
        if isinstance(self.driver, AgentDriver):
            self.driver.note_plan()
        if not self.driver.route:
            return
        if self._stack is None:
            self._stack = CarlaStack(self._vehicle, self.driver, self._map)
        else:
            self._stack.take_route()

    def _scene(self, surroundings: Surroundings) -> Scene | None:
        return None if self._stack is None else self._stack.scene(surroundings)
