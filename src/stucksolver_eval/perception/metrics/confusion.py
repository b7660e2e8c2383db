"""A confusion matrix: what was said, by what was so."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Confusion:
    """`counts[i, j]`: how often `names[i]` was so and `names[j]` was said; an answer may be that nothing is known."""

    names: tuple[str, ...]
    counts: NDArray[np.int64]
    unknown: NDArray[np.int64]
    """(n,): how often nothing was said about each."""

    @property
    def answered(self) -> float | None:
        """Share of the questions with an answer."""
        asked = int(self.counts.sum() + self.unknown.sum())
        return float(self.counts.sum()) / asked if asked else None

    @property
    def accuracy(self) -> float | None:
        """Share of the answers that are right."""
        answers = int(self.counts.sum())
        return float(np.trace(self.counts)) / answers if answers else None

    def recall(self, name: str) -> float | None:
        """Share of what was so that was said so, answered or not."""
        i = self.names.index(name)
        asked = int(self.counts[i].sum() + self.unknown[i])
        return float(self.counts[i, i]) / asked if asked else None

    def precision(self, name: str) -> float | None:
        """Share of what was said that was so."""
        i = self.names.index(name)
        said = int(self.counts[:, i].sum())
        return float(self.counts[i, i]) / said if said else None


def confusion(names: Sequence[str], pairs: Sequence[tuple[str, str | None]]) -> Confusion:
    """Of pairs (what was so, what was said or None). Raises `ValueError` for a name that is not among `names`."""
    at = {name: i for i, name in enumerate(names)}
    counts = np.zeros((len(names), len(names)), np.int64)
    unknown = np.zeros(len(names), np.int64)
    for so, said in pairs:
        strange = [one for one in (so, said) if one is not None and one not in at]
        if strange:
            raise ValueError(f"{strange[0]!r} is none of {', '.join(names)}")
        if said is None:
            unknown[at[so]] += 1
        else:
            counts[at[so], at[said]] += 1
    return Confusion(tuple(names), counts, unknown)
