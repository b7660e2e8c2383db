"""Sentences that say what a plan does, in the future and while it is done."""

from __future__ import annotations

from dataclasses import dataclass

from stucksolver.plan import RecoveryPlan
from stucksolver.plan.behaviors import Behavior


@dataclass(frozen=True)
class Phrase:
    """`will` completes "I will ..." and "May I ...?"; `doing` completes "I am ...". `{side}` is left or right."""

    will: str
    doing: str


BEHAVIORS: dict[str, Phrase] = {
    "wait": Phrase("wait a moment", "waiting a moment"),
    "keep_lane": Phrase("drive on in my lane", "driving on in my lane"),
    "follow_vehicle": Phrase("follow the vehicle ahead", "following the vehicle ahead"),
    "change_lane": Phrase("go round it in the lane on the {side}", "changing to the lane on the {side}"),
    "borrow_oncoming_lane": Phrase(
        "go round it on the left when the oncoming lane is free", "going round it on the left"
    ),
    "nudge": Phrase("move a little to the {side}", "moving a little to the {side}"),
    "nose_out": Phrase("turn out to the {side} and wait for a gap", "waiting for a gap on the {side}"),
    "creep": Phrase("creep forward a little", "creeping forward a little"),
    "back_up": Phrase("back up a little", "backing up a little"),
    "drive_over": Phrase("drive slowly over it", "driving slowly over it"),
    "pull_over": Phrase("pull over to the right and stop", "pulling over to the right"),
    "rejoin_route": Phrase("return to my lane", "returning to my lane"),
    "turn_round": Phrase("turn round and drive back", "turning round"),
    "replan": Phrase("take another way", "looking for another way"),
    "hazard_lights": Phrase("switch on the hazard lights", "switching on the hazard lights"),
    "request_assistance": Phrase("stop and call the operator", "calling the operator"),
}
"""By the behaviour's name in the registry."""


def will(plan: RecoveryPlan) -> str:
    """Return what the plan does, to complete "I will": its parts in order."""
    parts = list(dict.fromkeys(_side(BEHAVIORS[one.name].will, one) for one in plan.behaviors))
    return parts[0] if len(parts) == 1 else ", then ".join([", ".join(parts[:-1]), parts[-1]])


def doing(behavior: Behavior) -> str:
    """Return what is being done: `I am going round it on the left.`"""
    return f"I am {_side(BEHAVIORS[behavior.name].doing, behavior)}."


def _side(text: str, behavior: Behavior) -> str:
    return text.format(side=getattr(behavior, "side", "left"))
