"""Implements `python -m lab distill train`, `eval` and `export`."""

from __future__ import annotations

import json
import shlex
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lab.language.student.data import Example, examples, files_in
from lab.language.student.metrics import answered, scores, temperature_of, with_choices
from lab.language.student.report import draw_calibration, report
from stucksolver.optional_dependencies import can_plot
from stucksolver_language.student import DistilledReasoner
from stucksolver_language.student.network import CARD, WEIGHTS, Card, StudentNetwork, card_text
from stucksolver_language.student.vocabulary import vocabulary

SCORES, PLOT = "student_scores.json", "calibration.svg"
HELD_OUT = ("tune", "types", "maps", "routes")
Say = Callable[[str], None]


@dataclass(frozen=True)
class StudentJob:
    """Options of a training.

    Attributes:
        data: Folders that `python -m lab distill collect --waits` filled.
        out: Folder for the weights, their card and the scores.
        apart: Maps, and routes as `SUITE/ID`, that are held out as a whole.
        minutes, steps, seed: As in `lab.language.student.train.Settings`.
    """

    data: tuple[Path, ...]
    out: Path
    apart: tuple[str, ...] = ("motorway",)
    minutes: float = 5.0
    """Training time (min). Ours."""
    steps: int | None = None
    seed: int = 1
    """Seed of the weights, the order and the noise."""


def train(asked: StudentJob, say: Say) -> Path:
    """Train, calibrate, export and score a student, and return the path of its card. It requires torch.

    Raises:
        ValueError: There are no samples, or a file of them is damaged.
        ExportError: The exported network differs from the trained one.
    """
    from lab.language.student.export import export
    from lab.language.student.train import StudentTrainOptions, fit

    words = vocabulary()
    groups = _groups(asked.data, asked.apart, asked.seed)
    say(", ".join(f"{name} {len(found)}" for name, found in groups.items()) + " examples")
    taught = groups.get("train", [])
    settings = StudentTrainOptions(minutes=asked.minutes, steps=asked.steps, seed=asked.seed)
    net = fit(taught, words.width + 1, settings, say)
    card = export(net, asked.out, words, _trained(asked, groups), taught)
    temperature = temperature_of(answered(StudentNetwork(asked.out), groups.get("tune") or taught))
    card = _rewritten(card, asked.out, temperature=round(temperature, 3))
    found = evaluate(asked.out, asked.out, groups, say)
    _rewritten(card, asked.out, scores=_short(found))
    return asked.out / CARD


def _rewritten(card: Card, folder: Path, **changes: Any) -> Card:
    """Write a card with some values changed to a folder, and return it."""
    changed = card.model_copy(update=changes)
    (folder / CARD).write_text(card_text(changed), encoding="utf-8")
    return changed


def score(data: Sequence[Path], weights: Path, out: Path, apart: Sequence[str], say: Say) -> dict[str, Any]:
    """Score the weights of a folder on samples, and write the metrics to another one.

    Raises:
        ValueError: There are no samples, or a file of them is damaged.
    """
    return evaluate(weights, out, _groups(data, apart, 1), say)


def evaluate(weights: Path, out: Path, groups: dict[str, list[Example]], say: Say) -> dict[str, Any]:
    """Score on the groups that were not trained on, print the tables, and draw the calibration if possible."""
    out.mkdir(parents=True, exist_ok=True)
    network = StudentNetwork(weights)
    student = DistilledReasoner(weights)
    found = {
        name: with_choices(scores(answered(network, groups[name])), student, groups[name])
        for name in HELD_OUT
        if groups.get(name)
    }
    say(report(found))
    (out / SCORES).write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    if can_plot() and found:
        draw_calibration(found, out / PLOT)
    return found


def copy_to(weights: Path, out: Path) -> Path:
    """Check the weights of a folder and copy the files for the runtime to another one.

    Raises:
        StudentWeightsError: The weights cannot be used.
    """
    card = StudentNetwork(weights).card
    out.mkdir(parents=True, exist_ok=True)
    (out / WEIGHTS).write_bytes((weights / WEIGHTS).read_bytes())
    (out / CARD).write_text(card_text(card), encoding="utf-8")
    return out / WEIGHTS


def _groups(data: Sequence[Path], apart: Sequence[str], seed: int) -> dict[str, list[Example]]:
    found: dict[str, list[Example]] = {}
    for example in examples(files_in(data), vocabulary(), apart, seed):
        found.setdefault(example.group, []).append(example)
    if not found:
        raise ValueError("no samples in these folders. Run `python -m lab distill collect --waits` first")
    return found


def _trained(asked: StudentJob, groups: dict[str, list[Example]]) -> dict[str, Any]:
    """Return the origin of the weights for people: the command without folders of this machine, and the data."""
    command = ["stucksolver", "distill", "train", "--data", "DIR", "--seed", str(asked.seed)]
    command += ["--steps", str(asked.steps)] if asked.steps else ["--minutes", f"{asked.minutes:g}"]
    moments = [group.moment for group in groups.get("train", ()) if group.hold >= 0]
    return {
        "command": shlex.join([*command, "--hold-out", ",".join(asked.apart), "--out", "OUT"]),
        "moments": len(moments),
        "standstills": len({(m.suite, m.route_id, m.seed, m.standstill) for m in moments}),
        "drives": dict(sorted(Counter(s for s, *_ in {(m.suite, m.route_id, m.seed) for m in moments}).items())),
        "held_out_types": sorted({group.moment.scenario for group in groups.get("types", ())}),
        "held_out_maps_and_routes": sorted(asked.apart),
    }


def _short(found: dict[str, Any]) -> dict[str, Any]:
    """Return the scores for the card, without the tables of calibration."""
    return {
        name: {**item, "wait": {t: {k: v for k, v in w.items() if k != "calibration"} for t, w in item["wait"].items()}}
        for name, item in found.items()
    }
