"""Have the route planned again."""

from typing import ClassVar, Literal

from stucksolver.decision.behaviors.base import Standing


class ReplanRoute(Standing):
    """Plan the route anew from a candidate waypoint of the scene, or from here; the stack then drives it."""

    summary: ClassVar[str] = "Plan the route anew, from the candidate waypoint route_start of the scene or from here."

    name: Literal["replan"] = "replan"
    route_start: str | None = None

    def time_allowance_s(self, expected_s: float) -> float:
        return 0.0
