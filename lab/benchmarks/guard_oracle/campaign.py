"""Drives numbered scenes in sequence. Each is generated from its number, so that it can be driven again alone."""

from __future__ import annotations

import math
import random
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

import lab.benchmarks.guard_oracle.scenes  # noqa: F401
from lab.benchmarks.guard_oracle.case import Case
from lab.benchmarks.guard_oracle.causes import excused_by
from lab.benchmarks.guard_oracle.drive import drive, judged, manner, silence
from lab.benchmarks.guard_oracle.plans import at_random, from_search, nosed
from lab.benchmarks.guard_oracle.recording import Recording, copied
from lab.benchmarks.guard_oracle.scene import Setting, class_of
from lab.benchmarks.guard_oracle.vehicle import Manner
from lab.benchmarks.guard_oracle.world import World
from stucksolver.plan import RecoveryPlan
from stucksolver.plan.behaviors import BorrowOncomingLane
from stucksolver.scene.frenet_scene import FrenetScene

RANDOM_PLANS = 5
"""Number of random plans per scene, in addition to the plan of the search."""
NOSED = RANDOM_PLANS + 1
"""Number of the proposal that noses out. It was added later; the plans before it have their old numbers."""
GUIDED = 0.3
"""Fraction of plans with a pass that are proposed as requested by a passenger. Ours."""
Row = dict[str, Any]


def setting_of(seed: int, number: int) -> tuple[str, Setting]:
    """Return the class and the scene of a number, created anew on each call, because driving changes it."""
    name, maker = class_of(number)
    return name, maker(random.Random(f"{seed}/{number}"))


def scene_rows(seed: int, number: int, judge_only: bool = False, only: int | None = None) -> Iterator[Row]:
    """Yield rows of all proposals in a scene, or of one.

    An impossible scene has no rows. `judge_only`: drive none.
    """
    name, setting = setting_of(seed, number)
    if not World(setting, Manner()).is_possible():
        return
    for k in range(NOSED + 1) if only is None else (only,):
        row = one(seed, number, k, judge_only)
        if row is not None:
            yield {"scene": number, "k": k, "class": name, **row}


@dataclass
class Proposal:
    """A plan in a scene. `silent`: time from which the solver is silent (s)."""

    world: World
    plan: RecoveryPlan
    guided: bool
    silent: float


def proposal_of(seed: int, number: int, k: int, may_fall_silent: bool = True) -> Proposal | None:
    """Return proposal `k` of a scene, created anew on each call.

    Proposal 0 is the plan of the search, or None if it waits.
    """
    draw = random.Random(f"{seed}/{number}/{k}")
    _, setting = setting_of(seed, number)
    how = manner(draw)
    silent = silence(draw) if may_fall_silent else math.inf
    world = World(setting, how)
    if k == 0:
        plan = from_search(FrenetScene(world.surroundings()), setting.stopped_s)
    else:
        plan = nosed(draw) if k == NOSED else at_random(draw, setting)
    if plan is None:
        return None
    guided = draw.random() < GUIDED and any(isinstance(b, BorrowOncomingLane) for b in plan.behaviors)
    return Proposal(world, plan, guided, silent)


def proposals_of(seed: int, number: int) -> Iterator[tuple[int, Proposal]]:
    """Yield all proposals in a scene with their numbers, without silence of the solver; none in an impossible scene."""
    if not World(setting_of(seed, number)[1], Manner()).is_possible():
        return
    for k in range(NOSED + 1):
        proposal = proposal_of(seed, number, k, may_fall_silent=False)
        if proposal is not None:
            yield k, proposal


def one(seed: int, number: int, k: int, judge_only: bool = False) -> Row | None:
    """Return proposal `k` of a scene, judged and, if accepted, driven; None if the search waits."""
    proposal = proposal_of(seed, number, k)
    if proposal is None:
        return None
    silent = math.nan if judge_only else proposal.silent
    return judge_and_drive(proposal.world, proposal.plan, proposal.guided, silent, "search" if k == 0 else "random")


def judge_and_drive(world: World, plan: RecoveryPlan, guided: bool, silent: float, source: str) -> Row:
    """Return the row of a proposal. It is not driven if `silent` is NaN."""
    execution, verdict = judged(world, plan, guided)
    row: Row = {"source": source, "plan": plan.model_dump(mode="json")["behaviors"], "accepted": verdict.accepted}
    if not verdict.accepted:
        return {**row, "codes": sorted({r.code.value for r in verdict.rejects}), "why": str(verdict)[:200]}
    if math.isnan(silent) or all(b.stands_still for b in plan.behaviors):
        return {**row, "driven": False}
    ended = drive(world, execution, silent)
    row |= {"driven": True, "end": ended.how, "t": round(ended.t, 2), "missed": ended.missed}
    row["nearest"] = round(min(ended.nearest, 1.0), 3)
    row["drift"] = round(world.ego.manner.drift, 2)
    if ended.contact is not None and ended.recording is not None:
        case = Case(ended.contact, ended.recording, partial(_goes_well, ended.recording, plan, guided))
        row["contact"] = {k: round(v, 3) if isinstance(v, float) else v for k, v in asdict(ended.contact).items()}
        row |= {"excused": excused_by(case), **case.figures()}
    return row


def _goes_well(recording: Recording, plan: RecoveryPlan, guided: bool, without: frozenset[str]) -> bool:
    """True if a recorded plan, driven again with a solver that is never silent, ends without a contact that counts.

    `without`: names of road users to remove; the solver is then silent as in the record.
    """
    silent_from = recording.silent_from if without else math.inf
    world = copied(recording.start)
    world.others[:] = [other for other in world.others if other.name not in without]
    execution, verdict = judged(world, plan, guided)
    if not verdict.accepted:
        return False
    ended = drive(world, execution, silent_from)
    if ended.contact is None or ended.recording is None:
        return True
    return excused_by(Case(ended.contact, ended.recording, lambda _: False)) is not None
