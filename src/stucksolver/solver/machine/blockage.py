"""What is told to people about where the vehicle stands, and whether the way is still blocked."""

from __future__ import annotations

from stucksolver.scene import PastAttempt, Scene

AHEAD_M = 25.0


def still_blocked(scene: Scene | None) -> bool:
    """Does anything stand in the way close ahead?"""
    if scene is None:
        return False
    return any(o.in_path and o.gap_m is not None and -0.5 < o.gap_m < AHEAD_M for o in scene.objects)


def why_stopped(scene: Scene | None, attempts: tuple[PastAttempt, ...]) -> str:
    """In a line: what blocks the way, and what became of the last plan."""
    parts = []
    ahead = [o for o in scene.objects if o.in_path and o.gap_m is not None and o.gap_m > -0.5] if scene else []
    if ahead:
        nearest = min(ahead, key=lambda o: o.gap_m or 0.0)
        parts.append(f"{nearest.kind.value} {nearest.id} blocks the way {max(nearest.gap_m or 0.0, 0.0):.0f} m ahead")
    if attempts:
        parts.append(f"the last plan failed: {attempts[-1].outcome}")
    return "; ".join(parts) or "nothing helps, and nothing is seen in the way"
