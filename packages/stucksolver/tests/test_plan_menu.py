"""The menu: plans that the guard has assessed, with what is missing where one is refused."""

from __future__ import annotations

import pytest

from stucksolver.guard import Guard
from stucksolver.plan import RecoveryPlan, intent_authorizes
from stucksolver.plan.assessment import PlanAssessment, Shortfall
from stucksolver.plan.behaviors import BackUp, BorrowOncomingLane
from stucksolver.plan.plan_text import assessment_text, plan_text
from stucksolver.reasoners.search.menu import LETTERS, plan_menu
from stucksolver.scene import LineKind, RejectCode, ZoneKind
from stucksolver.scene.road import Zone
from stucksolver.solver.state_machine.plan_preview import PlanPreview
from worlds import World, said, searched, straight_road, thing

ROAD = straight_road()
FRONT_X = 52.45
"""Front bumper of the ego (m)."""


def stopped(world, **update):
    scene = world.scene()
    return scene.model_copy(update={"ego": scene.ego.model_copy(update={"stopped_for_s": 20.0}), **update})


def preview(world, reading=None):
    return PlanPreview(Guard(), world.view(), lambda plan: intent_authorizes(reading, plan))


def menu_of(world, **update):
    scene = stopped(world, **update)
    reading = None if scene.guidance is None else scene.guidance.reading
    return plan_menu(scene, preview(world, reading).assess)


def car(gap_m, y=0.0, name="lead"):
    return thing(name, FRONT_X + gap_m + 2.3, y)


def names(item):
    return [behavior.name for behavior in item.plan.behaviors]


def test_menu_accepted_plan_comes_first_with_time_gap_and_margin():
    world = World(ROAD, [car(8.0)])
    first = menu_of(world)[0]
    assert (first.letter, names(first), first.accepted) == ("A", ["borrow_oncoming_lane"], True)
    found = preview(world).assess(first.plan)
    assert found.gap_m is not None and found.gap_margin_m is not None and found.gap_margin_m > 0.0
    assert f"{found.duration_s:.1f} s" in first.text and "m to spare" in first.text and "gap " in first.text


@pytest.mark.parametrize("gap_m", [1.5, 8.0])
def test_menu_first_plan_is_that_of_the_search(gap_m):
    world = World(ROAD, [car(gap_m)])
    assert menu_of(world)[0].plan == searched(world, stopped(world)).plan


def test_menu_refused_plan_names_the_missing_amount():
    """With too little sight for a pass, the pass is listed with the meters that are missing."""
    refused = [item for item in menu_of(World(ROAD, [car(8.0)], sight_m=90.0)) if not item.accepted]
    sight = [item for item in refused if "oncoming_sight" in item.text]
    assert sight and " m short (oncoming lane: sight distance" in sight[0].text


def test_menu_plan_that_waits_for_traffic_is_listed_as_such():
    oncoming = thing("oncoming", 120.0, 3.5, speed=-10.0)
    first = menu_of(World(ROAD, [car(8.0), oncoming]))[0]
    assert names(first) == ["borrow_oncoming_lane"] and not first.accepted
    assert "accepted when traffic has passed" in first.text


def test_menu_has_at_most_six_plans_of_different_kinds():
    road = straight_road(left=LineKind.BROKEN)
    for world in (World(road, [car(8.0)]), World(ROAD, [car(0.8)]), World(road, [car(3.0), car(3.0, 3.5, "other")])):
        menu = menu_of(world)
        assert [item.letter for item in menu] == list(LETTERS[: len(menu)])
        accepted = [plan_text(item.plan) for item in menu if item.accepted]
        assert len(set(accepted)) == len(accepted)
        assert [item.accepted for item in menu] == sorted((item.accepted for item in menu), reverse=True)


def test_menu_of_a_blocked_road_has_no_accepted_plan():
    wall = [thing(f"w{k}", FRONT_X + 4.0, -4.0 + 2.0 * k, length=1.0, width=2.0) for k in range(6)]
    menu = menu_of(World(straight_road(oncoming=None), wall))
    assert not any(item.accepted for item in menu)
    assert all(" short (" in item.text for item in menu)


def test_menu_without_behaviors_is_empty():
    assert menu_of(World(ROAD, [car(8.0)], offers=())) == ()


def test_menu_with_guidance_has_only_plans_that_are_asked_for():
    world = World(ROAD, [car(8.0)])
    menu = menu_of(world, guidance=said("please overtake the car"))
    assert menu and all("borrow_oncoming_lane" in names(item) for item in menu if item.accepted)


def test_menu_is_deterministic():
    world = World(ROAD, [car(1.5)])
    assert menu_of(world) == menu_of(world)


def test_mirrored_item_swaps_sides():
    world = World(straight_road(left=LineKind.BROKEN), [car(8.0)])
    item = menu_of(world)[0]
    assert "change_lane(left" in item.text and "change_lane(right" in item.mirrored().text.partition("+")[0]
    assert item.mirrored().mirrored() == item


def test_plan_text_has_the_values_in_order():
    plan = RecoveryPlan(behaviors=(BackUp(distance_m=3.0), BorrowOncomingLane(past_object_id="car 7", speed_mps=5.5)))
    assert plan_text(plan) == "back_up(3, 1)+borrow_oncoming_lane(car 7, 5.5)"


def test_assessment_text_never_loses_the_amount():
    """A long detail is cut after the amount."""
    lacking = Shortfall(code=RejectCode.GAP, detail="x" * 500, missing=0.34, unit="m")
    text = assessment_text(PlanAssessment(step=1, shortfalls=(lacking,)))
    assert text.startswith("refused at behavior 2: gap 0.3 m short (xxx") and len(text) < 200


def test_scene_has_the_zones_that_the_ego_has_not_left():
    zones = (
        Zone(kind=ZoneKind.CROSSWALK, start_m=20.0, end_m=24.0),
        Zone(kind=ZoneKind.JUNCTION, start_m=FRONT_X + 10.0, end_m=FRONT_X + 30.0),
    )
    (zone,) = World(straight_road(zones=zones)).scene().zones
    assert (zone.kind, zone.start_m, zone.end_m) == (ZoneKind.JUNCTION, pytest.approx(10.0), pytest.approx(30.0))
