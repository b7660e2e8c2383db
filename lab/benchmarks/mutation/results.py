"""The results of mutants: one line each in a file to which every finished mutant is added at once."""

from __future__ import annotations

import csv
from collections.abc import Iterable
from dataclasses import astuple, dataclass, fields
from pathlib import Path

KILLED, SURVIVED, UNREACHED = "killed", "survived", "unreached"


@dataclass(frozen=True)
class Result:
    """The result of a mutant.

    Attributes:
        file: Its file, below `packages/stucksolver/src/stucksolver`.
        line: Its line.
        kind: The kind of change, in a word.
        change: The line before and after.
        outcome: `killed`, `survived`, or `unreached` if no test runs its line.
        by: The test that failed, or `time` if the tests no longer ended.
        ran: Number of tests that ran.
        reaching: Number of tests that reach its line.
        took_s: CPU time (s).
    """

    file: str
    line: int
    kind: str
    change: str
    outcome: str
    by: str
    ran: int
    reaching: int
    took_s: float

    @property
    def key(self) -> tuple[str, int, str, str]:
        """Values that distinguish a mutant from all others."""
        return self.file, self.line, self.kind, self.change


COLUMNS = tuple(field.name for field in fields(Result))


def read(path: Path) -> list[Result]:
    """Return the results in a file, the last one of each mutant. A line that was cut off is left out."""
    if not path.exists():
        return []
    found: dict[tuple[str, int, str, str], Result] = {}
    with path.open(newline="", encoding="utf-8") as file:
        for row in csv.reader(file, delimiter="\t", quoting=csv.QUOTE_NONE, quotechar=None):
            if len(row) != len(COLUMNS) or row[0] == COLUMNS[0]:
                continue
            file_, line, kind, change, outcome, by, ran, reaching, took = row
            result = Result(file_, int(line), kind, change, outcome, by, int(ran), int(reaching), float(took))
            found[result.key] = result
    return list(found.values())


def line_of(result: Result) -> str:
    """Return a result as a line."""
    return "\t".join(str(value).replace("\t", " ").replace("\n", " ") for value in astuple(result)) + "\n"


def write(path: Path, results: Iterable[Result]) -> None:
    """Write a whole file, sorted by position."""
    path.parent.mkdir(parents=True, exist_ok=True)
    text = "".join(
        line_of(result)
        for result in sorted(results, key=lambda result: (result.file, result.line, result.kind, result.change))
    )
    path.write_text("\t".join(COLUMNS) + "\n" + text, encoding="utf-8")
