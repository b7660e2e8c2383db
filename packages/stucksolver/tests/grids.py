"""Grids of parametrized tests: thinned to rows that are always the same; `WHOLE_GRIDS=1` runs all (`make whole`)."""

from __future__ import annotations

import itertools
import os
import random
from collections.abc import Iterable
from typing import Any, TypeVar

Row = TypeVar("Row")
WHOLE = bool(os.environ.get("WHOLE_GRIDS"))


def sample(rows: Iterable[Row], most: int) -> list[Row]:
    """Return at most this many rows, drawn at random with a fixed seed, in their order."""
    found = list(rows)
    if WHOLE or len(found) <= most:
        return found
    return [found[k] for k in sorted(random.Random(1).sample(range(len(found)), most))]


def each_value(*axes: Iterable[Any]) -> list[tuple[Any, ...]]:
    """Return as many rows as the longest axis has values: each value of each axis occurs, not each combination."""
    values = [list(axis) for axis in axes]
    if WHOLE:
        return list(itertools.product(*values))
    longest, draw, columns = max(map(len, values)), random.Random(1), []
    for axis in values:
        column = [axis[k % len(axis)] for k in range(longest)]
        if columns:
            draw.shuffle(column)
        columns.append(column)
    return list(zip(*columns, strict=True))
