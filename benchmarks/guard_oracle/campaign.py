"""Scenes one after the other, each from its own number, so that any one of them can be driven again alone."""

from __future__ import annotations

import math
import random
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

import benchmarks.guard_oracle.scenes  # noqa: F401
from benchmarks.guard_oracle.causes import excluded_by
from benchmarks.guard_oracle.drive import drive, judged, manner, silence
from benchmarks.guard_oracle.plans import at_random, from_rules
from benchmarks.guard_oracle.scene import CLASSES, Setting
from benchmarks.guard_oracle.vehicle import Manner
from benchmarks.guard_oracle.world import World
from stucksolver.decision import RecoveryPlan
from stucksolver.decision.behaviors import BorrowOncomingLane
from stucksolver.scene.view import FrenetScene

RANDOM_PLANS = 5
"""Plans at random for each scene, beside the rules' own."""
GUIDED = 0.3
"""Such a share of the plans that pass somebody are proposed as asked for by a passenger."""
Row = dict[str, Any]


def setting_of(seed: int, number: int) -> tuple[str, Setting]:
    """The class and the scene of a number; made anew on each call, since driving uses it up."""
    draw = random.Random(f"{seed}/{number}")
    names = list(CLASSES)
    name = names[number % len(names)]
    return name, CLASSES[name](draw)


def scene_rows(seed: int, number: int, judge_only: bool = False, only: int | None = None) -> Iterator[Row]:
    """A row for each proposal in a scene, or for one; none where the scene is impossible. `judge_only`: drive none."""
    name, setting = setting_of(seed, number)
    if not World(setting, Manner()).is_possible():
        return
    for k in range(RANDOM_PLANS + 1) if only is None else (only,):
        row = one(seed, number, k, judge_only)
        if row is not None:
            yield {"scene": number, "k": k, "class": name, **row}


@dataclass
class Proposal:
    """A plan in a scene. `silent`: from when on the solver will say nothing more (s)."""

    world: World
    plan: RecoveryPlan
    guided: bool
    silent: float


def proposal_of(seed: int, number: int, k: int, may_fall_silent: bool = True) -> Proposal | None:
    """Proposal `k` of a scene, made anew on each call. Proposal 0 is the rules' own; None if they wait."""
    draw = random.Random(f"{seed}/{number}/{k}")
    _, setting = setting_of(seed, number)
    how = manner(draw)
    silent = silence(draw) if may_fall_silent else math.inf
    world = World(setting, how)
    plan = from_rules(FrenetScene(world.surroundings()), setting.stopped_s) if k == 0 else at_random(draw, setting)
    if plan is None:
        return None
    guided = draw.random() < GUIDED and any(isinstance(b, BorrowOncomingLane) for b in plan.behaviors)
    return Proposal(world, plan, guided, silent)


def proposals_of(seed: int, number: int) -> Iterator[tuple[int, Proposal]]:
    """Every proposal in a scene with its number, to a solver that never falls silent; none in an impossible scene."""
    if not World(setting_of(seed, number)[1], Manner()).is_possible():
        return
    for k in range(RANDOM_PLANS + 1):
        proposal = proposal_of(seed, number, k, may_fall_silent=False)
        if proposal is not None:
            yield k, proposal


def one(seed: int, number: int, k: int, judge_only: bool = False) -> Row | None:
    """Proposal `k` of a scene, judged and, if accepted, driven; None where the rules wait."""
    told = proposal_of(seed, number, k)
    if told is None:
        return None
    silent = math.nan if judge_only else told.silent
    return judge_and_drive(told.world, told.plan, told.guided, silent, "rules" if k == 0 else "random")


def judge_and_drive(world: World, plan: RecoveryPlan, guided: bool, silent: float, source: str) -> Row:
    """The row of a proposal; it is not driven if `silent` is no number."""
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
    if ended.contact is not None:
        row["contact"] = {k: round(v, 3) if isinstance(v, float) else v for k, v in asdict(ended.contact).items()}
        row["excluded"] = excluded_by(ended.contact)
    return row
