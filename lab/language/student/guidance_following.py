"""Scores the student's plan after a passenger's sentence: whether it is of the kind that the sentence requests.

Each sentence is used at samples of collected drives at which the guard accepted a plan of that kind without guidance.
The interpreter interprets it, and the student decides with the interpretation. In comparison, the student decides with
the meaning that the sentence's author gave, which shows the interpreter's share of the misses. It requires no torch.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from lab.language.plan_search.decision_samples import DecisionSample, read_moments
from lab.language.student.data import files_in, held_out
from stucksolver.interpreter import Interpreter
from stucksolver.plan import RecoveryPlan, plan_matches_intent
from stucksolver.reasoners.reasoner import ACCEPTED, ReasonerRequest
from stucksolver.scene import DirectedSide, Guidance, GuidanceIntent, Interpretation, Scene
from stucksolver_language.student import DistilledReasoner
from stucksolver_language.student.candidates import leads_on
from stucksolver_language.student.scene_codec import read_scene

PER_SENTENCE = 5
"""Maximum number of samples for each sentence, spread evenly over the fitting ones. Ours."""


@dataclass(frozen=True)
class Sentence:
    """A sentence with its author's meaning."""

    text: str
    situation: str
    meant: Interpretation


@dataclass(frozen=True)
class PlanSample:
    """A sample of a drive: the scene, and the plans that the guard accepted there."""

    scene: Scene
    accepted: tuple[RecoveryPlan, ...]


def sentences_in(files: Sequence[Path]) -> list[Sentence]:
    """Return the sentences in files such as results/words/blind-1.jsonl.

    Raises:
        ValueError: A line is no such sentence. The message has its position.
    """
    lines = [(path, k, line) for path in files for k, line in enumerate(path.read_text("utf-8").splitlines(), 1)]
    return [_sentence(line, f"{path}:{number}") for path, number, line in lines]


def _sentence(line: str, where: str) -> Sentence:
    try:
        item = json.loads(line)
        intent, side = GuidanceIntent(item["intent"]), item["side"]
        side = side and DirectedSide(side)
        meant = Interpretation(intent=intent, likely=intent, side=side, confidence=1.0, reader="author")
        return Sentence(item["text"], item["situation"], meant)
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(f"{where}: no sentence with text, situation, intent and side") from error


def places_in(folders: Sequence[Path], maps: Sequence[str]) -> list[PlanSample]:
    """Return the samples of drives that were not trained on and at which the guard accepted a plan.

    Raises:
        ValueError: A file of samples is damaged.
    """
    moments = [moment for path in files_in(folders) for moment in read_moments(path)]
    held = [sample for sample in moments if held_out(sample, maps) in ("types", "maps")]
    places = [PlanSample(read_scene(item.scene), _accepted(item)) for item in held]
    return [place for place in places if place.accepted]


def _accepted(moment: DecisionSample) -> tuple[RecoveryPlan, ...]:
    return tuple(plan.plan for plan in moment.plans if plan.value_m is not None)


def matches_request(meant: Interpretation, plan: RecoveryPlan) -> bool:
    """True if a plan is of the requested kind. The vehicle is stopped at these samples, so passing is going on, too."""
    return plan_matches_intent(meant, plan) or (meant.intent is GuidanceIntent.GO and leads_on(plan))


def wording_scores(
    sentences: Sequence[Sentence], places: Sequence[PlanSample], student: DistilledReasoner, reader: Interpreter
) -> dict[str, Counter[str]]:
    """Return the number of trials and of each result by intent.

    `read` is a plan of the requested kind after the interpreter's interpretation, `meant` after the author's.
    `asked_back`, `other` and `none` are the other results with the interpreter: the vehicle asks what was meant,
    proposes another plan, or none.
    """
    found: dict[str, Counter[str]] = {}
    for number, sentence in enumerate(sentences):
        fitting = [p for p in places if any(matches_request(sentence.meant, plan) for plan in p.accepted)]
        if not fitting:
            continue
        count = found.setdefault(sentence.meant.intent.value, Counter())
        reading = reader.read(sentence.text, sentence.situation)
        count["sentences"] += 1
        apart = -(-len(fitting) // PER_SENTENCE)
        for place in fitting[number % apart :: apart]:
            count["trials"] += 1
            count[_ending(sentence, reading, place, student)] += 1
            count["meant"] += _ending(sentence, sentence.meant, place, student) == "read"
    return found


def _ending(sentence: Sentence, reading: Interpretation, place: PlanSample, student: DistilledReasoner) -> str:
    if reading.intent is GuidanceIntent.UNCLEAR:
        return "asked_back"
    guidance = Guidance(text=sentence.text[:500], time_s=place.scene.time_s, reading=reading)

    def check(plan: RecoveryPlan) -> str:
        return ACCEPTED if plan in place.accepted else "not accepted"

    request = ReasonerRequest(place.scene.model_copy(update={"guidance": guidance}), check)
    plan = student.decide(request).decision.plan
    if plan is None:
        return "none"
    return "read" if matches_request(sentence.meant, plan) else "other"


def wording_table(found: dict[str, Counter[str]]) -> str:
    """Return the scores as a table, with a row for each intent and one for all."""
    rows = [
        "| asked for | sentences | trials | plan of that kind | meaning given | asks back | no plan | another |",
        "|---|---|---|---|---|---|---|---|",
    ]
    total: Counter[str] = Counter()
    for count in found.values():
        total.update(count)
    for name, count in [*sorted(found.items()), ("all", total)]:
        shares = [f"{100 * count[key] / max(count['trials'], 1):.1f} %" for key in ("read", "meant")]
        rest = [str(count[key]) for key in ("asked_back", "none", "other")]
        rows.append(f"| {' | '.join([name, str(count['sentences']), str(count['trials']), *shares, *rest])} |")
    return "\n".join(rows)
