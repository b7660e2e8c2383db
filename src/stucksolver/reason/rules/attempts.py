"""What was tried of late."""

from __future__ import annotations

from stucksolver.scene import Scene

REMEMBERED_S = 30.0


def has_failed(scene: Scene, *words: str) -> bool:
    """Was a plan of the last half minute refused or given up for one of these reasons, or of one of these names?"""
    recent = [a for a in scene.attempts if scene.time_s - a.time_s < REMEMBERED_S]
    return any(word in a.outcome or word in a.behaviors for a in recent for word in words)
