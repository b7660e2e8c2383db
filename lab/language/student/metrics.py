"""Scores the student on samples that it was not trained on, in comparison with the rules. It requires no torch.

Each standstill has the same weight, however long it was: its samples share it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from stucksolver.reasoners.rules import RuleReasoner

from lab.language.student.data import Example
from stucksolver.plan import CauseCode, RecoveryPlan
from stucksolver.reasoners.reasoner import ACCEPTED, Reasoner, ReasonerRequest
from stucksolver_language.student.heads import CAUSES, TIMES_S, StudentOutput, ends_within
from stucksolver_language.student.network import StudentNetwork
from stucksolver_language.student.scene_codec import read_scene
from stucksolver_language.student.student_reasoner import SelectionPolicy

BINS = 10
"""Number of bins of the calibration."""
SOON_S = 10.0
"""Time within which the end of a wait makes it worthwhile (s). Ours."""
ASKED = SelectionPolicy().tried
"""Number of plans that the guard checks, as in the student."""
Array = NDArray[np.float64]


@dataclass(frozen=True)
class ScoredExamples:
    """Examples with the network's outputs. `weight` gives each standstill the same share (examples,)."""

    examples: list[Example]
    numbers: list[StudentOutput]
    weight: Array


def answered(network: StudentNetwork, examples: Sequence[Example]) -> ScoredExamples:
    """Return the network's answers to examples."""
    keys = [(m.suite, m.route_id, m.seed, m.standstill) for m in (example.moment for example in examples)]
    counts = Counter(keys)
    numbers = [network.run(example.scene, example.plans, example.named) for example in examples]
    return ScoredExamples(list(examples), numbers, np.array([1.0 / counts[key] for key in keys]))


def scores(scored: ScoredExamples) -> dict[str, Any]:
    """Return all scores of one group of examples, in the form of the card."""
    found: dict[str, Any] = {
        "moments": len(scored.examples),
        "standstills": round(float(scored.weight.sum())),
        "wait": {f"{until:g}": wait_scores(scored, number) for number, until in enumerate(TIMES_S)},
    }
    return found | {"cause": cause_scores(scored), "plans": plan_scores(scored), "words": word_scores(scored)}


def with_choices(found: dict[str, Any], student: Reasoner, examples: Sequence[Example]) -> dict[str, Any]:
    """Return scores with the choices of the student and the rules at the same samples."""
    choices = {name: choice_scores(item, examples) for name, item in (("student", student), ("rules", RuleReasoner()))}
    return found | {"choices": choices}


def wait_scores(scored: ScoredExamples, number: int) -> dict[str, Any]:
    """Return the calibration of the probability that the wait ends within `TIMES_S[number]`."""
    p, y, w, rules = _ends(scored, number)
    if not len(p):
        return {"moments": 0}
    base = float(np.average(y, weights=w))
    return {
        "moments": len(p),
        "share": round(base, 3),
        "brier": round(float(np.average((p - y) ** 2, weights=w)), 4),
        "brier_of_share": round(base * (1.0 - base), 4),
        "accuracy": round(float(np.average((p >= 0.5) == y, weights=w)), 3),
        "accuracy_rules": round(float(np.average(rules == y, weights=w)), 3),
        "calibration": calibration(p, y, w),
    }


def _ends(scored: ScoredExamples, number: int) -> tuple[Array, Array, Array, Array]:
    """Return the probability, the truth, the weight, and whether the rules wait, for known truths."""
    rows = []
    for example, out, weight in zip(scored.examples, scored.numbers, scored.weight, strict=True):
        labels = example.ends[: number + 1]
        if not (labels == 1).any() and labels[-1] != 0:
            continue
        rows.append(
            (ends_within(out.hazard)[number], float((labels == 1).any()), weight, float(example.rules_hold > 0))
        )
    table = np.array(rows, np.float64).reshape(-1, 4)
    return table[:, 0], table[:, 1], table[:, 2], table[:, 3]


def calibration(p: Array, y: Array, w: Array) -> list[dict[str, float]]:
    """Return the number of samples, their mean probability and the true share for each bin of probabilities."""
    place = np.minimum((p * BINS).astype(int), BINS - 1)
    return [
        {
            "from": number / BINS,
            "moments": int(here.sum()),
            "weight": round(float(w[here].sum()), 1),
            "said": round(float(np.average(p[here], weights=w[here])), 3),
            "true": round(float(np.average(y[here], weights=w[here])), 3),
        }
        for number in range(BINS)
        for here in (place == number,)
        if here.any()
    ]


