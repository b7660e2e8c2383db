"""Answers with the letter of a plan, in the short and in the long form, now and from a record."""

from __future__ import annotations

import json

import mind
import pytest
from chat_server import available_in
from menu_worlds import WORLD, Scripted, request_of, stopped

from left_hand_worlds import LeftHandWorld, left_hand
from stucksolver.plan import CauseCode, Intent, PictureObject, RecoveryPlan, WaitReason
from stucksolver.plan.behaviors import ChangeLane, Creep
from stucksolver.plan.mirror import mirrored_plan
from stucksolver.reasoners import ReasonerError, ReasonerTrace, parse_trace
from stucksolver.record import Recorder, replay
from stucksolver.scene import Guidance, LightState, LineKind, ObjectKind, ObservedSign, SignWord
from stucksolver_language.llm import AnswerError, LanguageModelReasoner, parse_answer
from stucksolver_language.llm.answer_form import CONCLUSIONS, AnswerForm
from stucksolver_language.llm.prompt import messages
from worlds import World, drive, ladder, red_light, straight_road, thing

SCENE = stopped()
PLAN = RecoveryPlan(behaviors=(ChangeLane(side="left", distance_m=30.0, speed_mps=5.0),))
MENU = {"A": PLAN, "B": RecoveryPlan(behaviors=(Creep(distance_m=2.0, speed_mps=1.0),))}


def short(**update):
    data = {
        "choice": "A",
        "S1": ["car"],
        "S2": "S2.5:parked_vehicle",
        "why": "A parked car blocks us.",
    }
    return json.dumps(data | update)


def long(scene=SCENE, **decision):
    text = messages(scene)[1].text
    data = mind.answer(text, available_in(text))
    data["decision"] |= {"choice": "A", "behaviors": None, **decision}
    return json.dumps(data)


# ---- the letter


def test_letter_means_the_plan_of_the_menu():
    decision = parse_answer(short(), SCENE, MENU)
    assert decision.plan == PLAN
    assert decision.analysis.cause is CauseCode.PARKED_VEHICLE and decision.analysis.immobilized
    assert [step.answer for step in decision.analysis.steps] == [False, False, False, True]
    assert decision.rationale == "A parked car blocks us."


def test_letter_in_the_long_form_means_the_plan_of_the_menu():
    assert parse_answer(long(), SCENE, MENU).plan == PLAN


@pytest.mark.parametrize("answer", [short, long])
def test_unknown_letter_is_one_clear_error(answer):
    with pytest.raises(AnswerError, match="no plan 'D'; the plans that are listed are A, B"):
        parse_answer(answer(choice="D"), SCENE, MENU)
    with pytest.raises(AnswerError, match="no plan 'A'; no plan is listed"):
        parse_answer(answer(), SCENE)


@pytest.mark.parametrize("answer", [short, long])
def test_letter_with_behaviors_is_an_error(answer):
    own = [{"name": "creep", "distance_m": 2.0, "speed_mps": 1.0}]
    with pytest.raises(AnswerError, match="choice is A, so behaviors must be null"):
        parse_answer(answer(behaviors=own), SCENE, MENU)


def test_own_plan_is_a_list_in_place_of_the_letter():
    own = [{"name": "creep", "distance_m": 2.0, "speed_mps": 1.0}]
    assert parse_answer(short(choice=own), SCENE, MENU).plan == MENU["B"]
    assert parse_answer(short(choice=own), SCENE).plan == MENU["B"]
    for wrong in ([], None, own * 7, [{"name": "fly"}], 3, {"A": 1}):
        with pytest.raises(AnswerError):
            parse_answer(short(choice=wrong), SCENE, MENU)
    with pytest.raises(AnswerError, match="choice is none"):
        parse_answer(short(choice="none", behaviors=own), SCENE, MENU)


def test_none_with_a_reason_to_wait_is_no_plan():
    decision = parse_answer(short(choice="none", S2="S2.4:queue"), SCENE, MENU)
    assert decision.plan is None and decision.analysis.wait is WaitReason.QUEUE and not decision.analysis.immobilized


@pytest.mark.parametrize("code", ["S2.2", "S2.3", "S2.4:light", "S2.4:people"])
def test_plan_although_waiting_is_right_is_an_error(code):
    with pytest.raises(AnswerError, match="S2"):
        parse_answer(short(S2=code), SCENE, MENU)


