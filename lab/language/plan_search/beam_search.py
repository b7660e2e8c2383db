"""A beam search over plans of up to three behaviors; the real guard judges each before it counts."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import TypeVar

from lab.language.plan_search.ego_trajectory import EgoTrajectory, begin, drive, moved, stand
from stucksolver.guard import Guard
from stucksolver.plan import RecoveryPlan
from stucksolver.plan.behaviors import Behavior
from stucksolver.scene import Scene, Surroundings
from stucksolver.scene.base_model import FrozenModel
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.solver.state_machine.admission import check_offered
from stucksolver.solver.state_machine.execution import Execution
from stucksolver_language.student.candidates import offered

T = TypeVar("T")
Value = Callable[[EgoTrajectory], float]
"""Ranks a trajectory; larger is better."""


@dataclass(frozen=True)
class SearchSettings:
    """Limits of a search.

    Attributes:
        depth: Most behaviors in a plan.
        beam: Number of partial plans that are continued at each depth.
        steps: Number of values of each parameter for the first behavior.
        later_steps: Number of values of each parameter for the second and third behavior.
        looked: Number of plans for which the simulator looks ahead; the others only get a quick value.
    """

    depth: int = 3
    """Most behaviors in a plan. Ours."""
    beam: int = 6
    """Number of partial plans that are continued at each depth. Ours."""
    steps: int = 4
    """Values of each parameter for the first behavior. Ours."""
    later_steps: int = 3
    """Values of each parameter for the later behaviors. Ours."""
    looked: int = 16
    """Number of plans for which the simulator looks ahead. Ours."""


class Candidate(FrozenModel):
    """A plan that the guard accepts at the standstill, with its value in the look-ahead (m)."""

    plan: RecoveryPlan
    value: float


@dataclass(frozen=True)
class SearchedPlan:
    """A plan that the guard accepts at the standstill, the end of its trajectory, and its value (m)."""

    plan: RecoveryPlan
    trail: EgoTrajectory
    value: float


@dataclass(frozen=True)
class _Node:
    behaviors: tuple[Behavior, ...]
    trail: EgoTrajectory
    value: float


@dataclass
class Search:
    """A search from one standstill. `checked` counts the guard checks."""

    guard: Guard
    scene: Scene
    surroundings: Surroundings
    value: Value
    settings: SearchSettings = field(default_factory=SearchSettings)
    checked: int = 0
    """Number of guard checks."""

    def run(self) -> tuple[SearchedPlan, ...]:
        """Return all plans found that the guard accepts as a whole, best first."""
        beam = [_Node((), begin(self.surroundings), 0.0)]
        found: list[SearchedPlan] = []
        for depth in range(self.settings.depth):
            options = offered(self.scene, self.settings.steps if depth == 0 else self.settings.later_steps)
            views = [FrenetScene(moved(self.surroundings, node.trail)) for node in beam]
            children = (
                self._extended(node, option, view) for node, view in zip(beam, views, strict=True) for option in options
            )
            nodes = [child for child in children if child is not None]
            found += [plan for node in nodes if (plan := self._admitted(node)) is not None]
            beam = varied(nodes, lambda n: (kinds(n.behaviors), n.value), self.settings.beam)
        return tuple(sorted(found, key=lambda item: -item.value))

    def _extended(self, node: _Node, behavior: Behavior, view: FrenetScene) -> _Node | None:
        """Return the plan with one more behavior, if the guard accepts that behavior from the plan's end (`view`)."""
        self.checked += 1
        if behavior.stands_still:
            if not self.guard.allows_standing(behavior, view).accepted:
                return None
            trail = stand(node.trail, behavior.time_allowance_s(0.0))
        else:
            verdict, proven = self.guard.accept((behavior,), view, guided=False)
            if proven is None or not verdict.accepted:
                return None
            trail = drive(node.trail, proven, view)
        return _Node((*node.behaviors, behavior), trail, self.value(trail))

    def _admitted(self, node: _Node) -> SearchedPlan | None:
        """Return the whole plan, if the solver would admit it at the standstill."""
        plan = RecoveryPlan.model_validate({"behaviors": node.behaviors})
        self.checked += 1
        if check_offered(plan, self.scene) is not None:
            return None
        view = FrenetScene(self.surroundings)
        verdict = Execution(plan, self.guard, guided=False).start(view, self.scene.time_s)
        return SearchedPlan(plan, node.trail, node.value) if verdict.accepted else None


def kinds(behaviors: Iterable[Behavior]) -> tuple[str, ...]:
    """Return the names of behaviors: the kind of a plan, without its parameters."""
    return tuple(behavior.name for behavior in behaviors)


def varied(items: Iterable[T], key: Callable[[T], tuple[tuple[str, ...], float]], most: int) -> list[T]:
    """Return the best items of each kind in turn: first the best one of each kind, then the second best, and so on.

    Args:
        items: The items to choose from.
        key: Returns the kind and the value of an item.
        most: Maximum number of items to return.
    """
    turns: Counter[tuple[str, ...]] = Counter()
    ranked: list[tuple[int, float, T]] = []
    for item in sorted(items, key=lambda item: -key(item)[1]):
        kind, value = key(item)
        ranked.append((turns[kind], -value, item))
        turns[kind] += 1
    return [item for _, _, item in sorted(ranked, key=lambda item: item[:2])[:most]]
