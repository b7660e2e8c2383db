"""Finds the tests that reach each line of the product, and the CPU time of each test."""

from __future__ import annotations

import os
import sys
from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from types import CodeType
from typing import Any

import pytest

from lab.benchmarks.mutation.session import Job, Session, in_forks, is_general, say

CHUNK = 12
"""Number of tests of one file that run in the same process. Ours."""
LONGEST_S = 900.0
"""Longest CPU time of a chunk (s). Ours."""


@dataclass
class Reach:
    """Tests that reach each line.

    Attributes:
        took_s: CPU time of each test that passes, by its index (s).
        lines: Indices of the tests that reach a line, by file and line.
        left_out: Tests that do not pass without a change, and the reason.
    """

    took_s: dict[int, float] = field(default_factory=dict)
    lines: dict[tuple[str, int], set[int]] = field(default_factory=lambda: defaultdict(set))
    left_out: dict[int, str] = field(default_factory=dict)

    def tests(self, file: str, spans: Iterable[tuple[int, int]]) -> set[int]:
        """Return the tests that reach any line of these spans."""
        found: set[int] = set()
        for first, last in spans:
            for line in range(first, last + 1):
                found |= self.lines.get((file, line), set())
        return found

    def in_order(self, tests: Iterable[int], names: list[str]) -> list[int]:
        """Return tests in their running order: first those that state a promise, and the quick ones first."""
        return sorted(tests, key=lambda k: (is_general(names[k]), round(self.took_s[k], 2), k))


class Lines:
    """Records the lines of a folder that run, each once per test (PEP 669)."""

    def __init__(self, folder: Path) -> None:
        self._folder = str(folder) + os.sep
        self.found: set[tuple[str, int]] = set()
        self._monitoring = sys.monitoring  # type: ignore[attr-defined,unused-ignore]
        self._tool = self._monitoring.COVERAGE_ID

    def _line(self, code: CodeType, line: int) -> Any:
        if code.co_filename.startswith(self._folder):
            self.found.add((code.co_filename[len(self._folder) :], line))
        return self._monitoring.DISABLE

    def start(self) -> None:
        """Start the recording."""
        self._monitoring.use_tool_id(self._tool, "mutation")
        self._monitoring.register_callback(self._tool, self._monitoring.events.LINE, self._line)
        self._monitoring.set_events(self._tool, self._monitoring.events.LINE)

    def afresh(self) -> None:
        """Drop the lines, and record each once more."""
        self.found = set()
        self._monitoring.restart_events()


def reach_of(items: list[pytest.Item], session: Session, root: Path, processes: int) -> Reach:
    """Run every test once, without a change, and return the reached lines. `root`: the folder of the sources."""
    chunks: list[list[int]] = []
    for k, item in enumerate(items):
        if chunks and len(chunks[-1]) < CHUNK and items[chunks[-1][-1]].path == item.path:
            chunks[-1].append(k)
        else:
            chunks.append([k])

    def work(chunk: list[int]) -> Iterator[list[Any]]:
        lines = Lines(root)
        lines.start()
        for k, after in zip(chunk, [*chunk[1:], None], strict=True):
            lines.afresh()
            outcome, took_s = session.run(items[k], None if after is None else items[after])
            yield [k, outcome, took_s, sorted(lines.found)]

    found = Reach()
    jobs = (Job(chunk, lambda chunk=chunk: work(chunk), LONGEST_S) for chunk in chunks)  # type: ignore[misc]
    for count, ended in enumerate(in_forks(jobs, processes), 1):
        found.left_out.update(dict.fromkeys(ended.key, ended.how))
        for k, outcome, took_s, lines in ended.told:
            found.left_out[k] = outcome
            if outcome != "passed":
                continue
            del found.left_out[k]
            found.took_s[k] = took_s
            for file, line in lines:
                found.lines[file, line].add(k)
        if count % 50 == 0:
            say(f"{count} of {len(chunks)} groups of tests have run")
    return found
