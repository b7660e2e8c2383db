"""Runs the built-in planner in place of CARLA's BehaviorAgent, in a Python in which stucksolver is installed.

This module also runs on Python 3.7, where it reports what is missing. The planner requires Python 3.10 and numpy.
"""

from __future__ import annotations

import importlib
import sys
from typing import Any, Sequence

from stucksolver_bridge.agent_driver import AgentRoutePoint, densified_route
from stucksolver_bridge.agent_plan import AHEAD_M, straightest

MODULE, CLASS = "stucksolver_carla.drivers.planner", "PlannerDriver"


class PlannerError(RuntimeError):
    """The planner cannot be loaded in this Python; the message gives the reason and the remedy."""


class InProcessPlanner:
    """The planner, with the methods that the entry requires from a driver in addition to those of the planner.

    `behavior` is `cautious`, `normal` or `aggressive`. Raises `PlannerError` if stucksolver cannot be imported.
    """

    def __init__(self, vehicle: Any, behavior: str, carla_map: Any) -> None:
        self.vehicle = vehicle
        self.driver = _planner_class()(vehicle, behavior, carla_map=carla_map)

    def set_plan(self, plan: Sequence[Any]) -> None:
        """Drive a plan, and continue along the lane beyond its end.

        The plan has pairs of a `carla.Waypoint` and a `RoadOption` or its command. The evaluator ends the run some
        meters before or after the last waypoint. Raises `ValueError` for fewer than two pairs.
        """
        self.driver.set_route(route_beyond(plan))

    def __getattr__(self, name: str) -> Any:
        return getattr(self.driver, name)


def route_beyond(plan: Sequence[Any]) -> list[AgentRoutePoint]:
    """Return a plan as a route with a point about every meter, continued along the lane beyond its end.

    Raises `ValueError` for a plan of fewer than two points.
    """
    if len(plan) < 2:
        raise ValueError("a plan must have at least two waypoints; use hold() to stay stopped")
    route = densified_route(plan)
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
