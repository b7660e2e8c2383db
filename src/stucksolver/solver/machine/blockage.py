"""Describes to people where the vehicle stands, and whether the way is still blocked."""

from __future__ import annotations

from stucksolver.scene import PastAttempt, Scene

AHEAD_M = 25.0
BLIND_LIMIT_S = 5.0
"""After this long without new surroundings, what was seen before no longer says whether a plan is done, or whether
waiting is right.
"""


def still_blocked(scene: Scene | None) -> bool:
    """True if something stands in the way close ahead."""
    if scene is None:
        return False
    return bool(scene.in_path_ahead(AHEAD_M))


def why_stopped(
    scene: Scene | None, attempts: tuple[PastAttempt, ...], unseen_s: float = 0.0, fault: str | None = None
) -> str:
    """One line that says what blocks the way and how the last plan ended.

    If nothing new has been seen for `unseen_s` and that is long, it says this, with the sensors' `fault`, instead of
    what was seen before.
    """
    parts = []
    ahead = scene.in_path_ahead() if scene else ()
    if unseen_s > BLIND_LIMIT_S:
        parts.append(f"the sensors have shown nothing new for {unseen_s:.0f} s" + (f" ({fault})" if fault else ""))
    elif ahead:
        nearest = ahead[0]
        parts.append(f"{nearest.kind.value} {nearest.id} blocks the way {max(nearest.gap_m or 0.0, 0.0):.0f} m ahead")
    if attempts:
        parts.append(f"the last plan failed: {attempts[-1].outcome}")
    return "; ".join(parts) or "nothing helps, and nothing is seen in the way"
