"""Sentences about the reason of a wait, and about the obstacle."""

from __future__ import annotations

from stucksolver.guard import Verdict
from stucksolver.plan import CauseCode, WaitReason
from stucksolver.scene import ObjectKind, Scene
from stucksolver.solver import StandstillReason
from stucksolver_passenger.sentences.nouns import SOMETHING, capitalize, noun
from stucksolver_passenger.sentences.rejections import rejection_sentence

WAITS: dict[WaitReason, tuple[str, str]] = {
    WaitReason.AT_DESTINATION: ("We are there.", "I stay here."),
    WaitReason.LIGHT: ("I am waiting for the red light.", "I will drive on when it is green."),
    WaitReason.STOP_SIGN: ("I am stopping for the stop sign.", "I will drive on when the way is free."),
    WaitReason.QUEUE: ("I am waiting in a queue.", "I will move up when it moves."),
    WaitReason.PEOPLE: ("I am waiting for people on the road.", "I will drive on when they are out of the way."),
    WaitReason.YIELD: ("I am giving way.", "I will drive on when the others have passed."),
    WaitReason.UNKNOWN_STOPPED: (
        "{Thing} has stopped in front of me.",
        "I will watch for a moment whether it drives on by itself.",
    ),
    WaitReason.NO_SAFE_WAY: ("{Thing} is in my way, and I see no safe way past it.", "I will keep looking for one."),
}
"""Current situation, and next action."""

CAUSES: dict[CauseCode, str] = {
    CauseCode.PARKED_VEHICLE: "A parked {bare} blocks my lane.",
    CauseCode.DISABLED_VEHICLE: "A broken-down {bare} blocks my lane.",
    CauseCode.STATIC_OBSTACLE: "{Thing} blocks my lane.",
    CauseCode.BLOCKED_ROAD: "The road ahead is blocked.",
    CauseCode.LOOP: "I have been past here before and am making no progress.",
    CauseCode.UNKNOWN: "I am making no progress, and I do not know why.",
}
CANNOT_GO_ON = "I cannot go on"
KEEPS_LOOKING = "I will keep looking for a way."
NEAR_M = 60.0
"""Distance within which an object holds the car (m). Ours."""


CLOSED_GATE = ("I am waiting at a closed gate.", "I will drive on when it opens.")
"""The same for a gate, which has the code of a light."""
IMMOVABLE = "I am trying to drive, but the car does not move, although nothing is in its way."
NOT_KNOWN = "I have stopped, and I do not know the reason yet."


def waiting(reason: WaitReason, scene: Scene | None) -> tuple[str, str]:
    """Return the reason of the wait, and the next action."""
    ahead = () if scene is None else scene.in_path_ahead(NEAR_M)
    gate = reason is WaitReason.LIGHT and bool(ahead) and ahead[0].kind is ObjectKind.CROSSING_GATE
    now, then = CLOSED_GATE if gate else WAITS[reason]
    return _filled(now, scene), _filled(then, scene)


def standstill_sentence(reason: StandstillReason, scene: Scene | None) -> str:
    """Return why the car stands still, and the next action, for a notice that asks nothing."""
    if reason.immovable:
        return IMMOVABLE
    if reason.wait is not None:
        return " ".join(waiting(reason.wait, scene))
    if reason.reject is not None:
        return rejection_sentence(Verdict(rejects=(reason.reject,)), scene, CANNOT_GO_ON)
    return NOT_KNOWN if reason.cause is None else f"{blocked_by(reason.cause, scene)} {KEEPS_LOOKING}"


def blocked_by(cause: CauseCode | None, scene: Scene | None) -> str:
    """Return the cause of the immobilization."""
    return _filled(CAUSES[cause or CauseCode.UNKNOWN], scene)


def _filled(text: str, scene: Scene | None) -> str:
    ahead = () if scene is None else scene.in_path_ahead(NEAR_M)
    thing = noun(ahead[0].kind) if ahead else SOMETHING
    bare = thing.partition(" ")[2] if thing.startswith(("a ", "an ")) else "vehicle"
    return text.format(Thing=capitalize(thing), bare=bare)
