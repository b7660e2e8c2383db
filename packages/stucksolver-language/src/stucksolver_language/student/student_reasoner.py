"""The student as a reasoner. It waits if the wait will end without a plan, and otherwise proposes the best plan."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from stucksolver.reasoners.rules import RuleReasoner
from stucksolver.reasoners.rules.analyze import LIGHT_AHEAD_M, blocker, loops, red_light_within
from stucksolver.reasoners.rules.observe import goes_first

from stucksolver.plan import CauseCode, Decision, Intent, RecoveryPlan, WaitReason
from stucksolver.reasoners.reasoner import (
    ACCEPTED,
    PARSERS,
    ReasonerAnswer,
    ReasonerError,
    ReasonerRequest,
    ReasonerTrace,
)
from stucksolver.scene import REQUESTS, GuidanceIntent, ObjectKind, Scene
from stucksolver_language.student.candidates import candidates
from stucksolver_language.student.chain_codec import (
    FORMAT,
    MOST_CONTROLS,
    MOST_PARTICIPANTS,
    ChainError,
    ReasoningChain,
    read_chain,
    write_chain,
)
from stucksolver_language.student.decision_renderer import render
from stucksolver_language.student.feature_encoding import EncodedScene, encode
from stucksolver_language.student.heads import CAUSES, HOLDS, INTENTS, StudentOutput, ends_within
from stucksolver_language.student.network import DATA, StudentNetwork
from stucksolver_language.student.scene_codec import write_scene

DUTIES = frozenset({WaitReason.LIGHT, WaitReason.STOP_SIGN, WaitReason.PEOPLE, WaitReason.YIELD})
"""Reasons that oblige the vehicle to wait by the rules of the road, no matter when the wait will end."""


@dataclass(frozen=True)
class SelectionPolicy:
    """Rules by which the student chooses. Set manually; docs/distilled.md describes the consequences.

    Attributes:
        soon: Lowest probability that a wait ends within 10 s, for which the student waits.
        longest_s: Longest stop for which it waits (s). The limit holds for any prediction: one that is always wrong
            must not hold the vehicle indefinitely.
        margin: Lowest advantage in value over the rules' plan from which another plan is preferred (10 m of
            progress). With the default the rules' plan comes first: on held-out data the others were worth less where
            it was accepted.
        unlikely: Lowest probability that the guard accepts a plan, for which the guard is queried.
        tried: Maximum number of plans about which the guard is queried.
        instead: Lowest value of an accepted plan that is proposed where the rules request assistance (10 m). A smaller
            one would only move the position at which help is needed.
    """

    soon: float = 0.5
    longest_s: float = 60.0
    margin: float = 10.0
    unlikely: float = 0.5
    tried: int = 8
    instead: float = 2.5


class DistilledReasoner:
    """Reasons with a small network, in milliseconds, on one core of a CPU.

    Args:
        folder: Folder of the weights and their card.
        choice: Rules by which it chooses.

    Raises:
        StudentWeightsError: The weights cannot be used here.
    """

    def __init__(self, folder: Path = DATA, choice: SelectionPolicy | None = None) -> None:
        self._network = StudentNetwork(folder)
        self._choice = choice or SelectionPolicy()
        self._rules = RuleReasoner()
        self.name = f"distilled ({self._network.card.sha256[:8]})"

    def decide(self, request: ReasonerRequest) -> ReasonerAnswer:
        """Return the decision for a scene. The same scene and the same verdicts of the guard give the same answer.

        Raises:
            ReasonerError: The scene cannot be written as text, because it has values that are not numbers.
        """
        began = time.perf_counter()
        try:
            prompt = write_scene(request.scene)
        except ValueError as error:
            raise ReasonerError(f"the scene cannot be written: {error}") from error
        text = write_chain(self._chain(request))
        decision = render(read_chain(text), request.scene)
        trace = ReasonerTrace(
            format=FORMAT,
            prompt=prompt,
            answers=(text,),
            model=self.name,
            seconds=round(time.perf_counter() - began, 4),
        )
        return ReasonerAnswer(decision, self.name, trace)

    def _chain(self, request: ReasonerRequest) -> ReasoningChain:
        scene, rules_decision = request.scene, self._rules.decide(request).decision
        own = rules_decision.plan
        known = set(self._network.card.vocabulary.behaviors)
        plans = tuple(p for p in candidates(scene) if known.issuperset(b.name for b in p.behaviors))
        if own is not None and known.issuperset(b.name for b in own.behaviors):
            plans = tuple(dict.fromkeys((own, *plans)))
        encoded = encode(scene)
        numbers = self._network.answer(encoded, plans)
        within = ends_within(numbers.hazard)
        ends = round(float(within[2]), 2), round(float(within[4]), 2)
        wait = self._wait(scene, numbers, ends[0], rules_decision.analysis.wait)
        idle = wait is not None or not _wanted(scene) or _unheld(scene, rules_decision)
        plan = None if idle else self._plan(request, plans, numbers, own)
        if wait is None and plan is None and _wanted(scene):
            wait = rules_decision.analysis.wait or WaitReason.NO_SAFE_WAY
        stuck = plan is not None or wait is WaitReason.NO_SAFE_WAY
        asked = None if scene.guidance is None else _asked(scene)
        return ReasoningChain(
            controls=tuple(n for n, c in enumerate(scene.controls) if c.applies is not False)[:MOST_CONTROLS],
            participants=_participants(encoded, numbers),
            asked=asked,
            immobilized=(stuck and scene.ego.is_slow) or loops(scene),
            cause=_cause(scene, numbers, rules_decision.analysis.cause) if stuck and asked is None else None,
            wait=wait,
            ends=ends,
            plan=plan,
        )

    def _wait(
        self, scene: Scene, numbers: StudentOutput, soon: float, rules_wait: WaitReason | None
    ) -> WaitReason | None:
        """Return why waiting is right, or None if it is not. `rules_wait` is the reason that the rules give."""
        if scene.ego.at_destination:
            return WaitReason.AT_DESTINATION
        choice = self._choice
        if rules_wait in DUTIES:
            return rules_wait
        if scene.guidance is not None or not scene.ego.is_slow:
            return None
        if soon < choice.soon or scene.ego.stopped_for_s > choice.longest_s:
            return None
        reasons = [
            (logit, item)
            for logit, item in zip(numbers.hold, HOLDS, strict=True)
            if item not in (None, WaitReason.AT_DESTINATION, WaitReason.NO_SAFE_WAY)
        ]
        return max(reasons, key=lambda pair: pair[0])[1]

    def _plan(
        self,
        request: ReasonerRequest,
        plans: tuple[RecoveryPlan, ...],
        numbers: StudentOutput,
        own: RecoveryPlan | None,
    ) -> RecoveryPlan | None:
        """Return the best plan that the guard accepts; or else the rules' plan, for which a gap may open."""
        ranked = self._ranked(request.scene, plans, numbers, own)
        if own is not None and any(b.calls_person for b in own.behaviors):
            if request.check is None or held_by_law(request.scene):
                return own
            worth = dict(zip(plans, numbers.value, strict=True))
            ranked = [plan for plan in ranked if plan != own and worth[plan] >= self._choice.instead]
        for plan in ranked[: self._choice.tried]:
            if request.check is None or request.check(plan) == ACCEPTED:
                return plan
        return own

    def _ranked(
        self, scene: Scene, plans: tuple[RecoveryPlan, ...], numbers: StudentOutput, own: RecoveryPlan | None
    ) -> list[RecoveryPlan]:
        """Return the plans for the guard, best first.

        Plans that failed before in this intervention come last, unless the rules propose them again.
        """
        accepted = 1.0 / (1.0 + np.exp(-numbers.accepted.astype(np.float64)))
        shares = np.exp(numbers.prior.astype(np.float64) - float(numbers.prior.max()))
        fits = shares / shares.max()
        tried = {attempt.behaviors for attempt in scene.attempts}
        blocked = blocker(scene) is not None and scene.guidance is None
        ranked = []
        for number, plan in enumerate(plans):
            ours = plan == own
            stays = blocked and all(b.stays_behind_blocker for b in plan.behaviors)
            if (accepted[number] < self._choice.unlikely or stays) and not ours:
                continue
            # With guidance, the match with the utterance ranks the plans; without guidance, their value does.
            worth = fits[number] if scene.guidance is not None else float(numbers.value[number])
            score = accepted[number] * worth + (self._choice.margin if ours else 0.0)
            again = not ours and tuple(b.name for b in plan.behaviors) in tried
            ranked.append((again, -score, number))
        return [plans[number] for _, _, number in sorted(ranked)]


