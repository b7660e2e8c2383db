"""Arms by name."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from stucksolver.detect import DetectorSettings
from stucksolver.evaluate.arms.arm import Arm, DriverAlone
from stucksolver.evaluate.arms.solver_arm import Listener, SolverArm, TimedReasoner
from stucksolver.evaluate.arms.timers import TimersArm
from stucksolver.evaluate.routes.line import RouteLine
from stucksolver.evaluate.runner.job import ArmSpec
from stucksolver.guard import Guard
from stucksolver.ladder import find_ladder
from stucksolver.reason import Reasoner, RuleReasoner
from stucksolver.solver import StuckSolver
from stucksolver.stacks.carla_stack import CarlaStack
from stucksolver.stacks.driver import BehaviorDriver

NONE, TIMERS = "none", "timers"


class ArmError(ValueError):
    """No such arm; the message lists what there is."""


def _reasoners() -> dict[str, Callable[[], Reasoner]]:
    return {"rules": RuleReasoner}


def check_recovery(name: str) -> None:
    """Raises `ArmError` for a name that is no arm."""
    known = (NONE, TIMERS, *_reasoners())
    if name not in known:
        raise ArmError(f"unknown recovery {name!r}; there are {', '.join(known)}")


def make_arm(spec: ArmSpec, ego: Any, driver: BehaviorDriver, carla_map: Any, line: RouteLine) -> Arm:
    """An arm for a driver that has its route. Raises `ArmError`."""
    check_recovery(spec.recovery)
    if spec.recovery == NONE:
        return DriverAlone(driver)
    if spec.recovery == TIMERS:
        return TimersArm(ego, driver, line)
    stack = CarlaStack(ego, driver, carla_map)
    reasoner = TimedReasoner(_reasoners()[spec.recovery]())
    return SolverArm(stack, reasoner, lambda listener: _solver(spec, stack, reasoner, listener))


def _solver(spec: ArmSpec, stack: CarlaStack, reasoner: Reasoner, listener: Listener) -> StuckSolver:
    ladder = find_ladder(spec.ladder or "evaluation")
    return StuckSolver(
        stack.scene,
        reasoner=reasoner,
        guard=Guard(ladder.guard_policy()),
        detector=DetectorSettings(**spec.detector),
        clock=spec.clock,
        on_event=listener,
    )
