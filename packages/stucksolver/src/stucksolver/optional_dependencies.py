"""Checks whether matplotlib is installed, which comes with the extra `report`."""

from __future__ import annotations

import importlib.util


def can_plot() -> bool:
    """Return True if matplotlib is installed."""
    return importlib.util.find_spec("matplotlib") is not None
