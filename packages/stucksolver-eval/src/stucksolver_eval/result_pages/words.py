#!/usr/bin/env python3
"""Writes results/words.md: accuracy of the interpreter on the blind sentences, compared with simple patterns.

```sh
python -m stucksolver_eval.result_pages.words
```

Needs the extra [language] of the README. The authors of the sentences in results/words had access to neither the
grammar nor the training sentences.
"""

from __future__ import annotations

import json
import re
from collections import Counter
from dataclasses import dataclass

import numpy as np

from stucksolver.scene import GuidanceIntent, Interpretation
from stucksolver.scene.interpretation import MOVES, STAYS
from stucksolver_eval.result_pages import RESULTS
from stucksolver_language.intent.intent_decoder import INTENTS
from stucksolver_language.intent.network import NetworkInterpreter

SETS = ("blind-1", "blind-2", "blind-3")
BINS = ((0.0, 0.5), (0.5, 0.7), (0.7, 0.8), (0.8, 0.85), (0.85, 0.9), (0.9, 1.01))
"""Bins of confidence in the table of calibration. Ours."""
PATTERNS = (
    ("wait", r"\b(do ?n.?t|do not|(?<!will )(?<!will never )(never(?! mind)|stop|wait|stay)|hold on|not yet)\b"),
    ("pull_over", r"\b(pull(ing)? over|pull to the side|to the roadside)\b"),
    ("back_up", r"\b(back (it )?up|reverse|go back a (bit|little))\b"),
    ("drive_over", r"\bdrive (right )?over\b"),
    ("overtake", r"\b(over ?take|pass|get past|go (a)?round|drive (a)?round|get (a)?round)\b"),
    ("overtake", r"\b(left|right)\b"),
    ("go", r"\b(go|drive|move|edge|creep|continue|proceed)\b"),
)
"""Patterns of an earlier interpreter. They did not distinguish small talk from unclear requests."""

TITLE = "# What the reader of words understands"
ABOUT = """There are three sets of 500 sentences, written by three authors who had seen neither the grammar nor the
training sentences. None of these sentences was used for training. The misses of the first two sets were known when the
training set grew from 10,800 to 21,900 sentences. It has not changed since, so the third set is independent of the
weights. The confidence thresholds were set on 1,149 held-out training sentences. Only the one of reroute, 0.85, was
chosen after looking at these sets: it gave two more true positives and no more false positives.
"Understood": the most likely intent is the intended one. "Acted on as meant": so is the intent after the confidence
threshold. A reading that would move the vehicle counts only if it is confident enough
([docs/words.md](../docs/words.md)); otherwise the passenger is asked again. The rules that take away what words deny,
forbid or warn of are included; they were written with the misses of these sets known. "Moves wrongly" counts readings
that may move the vehicle although the sentence asked for no motion, or forbade that one. "Holds needlessly" counts
readings that hold it although the sentence asked for a motion, or for nothing and did not warn. The
guard still decides after that."""


@dataclass(frozen=True)
class Read:
    """A blind sentence with its interpretation, and the intent that the patterns find."""

    sentence: dict[str, object]
    reading: Interpretation
    pattern: str

    @property
    def meant_intent(self) -> str:
        """The intent of the sentence's author."""
        return str(self.sentence["intent"])

    @property
    def understood(self) -> bool:
        """True if the most likely intent is the intended one."""
        return self.reading.likely.value == self.meant_intent

    @property
    def acted(self) -> bool:
        """True if the intent after the confidence threshold is the intended one."""
        return self.reading.intent.value == self.meant_intent

    @property
    def held_needlessly(self) -> bool:
        """True if the interpretation holds the vehicle although the sentence neither asked for that nor warned."""
        warned = not {"not_clear", "returning_soon"}.isdisjoint(self.sentence["claims"])  # type: ignore[arg-type]
        meant = GuidanceIntent(self.meant_intent)
        return self.reading.intent in STAYS and meant not in STAYS | {GuidanceIntent.UNLAWFUL} and not warned

    @property
    def moved_wrongly(self) -> bool:
        """True if the interpretation asks for a motion although the sentence asked for none or forbade this one."""
        unsafe = self.reading.intent.value in self.sentence["unsafe_if"]  # type: ignore[operator]
        wrong = GuidanceIntent(self.meant_intent) not in MOVES or unsafe
        return self.reading.intent in MOVES and not self.acted and wrong


def pattern_intent(text: str) -> str:
    """Return the intent that the patterns find in a sentence."""
    return next((intent for intent, pattern in PATTERNS if re.search(pattern, text.lower())), "unclear")


