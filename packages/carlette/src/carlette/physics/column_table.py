"""Columns of numbers that grow and shrink together."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np


class Table:
    """Base of dataclasses whose fields are arrays with one row for each item.

    Rows are rarely added or removed but are stepped on every tick, so the arrays are dense.
    """

    def append(self, **values: Any) -> int:
        """Add a row (columns without a value get zeros) and return its index."""
        index = len(self)
        for field in fields(self):  # type: ignore[arg-type]
            column = getattr(self, field.name)
            # np.concatenate would repack the overlapping fields of the snapshot's records.
            longer = np.zeros((index + 1, *column.shape[1:]), column.dtype)
            longer[:index] = column
            if field.name in values:
                longer[index] = values[field.name]
            setattr(self, field.name, longer)
        return index

    def delete(self, index: int) -> None:
        """Remove a row. The rows after it move up."""
        for field in fields(self):  # type: ignore[arg-type]
            column = getattr(self, field.name)
            setattr(self, field.name, column[np.arange(len(column)) != index])

    def __len__(self) -> int:
        return len(next(iter(self.__dict__.values())))


def numbers(width: int = 0) -> Any:
    """Return a default factory for an empty column of floats, or of rows of `width` floats."""
    return lambda: np.zeros((0, width) if width else 0)


def flags() -> Any:
    """Return a default factory for an empty column of booleans."""
    return lambda: np.zeros(0, bool)


def indices() -> Any:
    """Return a default factory for an empty column of integers."""
    return lambda: np.zeros(0, np.int64)