@pytest.mark.parametrize("code", CONCLUSIONS)
def test_every_code_of_the_schema_can_be_read(code):
    guided = SCENE.model_copy(update={"guidance": Guidance(text="overtake", time_s=0.0)})
    scene = guided if code.startswith("S2.1") else SCENE
    decision = parse_answer(short(choice="none", S2=code), scene, MENU)
    named = [step for step in decision.analysis.steps if step.answer]
    assert [step.id for step in named] == ([] if ":no:" in code else [code.partition(":")[0]])


def test_code_of_a_question_that_was_not_asked_is_an_error():
    with pytest.raises(AnswerError, match=r"S2: 'S2\.1:overtake' is no code for S2\.2"):
        parse_answer(short(S2="S2.1:overtake"), SCENE, MENU)


PLAN_TEXT = '[{"name": "creep", "distance_m": 2, "speed_mps": 1}]'


@pytest.mark.parametrize(
    "form",
    [
        "```json\n{}\n```",
        "I choose this: {} Good luck.",
        "<think>maybe B</think>{}",
        '<tool_call>{{"name": "decide", "arguments": {}}}</tool_call>',
    ],
)
def test_short_form_is_found_in_what_stands_around_it(form):
    assert parse_answer(form.format(short()), SCENE, MENU).plan == PLAN


@pytest.mark.parametrize("choice", ["A", PLAN_TEXT])
def test_short_form_is_read_from_calls_written_as_text(choice):
    """Python's notation, and an element for each argument."""
    quoted = f'"{choice}"' if choice == "A" else choice
    fields = {"choice": choice, "S1": '["car"]', "S2": "S2.5:parked_vehicle", "why": "A parked car."}
    python = f'[decide(choice={quoted}, S1=["car"], S2="S2.5:parked_vehicle", why="A parked car.")]'
    tags = "".join(f"<parameter={name}>{value}</parameter>" for name, value in fields.items())
    elements = "".join(f"<{name}>{value}</{name}>" for name, value in fields.items())
    for text in (python, f"<function=decide>{tags}</function>", f"<tool_call>decide{elements}</tool_call>"):
        decision = parse_answer(text, SCENE, MENU)
        assert decision.plan == (PLAN if choice == "A" else MENU["B"]), text
        assert decision.observation.participants[0].object_id == "car"


# ---- the observation


def test_codes_of_the_first_step_become_an_observation():
    cones = [thing(f"c{k}", 60.0 + 6.0 * k, kind=ObjectKind.CONE) for k in range(4)]
    world = World(straight_road(left=LineKind.BROKEN), cones, (red_light(40.0, LightState.GREEN),))
    scene = stopped(world, signs=(ObservedSign(word=SignWord.ROAD_WORK, object_id="c0"),))
    codes = ["c0:barrier", "light:green", "sign:road_work", "work_zone", "seen:debris@-10~20"]
    seen = parse_answer(short(S1=codes), scene, MENU).observation
    (control,), (sign,), (cone,) = seen.controls, seen.signs, seen.participants
    assert (control.state, control.distance_m) == (LightState.GREEN, 40.0)
    assert (sign.content, sign.object_id) == ("road_work", "c0")
    assert (cone.object_id, cone.kind, cone.intent) == ("c0", ObjectKind.BARRIER, Intent.UNKNOWN)
    assert seen.work_zone.start_m == pytest.approx(60.0 - 0.2 - 52.45, abs=0.01)
    assert seen.work_zone.end_m == pytest.approx(78.2 - 52.45, abs=0.01)
    assert seen.picture_only == (PictureObject(kind=ObjectKind.DEBRIS, bearing_deg=-10.0, distance_m=20.0),)


@pytest.mark.parametrize("code", ["ghost", "light:pink", "sign:free_beer", "seen:ufo@1~2", "car:ufo", "seen:car@999~1"])
def test_unknown_code_is_an_error_that_names_it(code):
    with pytest.raises(AnswerError, match="S1: "):
        parse_answer(short(S1=[code]), SCENE, MENU)


def test_long_observation_has_signs_work_zone_and_what_only_the_image_shows():
    data = json.loads(long())
    data["observation"] |= {
        "signs": [{"content": "ROAD CLOSED", "object_id": "car"}],
        "work_zone": True,
        "picture_only": [{"kind": "debris", "bearing_deg": 5, "distance_m": 12}],
    }
    seen = parse_answer(json.dumps(data), SCENE, MENU).observation
    assert seen.signs[0].content == "ROAD CLOSED" and seen.picture_only[0].distance_m == 12.0
    assert seen.work_zone is not None and seen.work_zone.end_m is None
    data["observation"]["signs"][0]["object_id"] = "ghost"
    with pytest.raises(AnswerError, match="unknown object 'ghost'"):
        parse_answer(json.dumps(data), SCENE, MENU)


# ---- left-hand traffic