def read_set(name: str, reader: NetworkInterpreter) -> list[Read]:
    """Interpret a blind set with the interpreter and the patterns."""
    lines = (RESULTS / "words" / f"{name}.jsonl").read_text(encoding="utf-8").splitlines()
    sentences = [json.loads(line) for line in lines]
    return [Read(s, reader.read(s["text"], s["situation"]), pattern_intent(s["text"])) for s in sentences]


def by_class(reads: list[Read]) -> list[str]:
    """Return the table of one set, a row per class."""
    rows = [
        "| class | sentences | understood | acted on as meant | asked back | moves wrongly | holds needlessly "
        "| patterns |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for kind in [*dict.fromkeys(str(r.sentence["class"]) for r in reads), "all"]:
        some = [r for r in reads if kind in (r.sentence["class"], "all")]
        back = sum(r.reading.intent is GuidanceIntent.UNCLEAR and r.meant_intent != "unclear" for r in some)
        fits = sum(r.pattern == r.meant_intent or (r.pattern == "unclear" and r.meant_intent == "none") for r in some)
        wrongly = sum(r.moved_wrongly for r in some)
        holds = sum(r.held_needlessly for r in some)
        flags = ([r.understood for r in some], [r.acted for r in some])
        shares = " | ".join(f"{100 * sum(flag) / len(some):.1f} %" for flag in flags)
        rows.append(
            f"| {kind} | {len(some)} | {shares} | {back} | {wrongly} | {holds} | {100 * fits / len(some):.1f} % |"
        )
    return rows


def calibration(reads: list[Read]) -> list[str]:
    """Return the calibration table: the share of correct interpretations by confidence."""
    rows = ["| confidence | readings | mean confidence | right |", "|---|---|---|---|"]
    for low, high in BINS:
        some = [r for r in reads if low <= r.reading.confidence < high]
        if some:
            mean = np.mean([r.reading.confidence for r in some])
            right = np.mean([r.understood for r in some])
            rows.append(f"| {low:.2f} to {min(high, 1.0):.2f} | {len(some)} | {mean:.2f} | {right:.2f} |")
    return rows


def fields(reads: list[Read]) -> str:
    """Return the accuracy of the other fields over all sentences."""
    n = len(reads)
    side = sum((r.reading.side.value if r.reading.side else None) == r.sentence["side"] for r in reads)
    negated = sum(r.reading.negated == r.sentence["negated"] for r in reads)
    urgent = sum(r.reading.urgent == r.sentence["urgent"] for r in reads)
    claims = sum({c.value for c in r.reading.claims} == set(r.sentence["claims"]) for r in reads)  # type: ignore[call-overload]
    shares = [
        f"{name} {100 * right / n:.1f} %"
        for name, right in (("side", side), ("negation", negated), ("urgency", urgent), ("all claims", claims))
    ]
    return ", ".join(shares)


def misses(reads: list[Read]) -> list[str]:
    """Return a table of all sentences without the intended action."""
    rows = ["| meant | read as | confidence | words | situation |", "|---|---|---|---|---|"]
    for r in sorted((r for r in reads if not r.acted), key=lambda r: (r.meant_intent, str(r.sentence["id"]))):
        read = r.reading.likely.value
        if r.reading.likely is not r.reading.intent:
            read += " (waits)" if r.reading.intent is GuidanceIntent.WAIT else " (asked back)"
        mark = "**" if r.moved_wrongly else ""
        text, situation = (str(r.sentence[key]).replace("|", "\\|") for key in ("text", "situation"))
        rows.append(f"| {r.meant_intent} | {mark}{read}{mark} | {r.reading.confidence:.2f} | {text} | {situation} |")
    return rows


def main() -> None:
    """Write the page."""
    reader = NetworkInterpreter()
    made = f"Generated by `python -m stucksolver_eval.result_pages.words` with the weights {reader.name}. {ABOUT}"
    parts = [TITLE, "", made]
    every: list[Read] = []
    for name in SETS:
        reads = read_set(name, reader)
        every += reads
        confused = Counter((r.meant_intent, r.reading.likely.value) for r in reads if not r.understood).most_common(8)
        parts += ["", f"## {name}", "", *by_class(reads), "", f"Other fields: {fields(reads)}.", ""]
        parts += [
            "Most frequent mistakes: " + ", ".join(f"{meant} as {read} {n}" for (meant, read), n in confused) + "."
        ]
    parts += ["", "## Calibration, all sets", "", *calibration(every)]
    for name in SETS:
        some = [r for r in every if str(r.sentence["id"]).startswith(f"b{name[-1]}")]
        parts += ["", f"## Every miss of {name}", "", "Bold: moves wrongly.", "", *misses(some)]
    (RESULTS / "words.md").write_text("\n".join(parts) + "\n", encoding="utf-8")
    assert len(INTENTS) == len(GuidanceIntent)


if __name__ == "__main__":
    main()
