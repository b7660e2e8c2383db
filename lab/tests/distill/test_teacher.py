"""The teacher's data: what a grid holds, how endings are ordered, and what is kept of a campaign that was killed."""

from __future__ import annotations

import pytest
from stucksolver.reasoners.playback import BOOK, PlanTable, PlaybackReasoner, read_book, scene_digest

from lab.language.plan_search.beam_search import kinds, varied
from lab.language.plan_search.grade import Grade
from lab.language.plan_search.labels import Label, LabelFile, best
from stucksolver.plan import RecoveryPlan
from stucksolver.plan.behaviors import REGISTRY, Wait, describe
from stucksolver.reasoners import ReasonerRequest, RuleReasoner
from stucksolver.reasoners.registry import ReasonerNameError
from stucksolver.scene import Scene, SceneEgo
from stucksolver_language.student.candidates import offered

PLAN = RecoveryPlan(behaviors=(Wait(duration_s=5.0),))


def scene(time_s: float = 0.0) -> Scene:
    ego = SceneEgo(
        speed_mps=0.0,
        lane_id=None,
        lateral_offset_m=0.0,
        distance_to_destination_m=100.0,
        at_destination=False,
        length_m=4.8,
        width_m=2.0,
    )
    offers = describe(tuple(REGISTRY))
    return Scene(time_s=time_s, frame=1, ego=ego, objects=(), controls=(), lanes=(), behaviors=offers)


def label(source: str = "teacher", **changes: object) -> Label:
    got: dict[str, object] = {
        "recovered_after_s": 10.0,
        "collisions": 0,
        "infractions": 0,
        "near_misses": 0,
        "comfort": 0.9,
        "driving_score": 100.0,
        "completion": 100.0,
        "success": True,
        "state": "Perfect",
    }
    grade = Grade.model_validate({**got, **changes})
    return Label.model_validate(
        {
            "standstill": "1-1-a",
            "scenario": "Accident",
            "source": source,
            "plan": PLAN,
            "reached": True,
            "grade": grade,
            "drive_s": 1.0,
        }
    )


def test_the_grid_holds_only_valid_behaviors_and_calls_nobody():
    found = offered(scene(), 4)
    names = {behavior.name for behavior in found}
    assert names >= {"wait", "change_lane", "creep", "back_up"}
    assert "request_assistance" not in names
    assert len(set(found)) == len(found)
    # No object is there, so nothing can be passed, followed or driven over.
    assert not names & {"borrow_oncoming_lane", "follow_vehicle", "drive_over"}
    assert {b.duration_s for b in found if isinstance(b, Wait)} >= {0.5, 60.0}


def test_harm_outweighs_everything_and_a_recovery_everything_but_harm():
    quick, slow = label(), label(recovered_after_s=50.0)
    harmed, stays = label(collisions=1, driving_score=100.0), label(recovered_after_s=None, driving_score=100.0)
    assert best([slow, harmed, stays, quick]) is quick
    assert best([harmed, stays]) is stays
    assert best([stays, slow]) is slow


def test_label_standstill_not_reached_is_not_used():
    """A run that did not reach the same standstill gives no label."""
    assert best([label().model_copy(update={"reached": False})]) is None


def test_labels_survive_a_kill_in_the_middle_of_a_line(tmp_path):
    path = tmp_path / "labels.jsonl"
    LabelFile(path).add(label())
    LabelFile(path).add(label("rules"))
    whole = path.read_text(encoding="utf-8")
    path.write_text(whole + whole[:50], encoding="utf-8")
    assert [item.source for item in LabelFile(path).labels] == ["teacher", "rules"]
    assert path.read_text(encoding="utf-8") == whole


def test_a_line_that_is_no_label_is_named(tmp_path):
    path = tmp_path / "labels.jsonl"
    path.write_text('{"a": 1}\n', encoding="utf-8")
    with pytest.raises(ValueError, match="line 1"):
        LabelFile(path)


def test_the_chosen_plans_take_turns_by_kind():
    plans = [(("wait",), 9.0), (("wait",), 8.0), (("creep",), 1.0)]
    assert varied(plans, lambda plan: plan, 2) == [plans[0], plans[2]]
    assert kinds(PLAN.behaviors) == ("wait",)


def test_the_book_is_played_back_for_its_scene_alone(tmp_path):
    here, elsewhere = scene(), scene(time_s=1.0)
    (tmp_path / BOOK).write_text(PlanTable(plans={scene_digest(here): PLAN}).model_dump_json(), encoding="utf-8")
    book = read_book(tmp_path)
    rules = RuleReasoner().decide(ReasonerRequest(elsewhere)).decision
    then_rules = PlaybackReasoner(book, "rules")
    assert then_rules.decide(ReasonerRequest(here)).decision.plan == PLAN
    assert then_rules.decide(ReasonerRequest(elsewhere)).decision == rules
    teacher = PlaybackReasoner(book)
    assert teacher.decide(ReasonerRequest(here)).decision.plan == PLAN
    after = teacher.decide(ReasonerRequest(elsewhere)).decision
    assert after.plan is None and after.analysis.wait is not None


def test_plan_table_missing_file_names_collect_command(tmp_path):
    """A folder without a plan table is rejected, and the error names the command that writes one."""
    with pytest.raises(ReasonerNameError, match="distill collect"):
        read_book(tmp_path)
