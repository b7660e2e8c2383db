#!/usr/bin/env python3
"""Writes results/words.md: how well the reader understands the blind sentences, beside the patterns it replaced.

    python -m stucksolver_eval.pages.words

Needs `pip install 'stucksolver[words]'`. The sentences in results/words were written by people who had seen neither the
grammar nor the training sentences.
"""

from __future__ import annotations

import json
import re
from collections import Counter
from dataclasses import dataclass

import numpy as np

from stucksolver.scene import GuidanceIntent, Reading
from stucksolver.words.fields import INTENTS, MOVES
from stucksolver.words.network import NetworkReader
from stucksolver_eval.pages import RESULTS

SETS = ("blind-1", "blind-2", "blind-3")
BINS = ((0.0, 0.5), (0.5, 0.7), (0.7, 0.8), (0.8, 0.85), (0.85, 0.9), (0.9, 1.01))
PATTERNS = (
    ("wait", r"\b(do ?n.?t|do not|(?<!will )(?<!will never )(never(?! mind)|stop|wait|stay)|hold on|not yet)\b"),
    ("pull_over", r"\b(pull(ing)? over|pull to the side|to the roadside)\b"),
    ("back_up", r"\b(back (it )?up|reverse|go back a (bit|little))\b"),
    ("drive_over", r"\bdrive (right )?over\b"),
    ("overtake", r"\b(over ?take|pass|get past|go (a)?round|drive (a)?round|get (a)?round)\b"),
    ("overtake", r"\b(left|right)\b"),
    ("go", r"\b(go|drive|move|edge|creep|continue|proceed)\b"),
)
"""What read the words before; no pattern of theirs told small talk from an unclear request."""

TITLE = "# What the reader of words understands"
ABOUT = """Three sets of 500 sentences, written by three authors who had seen neither the grammar nor the training
sentences; none of them was trained on. The misses of the first two were known when the training
sentences grew from 10,800 to 21,900; those have not changed since, so that the third set and the weights
know nothing of each other. The thresholds of doubt follow the 1,149 training sentences kept apart.
Only that of reroute, 0.85, was chosen after looking at these sets: two more true ones and no more false ones.
"Understood" is the likeliest intent. "Acted on as meant" is what is left after doubt: a reading that
would move the vehicle counts only where it is sure enough ([docs/words.md](../docs/words.md)), else the
passenger is asked back. "Moves wrongly" counts the readings that may move the vehicle where the sentence
asked for no motion, or forbade that one. The guard decides after that."""


@dataclass(frozen=True)
class Read:
    """A blind sentence with what was made of it."""

    said: dict[str, object]
    reading: Reading
    pattern: str

    @property
    def meant(self) -> str:
        """The intent that the sentence was written for."""
        return str(self.said["intent"])

    @property
    def understood(self) -> bool:
        """Whether the likeliest reading is what was meant."""
        return self.reading.likely.value == self.meant

    @property
    def acted(self) -> bool:
        """Whether the reading that is acted on is what was meant."""
        return self.reading.intent.value == self.meant

    @property
    def moved_wrongly(self) -> bool:
        """Does the reading ask for a motion, where the sentence asked for none or forbade just that?"""
        wrong = GuidanceIntent(self.meant) not in MOVES or self.reading.intent.value in self.said["unsafe_if"]  # type: ignore[operator]
        return self.reading.intent in MOVES and not self.acted and wrong


def pattern_intent(text: str) -> str:
    """What the patterns make of a sentence."""
    return next((intent for intent, pattern in PATTERNS if re.search(pattern, text.lower())), "unclear")


def read_set(name: str, reader: NetworkReader) -> list[Read]:
    """A blind set, read."""
    lines = (RESULTS / "words" / f"{name}.jsonl").read_text(encoding="utf-8").splitlines()
    said = [json.loads(line) for line in lines]
    return [Read(s, reader.read(s["text"], s["situation"]), pattern_intent(s["text"])) for s in said]


