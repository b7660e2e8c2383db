"""Describes to people where the vehicle stands, and whether the way is still blocked."""

from __future__ import annotations

from stucksolver.scene import Scene
from stucksolver.solver.machine.turn import Turn

AHEAD_M = 25.0


def still_blocked(scene: Scene | None) -> bool:
    """True if something stands in the way close ahead."""
    if scene is None:
        return False
    return bool(scene.in_path_ahead(AHEAD_M))


def why_stopped(turn: Turn) -> str:
    """One line that says what blocks the way and how the last plan ended.

    If nothing new has been seen for long, it says this, with the sensors' fault, instead of what was seen before.
    """
    scene, attempts, fault = turn.state.scene, turn.state.history.attempts, turn.state.senses_fault
    parts = []
    ahead = scene.in_path_ahead() if scene else ()
    if turn.is_blind:
        parts.append(f"the sensors have shown nothing new for {turn.unseen_s:.0f} s" + (f" ({fault})" if fault else ""))
    elif ahead:
        nearest = ahead[0]
        parts.append(f"{nearest.kind.value} {nearest.id} blocks the way {max(nearest.gap_m or 0.0, 0.0):.0f} m ahead")
    if attempts:
        parts.append(f"the last plan failed: {attempts[-1].outcome}")
    return "; ".join(parts) or "nothing helps, and nothing is seen in the way"
