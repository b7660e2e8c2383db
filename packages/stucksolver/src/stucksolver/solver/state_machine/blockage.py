"""Whether the ego's path is blocked, and how that is described to people."""

from __future__ import annotations

import math

from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.solver.state_machine.pending_transition import PendingTransition

AHEAD_M = 25.0
"""Only a nearer object holds the vehicle (m): its driver would stop behind it, and not drive up to it first. Ours:
twice the stopping distance at 20 km/h, and a bus.
"""
CRAWLS_MPS = 0.5
"""A faster object moves on and blocks nothing (m/s): below the slowest walking pace."""


def blocked_at_m(view: FrenetScene) -> float | None:
    """Return the gap to the nearest object that stands in the route's path close ahead (m); None if there is none."""
    stands = view.in_corridor(view.ego.width_m / 2) & (view.s > view.ego_s) & (view.speed <= CRAWLS_MPS)
    nearest = float(view.gap[stands].min(initial=math.inf))
    return nearest if nearest < AHEAD_M else None


def blockage_text(turn: PendingTransition) -> str:
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
