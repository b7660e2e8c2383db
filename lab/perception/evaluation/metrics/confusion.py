"""A confusion matrix that also counts missing answers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class ConfusionMatrix:
    """`counts[i, j]` is the number of samples with the truth `names[i]` and the answer `names[j]`."""

    names: tuple[str, ...]
    counts: NDArray[np.int64]
    unknown: NDArray[np.int64]
    """Shape (n,): number of samples without an answer for each true name."""

    @property
    def answered(self) -> float | None:
        """Share of samples with an answer; None without samples."""
        asked = int(self.counts.sum() + self.unknown.sum())
        return float(self.counts.sum()) / asked if asked else None

    @property
    def accuracy(self) -> float | None:
        """Share of answers that are right; None without answers."""
        answers = int(self.counts.sum())
        return float(np.trace(self.counts)) / answers if answers else None

    def recall(self, name: str) -> float | None:
        """Return the share of a true name that was answered correctly; missing answers count as wrong."""
        i = self.names.index(name)
        asked = int(self.counts[i].sum() + self.unknown[i])
        return float(self.counts[i, i]) / asked if asked else None

    def precision(self, name: str) -> float | None:
        """Return the share of the answers with this name that are right."""
        i = self.names.index(name)
        answers = int(self.counts[:, i].sum())
        return float(self.counts[i, i]) / answers if answers else None


def confusion(names: Sequence[str], pairs: Sequence[tuple[str, str | None]]) -> ConfusionMatrix:
    """Count pairs of (truth, answer or None).

    Raises:
        ValueError: A name is unknown.
    """
    at = {name: i for i, name in enumerate(names)}
    counts = np.zeros((len(names), len(names)), np.int64)
    unknown = np.zeros(len(names), np.int64)
    for so, answer in pairs:
        strange = [text for text in (so, answer) if text is not None and text not in at]
        if strange:
            raise ValueError(f"unknown name: {strange[0]!r}. Expected one of {', '.join(names)}")
        if answer is None:
            unknown[at[so]] += 1
        else:
            counts[at[so], at[answer]] += 1
    return ConfusionMatrix(tuple(names), counts, unknown)
