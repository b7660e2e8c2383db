"""Examples for the student, from collected samples: numbers, labels, and the group of each.

The rules are queried here for their answers. They teach the wording of the chain (the reason of a wait, the next action
of each object) and the plan that fits a passenger's utterance. The end of the wait, the cause and the plans that the
guard accepts are known from the drives.
"""

from __future__ import annotations

import hashlib
import math
import random
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from stucksolver.reasoners.rules import RuleReasoner

from lab.language.plan_search.decision_samples import DecisionSample, read_moments
from lab.language.student.scenario_causes import CAUSE_OF
from stucksolver.plan import CauseCode, RecoveryPlan
from stucksolver.reasoners.reasoner import ReasonerRequest
from stucksolver.scene import REQUESTS, DirectedSide, Guidance, Interpretation, Scene
from stucksolver_language.llm.prompt import user_text
from stucksolver_language.llm.prompt_parser import read_prompt
from stucksolver_language.student.candidates import candidates, leads_on
from stucksolver_language.student.feature_encoding import MOST, EncodedScene, Floats, encode, encode_plans
from stucksolver_language.student.heads import CAUSES, HOLDS, INTENTS, TIMES_S
from stucksolver_language.student.scene_codec import read_scene
from stucksolver_language.student.vocabulary import Vocabulary

WORTH_M = 10.0
"""Unit of a plan's value (m). Ours."""
TUNED = 10
"""One of this many drives is not trained on, but calibrates the probabilities. Ours."""
BEGUN_S = 3.0
"""Time before which a stopped vehicle has not set off at all (s). Ours.

The end of such a wait is trivial to predict.
"""
BLURRED = 0.3
"""Share of the samples that are also learned in the less exact form of a language model's prompt. Ours."""
LEAST_M = -30.0
"""Least value of a plan that is distinguished (m). Ours; lower ones are equally bad."""
WORDS_EACH = 3
"""Number of requests by a passenger that are tried at each sample whose plans were judged. Ours."""


@dataclass(frozen=True)
class Example:
    """One sample as numbers, with its labels; -1 for an unknown label.

    Attributes:
        group: Result of `held_out`.
        scene: The scene as numbers.
        ends: For each interval of `TIMES_S`: 1 the wait ended in it, 0 it lasted longer, -1 not known (5,).
        cause, hold: Index of the label. The cause is that of the rules, or of the scenario if the rules have none:
            there are too few types of scenarios to learn all causes from them.
        true_cause: Cause of the scenario, for the scores; -1 without one.
        intents: Index of the label for each row of objects (rows,).
        plans, named: The candidate plans as numbers.
        accepted: 1, 0, or -1 for each plan (plans,).
        value: Value of each plan in `WORTH_M`; NaN if not known (plans,).
        fitting: True for the plans of the same kind as the rules' plan (plans,); all False if they have none.
        rules_cause, rules_hold: Answers of the rules.
    """

    group: str
    moment: DecisionSample
    scene: EncodedScene
    ends: NDArray[np.int64]
    cause: int
    true_cause: int
    hold: int
    intents: NDArray[np.int64]
    plans: Floats
    named: NDArray[np.int64]
    accepted: NDArray[np.int64]
    value: Floats
    fitting: NDArray[np.bool_]
    rules_cause: int
    rules_hold: int


def held_out(moment: DecisionSample, apart: Sequence[str], share: int = 5) -> str:
    """Return the group of a sample: `train`, `tune` (for the temperature only), `types`, `maps` or `routes`.

    Variants of one situation (`…TwoWays`, `…V2`) stay together.

    Args:
        moment: The sample.
        apart: Maps, and routes as `SUITE/ID`, that are held out as a whole.
        share: One of this many families of scenario types is held out.
    """
    if moment.town in apart:
        return "maps"
    if f"{moment.suite}/{moment.route_id}" in apart:
        return "routes"
    family = moment.scenario.removesuffix("TwoWays").removesuffix("V2")
    if _number(family) % share == 0:
        return "types"
    return "tune" if _number(f"{moment.suite} {moment.route_id} {moment.seed}") % TUNED == 0 else "train"


def _number(text: str) -> int:
    return int(hashlib.sha256(text.encode()).hexdigest(), 16)


def files_in(folders: Iterable[Path]) -> list[Path]:
    """Return the files of samples in folders that `python -m lab distill collect --waits` filled, in order."""
    return sorted(path for folder in folders for path in folder.rglob("*.jsonl.gz"))


def examples(paths: Iterable[Path], words: Vocabulary, apart: Sequence[str], seed: int) -> Iterator[Example]:
    """Yield the examples of files of samples.

    Raises:
        ValueError: A file is damaged. The message has its name.
    """
    rng = random.Random(seed)
    for path in paths:
        for moment in read_moments(path):
            if moment.at_s < BEGUN_S and moment.answer is None:
                continue
            scene = read_scene(moment.scene)
            group = held_out(moment, apart)
            yield example(moment, scene, group, words)
            if group == "train" and rng.random() < BLURRED:
                yield example(moment, read_prompt(user_text(scene)), group, words)
            if moment.plans:
                for reading in rng.sample(_requests(), WORDS_EACH):
                    yield _guided(moment, scene, group, words, reading)


