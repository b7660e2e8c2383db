"""Bars for table cells, as SVG text. Each has its figure next to it, so screen readers skip the bars."""

from __future__ import annotations

WIDTH = 100
HEIGHT = 10


def bar_cell(value: float | None, digits: int = 1) -> str:
    """Return a table cell with a figure from 0 to 100 and its bar; None means that there is no figure."""
    if value is None:
        return '<td class="figure">no route</td>'
    length = WIDTH * min(max(value, 0.0), 100.0) / 100.0
    bar = f'<rect class="rail" width="{WIDTH}" height="{HEIGHT}"/><rect width="{length:.1f}" height="{HEIGHT}"/>'
    drawn = f'<svg class="bar" viewBox="0 0 {WIDTH} {HEIGHT}" aria-hidden="true">{bar}</svg>'
    return f'<td class="figure">{value:.{digits}f} {drawn}</td>'
