"""What the ego pushes counts as stationary, and so does the ego: the rules see the scene as it is after a stop."""

from __future__ import annotations

from collections.abc import Callable

from stucksolver.plan import Decision, RecoveryPlan
from stucksolver.plan.behaviors import Wait
from stucksolver.scene import Scene, SceneObject

STANDING_MPS = 0.2
STOP_S, STAND_S = 2.0, 10.0
"""How long to wait before acting on what was pushed; the second if it must first be stationary for longer (s)."""


def pushed_object(scene: Scene) -> SceneObject | None:
    """Return the object that the ego pushes, or None."""
    return next((o for o in scene.objects if o.pushed), None)


def as_stationary(scene: Scene, waited_s: float = 0.0) -> Scene:
    """Return the scene with the ego stopped, and with what it pushes stationary for `waited_s` longer (s)."""
    ego = scene.ego.model_copy(update={"speed_mps": 0.0})
    objects = tuple(_at_rest(o, waited_s) if o.pushed else o for o in scene.objects)
    return scene.model_copy(update={"ego": ego, "objects": objects})


def assume_stopped(scene: Scene, decide: Callable[[Scene], Decision]) -> Decision:
    """Return what `decide` decides; if the ego pushes something, for the scene after a stop, with the stop first."""
    found, stop_s = pushed_object(scene), STOP_S
    if found is None:
        return decide(scene)
    decision = decide(as_stationary(scene))
    if scene.ego.speed_mps < STANDING_MPS or not scene.offers("wait"):
        return decision
    if decision.plan is None:
        # By the end of a longer stop it will have been stationary for long enough.
        decision, stop_s = decide(as_stationary(scene, STAND_S)), STAND_S
    why = f"{found.kind.value} {found.id} is being pushed along: stop, then {decision.rationale}"
    stop = Wait(duration_s=stop_s)
    plan = RecoveryPlan(behaviors=(stop,))
    if decision.plan is not None:
        plan = decision.plan.model_copy(update={"behaviors": (stop, *decision.plan.behaviors)})
    analysis = decision.analysis.model_copy(update={"immobilized": True, "wait": None})
    return decision.model_copy(update={"analysis": analysis, "plan": plan, "rationale": why})


def _at_rest(o: SceneObject, waited_s: float) -> SceneObject:
    still = {"vx_mps": 0.0, "vy_mps": 0.0, "speed_along_mps": 0.0, "speed_across_mps": 0.0}
    return o.model_copy(update={**still, "stationary_s": (o.stationary_s or 0.0) + waited_s})
