"""Displays the progress of a suite: in place on a terminal, one line per route elsewhere."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TextIO

from stucksolver_eval.metrics.multi_ability import ABILITIES
from stucksolver_eval.results.checkpoint import RouteRecord, status_text
from stucksolver_eval.results.outcome import RouteOutcome
from stucksolver_eval.runner.route_process import RouteTask

BAR = 30
"""Width of the progress bar (characters)."""


@dataclass
class _Tally:
    routes: int = 0
    score: float = 0.0
    successes: int = 0

    def add(self, record: RouteRecord | None) -> None:
        self.routes += 1
        if record is not None:
            self.score += record.scores.score_composed
            self.successes += record.success

    def text(self) -> str:
        if not self.routes:
            return "      –      –"
        return f"{self.score / self.routes:7.1f}{100 * self.successes / self.routes:7.0f}"


@dataclass
class ProgressDisplay:
    """The progress of `total` routes, of which an earlier run finished `before`."""

    total: int
    before: int
    out: TextIO
    now: Callable[[], float] = time.monotonic
    _running: dict[str, float] = field(default_factory=dict)
    _all: _Tally = field(default_factory=_Tally)
    _groups: dict[str, _Tally] = field(default_factory=dict)
    _failed: int = 0
    _done: int = 0
    _lines: int = 0
    _began_s: float = 0.0

    def __post_init__(self) -> None:
        self._began_s = self.now()
        self._groups = {name: _Tally() for name in ABILITIES}

    def goes_on(self, task: RouteTask, time_s: float) -> None:
        """Display a route's progress (simulated time, s)."""
        self._running[_label(task)] = time_s
        self._draw()

    def is_over(self, task: RouteTask, outcome: RouteOutcome, record: RouteRecord | None) -> None:
        """Count a finished route and print its end."""
        self._running.pop(_label(task), None)
        self._done += 1
        self._failed += outcome.state in ("crashed", "invalid")
        self._all.add(record)
        for name, types in ABILITIES.items():
            if task.job.scenario in types:
                self._groups[name].add(record)
        self._say(self._line(task, outcome, record))
        self._draw()

    def close(self) -> None:
        """End the last line."""
        if self._lines:
            print(file=self.out, flush=True)

    def _line(self, task: RouteTask, outcome: RouteOutcome, record: RouteRecord | None) -> str:
        label = f"[{self.before + self._done}/{self.total}] {_label(task)}"
        if record is None:
            return f"{label}: {outcome.state}: {(outcome.reason.splitlines() or ['?'])[-1]}"
        rate = outcome.ticks / max(outcome.wall_s, 1e-9)
        return f"{label}: {status_text(record.status)}, DS {record.scores.score_composed:.1f} ({rate:.0f} ticks/s)"

    def _say(self, text: str) -> None:
        self._wipe()
        print(text, file=self.out, flush=True)

    def _wipe(self) -> None:
        if self._lines:
            print(f"\r\x1b[{self._lines - 1}A\x1b[J" if self._lines > 1 else "\r\x1b[J", end="", file=self.out)
            self._lines = 0

    def _draw(self) -> None:
        """Draw the progress bar, the running routes and the present scores."""
        if not self.out.isatty():
            return
        self._wipe()
        done = self.before + self._done
        filled = BAR * done // max(self.total, 1)
        rows = [f"{'█' * filled}{'░' * (BAR - filled)} {done}/{self.total}  {self._eta()}  crashed {self._failed}"]
        rows += [f"  {label} … {time_s:.0f} s" for label, time_s in self._running.items()]
        rows += [f"  {'':16}{'DS':>7}{'SR %':>7}", f"  {'all':16}{self._all.text()}"]
        rows += [f"  {name.replace('_', ' '):16}{tally.text()}" for name, tally in self._groups.items()]
        print("\n".join(rows), end="", file=self.out, flush=True)
        self._lines = len(rows)

    def _eta(self) -> str:
        if not self._done:
            return "time left: unknown"
        left_s = (self.total - self.before - self._done) * (self.now() - self._began_s) / self._done
        return f"time left: {left_s / 60:.0f} min" if left_s >= 90 else f"time left: {left_s:.0f} s"


def _label(task: RouteTask) -> str:
    job = task.job
    return f"{job.route.id} {job.scenario} (seed {job.seed})"
