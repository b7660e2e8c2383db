"""A turn in several legs is recorded and derived again like all other plans."""

from __future__ import annotations

import math

import pytest
from test_record import recorded

from stucksolver.plan import Analysis, Decision, Observation, RecoveryPlan
from stucksolver.plan.behaviors import TurnAround
from stucksolver.reasoners import ReasonerAnswer
from stucksolver.record import replay
from stucksolver.solver import EventKind
from test_guard_turning import WIDE
from test_turning import Turner


class TurnsRound:
    """A reasoner that turns round, once."""

    name = "turns_round"

    def decide(self, request):
        plan = None if request.scene.attempts else RecoveryPlan(behaviors=(TurnAround(),))
        analysis = Analysis(steps=(), immobilized=True, reason="a test")
        observation = Observation(controls=(), participants=(), summary="")
        return ReasonerAnswer(
            Decision(observation=observation, analysis=analysis, plan=plan, rationale="a test"), self.name
        )


@pytest.mark.integration
def test_a_turn_is_derived_again_to_the_last_verdict(tmp_path):
    world = Turner(WIDE, cruise_mps=0.0)
    seen, files = recorded(tmp_path, world, 60.0, reasoner=TurnsRound())
    assert EventKind.FINISHED in seen.kinds() and math.cos(world.yaw) < -0.9
    report = replay(files[0])
    assert report.matches
    assert report.ticks > 300
