"""Sentences about a plan, in the future and during its execution."""

from __future__ import annotations

from dataclasses import dataclass

from stucksolver.plan import RecoveryPlan
from stucksolver.plan.behaviors import Behavior


@dataclass(frozen=True)
class PlanPhrase:
    """`future_phrase` completes "I will ..." and "May I ...?"; `present_phrase` completes "I am ...".

    `{side}` is left or right.
    """

    future: str
    present: str


BEHAVIORS: dict[str, PlanPhrase] = {
    "wait": PlanPhrase("wait a moment", "waiting a moment"),
    "keep_lane": PlanPhrase("drive on in my lane", "driving on in my lane"),
    "follow_vehicle": PlanPhrase("follow the vehicle ahead", "following the vehicle ahead"),
    "change_lane": PlanPhrase("go round it in the lane on the {side}", "changing to the lane on the {side}"),
    "borrow_oncoming_lane": PlanPhrase(
        "go round it on the left when the oncoming lane is free", "going round it on the left"
    ),
    "nudge": PlanPhrase("move a little to the {side}", "moving a little to the {side}"),
    "nose_out": PlanPhrase("turn out to the {side} and wait for a gap", "waiting for a gap on the {side}"),
    "creep": PlanPhrase("creep forward a little", "creeping forward a little"),
    "back_up": PlanPhrase("back up a little", "backing up a little"),
    "drive_over": PlanPhrase("drive slowly over it", "driving slowly over it"),
    "pull_over": PlanPhrase("pull over to the right and stop", "pulling over to the right"),
    "rejoin_route": PlanPhrase("return to my lane", "returning to my lane"),
    "turn_round": PlanPhrase("turn round and drive back", "turning round"),
    "replan": PlanPhrase("take another way", "looking for another way"),
    "hazard_lights": PlanPhrase("switch on the hazard lights", "switching on the hazard lights"),
    "request_assistance": PlanPhrase("stop and call the operator", "calling the operator"),
}
"""Phrases by the behavior's name in the registry."""


def future_phrase(plan: RecoveryPlan) -> str:
    """Return the parts of a plan in order, to complete "I will"."""
    parts = list(dict.fromkeys(_side(BEHAVIORS[behavior.name].future, behavior) for behavior in plan.behaviors))
    return parts[0] if len(parts) == 1 else ", then ".join([", ".join(parts[:-1]), parts[-1]])


def present_phrase(behavior: Behavior) -> str:
    """Return the behavior in execution: `I am going round it on the left.`"""
    return f"I am {_side(BEHAVIORS[behavior.name].present, behavior)}."


def _side(text: str, behavior: Behavior) -> str:
    return text.format(side=getattr(behavior, "side", "left"))
