"""Renders a chain of codes as a decision with prose. The measured numbers come from the scene."""

from __future__ import annotations

from stucksolver.plan import (
    QUESTIONS,
    Analysis,
    AnalysisStep,
    Decision,
    Observation,
    ObservedControl,
    Participant,
    WaitReason,
)
from stucksolver.scene import Scene
from stucksolver.scene.wording import whereabouts
from stucksolver_language.student.chain_codec import ChainError, ReasoningChain

HELD_BY = frozenset(WaitReason) - {WaitReason.AT_DESTINATION, WaitReason.UNKNOWN_STOPPED, WaitReason.NO_SAFE_WAY}
"""Reasons to wait that belong to question S2.4."""


def render(chain: ReasoningChain, scene: Scene) -> Decision:
    """Return the decision that a chain means in a scene.

    Raises:
        ChainError: The chain names an object or a control that is not in the scene.
    """
    observation = _observation(chain, scene)
    reason = _reason(chain, scene)
    steps = tuple(
        AnalysisStep(id=name, question=QUESTIONS[name], answer=answer, evidence=evidence)
        for name, answer, evidence in _steps(chain, scene, reason)
    )
    analysis = Analysis(
        steps=steps,
        immobilized=chain.immobilized,
        cause=chain.cause,
        wait=chain.wait,
        guidance_intent=chain.asked,
        reason=reason,
    )
    return Decision(observation=observation, analysis=analysis, plan=chain.plan, rationale=_rationale(chain, reason))


def _observation(chain: ReasoningChain, scene: Scene) -> Observation:
    objects = {o.id: o for o in scene.objects}
    missing = [name for name, _ in chain.participants if name not in objects]
    if missing or any(number >= len(scene.controls) for number in chain.controls):
        what = f"object {missing[0]!r}" if missing else "a traffic control"
        raise ChainError(f"the answer names {what} that is not in the scene")
    controls = tuple(
        ObservedControl(kind=c.kind, state=c.state, applies=c.applies, distance_m=round(c.distance_m, 1))
        for c in (scene.controls[number] for number in chain.controls)
    )
    participants = tuple(
        Participant(object_id=name, kind=o.kind, lane=o.lane, distance_m=o.gap_m, intent=intent)
        for name, intent in chain.participants
        for o in (objects[name],)
    )
    observed = [
        f"{p.kind.value} {p.object_id} ({p.intent.value.replace('_', ' ')}"
        + (f", {whereabouts(p.distance_m)})" if p.distance_m is not None else ")")
        for p in participants
    ]
    return Observation(
        controls=controls, participants=participants, summary="; ".join(observed) or "nothing relevant in sight"
    )


def _steps(chain: ReasoningChain, scene: Scene, reason: str) -> list[tuple[str, bool, str]]:
    """Return the questions of the chain with their answers and evidence."""
    if chain.asked is not None:
        return [("S2.1", chain.plan is not None, reason)]
    ego = scene.ego
    moving = not ego.is_slow and not chain.immobilized
    held = chain.wait in HELD_BY
    motion = f"{abs(ego.speed_mps):.1f} m/s, stopped for {ego.stopped_for_s:.1f} s"
    left = ego.distance_to_destination_m
    to_go = "the destination is beyond the known road" if left is None else f"{left:.0f} m to go"
    ends = f"probability that it goes on by itself: {chain.ends[0]:.0%} within 10 s, {chain.ends[1]:.0%} within 40 s"
    return [
        ("S2.2", chain.wait is WaitReason.AT_DESTINATION, to_go),
        ("S2.3", moving, motion),
        ("S2.4", held, ends),
        ("S2.5", chain.immobilized, reason),
    ]


def _reason(chain: ReasoningChain, scene: Scene) -> str:
    soon = chain.ends[0]
    if chain.asked is not None:
        return f"the passenger asks for: {chain.asked.value.replace('_', ' ')}"
    if chain.wait is WaitReason.AT_DESTINATION:
        return "the route is complete"
    if chain.wait is WaitReason.NO_SAFE_WAY:
        return "no plan is likely to be safe now"
    if chain.wait is not None:
        return f"{chain.wait.value.replace('_', ' ')}; {soon:.0%} likely to end by itself within 10 s"
    if not chain.immobilized:
        return "it is moving"
    cause = "unknown" if chain.cause is None else chain.cause.value.replace("_", " ")
    return f"{cause}; {1.0 - soon:.0%} likely to last longer than 10 s"


def _rationale(chain: ReasoningChain, reason: str) -> str:
    if chain.plan is None:
        return f"wait: {reason}"
    return f"{', then '.join(b.name.replace('_', ' ') for b in chain.plan.behaviors)}: {reason}"
