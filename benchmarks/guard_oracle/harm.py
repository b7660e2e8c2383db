"""Was a refusal right? A plan is driven with nobody looking on, and what would have come of it is seen.

That says less than the guard's promise asks for: it drives a few ways of doing it beside others who do one thing each.
A refusal that shows no harm here may be right all the same; one that does is.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import Any

from benchmarks.guard_oracle.campaign import setting_of
from benchmarks.guard_oracle.causes import excluded_by
from benchmarks.guard_oracle.contact import contact_with
from benchmarks.guard_oracle.drive import EVERY, MOST_S
from benchmarks.guard_oracle.others import AlongLane
from benchmarks.guard_oracle.vehicle import Manner
from benchmarks.guard_oracle.world import DT, World
from stucksolver.decision import RecoveryPlan
from stucksolver.decision.directive import CONTINUE
from stucksolver.guard import NOBODY, Guard, Verdict
from stucksolver.scene.view import View
from stucksolver.solver.execution import Execution, Outcome

BRAKES_MPS2 = 3.5
"""Nobody may be made to brake harder, to begin a plan."""


class Unguarded(Guard):
    """Accepts whatever has a path, and never ends it."""

    def accept(self, behaviors: Any, view: Any, guided: bool, approvals: Any = NOBODY) -> Any:
        return Verdict(), self.lay_out(behaviors, view, guided, approvals)

    def recheck(self, *_: Any, **__: Any) -> Verdict:
        return Verdict()


@dataclass
class Harm:
    """What came of it: the first contact, and the hardest that somebody behind us had to brake (m/s²)."""

    contact: str | None = None
    brakes_mps2: float = 0.0

    @property
    def shown(self) -> bool:
        return self.contact is not None or self.brakes_mps2 > BRAKES_MPS2


def harm_of(seed: int, number: int, k: int, plan: RecoveryPlan) -> Harm:
    """Of a plan in a scene, over eager and sluggish ways of driving it and both ways in which others answer."""
    worst = Harm()
    for eager, keen, answers in itertools.product((0.0, 1.0), (0.0, 1.0), ("lane", "way")):
        _, setting = setting_of(seed, number)
        for other in setting.others:
            if isinstance(other, AlongLane):
                other.answers = answers
        found = _driven(World(setting, Manner(eager, keen, follows=True)), plan)
        worst.contact = worst.contact or found.contact
        worst.brakes_mps2 = max(worst.brakes_mps2, found.brakes_mps2)
    return worst


def _driven(world: World, plan: RecoveryPlan) -> Harm:
    execution = Execution(plan, Unguarded(), False)
    harm = Harm()
    if not execution.start(View(world.surroundings()), 0.0).accepted:
        return harm
    order: Any = CONTINUE
    for k in range(round(MOST_S / DT)):
        if k % EVERY == 0:
            order = execution.tick(View(world.surroundings()), world.t)
            if isinstance(order, Outcome):
                return harm
        world.step(order)
        harm.brakes_mps2 = max(harm.brakes_mps2, _must_brake(world))
        hit = world.touched()
        if hit is not None:
            contact = contact_with(world, hit, "", False)
            if excluded_by(contact) is None:
                harm.contact = f"{contact.role}, at our {contact.part}"
            return harm
    return harm


def _must_brake(world: World) -> float:
    """The hardest that anybody behind us in a lane that we have entered must brake now, to stay behind us (m/s²)."""
    most = 0.0
    for other in world.others:
        if not isinstance(other, AlongLane) or other.way < 0 or other.was_behind:
            continue
        rear = world.rear_within(other.d - other.body.width / 2, other.d + other.body.width / 2)
        quicker = other.v - max(world.ego_speed, 0.0)
        if rear is None or quicker <= 0.0 or other.front > rear:
            continue
        most = max(most, quicker**2 / (2 * max(rear - other.front, 0.05)))
    return most if math.isfinite(most) else 99.0
