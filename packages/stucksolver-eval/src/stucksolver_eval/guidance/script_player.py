"""Sends the lines of a route and answers questions when they are due."""

from __future__ import annotations

from collections.abc import Sequence
from random import Random

from stucksolver.solver import Question
from stucksolver_eval.criteria.criterion import STANDING_MPS
from stucksolver_eval.guidance.script import ScriptLine


class ScriptPlayer:
    """Call `due` once per tick. Each line is due once."""

    def __init__(self, lines: Sequence[ScriptLine], random: Random) -> None:
        self._left = [(line, line.wording(random)) for line in lines]
        self._moved_s: float | None = None
        self._question: tuple[str, float] | None = None
        """Id of the open question, and its time (s)."""

    def due(
        self, time_s: float, place_m: float, speed_mps: float, question: Question | None = None
    ) -> list[tuple[ScriptLine, str]]:
        """Return the lines that are due at this tick, with their wording. `question` is the open question."""
        if not self._left:
            return []
        if self._moved_s is None or speed_mps >= STANDING_MPS:
            self._moved_s = time_s
        if question is None:
            self._question = None
        elif self._question is None or self._question[0] != question.id:
            self._question = (question.id, time_s)
        stopped_s = time_s - self._moved_s
        due_lines = [
            (line, text) for line, text in self._left if self._is_due(line, time_s, place_m, stopped_s, question)
        ]
        self._left = [item for item in self._left if item not in due_lines]
        return due_lines

    def _is_due(
        self, line: ScriptLine, time_s: float, place_m: float, stopped_s: float, question: Question | None
    ) -> bool:
        when = line.when
        if when.asked is not None:
            asked = question is not None and question.to == when.asked and self._question is not None
            return asked and self._question is not None and time_s - self._question[1] >= when.after_s
        if when.time_s is not None:
            return time_s >= when.time_s
        if when.stopped_s is not None:
            return stopped_s >= when.stopped_s > 0 or (when.stopped_s == 0 and time_s == 0)
        return when.place_m is not None and place_m >= when.place_m
