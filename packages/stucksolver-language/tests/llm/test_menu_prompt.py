"""What the prompt says beside the measured objects: menu, failures, work zones, roads, and how to read it."""

from __future__ import annotations

import pytest
from menu_worlds import request_of, stopped

from stucksolver.guard import RejectCode, RejectReason, Verdict
from stucksolver.plan import RecoveryPlan
from stucksolver.plan.behaviors import BackUp, BorrowOncomingLane
from stucksolver.reasoners.search.menu import plan_menu
from stucksolver.scene import AttemptOutcome, CandidateWaypoint, LineKind, ObjectKind, ZoneKind
from stucksolver.scene.road import Zone
from stucksolver.solver.state_machine.history import AttemptHistory
from stucksolver_language.llm.answer_form import AnswerForm
from stucksolver_language.llm.menu_text import MENU, NO_MENU
from stucksolver_language.llm.model_options import ModelOptions, parse_options
from stucksolver_language.llm.prompt import system_text, user_text
from stucksolver_language.llm.prompt_parser import read_prompt
from stucksolver_language.llm.scene_prompt import scene_text
from worlds import World, straight_road, thing

ROAD = straight_road(left=LineKind.BROKEN)
PASS = RecoveryPlan(behaviors=(BackUp(distance_m=3.0), BorrowOncomingLane(past_object_id="o1", speed_mps=5.5)))
FAR = RejectReason(
    code=RejectCode.ONCOMING_SIGHT,
    detail="oncoming lane: " + "occluded " * 30 + "sight distance 80.0 m, required 152.2 m",
    margin=-72.2,
    unit="m",
)


def crowd(count=30):
    return World(ROAD, [thing(f"o{k}", 58.0 + 3 * k, (k % 3) * 3.5 - 1) for k in range(count)])


def failed(times, reason=FAR):
    history = AttemptHistory(remembered=8)
    for k in range(times):
        history = history.with_attempt(
            PASS, AttemptOutcome.REJECTED, 10.0 + k, text="", verdict=Verdict(rejects=(reason,))
        )
    return history.attempts


def listed(text):
    return [line.split()[0] for line in text.splitlines() if line.startswith("o") and line.split()[0][1:].isdigit()]


# ---- failures


def test_failed_plan_is_told_with_parameters_and_missing_amount():
    """The amount stands before the reason, which may be long."""
    made = stopped(crowd(2), attempts=failed(1), time_s=25.0)
    (line,) = [line for line in scene_text(made).splitlines() if line.startswith("back_up(")]
    told = "back_up(3, 1)+borrow_oncoming_lane(o1, 5.5): refused 15 s ago, oncoming_sight 72.2 m short; oncoming_sight:"
    assert line.startswith(told)


def test_failed_plans_never_push_an_object_out():
    without, with_them = (scene_text(stopped(crowd(), attempts=attempts)) for attempts in ((), failed(6)))
    assert listed(without) == listed(with_them)
    assert with_them.count("72.2 m short") == 3


def test_failed_plan_of_an_old_record_is_told_by_its_names():
    (old,) = failed(1)
    old = old.model_copy(update={"plan": (), "missing": ()})
    assert "\nback_up+borrow_oncoming_lane: refused 10 s ago; oncoming_sight: " in scene_text(
        stopped(crowd(2), attempts=(old,), time_s=20.0)
    )


# ---- work zones and roads


def cones(count, spacing_m=6.0):
    return [thing(f"c{k}", 60.0 + spacing_m * k, -0.5, kind=ObjectKind.CONE) for k in range(count)]


def test_work_zone_is_one_line_with_its_far_end():
    text = scene_text(stopped(World(ROAD, [*cones(9), thing("car", 90.0, 3.5)])))
    assert "\nwork_zone from 7.3 to 55.8 m, edges -0.7..-0.3, 9 cones and barriers, first c0, last c8" in text
    objects = text.partition("objects (")[2]
    assert "\nc0 " in objects and "\nc8 " in objects and "\ncar " in objects and "\nc4 " not in objects
    assert "more, farther" not in text


@pytest.mark.parametrize("objects", [cones(2), cones(4, spacing_m=20.0)])
def test_few_or_scattered_cones_are_no_work_zone(objects):
    assert "work_zone" not in scene_text(stopped(World(ROAD, objects)))


def test_junction_is_told_with_the_roads_off_the_route():
    zone = Zone(kind=ZoneKind.JUNCTION, start_m=70.0, end_m=90.0)
    made = stopped(World(straight_road(zones=(zone,)), [thing("car", 60.0)]))
    starts = [("own+20", "own"), ("left-elsewhere0", "left-elsewhere0"), ("right-elsewhere1", "right-elsewhere1")]
    waypoints = tuple(CandidateWaypoint(id=i, lane_id=lane, x_m=20, y_m=0, distance_m=20) for i, lane in starts)
    text = user_text(made.model_copy(update={"waypoints": waypoints}))
    assert "\njunction from 17.5 to 37.5 m, roads off the route: left-elsewhere0 right-elsewhere1\n" in text
    assert read_prompt(text).zones == made.zones


def test_velocity_across_the_road_is_told_and_read_back():
    walker = thing("walker", 62.0, -3.0, kind=ObjectKind.PEDESTRIAN, sideways=1.2)
    made = stopped(World(ROAD, [walker]))
    assert " 0/1.2 " in scene_text(made)
    assert read_prompt(user_text(made)).objects[0].speed_across_mps == 1.2


# ---- the menu


def test_menu_is_in_the_prompt_and_skipped_when_it_is_read_back():
    request = request_of()
    text = user_text(request.scene, plan_menu(request.scene, request.assess))
    assert f"\n{MENU}\nA change_lane(left, " in text
    back = read_prompt(text)
    assert [o.id for o in back.objects] == ["car"] and back.offers("change_lane")
    assert read_prompt(user_text(request.scene, ())).behaviors == back.behaviors


def test_empty_menu_is_told_as_such():
    scene = stopped()
    assert f"\n{NO_MENU}\n" in user_text(scene, ()) and "plans that the guard" not in user_text(scene, None)


# ---- how to read it


@pytest.mark.parametrize("form", [AnswerForm(menu, chain) for menu in (True, False) for chain in ("short", "long")])
def test_fixed_text_says_conventions_and_the_cap_that_holds(form):
    """In every form: what `?`, `gap`, the signs and lane `ego` mean, and the guard's cap in place of a range's end."""
    text = system_text(stopped(), form)
    for told in ("? is unknown", "left positive", "gap: along the route from our front bumper", "Lane ego is"):
        assert told in text
    assert "The guard's cap on speed_mps is 5.5" in text
    assert ("letter" in text) is form.menu and "{" not in text


# ---- options


def test_options_choose_the_form():
    assert ModelOptions().form == AnswerForm(menu=True, chain="short")
    assert parse_options(["menu=off", "chain=long"]).form == AnswerForm(menu=False, chain="long")
    assert parse_options(["menu=on"]).form.menu


@pytest.mark.parametrize("text", ["menu=maybe", "menu", "chain=", "chain=medium"])
def test_unknown_form_is_named(text):
    with pytest.raises(ValueError, match=f"unknown option: #{text}"):
        parse_options([text])