def held_by_law(scene: Scene) -> bool:
    """True if the rules of the road hold the vehicle, however long it has been stopped.

    The reasons are a light, a closed gate, or a road user with right of way. There the rule-based reasoner requests
    assistance when the wait is too long.
    """
    lead = blocker(scene)
    gated = lead is not None and lead.kind is ObjectKind.CROSSING_GATE
    return gated or red_light_within(scene, LIGHT_AHEAD_M) is not None or goes_first(scene) is not None


def _wanted(scene: Scene) -> bool:
    """True if a plan is permitted: the passenger requests it, or the vehicle makes no progress."""
    if scene.guidance is not None:
        return _asked(scene) in REQUESTS
    return (scene.ego.is_slow or loops(scene)) and not scene.ego.at_destination


def _unheld(scene: Scene, rules_decision: Decision) -> bool:
    """True if the rules find neither a reason to wait nor a plan, so there is nothing to pass."""
    nothing = rules_decision.plan is None and rules_decision.analysis.wait is None
    return nothing and scene.guidance is None and not loops(scene)


def _asked(scene: Scene) -> GuidanceIntent:
    reading = None if scene.guidance is None else scene.guidance.reading
    return GuidanceIntent.UNCLEAR if reading is None else reading.intent


def _cause(scene: Scene, numbers: StudentOutput, rules_cause: CauseCode | None) -> CauseCode:
    """Return the cause: that of the rules if they find one, else the network's."""
    if loops(scene):
        return CauseCode.LOOP
    if rules_cause not in (None, CauseCode.UNKNOWN):
        return rules_cause
    standing = [(logit, item) for logit, item in zip(numbers.cause, CAUSES, strict=True) if item is not CauseCode.LOOP]
    return max(standing, key=lambda pair: pair[0])[1]


def _participants(encoded: EncodedScene, numbers: StudentOutput) -> tuple[tuple[str, Intent], ...]:
    best = numbers.intent[: len(encoded.ids)].argmax(axis=1)
    found = [(name, INTENTS[k]) for name, k in zip(encoded.ids, best, strict=True)]
    return tuple((name, intent) for name, intent in found if intent is not None)[:MOST_PARTICIPANTS]


def _parse(text: str, scene: Scene) -> Decision:
    """Return a recorded answer as a decision."""
    try:
        return render(read_chain(text), scene)
    except ChainError as error:
        raise ReasonerError(str(error)) from error


PARSERS[FORMAT] = _parse
