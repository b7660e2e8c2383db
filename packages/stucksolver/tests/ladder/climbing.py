"""Reasoners and a stuck vehicle for the ladder's tests."""

from __future__ import annotations

from stucksolver.ladder import WaitPolicy, profile
from stucksolver.plan import RecoveryPlan
from stucksolver.reasoners import ReasonerAnswer, ReasonerError
from stucksolver.scene import LineKind
from worlds import World, noticed, straight_road, thing

TWO_WAY, SOLID = straight_road(), straight_road(oncoming=LineKind.SOLID)
QUICK = {"reasoner": {"tries": 2, "cooldown_s": 0.5, "repair_rounds": 0}, "passenger": {"within_s": 4.0}}
STANDING_STILL = {"cruise_mps": 0.0}


class Says:
    """Calls a function for every scene, and counts."""

    def __init__(self, answer, name="says"):
        self.answer, self.name, self.calls = answer, name, 0

    def decide(self, request):
        self.calls += 1
        return ReasonerAnswer(self.answer(request.scene), self.name)


def planning(*behaviors):
    plan = RecoveryPlan(behaviors=behaviors)
    return Says(lambda scene: noticed(scene).model_copy(update={"plan": plan}))


def helpless():
    def answer(scene):
        raise ReasonerError("no idea")

    return Says(answer)


def waits(**longest):
    usual = profile("default").waits
    reasons = {
        r: p.model_copy(update={"longest_s": longest.get(r.value, p.longest_s)}) for r, p in usual.reasons.items()
    }
    return WaitPolicy(**{**usual.model_dump(exclude={"reasons", "otherwise"}), "reasons": reasons})


def stuck(road=TWO_WAY, **more):
    return World(road, [thing("lead", 75.0)], x=66.0, **more)
