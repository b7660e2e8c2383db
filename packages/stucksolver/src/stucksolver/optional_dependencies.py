"""Whether pictures can be drawn: matplotlib comes with the extra `report`."""

from __future__ import annotations

import importlib.util


def can_plot() -> bool:
    """Is matplotlib there?"""
    return importlib.util.find_spec("matplotlib") is not None
