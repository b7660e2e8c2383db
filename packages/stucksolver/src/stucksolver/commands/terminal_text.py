"""Formats text for a terminal."""

from __future__ import annotations

import shutil
import textwrap

WIDTH = 80
"""Default width, for a pipe or a file (columns)."""
INDENT = "  "


def filled(text: str, width: int | None = None) -> str:
    """Return a paragraph in lines of at most `width` columns; addresses and paths are not broken."""
    limit = shutil.get_terminal_size((WIDTH, 24)).columns if width is None else width
    return textwrap.fill(text, max(limit, 20), subsequent_indent=INDENT, break_long_words=False, break_on_hyphens=False)
