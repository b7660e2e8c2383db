"""A confusion matrix that also counts missing answers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class ConfusionMatrix:
    """`counts[i, j]`: how often the truth was `names[i]` and the answer `names[j]`."""

    names: tuple[str, ...]
    counts: NDArray[np.int64]
    unknown: NDArray[np.int64]
    """Shape (n,): how often there was no answer for each true name."""

    @property
    def answered(self) -> float | None:
        """Share of questions with an answer; None without questions."""
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
        said = int(self.counts[:, i].sum())
        return float(self.counts[i, i]) / said if said else None


def confusion(names: Sequence[str], pairs: Sequence[tuple[str, str | None]]) -> ConfusionMatrix:
    """Count pairs of (truth, answer or None). Raises `ValueError` for an unknown name."""
    at = {name: i for i, name in enumerate(names)}
    counts = np.zeros((len(names), len(names)), np.int64)
    unknown = np.zeros(len(names), np.int64)
    for so, said in pairs:
        strange = [text for text in (so, said) if text is not None and text not in at]
        if strange:
            raise ValueError(f"{strange[0]!r} is not one of {', '.join(names)}")
        if said is None:
            unknown[at[so]] += 1
        else:
            counts[at[so], at[said]] += 1
    return ConfusionMatrix(tuple(names), counts, unknown)
