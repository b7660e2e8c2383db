"""Describes to people where the vehicle stands, and whether the way is still blocked."""

from __future__ import annotations

from stucksolver.scene import PastAttempt, Scene

AHEAD_M = 25.0


def still_blocked(scene: Scene | None) -> bool:
    """True if something stands in the way close ahead."""
    if scene is None:
        return False
    return bool(scene.in_path_ahead(AHEAD_M))


def why_stopped(scene: Scene | None, attempts: tuple[PastAttempt, ...]) -> str:
    """One line that says what blocks the way and how the last plan ended."""
    parts = []
    ahead = scene.in_path_ahead() if scene else ()
    if ahead:
        nearest = ahead[0]
        parts.append(f"{nearest.kind.value} {nearest.id} blocks the way {max(nearest.gap_m or 0.0, 0.0):.0f} m ahead")
    if attempts:
        parts.append(f"the last plan failed: {attempts[-1].outcome}")
    return "; ".join(parts) or "nothing helps, and nothing is seen in the way"
