"""Bars as SVG text, for the page; no library needed."""

from __future__ import annotations

import html
from collections.abc import Sequence

ROW_PX = 20
LABEL_PX = 310
BAR_PX = 420


def bars(values: Sequence[tuple[str, float | None]], unit: str) -> str:
    """Horizontal bars from 0 to 100; None: no bar."""
    height = ROW_PX * (len(values) + 1)
    rows = [
        f'<text x="{LABEL_PX}" y="14" font-size="12" fill="#5b6576">{html.escape(unit)}</text>',
        *(_bar(k, name, value) for k, (name, value) in enumerate(values, 1)),
    ]
    width = LABEL_PX + BAR_PX + 60
    return f'<svg viewBox="0 0 {width} {height}" width="{width}" role="img">{"".join(rows)}</svg>'


def _bar(row: int, name: str, value: float | None) -> str:
    top = row * ROW_PX
    label = f'<text x="{LABEL_PX - 8}" y="{top + 14}" font-size="12" text-anchor="end">{html.escape(name)}</text>'
    if value is None:
        return label + f'<text x="{LABEL_PX}" y="{top + 14}" font-size="12" fill="#8a94a6">no route</text>'
    length = BAR_PX * min(max(value, 0.0), 100.0) / 100.0
    bar = f'<rect x="{LABEL_PX}" y="{top + 3}" width="{length:.1f}" height="14" fill="#2f6fab"/>'
    figure = f'<text x="{LABEL_PX + length + 6:.1f}" y="{top + 14}" font-size="12">{value:.1f}</text>'
    return label + bar + figure