def cause_scores(scored: ScoredExamples) -> dict[str, Any]:
    """Return the share of right causes among the known ones.

    It is given for the network, the rules, and the student's answer, which is that of the rules if they have one.
    """
    unsure = (-1, CAUSES.index(CauseCode.UNKNOWN))
    rows = [
        (
            float(out.cause.argmax() == example.true_cause),
            float(example.rules_cause == example.true_cause),
            float((out.cause.argmax() if example.rules_cause in unsure else example.rules_cause) == example.true_cause),
            weight,
        )
        for example, out, weight in zip(scored.examples, scored.numbers, scored.weight, strict=True)
        if example.true_cause >= 0
    ]
    if not rows:
        return {"moments": 0}
    network, rules, student, weight = np.array(rows).T
    return {
        "moments": len(rows),
        "network": round(float(np.average(network, weights=weight)), 3),
        "student": round(float(np.average(student, weights=weight)), 3),
        "rules": round(float(np.average(rules, weights=weight)), 3),
    }


def plan_scores(scored: ScoredExamples) -> dict[str, Any]:
    """Return the share of the network's plans that the guard accepts, where it accepts any and there is no guidance.

    `first` is the share for the plan ranked first, `within` for one of the first `ASKED`, and `rules_accepted` for any
    plan of the kind that the rules propose.
    """
    rows = []
    for example, out in zip(scored.examples, scored.numbers, strict=True):
        if not (example.accepted == 1).any() or example.hold < 0:
            continue
        order = np.argsort(-out.value / (1.0 + np.exp(-out.accepted)), kind="stable")[:ASKED]
        taken = example.accepted[order] == 1
        rows.append((float(taken[0]), float(taken.any()), float((example.fitting & (example.accepted == 1)).any())))
    if not rows:
        return {"moments": 0}
    names = ("first", "within", "rules_accepted")
    return {"moments": len(rows)} | {
        name: round(float(mean), 3) for name, mean in zip(names, np.mean(rows, axis=0), strict=True)
    }


def choice_scores(reasoner: Reasoner, examples: Sequence[Example]) -> dict[str, Any]:
    """Return a reasoner's decisions at the samples with judged plans, and their consequences.

    `waits` is the share of samples at which it has no plan that the guard accepts. `worth` is the mean quick value of
    the plan (m), with 0 for a wait. `patient` is the share of waits among the samples at which the driver goes on by
    itself within 10 s, and `idle` among those at which it does not do so within 40 s.
    """
    rows = []
    for example in examples:
        if not example.moment.plans or example.hold < 0:
            continue
        judged = {plan.plan: plan.value_m for plan in example.moment.plans}
        scene = read_scene(example.moment.scene)

        def check(plan: RecoveryPlan, judged: dict[RecoveryPlan, float | None] = judged) -> str:
            return ACCEPTED if judged.get(plan) is not None else "not accepted"

        plan = reasoner.decide(ReasonerRequest(scene, check)).decision.plan
        value = None if plan is None else judged.get(plan)
        gone = example.moment.gone_after_s
        soon = gone is not None and gone <= SOON_S
        never = example.ends[-1] == 0
        rows.append((float(value is None), value or 0.0, float(soon), float(never)))
    if not rows:
        return {"moments": 0}
    waits, worth, soon, never = np.array(rows).T
    return {
        "moments": len(rows),
        "waits": round(float(waits.mean()), 3),
        "worth": round(float(worth.mean()), 2),
        "patient": round(float(waits[soon == 1].mean()), 3) if soon.any() else None,
        "idle": round(float(waits[never == 1].mean()), 3) if never.any() else None,
    }


def word_scores(scored: ScoredExamples) -> dict[str, Any]:
    """Return how often the student's best plan after a passenger's request is of the rules' kind."""
    rows = [
        (float(example.fitting[out.prior.argmax()]), float(example.fitting.mean()))
        for example, out in zip(scored.examples, scored.numbers, strict=True)
        if example.hold < 0 and example.fitting.any()
    ]
    if not rows:
        return {"moments": 0}
    right, chance = np.mean(rows, axis=0)
    return {"moments": len(rows), "right": round(float(right), 3), "by_chance": round(float(chance), 3)}


def temperature_of(scored: ScoredExamples) -> float:
    """Return the temperature of the hazards with the least surprise in the drives."""
    tried = np.geomspace(0.5, 4.0, 43)
    losses = [_surprise(scored, float(item)) for item in tried]
    return float(tried[int(np.argmin(losses))])


def _surprise(scored: ScoredExamples, temperature: float) -> float:
    total = 0.0
    for example, out, weight in zip(scored.examples, scored.numbers, scored.weight, strict=True):
        known = example.ends >= 0
        sign = np.where(example.ends[known] == 1, -1.0, 1.0)
        total += float(weight * np.logaddexp(0.0, sign * out.hazard[known].astype(np.float64) / temperature).sum())
    return total
