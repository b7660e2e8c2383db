"""Checks whether a rejection was right: drives the plan without a guard, and looks for harm.

This tests less than the guard promises. It tries only a few manners of driving, and each of the others does only one
thing. A rejection without harm here may still be right; one with harm is right.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection
from dataclasses import dataclass
from typing import Any

from lab.benchmarks.guard_oracle.campaign import setting_of
from lab.benchmarks.guard_oracle.case import Case
from lab.benchmarks.guard_oracle.causes import excused_by
from lab.benchmarks.guard_oracle.contact import contact_with
from lab.benchmarks.guard_oracle.drive import EVERY, MOST_S
from lab.benchmarks.guard_oracle.others import AlongLane
from lab.benchmarks.guard_oracle.recording import Recording
from lab.benchmarks.guard_oracle.scene import Setting, driving
from lab.benchmarks.guard_oracle.vehicle import Manner
from lab.benchmarks.guard_oracle.world import DT, World
from stucksolver.guard import NOBODY, Guard, RejectCode, Verdict
from stucksolver.plan import RecoveryPlan
from stucksolver.plan.behaviors import ChangeLane
from stucksolver.plan.directive import CONTINUE
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.solver.state_machine.execution import Execution
from stucksolver.solver.state_machine.execution_steps import ExecutionOutcome

OFF = frozenset({RejectCode.OFF_LANES, RejectCode.OFF_ROAD})
BRAKES_MPS2 = 3.5
"""Deceleration that the start of a plan may require of others (m/s²)."""
LANE_M, ROAD_M = 0.1, 0.15
"""Tolerance for the body beyond the lane that it must keep, and off the road (m). Ours."""


class Unguarded(Guard):
    """A guard that accepts every plan with a path, and never ends it."""

    def accept(self, behaviors: Any, view: Any, guided: bool, approvals: Any = NOBODY, stops: bool = False) -> Any:
        return Verdict(), self.lay_out(behaviors, view, guided, approvals, stops)

    def recheck(self, *_: Any, **__: Any) -> Verdict:
        return Verdict()


@dataclass
class Harm:
    """The outcome of a plan.

    It holds the first contact, the hardest braking of rear traffic (m/s²), and the distances by which the body reached
    further out of its lane and off the road than at the start (m).
    """

    contact: str | None = None
    brakes_mps2: float = 0.0
    """Hardest braking of rear traffic (m/s²)."""
    off_lane_m: float = 0.0
    """Increase of the distance out of the lane (m)."""
    off_road_m: float = 0.0
    """Increase of the distance off the road (m)."""

    def justifies(self, codes: Collection[str]) -> bool:
        """True if there is harm of the kind that a rejection with these codes should prevent."""
        off_lane = RejectCode.LEAVES_LANE in codes and self.off_lane_m > LANE_M
        off_road = not OFF.isdisjoint(codes) and self.off_road_m > ROAD_M
        return off_lane or off_road or self.contact is not None or self.brakes_mps2 > BRAKES_MPS2


def harm_of(seed: int, number: int, plan: RecoveryPlan, codes: Collection[str]) -> Harm:
    """Return the worst harm of a plan in a scene, over brisk and sluggish driving and both reactions of the others.

    If the plan was rejected because a vehicle may come out of an occluded area behind, one comes, at the speed limit.
    """
    worst = Harm()
    for how, answers in itertools.product((0.0, 1.0), ("lane", "way")):
        _, setting = setting_of(seed, number)
        if RejectCode.PATH_NOT_VISIBLE in codes:
            _add_unseen(setting, plan)
        for other in setting.others:
            if isinstance(other, AlongLane):
                other.answers = answers
        found = _driven(World(setting, Manner(how, how, follows=True)), plan)
        worst.contact = worst.contact or found.contact
        for what in ("brakes_mps2", "off_lane_m", "off_road_m"):
            setattr(worst, what, max(getattr(worst, what), getattr(found, what)))
    return worst


def _add_unseen(setting: Setting, plan: RecoveryPlan) -> None:
    """Add a vehicle at the speed limit in the lane to be entered, just out of sight behind the ego."""
    world = World(setting, Manner())
    side = next((b.side for b in plan.behaviors if isinstance(b, ChangeLane)), "")
    lane = next((lane for lane in setting.road.lanes if lane.name == side), None)
    if lane is None:
        return
    behind_m = next(x.behind_m for x in world.surroundings().sight if x.lane_id == side)
    s = setting.ego_s - behind_m - 2.5
    setting.others.append(driving("unseen", setting.road, s, lane.offset, setting.road.limit, "was not seen"))


def _driven(world: World, plan: RecoveryPlan) -> Harm:
    execution = Execution(plan, Unguarded(), False)
    harm = Harm()
    if not execution.start(FrenetScene(world.surroundings()), 0.0).accepted:
        return harm
    order: Any = CONTINUE
    recording = Recording(world)
    began = _out(world, DRIVING), _out(world, ("own",))
    for k in range(round(MOST_S / DT)):
        if k % EVERY == 0:
            order = execution.tick(FrenetScene(world.surroundings()), world.t)
            if isinstance(order, ExecutionOutcome):
                return harm
        recording.orders.append(order)
        world.step(order)
        harm.off_road_m = max(harm.off_road_m, _out(world, DRIVING) - max(began[0], 0.0))
        harm.off_lane_m = max(harm.off_lane_m, _out(world, ("own",)) - max(began[1], 0.0))
        harm.brakes_mps2 = max(harm.brakes_mps2, _must_brake(world))
        hit = world.touched()
        if hit is not None:
            contact = contact_with(world, hit, "")
            if excused_by(Case(contact, recording)) is None:
                harm.contact = f"{contact.role}, at our {contact.part}"
            return harm
    return harm


DRIVING = ("own", "left", "right", "oncoming")


def _out(world: World, names: tuple[str, ...]) -> float:
    """Return the distance by which the body reaches out of a set of adjacent lanes (m)."""
    lanes = [lane for lane in world.road.lanes if lane.name in names]
    _, _, right, left = world.ego_span()
    return max(left - max(lane.left_m for lane in lanes), min(lane.right_m for lane in lanes) - right)


def _must_brake(world: World) -> float:
    """Return the hardest braking that rear traffic in an entered lane needs now to stay behind the ego (m/s²)."""
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
