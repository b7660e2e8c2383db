"""Replan the route."""

from typing import ClassVar, Literal

from stucksolver.plan.behaviors.behavior import StationaryBehavior


class ReplanRoute(StationaryBehavior):
    """Replan the route from a candidate waypoint of the scene, or from here; the stack then follows it."""

    summary: ClassVar[str] = "Replan the route, from the candidate waypoint route_start of the scene or from here."

    name: Literal["replan"] = "replan"
    route_start: str | None = None

    def time_allowance_s(self, expected_s: float) -> float:
        return 0.0
