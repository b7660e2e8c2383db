"""Input and result of each part of the scoring."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from stucksolver_perception.recording import Recording


class MissingGroundTruthError(ValueError):
    """The recordings lack the data for a part; the message names the data and the remedy."""


@dataclass(frozen=True)
class ScoringInput:
    """Input of a part. The weights are folders; None means the shipped ones. `threads` is per network."""

    recordings: Sequence[Recording]
    lidar_weights: Path | None = None
    camera_weights: Path | None = None
    threads: int = 1
    """Number of threads per network."""
    say: Callable[[str], None] = lambda _: None


@dataclass(frozen=True)
class ScoringResult:
    """Scores of a part: `data` for JSON, `page` in Markdown, and all run times of each stage (ms)."""

    data: Mapping[str, Any]
    page: str
    stages_ms: Mapping[str, Sequence[float]] = field(default_factory=dict)


class StageTimer:
    """Measures run times of stages: `with watch("lidar"): ...`."""

    def __init__(self) -> None:
        self.stages_ms: dict[str, list[float]] = {}

    @contextmanager
    def __call__(self, stage: str) -> Iterator[None]:
        began = time.perf_counter()
        yield
        self.stages_ms.setdefault(stage, []).append(1e3 * (time.perf_counter() - began))


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a Markdown table."""
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join([*lines, *("| " + " | ".join(row) + " |" for row in rows)])


def figure(value: float | None, digits: int = 3) -> str:
    """Format a number; None becomes a dash."""
    return "–" if value is None else f"{value:.{digits}f}"


def percent(value: float | None) -> str:
    """Format a share as a percentage; None becomes a dash."""
    return "–" if value is None else f"{100.0 * value:.1f} %"


def plain(value: Any) -> Any:
    """Convert dataclasses, arrays and mappings with any keys to values that JSON supports."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {item.name: plain(getattr(value, item.name)) for item in dataclasses.fields(value)}
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, Mapping):
        return {_key(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return value


def _key(key: Any) -> str:
    return "-".join(f"{item:g}" for item in key) if isinstance(key, tuple) else str(key)
