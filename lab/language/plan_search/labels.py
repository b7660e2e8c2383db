"""The data of a campaign: one JSON line for each plan that was driven at a standstill."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Literal

from pydantic import ValidationError

from lab.language.plan_search.grade import Grade
from stucksolver.plan import RecoveryPlan
from stucksolver.scene.base_model import FrozenModel

Source = Literal["rules", "wait", "teacher"]
"""Source of the driven answer: the rules' decision, waiting from here on, or a plan that the search found."""


class Label(FrozenModel):
    """A plan at a standstill, and its outcome in an exact drive.

    Attributes:
        standstill: Its name; `standstills/NAME.json` holds its scene.
        scenario: Type of the route's first scenario.
        source: Source of the answer.
        plan: The plan; None for a wait.
        value: The plan's value in the look-ahead (m); None if that was not used.
        reached: True if the drive reached the same tick, bit for bit. Otherwise the line does not count.
        grade: The outcome; None if the drive failed.
        error: Reason of the failure.
        drive_s: Wall time of the drive (s).
    """

    version: Literal[1] = 1
    standstill: str
    scenario: str
    source: Source
    plan: RecoveryPlan | None
    value: float | None = None
    reached: bool
    grade: Grade | None
    error: str = ""
    drive_s: float

    @property
    def counts(self) -> bool:
        """True if the line is a valid label for the plan."""
        return self.reached and self.grade is not None


class LabelFile:
    """A file with one label per line. An incomplete last line of a killed process is dropped."""

    def __init__(self, path: Path) -> None:
        """Read the labels that the file already has.

        Raises:
            ValueError: A line other than the last is not a label. The message has its number.
        """
        self._path = path
        self.labels: list[Label] = []
        lines = path.read_text(encoding="utf-8").split("\n") if path.exists() else [""]
        for number, line in enumerate(lines[:-1], 1):
            self.labels.append(_read(line, f"{path}, line {number}"))
        if lines[-1]:
            path.write_text("".join(f"{line}\n" for line in lines[:-1]), encoding="utf-8")

    def add(self, label: Label) -> None:
        """Append a label immediately.

        Raises:
            OSError: It cannot be written.
        """
        self._path.parent.mkdir(parents=True, exist_ok=True)
        with self._path.open("a", encoding="utf-8") as file:
            file.write(label.model_dump_json() + "\n")
        self.labels.append(label)


def _read(line: str, where: str) -> Label:
    try:
        return Label.model_validate_json(line)
    except ValidationError as error:
        raise ValueError(f"{where} is not a label: {error.errors()[0]['msg']}") from error


def best(labels: Iterable[Label], *sources: Source) -> Label | None:
    """Return the label with the best grade among those of these sources (of all, if none is named), or None.

    The first of equal grades counts.
    """
    fitting = [label for label in labels if label.counts and (not sources or label.source in sources)]
    return max(fitting, key=lambda item: item.grade.rank if item.grade else (), default=None)


def by_standstill(labels: Iterable[Label]) -> dict[str, list[Label]]:
    """Return the labels of each standstill, in the order in which it first appears."""
    found: dict[str, list[Label]] = {}
    for label in labels:
        found.setdefault(label.standstill, []).append(label)
    return found
