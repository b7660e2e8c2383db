"""Verdicts that are kept: a change of the guard that changes any of them is seen, and is either meant or a fault.

Scenes and proposals are the oracle's. Each proposal is judged, what is accepted is driven, and every verdict on the way
is compared by its codes, the objects it names and its way out. After a change that is meant, write them anew and look
at what git shows:

    python packages/stucksolver/tests/test_guard_kept.py
"""

from __future__ import annotations

import itertools
import json
import math
from functools import cache
from pathlib import Path

import pytest

from lab.benchmarks.guard_oracle.campaign import proposals_of, setting_of
from lab.benchmarks.guard_oracle.drive import drive, judged
from lab.benchmarks.guard_oracle.scene import CLASSES
from stucksolver.guard import Verdict
from stucksolver.guard import guard as guard_module

KEPT = Path(__file__).with_name("guard_kept.json")
SEED, SCENES, QUICK, OFTEN, SOMETIMES, DRIVEN_OF = 41, 160, 8, 48, 96, 2
"""The first `QUICK` scenes belong to the unit tests, those from `OFTEN` on to the slow ones, those from
`SOMETIMES` on to a release; every other accepted plan is driven."""
FIGURES = 0.02
"""Gaps (m) and times (s) are the same within this: arithmetic differs a little from machine to machine."""
Said = str | list[float | None]


def told(verdict: Verdict) -> str:
    """What a verdict says, without the figures in its text."""
    why = " ".join(f"{r.code.value}:{r.object_id or ''}" for r in verdict.rejects)
    return f"{why}{' -> ' + verdict.abort.value if verdict.abort else ''}" or "ok"


def figures(verdict: Verdict) -> list[float | None]:
    """Gap and time of each reason."""
    return [None if item is None else round(item, 4) for r in verdict.rejects for item in (r.gap_m, r.time_s)]


def verdicts_of(number: int) -> dict[str, list[Said]]:
    """For each proposal in a scene: the verdict before it starts, then those on the way, with how often in a row."""
    found: dict[str, list[Said]] = {}
    for k, proposal in proposals_of(SEED, number):
        heard: list[str] = []
        looks = guard_module.Guard.recheck

        def look(guard, *args, looks=looks, heard=heard, **more):
            verdict = looks(guard, *args, **more)
            heard.append(told(verdict))
            return verdict

        execution, verdict = judged(proposal.world, proposal.plan, proposal.guided)
        found[str(k)] = [figures(verdict), told(verdict)]
        if verdict.accepted and (number + k) % DRIVEN_OF == 0:
            guard_module.Guard.recheck = look  # type: ignore[method-assign]
            try:
                ended = drive(proposal.world, execution, math.inf)
            finally:
                guard_module.Guard.recheck = looks  # type: ignore[method-assign]
            found[str(k)] += [f"{len(list(same))} {what}" for what, same in itertools.groupby(heard)] + [ended.how]
    return found


@cache
def kept() -> dict[str, dict[str, list[Said]]]:
    return json.loads(KEPT.read_text(encoding="utf-8")) if KEPT.exists() else {}


def marks(number: int) -> list[pytest.MarkDecorator]:
    """Those of a scene's test."""
    slow = [pytest.mark.slow] * (number >= OFTEN) + [pytest.mark.release] * (number >= SOMETIMES)
    return [pytest.mark.integration] * (number >= QUICK) + slow


@pytest.mark.integration
@pytest.mark.parametrize("number", [pytest.param(n, marks=marks(n)) for n in range(SCENES)])
def test_verdicts_are_as_they_were_kept(number):
    now, before = verdicts_of(number), kept()[str(number)]
    assert {k: said[1:] for k, said in now.items()} == {k: said[1:] for k, said in before.items()}
    for k, (numbers, *_) in now.items():
        assert numbers == pytest.approx(before[k][0], abs=FIGURES), k


def test_stored_verdicts_cover_all_classes_and_both_outcomes():
    """Scenes of every class are stored, with accepted and rejected plans."""
    assert {setting_of(SEED, number)[0] for number in range(SCENES)} == set(CLASSES)
    first = [row[1] for scene in kept().values() for row in scene.values()]
    assert 0.2 < sum(item == "ok" for item in first) / len(first) < 0.8


if __name__ == "__main__":
    rows = {str(number): verdicts_of(number) for number in range(SCENES)}
    KEPT.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