def example(moment: DecisionSample, scene: Scene, group: str, words: Vocabulary) -> Example:
    """Return one sample as an example, without an utterance."""
    rules = RuleReasoner().decide(ReasonerRequest(scene)).decision
    decision = moment.answer or rules
    encoded = encode(scene)
    judged_plans = [plan for plan in moment.plans if leads_on(plan.plan)]
    judged = [item.value_m for item in judged_plans]
    plans = [item.plan for item in judged_plans] or _answered(moment, scene)
    unjudged = len(plans) - len(judged)
    rows, named = encode_plans(plans, encoded.ids, words)
    stuck = moment.gone_after_s is None and moment.watched_s >= TIMES_S[-1]
    true = CAUSE_OF.get(moment.scenario) if stuck else None
    known_cause = decision.analysis.cause
    cause = true if known_cause in (None, CauseCode.UNKNOWN) else known_cause
    intents = np.full(MOST["objects"], -1, np.int64)
    intent_by_id = {participant.object_id: participant.intent for participant in decision.observation.participants}
    for row, name in enumerate(encoded.ids):
        intents[row] = INTENTS.index(intent_by_id.get(name))
    return Example(
        group=group,
        moment=moment,
        scene=encoded,
        ends=ends_of(moment.gone_after_s, moment.watched_s),
        cause=-1 if cause is None else CAUSES.index(cause),
        true_cause=-1 if true is None else CAUSES.index(true),
        hold=HOLDS.index(decision.analysis.wait),
        intents=intents,
        plans=rows,
        named=named,
        accepted=np.array([*(int(item is not None) for item in judged), *[-1] * unjudged], np.int64),
        value=np.array([*map(_worth, judged), *[math.nan] * unjudged], np.float32),
        fitting=_fitting(plans, decision.plan),
        rules_cause=-1 if rules.analysis.cause is None else CAUSES.index(rules.analysis.cause),
        rules_hold=HOLDS.index(rules.analysis.wait),
    )


def _answered(moment: DecisionSample, scene: Scene) -> list[RecoveryPlan]:
    """Return the plans among which a recorded answer chose; none if it had no plan."""
    if moment.answer is None or moment.answer.plan is None:
        return []
    return list(dict.fromkeys((moment.answer.plan, *candidates(scene))))


def _worth(value_m: float | None) -> float:
    return math.nan if value_m is None else max(value_m, LEAST_M) / WORTH_M


def ends_of(gone_after_s: float | None, watched_s: float) -> NDArray[np.int64]:
    """Return for each interval of `TIMES_S` whether the wait ended in it (1), lasted longer (0), or is not known (-1).

    Args:
        gone_after_s: Time of its end (s); None if it did not end.
        watched_s: Observed time (s).
    """
    found = np.full(len(TIMES_S), -1, np.int64)
    for number, until_s in enumerate(TIMES_S):
        if gone_after_s is not None and gone_after_s <= until_s:
            found[number] = 1
            break
        if gone_after_s is None and watched_s < until_s:
            break
        found[number] = 0
    return found


def _requests() -> list[Interpretation]:
    asked = sorted(REQUESTS, key=lambda request: request.value)
    sides = (None, *DirectedSide)
    return [Interpretation(intent=i, likely=i, side=s, confidence=1.0, reader="labels") for i in asked for s in sides]


def _guided(moment: DecisionSample, scene: Scene, group: str, words: Vocabulary, reading: Interpretation) -> Example:
    """Return the sample after a passenger's request. Only the fitting plan is learned from it."""
    guidance = Guidance(text="", time_s=scene.time_s, reading=reading)
    asked = scene.model_copy(update={"guidance": guidance})
    found = example(moment, asked, group, words)
    unknown = np.full_like(found.ends, -1)
    return replace(found, ends=unknown, cause=-1, true_cause=-1, hold=-1)


def _fitting(plans: Sequence[RecoveryPlan], wanted: RecoveryPlan | None) -> NDArray[np.bool_]:
    """Return which plans are of the same kind as a plan: the same behaviors with the same objects and choices."""
    if wanted is None:
        return np.zeros(len(plans), np.bool_)
    kind = kind_of(wanted)
    return np.array([kind_of(plan) == kind for plan in plans], np.bool_)


def kind_of(plan: RecoveryPlan) -> tuple[tuple[object, ...], ...]:
    """Return the kind of a plan, without its numbers and its standing behaviors."""
    moving = [behavior for behavior in plan.behaviors if not behavior.stands_still]
    return tuple(tuple(v for _, v in obj if isinstance(v, str)) for obj in moving)
