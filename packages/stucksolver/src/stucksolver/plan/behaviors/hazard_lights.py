"""Warn other road users."""

from typing import ClassVar, Literal

from stucksolver.plan.behaviors.behavior import PlanPhrase, StationaryBehavior
from stucksolver.scene.frenet_scene import FrenetScene


class HazardLights(StationaryBehavior):
    """Switch the hazard lights on or off. They go off by themselves when the vehicle is under way again."""

    summary: ClassVar[str] = "Switch the hazard lights on or off; the vehicle stays where it is or drives on."
    phrase: ClassVar[PlanPhrase] = PlanPhrase("switch on the hazard lights", "switching on the hazard lights")

    name: Literal["hazard_lights"] = "hazard_lights"
    on: bool = True

    @property
    def hazard_lights_on(self) -> bool | None:
        return self.on

    def precondition(self, view: FrenetScene) -> str | None:
        return None

    def time_allowance_s(self, expected_s: float) -> float:
        return 0.0
