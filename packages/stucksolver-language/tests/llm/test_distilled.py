"""The student: its scene text, its chain of codes, its weights, and what it never does."""

from __future__ import annotations

import hashlib
import json
import math
import shutil

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stucksolver.guard.verdict import OK
from stucksolver.ladder import parse_ladder, profile_text
from stucksolver.plan import CauseCode, Intent, RecoveryPlan, WaitReason
from stucksolver.plan.behaviors import REGISTRY
from stucksolver.plan.behaviors.registry import unknown_behavior_reason
from stucksolver.reasoners import ReasonerRequest, RuleReasoner, parse_trace
from stucksolver.reasoners.factory import make_reasoner
from stucksolver.reasoners.reasoner import ACCEPTED
from stucksolver.reasoners.registry import ReasonerNameError
from stucksolver.record import Recorder, replay
from stucksolver.scene import CandidateWaypoint, FailedAttempt, Guidance, LineKind, ObjectKind, Scene
from stucksolver.solver import StuckSolver
from stucksolver_language.llm.prompt import user_text
from stucksolver_language.llm.prompt_parser import PromptError, read_prompt
from stucksolver_language.student import DistilledReasoner, SelectionPolicy
from stucksolver_language.student.candidates import candidates
from stucksolver_language.student.chain_codec import MOST_TOKENS, ChainError, ReasoningChain, read_chain, write_chain
from stucksolver_language.student.feature_encoding import MOST, WIDTHS, encode, encode_plans
from stucksolver_language.student.network import CARD, DATA, WEIGHTS, read_card
from stucksolver_language.student.scene_codec import FIELDS, ROWS, VERSION, SceneTextError, read_scene, write_scene
from stucksolver_language.student.student_reasoner import held_by_law
from stucksolver_language.student.vocabulary import vocabulary
from worlds import World, drive, red_light, said, straight_road, thing

ROAD = straight_road(left=LineKind.BROKEN)
WORDS = ("please overtake them", "go back a little", "turn round", "drive over it", "wait", "what a nice day", "")


def scene(*things, controls=(), stopped_for_s=30.0, **update) -> Scene:
    found = World(ROAD, list(things), controls).scene()
    ego = found.ego.model_copy(update={"stopped_for_s": stopped_for_s, "progress_20s_m": 0.0})
    return found.model_copy(update={"ego": ego, **update})


@st.composite
def scenes(draw) -> Scene:
    """Scenes with anything anywhere, lights, words and failed attempts."""
    kinds = st.sampled_from(ObjectKind)
    places = st.tuples(st.floats(20.0, 150.0), st.floats(-8.0, 8.0), kinds)
    things = [thing(f"o {n}", x, y, kind=kind) for n, (x, y, kind) in enumerate(draw(st.lists(places, max_size=40)))]
    controls = (red_light(draw(st.floats(-5.0, 60.0))),) if draw(st.booleans()) else ()
    attempts = tuple(
        FailedAttempt(time_s=0.0, behaviors=(name,), outcome="no")
        for name in draw(st.lists(st.sampled_from(list(REGISTRY)), max_size=3))
    )
    words = draw(st.none() | st.sampled_from(WORDS))
    guidance = None if words is None else said(words)
    stopped_for_s = draw(st.floats(0.0, 500.0))
    return scene(*things, controls=controls, stopped_for_s=stopped_for_s, attempts=attempts, guidance=guidance)


@pytest.fixture(scope="module")
def student() -> DistilledReasoner:
    return DistilledReasoner()


# ---- the scene's text


@pytest.mark.integration
@given(scenes())
@settings(max_examples=60, deadline=None)
def test_a_scene_survives_its_text(one):
    text = write_scene(one)
    again = read_scene(text)
    assert write_scene(again) == text
    assert [o.id for o in again.objects] == [o.id for o in one.objects]
    assert again.behaviors == one.behaviors
    assert (again.guidance is None) == (one.guidance is None)


def test_scene_text_fields_match_digest_of_version():
    """The digest of the fields belongs to this version of the scene text."""
    # Who changes the rows raises VERSION, trains again and writes the new digest here.
    digest = hashlib.sha256(json.dumps(FIELDS).encode()).hexdigest()[:12]
    assert (VERSION, digest) == (1, "f9a77b8e9a85")


def test_every_field_of_a_row_exists():
    for letter, (_, kind) in ROWS.items():
        assert set(FIELDS[letter]) <= set(kind.model_fields)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda text: text.replace(f"scene/{VERSION}", f"scene/{VERSION + 1}"), "another version"),
        (lambda text: text.replace('["e"', '["x"'), "line 3: unknown row 'x'"),
        (lambda text: text[:-40], "line"),
        (lambda text: "", "another version"),
    ],
)
def test_scene_text_invalid_is_rejected_with_line(change, told):
    """Text that is not a scene of this version is rejected, with the line that is wrong."""
    with pytest.raises(SceneTextError, match=told):
        read_scene(change(write_scene(scene(thing("a", 62.0)))))


