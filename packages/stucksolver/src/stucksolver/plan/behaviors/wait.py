"""Stay stopped."""

from typing import ClassVar, Literal

from pydantic import Field

from stucksolver.plan.behaviors.behavior import PlanPhrase, StationaryBehavior
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.interpretation import GuidanceIntent, GuidanceLimits, Interpretation
from stucksolver.scene.objects import ObjectKind
from stucksolver.scene.surroundings import ControlKind, LightState

CLEAR_M = 15.0
"""The path ahead is free if nothing is in it up to here."""
ONCOMING_M = 80.0
"""Oncoming traffic counts up to this distance ahead."""
SIREN_BEHIND_M = 80.0
"""An emergency vehicle with its lights on counts up to this distance behind, as `rules.onward` does."""


class Wait(StationaryBehavior):
    """Stay stopped for a time, or until a condition holds, but never longer than that time."""

    summary: ClassVar[str] = (
        "Stay stopped for duration_s seconds, or less with until: `clear` the path ahead is free, `light` no light "
        "ahead is red or yellow, `oncoming` no oncoming traffic, `passed` no emergency vehicle with its lights on is "
        "behind or beside."
    )
    phrase: ClassVar[PlanPhrase] = PlanPhrase("wait a moment", "waiting a moment")

    name: Literal["wait"] = "wait"
    duration_s: float = Field(ge=0.5, le=60.0)
    until: Literal["time", "clear", "light", "oncoming", "passed"] = "time"

    def done(self, view: FrenetScene) -> bool:
        if self.until == "clear":
            return view.free_ahead_m() > CLEAR_M
        if self.until == "light":
            lights = [c for c in view.surroundings.controls if c.kind is ControlKind.TRAFFIC_LIGHT and c.applies]
            return all(c.state in (LightState.GREEN, LightState.OFF) or c.distance_m < -1.0 for c in lights)
        if self.until == "oncoming":
            return not ((view.vs < -0.5) & (view.gap > -view.ego.length_m) & (view.gap < ONCOMING_M)).any()
        if self.until == "passed":
            near = (view.s - view.ego_s > -SIREN_BEHIND_M) & (view.gap <= 0.0)
            sounds = (o.kind is ObjectKind.EMERGENCY and bool(o.emergency_lights) for o in view.objects)
            return not any(item and two for item, two in zip(near, sounds, strict=True))
        return False

    def time_allowance_s(self, expected_s: float) -> float:
        return self.duration_s

    def guided_parameters(self, reading: Interpretation, limits: GuidanceLimits) -> dict[str, float]:
        """Return the duration of a stop where somebody gets out. See `Behavior.guided_parameters`."""
        lets_out = reading.intent is GuidanceIntent.LET_ME_OUT
        return {"duration_s": limits.wait_s} if limits.wait_s is not None and lets_out else {}
