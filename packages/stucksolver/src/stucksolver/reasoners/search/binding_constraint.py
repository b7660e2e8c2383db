"""Explains why there is no plan: the requirement that the best refused plan misses, and by how much."""

from __future__ import annotations

from stucksolver.plan import CauseCode
from stucksolver.plan.assessment import Shortfall
from stucksolver.plan.behaviors import Behavior
from stucksolver.reasoners.search.plan_search import SearchResult
from stucksolver.scene import VEHICLES, Scene, SceneObject


def binding_constraint(scene: Scene, result: SearchResult) -> tuple[CauseCode | None, str] | None:
    """Return the cause, if an object is it, and the constraint in words; None if no plan was refused."""
    candidate = result.best or result.nearly
    if candidate is None or not candidate.assessment.shortfalls:
        return None
    first = candidate.assessment.shortfalls[0]
    moves = " and ".join(in_words(behavior) for behavior in candidate.plan.behaviors)
    amount = "" if first.missing is None or first.unit is None else f", {first.missing:.1f} {first.unit} short"
    return _cause(scene, first), f"cannot {moves}: {first.detail}{amount}"[:300]


def in_words(behavior: Behavior) -> str:
    """Return what a behavior does, to complete "I will ..."."""
    return behavior.phrase.future.format(**behavior.model_dump())


def _cause(scene: Scene, shortfall: Shortfall) -> CauseCode | None:
    obj = next((o for o in scene.objects if o.id == shortfall.object_id), None)
    return None if obj is None else _kind_of_cause(obj)


def _kind_of_cause(obj: SceneObject) -> CauseCode:
    if obj.kind not in VEHICLES:
        return CauseCode.STATIC_OBSTACLE
    return CauseCode.DISABLED_VEHICLE if obj.hazard_lights else CauseCode.PARKED_VEHICLE
