"""Sentences about the reason of a rejection, and about the next try."""

from __future__ import annotations

from dataclasses import dataclass

from stucksolver.guard import Verdict
from stucksolver.scene import PlanFailure, RejectCode, Scene
from stucksolver_passenger.sentences.nouns import noun_of

PASSED = "I will try when it has passed."
GONE = "I will try when it is out of the way."
AGAIN = "I will look again in a moment."
OTHERWISE = "I will look for another way."


@dataclass(frozen=True)
class RejectionText:
    """`why` completes "I can't: ..."; `then` states the next action. `{who}` is the object in the path."""

    why: str
    then: str


REFUSALS: dict[RejectCode, RejectionText] = {
    RejectCode.STALE: RejectionText("I do not see well enough at the moment", "I will try when I see clearly again."),
    RejectCode.IMPLAUSIBLE: RejectionText(
        "what I see does not add up at the moment", "I will try when I see clearly again."
    ),
    RejectCode.PRECONDITION: RejectionText("that cannot be done here", OTHERWISE),
    RejectCode.APPROVAL: RejectionText(
        "it would not be safe at the moment", AGAIN
    ),  # in other cases the solver asks for the approval
    RejectCode.NO_PATH: RejectionText("there is no room for it here", OTHERWISE),
    RejectCode.COLLISION: RejectionText("{who} is in the way", GONE),
    RejectCode.GAP: RejectionText("{who} is too close", "I will try when there is more room."),
    RejectCode.CLEARANCE: RejectionText("{who} would be too close to me", "I will try when there is more room."),
    RejectCode.RED_LIGHT: RejectionText("the light is red", "I will drive when it is green."),
    RejectCode.STOP_LINE: RejectionText("I have to stop at the line first", "I will try after that."),
    RejectCode.ONCOMING_SIGHT: RejectionText("I cannot see far enough ahead to use the other lane", AGAIN),
    RejectCode.ONCOMING_GAP: RejectionText("{who} is coming", PASSED),
    RejectCode.LANE_ENTRY: RejectionText("{who} is coming up in that lane", PASSED),
    RejectCode.ZONE: RejectionText("I would have to stop on a junction or a crossing", OTHERWISE),
    RejectCode.SOLID_LINE: RejectionText("there is a solid line", OTHERWISE),
    RejectCode.OFF_LANES: RejectionText("I would have to leave the lanes", OTHERWISE),
    RejectCode.OFF_ROAD: RejectionText("I would have to leave the road", OTHERWISE),
    RejectCode.DOOR: RejectionText("a car door may open there", "I will try when there is more room."),
    RejectCode.OFF_ROUTE: RejectionText("that leads too far away from our route", OTHERWISE),
    RejectCode.AUTHORITY: RejectionText("only the operator may allow that", OTHERWISE),
    RejectCode.WAIT_FIRST: RejectionText("{who} may drive on by itself", AGAIN),
    RejectCode.NOT_PASSABLE: RejectionText("I am not sure that it is safe to drive over it", OTHERWISE),
    RejectCode.LEAVES_LANE: RejectionText("there is no room for it in my lane", OTHERWISE),
    RejectCode.STOPPING_PLACE: RejectionText("I must not stop there", OTHERWISE),
    RejectCode.PATH_NOT_VISIBLE: RejectionText("I cannot see whether the way is free", AGAIN),
    RejectCode.NO_ABORT: RejectionText("I could not stop safely on the way", AGAIN),
    RejectCode.OVERSPEED: RejectionText("I would have to drive too fast", OTHERWISE),
    RejectCode.DEVIATION: RejectionText("I did not keep to the path that I had checked", OTHERWISE),
    RejectCode.TIMEOUT: RejectionText("it took too long", OTHERWISE),
    RejectCode.NOT_IMMOBILIZED: RejectionText("I am already moving again", "I will just drive on."),
    RejectCode.REPEATED: RejectionText("I have tried that here, and it did not work", OTHERWISE),
}

FAILURES: dict[PlanFailure, str] = {
    PlanFailure.PRECONDITION: "that cannot be done here",
    PlanFailure.EMPTY: "I have no plan for that",
    PlanFailure.NOT_SEEN: "I do not see it any more",
    PlanFailure.NOT_IN_THE_WAY: "there is nothing in my way",
    PlanFailure.NOT_LEADING: "nobody drives ahead of me",
    PlanFailure.NO_LANE: "there is no lane there",
    PlanFailure.NOT_OUR_LANE: "that lane belongs to oncoming traffic",
    PlanFailure.LANE_TOO_NARROW: "the other lane is too narrow",
    PlanFailure.NO_ROOM_TO_TURN: "the road is too narrow to turn round in",
    PlanFailure.NO_ROOM_ASIDE: "there is no room to move aside",
    PlanFailure.NO_SPACE_TO_PULL_AROUND: "I am too close to swing out",
    PlanFailure.NO_ROOM_TO_COME_BACK: "there is no room to return to my lane",
    PlanFailure.TOO_LONG: "it would take too long to get past",
    PlanFailure.MUST_BE_STOPPED: "I have to stop first",
}
"""Completions of "I can't: ..." if there is no path (`RejectCode.NO_PATH`)."""


CANNOT = "I can't"


def rejection_sentence(verdict: Verdict, scene: Scene | None, cannot: str = CANNOT) -> str:
    """Return the reason of a rejection, and the next action: `I can't: a truck is coming.

    I will try when it has passed.`

    The sentence contains the first of several reasons. The guard's checks start with the plainest. Too short a sight
    distance is given with what is missing.

    Args:
        verdict: The verdict.
        scene: The scene, which has the kind of the object.
        cannot: Beginning of the sentence.

    Raises:
        ValueError: The verdict contains no rejection.
    """
    if not verdict.rejects:
        raise ValueError("the verdict contains no rejection: pass only verdicts with one")
    first = verdict.rejects[0]
    refusal = REFUSALS[first.code]
    why = refusal.why if first.failure is None else FAILURES[first.failure]
    missing = ""
    if first.needed_m is not None and first.seen_m is not None and first.needed_m - first.seen_m >= 1.0:
        missing = f", {first.needed_m - first.seen_m:.0f} m are missing"
    return f"{cannot}: {why.format(who=noun_of(first.object_id, scene))}{missing}. {refusal.then}"


def abort_sentence(codes: tuple[RejectCode, ...]) -> str:
    """Return the reason why a running maneuver was ended. Without codes, a person ended it."""
    if not codes:
        return "I have ended that."
    return f"I have ended that: {REFUSALS[codes[0]].why.format(who='somebody')}."
