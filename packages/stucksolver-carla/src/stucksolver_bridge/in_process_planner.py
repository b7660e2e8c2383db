"""Our own planner in place of CARLA's BehaviorAgent, for a Python in which stucksolver is installed.

This file also runs on Python 3.7, where it reports what is missing. The planner itself needs Python 3.10 and numpy.
"""

from __future__ import annotations

import importlib
import sys
from typing import Any, Sequence

from stucksolver_bridge.agent_driver import AgentRoutePoint, filled
from stucksolver_bridge.agent_plan import AHEAD_M, straightest

MODULE, CLASS = "stucksolver_carla.drivers.planner", "PlannerDriver"


class PlannerError(RuntimeError):
    """The planner cannot drive in this Python; the message says why and what to do."""


class InProcessPlanner:
    """The planner, with the methods that the entry needs from a driver in addition to its own.

    `behavior` is `cautious`, `normal` or `aggressive`. Raises `PlannerError` if stucksolver cannot be imported.
    """

    def __init__(self, vehicle: Any, behavior: str, carla_map: Any) -> None:
        self.vehicle = vehicle
        self.driver = _planner_class()(vehicle, behavior, carla_map=carla_map)

    def set_plan(self, plan: Sequence[Any]) -> None:
        """Drive a plan, and continue along the lane beyond its end.

        The plan has pairs of a `carla.Waypoint` and a `RoadOption`, or our name for the option. The evaluator ends the
        drive some meters before or after the last one. Raises `ValueError` for fewer than two.
        """
        self.driver.set_route(route_beyond(plan))

    def __getattr__(self, name: str) -> Any:
        return getattr(self.driver, name)


def route_beyond(plan: Sequence[Any]) -> list[AgentRoutePoint]:
    """Return a plan as a route with a point about every meter, continued along the lane beyond its end.

    Raises `ValueError` for a plan of fewer than two points.
    """
    if len(plan) < 2:
        raise ValueError("a plan needs two waypoints; use hold() to stand still")
    route = filled(plan)
    last = straightest(route[-1].waypoint)
    while last is not None and last.transform.location.distance(plan[-1][0].transform.location) < AHEAD_M:
        route.append(AgentRoutePoint(last, "lane_follow"))
        last = straightest(last)
    return route


def _planner_class() -> Any:
    try:
        return getattr(importlib.import_module(MODULE), CLASS)
    except (ImportError, SyntaxError) as error:
        version = ".".join(map(str, sys.version_info[:3]))
        raise PlannerError(
            f"driver 'planner' cannot be loaded in Python {version} ({error}); run the evaluator in a Python 3.10 to "
            "3.12 in which stucksolver is installed, or leave 'driver' at 'agent'"
        ) from error
