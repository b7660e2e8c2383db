"""Says the lines of a route when their time has come."""

from __future__ import annotations

from collections.abc import Sequence
from random import Random

from stucksolver_eval.criteria.base import STANDING_MPS
from stucksolver_eval.guidance.script import Line


class Speaker:
    """Ask `due` once a tick; each line is said once."""

    def __init__(self, lines: Sequence[Line], random: Random) -> None:
        self._left = [(line, line.wording(random)) for line in lines]
        self._moved_s: float | None = None

    def due(self, time_s: float, place_m: float, speed_mps: float) -> list[tuple[Line, str]]:
        """The lines to be said at this tick, with their wording."""
        if not self._left:
            return []
        if self._moved_s is None or speed_mps >= STANDING_MPS:
            self._moved_s = time_s
        stopped_s = time_s - self._moved_s
        said = [(line, text) for line, text in self._left if _is_due(line, time_s, place_m, stopped_s)]
        self._left = [one for one in self._left if one not in said]
        return said


def _is_due(line: Line, time_s: float, place_m: float, stopped_s: float) -> bool:
    when = line.when
    if when.time_s is not None:
        return time_s >= when.time_s
    if when.stopped_s is not None:
        return stopped_s >= when.stopped_s > 0 or (when.stopped_s == 0 and time_s == 0)
    return when.place_m is not None and place_m >= when.place_m