@given(st.text(max_size=300))
@settings(max_examples=100, deadline=None)
def test_nonsense_is_never_a_scene(text):
    with pytest.raises(SceneTextError):
        read_scene(text)
    with pytest.raises(PromptError):
        read_prompt(text)


@pytest.mark.integration
@given(scenes())
@settings(max_examples=60, deadline=None)
def test_the_scene_of_a_prompt_is_read_back(one):
    told = user_text(one)
    again = user_text(read_prompt(told))
    # Far objects are not told, nor then what could be done with them. Objects that are equally near once their
    # distance is rounded may change places.
    fewer = "more, farther" in told
    left_out = ("and ", "behaviors available") if fewer else ("nothing",)
    lines, others = (sorted(x for x in t.splitlines() if not x.startswith(left_out)) for t in (told, again))
    assert lines == others


# ---- the chain


def test_a_chain_survives_its_codes():
    name = "a b=c:1"
    nudge = {"name": "nudge", "side": "left", "offset_m": 0.5, "distance_m": 5.0}
    plan = RecoveryPlan.model_validate({"behaviors": [nudge, {"name": "drive_over", "object_id": name}]})
    seen, cause = ((name, Intent.OBSTRUCTING),), CauseCode.STATIC_OBSTACLE
    chain = ReasoningChain((0,), seen, None, True, cause, None, (0.12, 0.5), plan)
    assert read_chain(write_chain(chain)) == chain


@pytest.mark.parametrize(
    "text", ["", "chain/2 S1 S2 free ends:0:0 S3 -", "chain/1 S1 S2 free S3 -", "chain/1 S1 S2 maybe ends:0:0 S3 -"]
)
def test_what_is_no_chain_is_refused(text):
    with pytest.raises(ChainError):
        read_chain(text)


# ---- numbers


@pytest.mark.integration
@given(scenes())
@settings(max_examples=30, deadline=None)
def test_encoding_tables_are_bounded_and_match_model_card(one):
    """All encoded values are below 10, and all tables have the shapes that the model card names."""
    found = encode(one)
    for kind, table in found.rows.items():
        assert table.shape == (MOST.get(kind, 1), WIDTHS[kind])
        assert abs(table).max() < 10.0
    rows, named = encode_plans(candidates(one), found.ids, vocabulary())
    assert abs(rows).max(initial=0.0) < 10.0
    assert named.max(initial=0) <= MOST["objects"]


def test_every_behavior_of_the_registry_is_in_the_vocabulary():
    words = vocabulary()
    assert words.behaviors == tuple(REGISTRY)
    assert {"speed_mps", "distance_m"} <= set(words.numbers)
    assert "side=left" in words.choices


# ---- what the student does


@pytest.mark.integration
@given(scenes())
@settings(max_examples=60, deadline=None)
def test_its_answer_is_short_and_valid_wherever_it_is_read(student, one):
    answer = student.decide(ReasonerRequest(one))
    text = answer.trace.answers[-1]
    assert len(text.split()) <= MOST_TOKENS
    assert parse_trace(answer.trace, one) == answer.decision
    for behavior in () if answer.decision.plan is None else answer.decision.plan.behaviors:
        assert unknown_behavior_reason(behavior) is None
        assert one.offers(behavior.name)


@pytest.mark.integration
@given(scenes())
@settings(max_examples=20, deadline=None)
def test_the_same_scene_always_gets_the_same_answer(student, one):
    first, again = student.decide(ReasonerRequest(one)), DistilledReasoner().decide(ReasonerRequest(one))
    assert first.decision == again.decision


def test_student_all_plans_rejected_falls_back_to_rules(student):
    """The student proposes only plans that the guard accepts; without one, it proposes the plan of the rules."""
    one = scene(thing("a", 62.0))
    asked: list[RecoveryPlan] = []

    def refuse(plan: RecoveryPlan) -> str:
        asked.append(plan)
        return "collision: no"

    plan = student.decide(ReasonerRequest(one, refuse)).decision.plan
    assert plan == RuleReasoner().decide(ReasonerRequest(one)).decision.plan
    assert len(set(asked)) == len(asked) <= 8


def test_the_word_for_accepted_is_the_guards():
    assert str(OK) == ACCEPTED


def test_it_never_waits_for_long_on_its_own_authority(student):
    impatient = DistilledReasoner(choice=SelectionPolicy(soon=0.0))
    soon, late = (scene(thing("a", 62.0), stopped_for_s=s) for s in (20.0, 61.0))
    assert impatient.decide(ReasonerRequest(soon)).decision.analysis.wait not in (None, WaitReason.NO_SAFE_WAY)
    assert impatient.decide(ReasonerRequest(late)).decision.plan is not None


