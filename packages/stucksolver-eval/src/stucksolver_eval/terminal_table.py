"""Tables for a terminal: a row per run if that fits its width, otherwise a column per run."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from string import ascii_uppercase

from stucksolver.commands.terminal_text import WIDTH

Row = tuple[str, ...]

BETWEEN = "  "
PART = "  "
"""Prefix of the name of a row that belongs to the run before it."""
NOTHING = ("", "–")


def table(head: Row, rows: Sequence[Row], width: int | None = None) -> str:
    """Return `rows` below `head`, or transposed if that would be wider than `width` columns.

    The first cell of a row is the name of its run. In a transposed table, metrics that no run has are omitted, and runs
    with long names become letters. Empty if no run has any metric.
    """
    limit = shutil.get_terminal_size((WIDTH, 24)).columns if width is None else width
    upright = _aligned([head, *rows])
    if max(len(line) for line in upright) <= limit or not rows:
        return "\n".join(upright)
    runs = _with_parts(rows)
    if all(cell in NOTHING for run in runs for cell in run[1:]):
        return ""
    label = max(len(name) for name in head)
    figures = [max(len(cell) for cell in run[1:]) for run in runs]
    names = [run[0] for run in runs]
    legend: list[str] = []
    if label + sum(len(BETWEEN) + max(len(name), size) for name, size in zip(names, figures, strict=True)) > limit:
        names = [_letter(k) for k in range(len(runs))] if len(runs) > 1 else [""]
        legend = [f"{name}: {run[0]}" if name else run[0] for name, run in zip(names, runs, strict=True)]
    parts = ["\n".join(legend)] if legend else []
    for group in _groups([max(len(n), size) for n, size in zip(names, figures, strict=True)], limit - label):
        turned = [
            (head[i], *(runs[k][i] for k in group))
            for i in range(1, len(head))
            if any(runs[k][i] not in NOTHING for k in group)
        ]
        lines = _aligned([(head[0] if any(names) else "", *(names[k] for k in group)), *turned])
        parts.append("\n".join(lines if any(names) else lines[2:]))
    return "\n\n".join(parts)


def _aligned(rows: Sequence[Row]) -> list[str]:
    """Return lines of equal columns, with a rule below the first."""
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    lines = [BETWEEN.join(cell.ljust(size) for cell, size in zip(row, widths, strict=True)).rstrip() for row in rows]
    return [lines[0], "-" * len(lines[0]), *lines[1:]]


def _with_parts(rows: Sequence[Row]) -> list[Row]:
    """Put rows that belong to the previous one into its cells, in brackets."""
    runs: list[Row] = []
    for row in rows:
        if not row[0].startswith(PART) or not runs:
            runs.append(row)
            continue
        what = row[0].strip()
        merged = (f"{old} ({what} {new})" if new else old for old, new in zip(runs[-1][1:], row[1:], strict=True))
        runs[-1] = (runs[-1][0], *merged)
    return runs


def _groups(sizes: Sequence[int], room: int) -> list[list[int]]:
    """Return the numbers of the runs side by side, at least one per group."""
    groups: list[list[int]] = []
    left = 0
    for k, size in enumerate(sizes):
        needed = len(BETWEEN) + size
        if not groups or needed > left:
            groups.append([])
            left = room
        groups[-1].append(k)
        left -= needed
    return groups


def _letter(k: int) -> str:
    """Return the letter of a run: A, B, ... Z, A1, B1, ..."""
    turn, which = divmod(k, len(ascii_uppercase))
    return f"{ascii_uppercase[which]}{turn or ''}"
