"""The menu as lines of the prompt."""

from __future__ import annotations

from collections.abc import Sequence

from stucksolver.reasoners.search.menu import MenuItem
from stucksolver.scene import Scene

MENU = "plans that the guard has checked (letter, behaviors with their values, verdict now):"
NO_MENU = "plans that the guard has checked: none is accepted or nearly accepted"


def menu_lines(scene: Scene, menu: Sequence[MenuItem] | None) -> list[str]:
    """Return one line for each plan, with the sides of the image; nothing if no search was made (None)."""
    if menu is None:
        return []
    return [MENU, *((item.mirrored() if scene.mirrored else item).text for item in menu)] if menu else [NO_MENU]