# ---- where the rules ask for help

CAR_AND_ROCK = (thing("car", 62.0), thing("rock", 82.0, 3.5, kind=ObjectKind.DEBRIS))
EAGER = SelectionPolicy(unlikely=0.0, instead=-100.0)


def for_help(*more, **update) -> Scene:
    one = scene(*CAR_AND_ROCK, *more, stopped_for_s=121.0, **update)
    plan = RuleReasoner().decide(ReasonerRequest(one)).decision.plan
    assert plan is not None and plan.behaviors[0].name == "request_assistance"
    return one


def test_student_candidates_include_lane_change_and_return():
    """The candidates contain lane changes followed by a second change or by a return to the route."""
    pairs = {tuple(b.name for b in plan.behaviors) for plan in candidates(for_help())}
    assert {("change_lane", "change_lane"), ("change_lane", "rejoin_route")} <= pairs


def test_student_accepted_plan_precedes_request_for_assistance():
    """A plan that the guard accepts is preferred to a request for assistance."""
    asked: list[RecoveryPlan] = []

    def accept(plan: RecoveryPlan) -> str:
        asked.append(plan)
        return ACCEPTED

    plan = DistilledReasoner(choice=EAGER).decide(ReasonerRequest(for_help(), accept)).decision.plan
    assert [plan] == asked
    assert plan is not None and not any(b.name == "request_assistance" for b in plan.behaviors)


@pytest.mark.parametrize(
    ("choice", "check"),
    [
        (EAGER, lambda plan: "collision: no"),
        (EAGER, None),
        (SelectionPolicy(unlikely=0.0, instead=100.0), lambda plan: ACCEPTED),
    ],
    ids=["all are refused", "nobody can be asked", "none is worth it"],
)
def test_without_such_a_plan_the_call_stands(choice, check):
    plan = DistilledReasoner(choice=choice).decide(ReasonerRequest(for_help(), check)).decision.plan
    assert plan is not None and plan.behaviors[0].name == "request_assistance"


def test_student_object_in_lane_is_not_passed_in_lane():
    """With an object in the ego's lane, the student does not try to continue in that lane."""
    one = scene(thing("a", 62.0), stopped_for_s=70.0)
    asked: list[RecoveryPlan] = []
    DistilledReasoner(choice=SelectionPolicy(unlikely=0.0, tried=1000)).decide(
        ReasonerRequest(one, lambda p: asked.append(p) or "no")
    )
    ways = {tuple(b.name for b in plan.behaviors) for plan in asked}
    assert ("borrow_oncoming_lane",) in ways
    assert not ways & {("keep_lane",), ("back_up", "keep_lane")}


def test_student_without_blocker_or_rule_plan_has_no_plan():
    """Without a blocker and without a plan of the rules, the student has no plan."""
    one = scene(stopped_for_s=5.0)
    assert RuleReasoner().decide(ReasonerRequest(one)).decision.plan is None
    restless = SelectionPolicy(soon=2.0, unlikely=0.0)
    assert DistilledReasoner(choice=restless).decide(ReasonerRequest(one, lambda plan: ACCEPTED)).decision.plan is None


def test_where_a_light_holds_the_vehicle_the_call_stands():
    one = scene(controls=(red_light(10.0),), stopped_for_s=200.0)
    assert RuleReasoner().decide(ReasonerRequest(one)).decision.plan is not None
    plan = DistilledReasoner(choice=EAGER).decide(ReasonerRequest(one, lambda plan: ACCEPTED)).decision.plan
    assert plan is not None and plan.behaviors[0].name == "request_assistance"


@pytest.mark.parametrize(
    ("more", "controls", "held"),
    [
        ((), (), False),
        ((), (red_light(10.0),), True),
        ((), (red_light(10.0, applies=False),), False),
        ((thing("gate", 56.0, kind=ObjectKind.CROSSING_GATE),), (), True),
        ((thing("across", 60.0, 15.0, yaw=-math.pi / 2, sideways=-6.0),), (), True),
    ],
)
def test_student_light_gate_or_priority_holds_regardless_of_stop_time(more, controls, held):
    """A light, a gate or traffic with priority holds the ego, however long it has been stopped."""
    one = scene(*CAR_AND_ROCK, *more, controls=controls, stopped_for_s=500.0)
    lane = one.ego.lane_id
    route = tuple(CandidateWaypoint(id=f"w{s}", lane_id=lane, x_m=s, y_m=0.0, distance_m=s) for s in (10.0, 30.0))
    assert held_by_law(one.model_copy(update={"waypoints": route})) is held


