"""An ego that pushes something stops before anything else. What it pushes then counts as stationary."""

from __future__ import annotations

from collections.abc import Callable

from stucksolver.plan import Decision, RecoveryPlan
from stucksolver.plan.behaviors import Wait
from stucksolver.scene import Scene, SceneObject

STANDING_MPS = 0.2
"""The ego is stopped if it is slower (m/s)."""
STOP_S = 2.0
"""Time to stop before the scene is assessed anew (s). Ours."""


def assume_stopped(scene: Scene, decide: Callable[[Scene], Decision]) -> Decision:
    """Return what `decide` decides, with what the ego pushes at rest; a stop alone while the ego still moves.

    What follows the stop is decided after it: the guard cannot check it in surroundings that move.
    """
    found = next((o for o in scene.objects if o.pushed), None)
    if found is None:
        return decide(scene)
    decision = decide(_as_stationary(scene))
    if scene.ego.speed_mps < STANDING_MPS or not scene.offers("wait"):
        return decision
    analysis = decision.analysis.model_copy(update={"immobilized": True, "wait": None})
    plan = RecoveryPlan(behaviors=(Wait(duration_s=STOP_S),))
    why = f"{found.kind.value} {found.id} is being pushed along: stop"
    return decision.model_copy(update={"analysis": analysis, "plan": plan, "rationale": why})


def _as_stationary(scene: Scene) -> Scene:
    ego = scene.ego.model_copy(update={"speed_mps": 0.0})
    objects = tuple(_at_rest(o) if o.pushed else o for o in scene.objects)
    return scene.model_copy(update={"ego": ego, "objects": objects})


def _at_rest(o: SceneObject) -> SceneObject:
    still = {"vx_mps": 0.0, "vy_mps": 0.0, "speed_along_mps": 0.0, "speed_across_mps": 0.0}
    return o.model_copy(update={**still, "stationary_s": o.stationary_s or 0.0})
