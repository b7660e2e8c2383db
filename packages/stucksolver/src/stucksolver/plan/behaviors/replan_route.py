"""Replan the route."""

from typing import ClassVar, Literal

from stucksolver.plan.behaviors.behavior import PlanPhrase, StationaryBehavior
from stucksolver.plan.simple_directives import Replan
from stucksolver.scene.interpretation import GuidanceIntent
from stucksolver.scene.scene import Scene


class ReplanRoute(StationaryBehavior):
    """Replan the route from a candidate waypoint of the scene, or from here; the stack then follows it."""

    summary: ClassVar[str] = "Replan the route, from the candidate waypoint route_start of the scene or from here."
    phrase: ClassVar[PlanPhrase] = PlanPhrase("take another way", "looking for another way")
    intents: ClassVar[tuple[GuidanceIntent, ...]] = (GuidanceIntent.REROUTE, GuidanceIntent.TURN_AROUND)
    solution_rank: ClassVar[int | None] = 10

    name: Literal["replan"] = "replan"
    route_start: str | None = None

    @classmethod
    def fits_scene(cls, scene: Scene) -> bool:
        return bool(scene.waypoints)

    def directive(self) -> Replan:
        return Replan(route_start=self.route_start)

    def time_allowance_s(self, expected_s: float) -> float:
        return 0.0