def test_at_the_destination_it_waits(student):
    ego = scene().ego.model_copy(update={"at_destination": True})
    said_there = student.decide(ReasonerRequest(scene(thing("a", 62.0), ego=ego))).decision
    assert said_there.plan is None
    assert said_there.analysis.wait is WaitReason.AT_DESTINATION


def test_words_that_nobody_has_read_move_nothing(student):
    one = scene(thing("a", 62.0), guidance=Guidance(text="go!", time_s=0.0))
    assert student.decide(ReasonerRequest(one)).decision.plan is None


@pytest.mark.integration
def test_it_drives_past_a_parked_car_without_touching_it(student):
    world = World(ROAD, [thing("a", 62.0)], ())
    seen = drive(world, 60.0, reasoner=student)
    assert world.x > 60.0
    assert seen.nearest_m > 0.3


@pytest.mark.integration
def test_its_decisions_are_derived_again_from_the_record(student, tmp_path):
    drive(World(ROAD, [thing("a", 62.0)], ()), 40.0, reasoner=student, record=Recorder(tmp_path))
    (path,) = tmp_path.rglob("*.jsonl")
    report = replay(path)
    assert report.findings == []
    assert report.decisions > 0
    assert report.underivable == 0


# ---- weights


def test_the_student_can_be_named_wherever_the_rules_can():
    assert make_reasoner("distilled").name.startswith("distilled")


def test_missing_weights_are_named_with_the_remedy(tmp_path):
    with pytest.raises(
        ReasonerNameError, match=r"no student in folder: .*; train it again with `python -m lab distill train`"
    ):
        make_reasoner(f"distilled:{tmp_path}")


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"versions": {"scene_text": 1, "features": 99, "heads": 1}}, "features 99"),
        ({"sha256": "0" * 64}, "weights do not match their card"),
        ({"name": None}, "damaged or of another version"),
    ],
)
def test_weights_of_another_version_are_named_with_the_remedy(tmp_path, change, told):
    for name in (CARD, WEIGHTS):
        shutil.copy(DATA / name, tmp_path)
    card = json.loads((tmp_path / CARD).read_text(encoding="utf-8"))
    (tmp_path / CARD).write_text(json.dumps({**card, **change}), encoding="utf-8")
    with pytest.raises(ReasonerNameError, match=rf"{told}.*python -m lab distill train"):
        make_reasoner(f"distilled:{tmp_path}")


def test_the_shipped_weights_know_every_behavior():
    known = read_card(DATA).vocabulary.behaviors
    assert set(known) == set(REGISTRY), "a behaviour is new: collect and train again"


def test_student_behavior_outside_vocabulary_is_never_proposed(monkeypatch):
    """A behavior that is missing from the vocabulary of the weights is never checked with the guard."""
    student = DistilledReasoner(choice=SelectionPolicy(unlikely=0.0, tried=1000))
    one = scene(thing("a", 62.0))
    asked: set[str] = set()

    def refuse(plan: RecoveryPlan) -> str:
        asked.update(behavior.name for behavior in plan.behaviors)
        return "no"

    student.decide(ReasonerRequest(one, refuse))
    assert "borrow_oncoming_lane" in asked
    asked.clear()
    card = student._network.card
    words = card.vocabulary
    fewer = tuple("another" if name == "borrow_oncoming_lane" else name for name in words.behaviors)
    known = card.model_copy(update={"vocabulary": words.model_copy(update={"behaviors": fewer})})
    monkeypatch.setattr(student._network, "card", known)
    student.decide(ReasonerRequest(one, refuse))
    assert asked
    assert "borrow_oncoming_lane" not in asked


# ---- the rung

RUNG = '[[rung]]\nkind = "distilled"\ntries = 2\n\n[[rung]]\nkind = "model"'


def test_ladder_rung_adds_student_to_solver():
    """A rung of the ladder can name the student, and the solver then has it as a reasoner."""
    text = profile_text("default").replace('[[rung]]\nkind = "model"', RUNG)
    made = parse_ladder(text, "mine")
    assert made.students() == ("distilled",)
    world = World(ROAD, [thing("a", 62.0)], ())
    solver = StuckSolver(lambda seen: world.scene(seen), ladder=made, clock="lockstep")
    assert "distilled" in solver.reasoners


def test_a_rung_without_weights_is_an_error_at_the_start(tmp_path):
    text = profile_text("default").replace(
        '[[rung]]\nkind = "model"', RUNG.replace("tries", f'weights = "{tmp_path}"\ntries')
    )
    with pytest.raises(ReasonerNameError, match="no student in folder"):
        StuckSolver(lambda seen: None, ladder=parse_ladder(text, "mine"))
