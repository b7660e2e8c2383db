"""Our own planner in place of CARLA's BehaviorAgent, in a Python in which stucksolver is installed.

What is in this file runs on Python 3.7 too, where it says what is missing; the planner itself needs 3.10 and numpy.
"""

from __future__ import annotations

import importlib
import sys
from typing import Any, Sequence

from stucksolver_bridge.agent_driver import RoutePoint, filled
from stucksolver_bridge.agent_plan import AHEAD_M, straightest

MODULE, CLASS = "stucksolver.stacks.planner", "PlannerDriver"


class PlannerError(RuntimeError):
    """The planner cannot drive in this Python; the message says why and what to do."""


class OwnPlanner:
    """The planner with what the entry asks of a driver, beside the methods that it has itself.

    `behavior` is `cautious`, `normal` or `aggressive`. Raises `PlannerError` where stucksolver cannot be imported.
    """

    def __init__(self, vehicle: Any, behavior: str, carla_map: Any) -> None:
        self.vehicle = vehicle
        self.driver = _planner_class()(vehicle, behavior, carla_map=carla_map)

    def set_plan(self, plan: Sequence[Any]) -> None:
        """Drive pairs of a `carla.Waypoint` and a `RoadOption` or our word for it, and on beyond them along the lane.

        Whoever runs the drive ends it some metres before or after the last of them. Raises `ValueError` for less than
        two.
        """
        self.driver.set_route(route_beyond(plan))

    def __getattr__(self, name: str) -> Any:
        return getattr(self.driver, name)


def route_beyond(plan: Sequence[Any]) -> list[RoutePoint]:
    """A plan as a route with a point about every metre, and on beyond its end along the lane.

    Raises `ValueError` for a plan of less than two points.
    """
    if len(plan) < 2:
        raise ValueError("a plan needs two waypoints; use hold() to stand still")
    route = filled(plan)
    last = straightest(route[-1].waypoint)
    while last is not None and last.transform.location.distance(plan[-1][0].transform.location) < AHEAD_M:
        route.append(RoutePoint(last, "lane_follow"))
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
