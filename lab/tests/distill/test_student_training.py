"""Training, where torch is installed: examples from moments, a few steps, and an export that the runtime accepts."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("torch")
pytest.importorskip("onnx")

from lab.language.plan_search.decision_samples import DecisionSample, JudgedPlan, write_moments
from lab.language.student.commands import SCORES, StudentJob, train
from stucksolver.reasoners import ReasonerRequest
from stucksolver_language.student import DistilledReasoner
from stucksolver_language.student.candidates import candidates
from stucksolver_language.student.scene_codec import write_scene
from worlds import World, straight_road, thing


def moments(count):
    """Standstills that end by themselves exactly if the vehicle ahead has moved a moment ago."""
    for number in range(count):
        ends = number % 2 == 0
        lead = thing("lead", 60.0 + number % 7, moved_s_ago=1.0 if ends else 200.0, stationary_s=1.0 if ends else 200.0)
        scene = World(straight_road(), [lead], ()).scene()
        plans = candidates(scene)
        yield DecisionSample(
            suite="s",
            route_id=str(number),
            seed=1,
            scenario="HardBreakRoute" if number % 5 else "Accident",
            town="grid_town",
            standstill=0,
            at_s=20.0,
            scene=write_scene(scene),
            gone_after_s=3.0 if ends else None,
            watched_s=100.0,
            plans=tuple(
                JudgedPlan(plan=plan, value_m=20.0 if plan.behaviors[0].name == "borrow_oncoming_lane" else None)
                for plan in plans
            ),
        )


@pytest.fixture(scope="module")
def trained(tmp_path_factory):
    folder = tmp_path_factory.mktemp("student")
    write_moments(folder / "data" / "a.jsonl.gz", moments(40))
    for out in ("one", "two"):
        train(StudentJob((folder / "data",), folder / out, steps=60), lambda line: None)
    return folder


def test_the_trained_student_answers_what_it_was_taught(trained):
    student = DistilledReasoner(trained / "one")
    for moved_s_ago, stays in ((1.0, True), (200.0, False)):
        lead = thing("lead", 62.0, moved_s_ago=moved_s_ago, stationary_s=moved_s_ago)
        decision = student.decide(ReasonerRequest(World(straight_road(), [lead], ()).scene())).decision
        assert (decision.plan is None) == stays


def test_the_same_seed_and_steps_give_the_same_weights(trained):
    one, two = ((trained / name / "student.onnx").read_bytes() for name in ("one", "two"))
    assert one == two
    assert (trained / "one" / SCORES).exists()


def test_no_path_of_this_machine_is_in_the_card(trained):
    assert str(trained) not in (trained / "one" / "student.json").read_text(encoding="utf-8")
    assert np.isfinite(DistilledReasoner(trained / "one")._network.card.temperature)
