"""Proposals for the guard: the plan that the search finds in a scene, and random behaviors."""

from __future__ import annotations

from collections.abc import Callable

from lab.benchmarks.guard_oracle.scene import SIDES, Drawn, Setting
from stucksolver.guard import Guard
from stucksolver.plan import RecoveryPlan
from stucksolver.plan.behaviors import (
    REGISTRY,
    BackUp,
    Behavior,
    BorrowOncomingLane,
    ChangeLane,
    Creep,
    KeepLane,
    NoseOut,
    Nudge,
    PullOver,
    RejoinRoute,
    Wait,
    describe,
)
from stucksolver.reasoners import ReasonerRequest
from stucksolver.reasoners.search import SearchReasoner
from stucksolver.scene import Status
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.scene_builder import build_scene
from stucksolver.solver.state_machine.plan_preview import PlanPreview

NAMES = tuple(REGISTRY)
SEARCH, GUARD = SearchReasoner(), Guard()


def from_search(view: FrenetScene, stopped_s: float) -> RecoveryPlan | None:
    """Return the plan of the search in this scene, or None if it waits."""
    speed = abs(view.ego.speed_mps)
    status = Status(time_s=view.surroundings.time_s, speed_mps=speed, progress_m=view.ego_s)
    scene = build_scene(view, status, describe(NAMES))
    ego = scene.ego.model_copy(update={"stopped_for_s": stopped_s if speed < 0.5 else 0.0})
    preview = PlanPreview(GUARD, view, lambda plan: False)
    request = ReasonerRequest(scene.model_copy(update={"ego": ego}), assess=preview.assess)
    return SEARCH.decide(request).decision.plan


def _change(draw: Drawn) -> ChangeLane:
    side = draw.choice(SIDES)
    return ChangeLane(side=side, distance_m=draw.uniform(15.0, 60.0), speed_mps=draw.uniform(1.0, 5.5))


def _nudge(draw: Drawn) -> Behavior:
    side, offset, way = draw.choice(SIDES), draw.uniform(0.2, 1.4), draw.uniform(4.0, 30.0)
    return Nudge(side=side, offset_m=offset, distance_m=way, speed_mps=draw.uniform(0.8, 4.0))


ANYWHERE: tuple[Callable[[Drawn], Behavior], ...] = (
    lambda draw: KeepLane(distance_m=draw.uniform(3.0, 50.0), speed_mps=draw.uniform(1.0, 5.5)),
    lambda draw: Creep(distance_m=draw.uniform(1.0, 15.0), speed_mps=draw.uniform(0.5, 2.2)),
    _nudge,
    _change,
    lambda draw: PullOver(distance_m=draw.uniform(10.0, 50.0), speed_mps=draw.uniform(1.0, 5.5)),
    lambda draw: RejoinRoute(),
    lambda draw: BackUp(distance_m=draw.uniform(1.0, 8.0), speed_mps=draw.uniform(0.5, 2.0)),
    lambda draw: BorrowOncomingLane(past_object_id="lead", speed_mps=draw.uniform(1.0, 5.5)),
)
"""Random behaviors that suit any scene."""


def at_random(draw: Drawn, setting: Setting) -> RecoveryPlan:
    """Return one or two behaviors, most of which suit the class of the scene."""
    fits = setting.propose is not None and draw.random() < 0.7
    first = setting.propose(draw) if fits and setting.propose else [draw.choice(ANYWHERE)(draw)]
    if len(first) == 1 and draw.random() < 0.15:
        extra = draw.choice(ANYWHERE)(draw) if draw.random() < 0.7 else Wait(duration_s=draw.uniform(1.0, 3.0))
        first = [*first, extra]
    return RecoveryPlan(behaviors=tuple(first))


def nosed(draw: Drawn) -> RecoveryPlan:
    """Return a lane change that noses out first, and waits there for its gap."""
    change = _change(draw)
    return RecoveryPlan(behaviors=(NoseOut(side=change.side, speed_mps=draw.uniform(0.5, 2.0)), change))