def test_letter_in_left_hand_traffic_is_the_solvers_plan():
    """The model reads `change_lane(right`, and the solver gets its own left."""
    road = straight_road(left=LineKind.BROKEN, oncoming=None)
    world = LeftHandWorld(left_hand(road), [thing("car", 60.0)])
    scene = world.scene()
    assert scene.mirrored
    chat = Scripted(short(S1=["car", "seen:debris@-10~20"]))
    answer = LanguageModelReasoner(chat).decide(request_of(world, stopped(world)))
    text = chat.asked[0][0][1].text
    assert "A change_lane(right, " in text and "change_lane(left, " not in text.partition("A ")[2].partition("+")[0]
    assert answer.decision.plan.behaviors[0].side == "left"
    assert answer.decision.plan == answer.trace.menu[0].plan == mirrored_plan(mirrored_plan(answer.trace.menu[0].plan))
    assert answer.decision.observation.picture_only[0].bearing_deg == 10.0


# ---- the reasoner, and the record


def test_reasoner_lists_the_menu_and_takes_the_letter():
    chat = Scripted(short())
    answer = LanguageModelReasoner(chat).decide(request_of())
    lines = chat.asked[0][0][1].text.splitlines()
    assert any(line.startswith("A change_lane(left, ") and ": accepted: " in line for line in lines)
    assert request_of().assess(answer.decision.plan).accepted


def test_reasoner_unknown_letter_is_repaired():
    chat = Scripted(short(choice="F"), short())
    assert LanguageModelReasoner(chat).decide(request_of()).decision.plan is not None
    assert "there is no plan 'F'" in chat.asked[1][0][-1].text


def test_reasoner_without_the_guard_has_no_menu():
    request = request_of()
    request = type(request)(request.scene)
    chat = Scripted(short())
    with pytest.raises(ReasonerError, match="no plan is listed"):
        LanguageModelReasoner(chat).decide(request)
    assert "plans that the guard has checked" not in chat.asked[0][0][1].text


def test_reasoner_with_menu_off_neither_searches_nor_offers_letters():
    chat = Scripted(short(choice="none"))
    LanguageModelReasoner(chat, form=AnswerForm(menu=False)).decide(request_of())
    (system, user), (tool,) = chat.asked[0]
    assert "plans that the guard has checked" not in user.text and "letter" not in system.text
    assert tool.parameters["properties"]["choice"]["anyOf"][0]["enum"] == ["none"]


def test_whole_plan_is_checked_for_the_model():
    """The second step of a plan is refused where it begins, with the missing amount."""
    world = World(straight_road(), [thing("car", 52.45 + 1.0 + 2.3)])
    plan = [
        {"name": "back_up", "distance_m": 1.0, "speed_mps": 1.0},
        {"name": "borrow_oncoming_lane", "past_object_id": "car", "speed_mps": 5.5},
    ]
    chat = Scripted(json.dumps({"behaviors": plan}), short(choice="none"))
    LanguageModelReasoner(chat).decide(request_of(world, check=lambda plan: "accepted"))
    verdict = chat.asked[1][0][-1].text
    assert verdict.startswith("refused at behavior 2: ") and " m short (" in verdict


def test_recorded_letter_means_the_same_plan_without_the_guard():
    answer = LanguageModelReasoner(Scripted(short())).decide(request_of())
    trace = ReasonerTrace.model_validate_json(answer.trace.model_dump_json(exclude_none=True))
    assert parse_trace(trace, SCENE) == answer.decision
    with pytest.raises(ReasonerError, match="no plan is listed"):
        parse_trace(trace.model_copy(update={"menu": ()}), SCENE)


def test_answers_of_the_former_format_have_no_menu():
    text = long(choice=None, behaviors=[{"name": "creep", "distance_m": 2.0, "speed_mps": 1.0}])
    assert parse_trace(ReasonerTrace(format="llm-decide-2", answers=(text,)), SCENE).plan == MENU["B"]


@pytest.mark.integration
def test_record_of_a_letter_is_derived_again(tmp_path):
    """A drive in which the model chooses by letter replays offline, to the last verdict."""
    world = World(WORLD.road, [thing("car", 75.0)], x=66.0)
    reasoner = LanguageModelReasoner(Scripted(short()))
    with Recorder(tmp_path) as recorder:
        drive(world, 20.0, record=recorder, models={"model": reasoner}, ladder=ladder(rungs={"reasoner": None}))
    report = replay(recorder.files[0])
    assert report.findings == [] and report.decisions >= 1
    assert '"menu":[{"letter":"A"' in recorder.files[0].read_text(encoding="utf-8").replace(" ", "")