def by_class(reads: list[Read]) -> list[str]:
    """The table of one set."""
    rows = [
        "| class | sentences | understood | acted on as meant | asked back | moves wrongly | patterns |",
        "|---|---|---|---|---|---|---|",
    ]
    for kind in [*dict.fromkeys(str(r.said["class"]) for r in reads), "all"]:
        some = [r for r in reads if kind in (r.said["class"], "all")]
        back = sum(r.reading.intent is GuidanceIntent.UNCLEAR and r.meant != "unclear" for r in some)
        fits = sum(r.pattern == r.meant or (r.pattern == "unclear" and r.meant == "none") for r in some)
        wrongly = sum(r.moved_wrongly for r in some)
        flags = ([r.understood for r in some], [r.acted for r in some])
        shares = " | ".join(f"{100 * sum(flag) / len(some):.1f} %" for flag in flags)
        rows.append(f"| {kind} | {len(some)} | {shares} | {back} | {wrongly} | {100 * fits / len(some):.1f} % |")
    return rows


def calibration(reads: list[Read]) -> list[str]:
    """How often a reading is right that is so sure."""
    rows = ["| confidence | readings | mean confidence | right |", "|---|---|---|---|"]
    for low, high in BINS:
        some = [r for r in reads if low <= r.reading.confidence < high]
        if some:
            mean = np.mean([r.reading.confidence for r in some])
            right = np.mean([r.understood for r in some])
            rows.append(f"| {low:.2f} to {min(high, 1.0):.2f} | {len(some)} | {mean:.2f} | {right:.2f} |")
    return rows


def fields(reads: list[Read]) -> str:
    """The other fields, over all sentences."""
    n = len(reads)
    side = sum((r.reading.side.value if r.reading.side else None) == r.said["side"] for r in reads)
    negated = sum(r.reading.negated == r.said["negated"] for r in reads)
    urgent = sum(r.reading.urgent == r.said["urgent"] for r in reads)
    claims = sum({c.value for c in r.reading.claims} == set(r.said["claims"]) for r in reads)  # type: ignore[call-overload]
    shares = [
        f"{name} {100 * right / n:.1f} %"
        for name, right in (("side", side), ("negation", negated), ("urgency", urgent), ("all claims", claims))
    ]
    return ", ".join(shares)


def misses(reads: list[Read]) -> list[str]:
    """Every sentence that is not acted on as meant."""
    rows = ["| meant | read as | confidence | words | situation |", "|---|---|---|---|---|"]
    for r in sorted((r for r in reads if not r.acted), key=lambda r: (r.meant, str(r.said["id"]))):
        read = r.reading.likely.value
        if r.reading.likely is not r.reading.intent:
            read += " (waits)" if r.reading.intent is GuidanceIntent.WAIT else " (asked back)"
        mark = "**" if r.moved_wrongly else ""
        text, situation = (str(r.said[key]).replace("|", "\\|") for key in ("text", "situation"))
        rows.append(f"| {r.meant} | {mark}{read}{mark} | {r.reading.confidence:.2f} | {text} | {situation} |")
    return rows


def main() -> None:
    """Prints the page."""
    reader = NetworkReader()
    parts = [TITLE, "", f"Made by `python -m stucksolver_eval.pages.words` with the weights {reader.name}. {ABOUT}"]
    every: list[Read] = []
    for name in SETS:
        reads = read_set(name, reader)
        every += reads
        confused = Counter((r.meant, r.reading.likely.value) for r in reads if not r.understood).most_common(8)
        parts += ["", f"## {name}", "", *by_class(reads), "", f"Other fields: {fields(reads)}.", ""]
        parts += [
            "Most frequent mistakes: " + ", ".join(f"{meant} as {read} {n}" for (meant, read), n in confused) + "."
        ]
    parts += ["", "## Calibration, all sets", "", *calibration(every)]
    for name in SETS:
        some = [r for r in every if str(r.said["id"]).startswith(f"b{name[-1]}")]
        parts += ["", f"## Every miss of {name}", "", "Bold: moves wrongly.", "", *misses(some)]
    (RESULTS / "words.md").write_text("\n".join(parts) + "\n", encoding="utf-8")
    assert len(INTENTS) == len(GuidanceIntent)


if __name__ == "__main__":
    main()
