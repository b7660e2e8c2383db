"""When waiting is right, what the cause is, and what the search makes of a blocked lane, without a passenger."""

from __future__ import annotations

import math
import re

import pytest

from stucksolver.guard import Guard, RejectCode
from stucksolver.plan import CauseCode, Intent, WaitLimits, WaitReason
from stucksolver.plan.behaviors import BorrowOncomingLane, ChangeLane
from stucksolver.scene import CandidateWaypoint, ControlKind, LightState, LineKind, ObjectKind, TrafficControl
from worlds import LANE_M, World, red_light, said, searched, straight_road, thing

TWO_WAY = straight_road()
MULTI = straight_road(left=LineKind.BROKEN, oncoming=None)


def decide(world, *, stopped_s=30.0, limits=None, **ego):
    scene = world.scene()
    ego = scene.ego.model_copy(update={"stopped_for_s": stopped_s, **ego})
    return searched(world, scene.model_copy(update={"ego": ego}), limits)


def blocked(**lead):
    """A road with one thing standing 10 m ahead."""
    return World(TWO_WAY, [thing("lead", 64.75, **lead)])


def wait_of(decision):
    assert decision.plan is None
    return decision.analysis.wait


def behaviors_of(decision):
    assert decision.plan is not None, decision.rationale
    return decision.plan.behaviors


# ---- waiting is right


@pytest.mark.parametrize("state", [LightState.RED, LightState.YELLOW])
def test_it_waits_at_a_red_light(state):
    assert wait_of(decide(World(TWO_WAY, controls=(red_light(5.0, state),)))) is WaitReason.LIGHT


@pytest.mark.parametrize("distance", [-1.5, 21.0])
def test_red_light_behind_or_far_is_no_legitimate_wait(distance):
    """A red light behind the ego or far away is no reason to wait."""
    decision = decide(World(TWO_WAY, controls=(red_light(distance),)))
    assert decision.analysis.cause is CauseCode.UNKNOWN


def test_a_red_light_for_others_is_no_reason_to_wait():
    decision = decide(World(TWO_WAY, controls=(red_light(5.0, applies=False),)))
    assert decision.analysis.wait is None


@pytest.mark.parametrize("stopped_s", [10.0, 179.0, 181.0, 3600.0])
def test_red_light_is_not_passed_but_requests_assistance(stopped_s):
    """No red light is passed, however long it lasts, but assistance is requested."""
    world = World(TWO_WAY, [thing("lead", 60.0, hazard=True)], controls=(red_light(18.0),))
    plan = decide(world, stopped_s=stopped_s).plan
    assert (plan is None) == (stopped_s < 180.0)
    assert plan is None or [b.name for b in plan.behaviors] == ["request_assistance"]


@pytest.mark.parametrize(("stopped_s", "waits"), [(40.0, True), (179.0, True), (200.0, False)])
def test_crossing_gate_closed_waits_like_red_light(stopped_s, waits):
    """A closed crossing gate is waited for like a red light."""
    gate = thing("gate", 60.0, kind=ObjectKind.CROSSING_GATE, length=0.3, width=3.0)
    decision = decide(World(TWO_WAY, [gate]), stopped_s=stopped_s)
    assert (decision.analysis.wait is WaitReason.LIGHT) == waits
    assert decision.plan is None or [b.name for b in decision.plan.behaviors] == ["request_assistance"]


def test_parked_car_before_green_light_is_passed():
    """A parked car before a traffic light is passed when the light is green."""
    world = World(TWO_WAY, [thing("lead", 60.0, hazard=True)], controls=(red_light(18.0, LightState.GREEN),))
    assert behaviors_of(decide(world))[0].name == "borrow_oncoming_lane"


def test_it_looks_around_for_three_seconds_at_a_stop_sign():
    sign = TrafficControl(kind=ControlKind.STOP_SIGN, distance_m=3.0, applies=True)
    world = World(TWO_WAY, controls=(sign,))
    assert wait_of(decide(world, stopped_s=1.0)) is WaitReason.STOP_SIGN
    assert decide(world, stopped_s=4.0).analysis.wait is None


@pytest.mark.parametrize(("moved_s_ago", "waits"), [(0.0, True), (59.0, True), (61.0, False), (None, False)])
def test_a_leader_that_moved_within_a_minute_is_a_queue(moved_s_ago, waits):
    decision = decide(blocked(moved_s_ago=moved_s_ago, stationary_s=59.0))
    assert (decision.analysis.wait is WaitReason.QUEUE) == waits
    assert (decision.plan is None) == waits


def test_a_leader_at_a_red_light_is_a_queue():
    world = blocked(stationary_s=100.0)
    world.controls = (red_light(25.0),)
    assert wait_of(decide(world)) is WaitReason.QUEUE


def test_a_leader_behind_one_that_moved_lately_is_a_queue():
    world = World(TWO_WAY, [thing("lead", 64.75), thing("next", 72.0, moved_s_ago=20.0)])
    assert wait_of(decide(world)) is WaitReason.QUEUE


def test_a_leader_that_moves_is_followed():
    assert wait_of(decide(blocked(speed=2.0))) is WaitReason.QUEUE


@pytest.mark.parametrize("kind", [ObjectKind.PEDESTRIAN, ObjectKind.ANIMAL])
def test_it_waits_for_whoever_crosses(kind):
    assert wait_of(decide(blocked(kind=kind))) is WaitReason.PEOPLE
    stepping = World(TWO_WAY, [thing("walker", 60.0, -3.0, kind=kind, sideways=1.2)])
    assert wait_of(decide(stepping)) is WaitReason.PEOPLE


@pytest.mark.parametrize(
    ("kind", "sd_m", "stood_s", "moved_s_ago", "waits"),
    [
        (ObjectKind.ANIMAL, 0.2, 62.0, None, False),
        (ObjectKind.ANIMAL, 0.2, 58.0, None, True),
        (ObjectKind.ANIMAL, 0.2, 62.0, 80.0, True),
        (ObjectKind.ANIMAL, None, 62.0, None, True),
        (ObjectKind.PEDESTRIAN, 0.2, 62.0, None, True),
    ],
    ids=["box", "not for long", "it came", "ground truth", "a person"],
)
def test_by_sensors_an_animal_that_never_moved_is_passed(kind, sd_m, stood_s, moved_s_ago, waits):
    """Boxes and cones are often taken for one."""
    lead = thing("lead", 62.0, kind=kind, length=1.0, width=0.5, stationary_s=stood_s, moved_s_ago=moved_s_ago)
    decision = decide(World(TWO_WAY, [lead.model_copy(update={"position_sd_m": sd_m})]))
    assert (decision.analysis.wait is WaitReason.PEOPLE) == (decision.plan is None) == waits


@pytest.mark.parametrize(("stopped_s", "waits"), [(5.0, True), (19.0, True), (21.0, False)])
def test_person_who_hesitates_at_lane_edge_is_given_time_then_passed(stopped_s, waits):
    """Such a person is not in the path, but the guard refuses to drive past so near: the ego goes around them."""
    person = thing("walker", 62.0, -1.45, kind=ObjectKind.PEDESTRIAN)
    decision = decide(World(TWO_WAY, [person]), stopped_s=stopped_s)
    assert (decision.plan is None) is waits
    if waits:
        assert decision.analysis.wait is WaitReason.PEOPLE and "walker" in decision.rationale
    else:
        assert decision.plan.behaviors[-1] == BorrowOncomingLane(past_object_id="walker", speed_mps=5.5)


def test_people_who_walk_away_hold_nobody_up():
    away = World(TWO_WAY, [thing("walker", 60.0, -3.0, kind=ObjectKind.PEDESTRIAN, sideways=-1.2)])
    assert decide(away).analysis.wait is None


@pytest.mark.parametrize(
    ("lead", "needed_s"), [({}, 10.0), ({"hazard": True}, 3.0), ({"y": -0.6}, 3.0)], ids=["unknown", "hazard", "parked"]
)
def test_a_stopped_vehicle_is_given_its_time_first(lead, needed_s):
    early, late = blocked(**lead, stationary_s=needed_s - 0.5), blocked(**lead, stationary_s=needed_s + 0.5)
    assert wait_of(decide(early)) is WaitReason.UNKNOWN_STOPPED
    assert behaviors_of(decide(late)) == (BorrowOncomingLane(past_object_id="lead", speed_mps=5.5),)


def test_the_limits_are_a_matter_of_policy():
    world = blocked(stationary_s=15.0)
    assert decide(world).plan is not None
    assert decide(world, limits=WaitLimits(unknown_vehicle_s=20.0)).plan is None


def test_at_the_destination_there_is_nothing_to_do():
    assert wait_of(decide(blocked(), at_destination=True)) is WaitReason.AT_DESTINATION


def test_while_it_moves_there_is_nothing_to_do():
    decision = decide(blocked(), speed_mps=3.0)
    assert decision.plan is None
    assert not decision.analysis.immobilized


def test_moving_without_getting_on_is_a_loop():
    decision = decide(blocked(), speed_mps=3.0, progress_20s_m=2.0)
    assert decision.analysis.cause is CauseCode.LOOP
    assert [b.name for b in behaviors_of(decision)] == ["replan"]


def test_red_light_ego_in_loop_has_not_waited():
    """An ego that drives in circles before a red light has not waited at it."""
    world = World(TWO_WAY)
    scene = world.scene()
    ego = scene.ego.model_copy(update={"speed_mps": 2.0, "progress_20s_m": 2.0, "stopped_for_s": 3.0})
    held = scene.model_copy(update={"ego": ego, "controls": (red_light(0.0),)})
    decision = searched(world, held)
    assert decision.analysis.cause is CauseCode.LOOP and decision.plan is None


def test_nothing_in_the_path_leaves_the_cause_unknown():
    decision = decide(World(TWO_WAY))
    assert decision.analysis.cause is CauseCode.UNKNOWN


def turns_right(*others, lead=()):
    """At a junction from which the route goes on to the right 15 m ahead, so that others cross it or join it."""
    world = World(TWO_WAY, [*lead, *others])
    scene = world.scene()
    route = [(12.0, 0.0, 12.0), (18.0, -6.0, 20.0), (20.0, -26.0, 40.0)]
    lane = scene.ego.lane_id
    waypoints = tuple(
        CandidateWaypoint(id=str(k), lane_id=lane, x_m=x, y_m=y, distance_m=s) for k, (x, y, s) in enumerate(route)
    )
    ego = scene.ego.model_copy(update={"stopped_for_s": 30.0})
    return searched(world, scene.model_copy(update={"waypoints": waypoints, "ego": ego}))


@pytest.mark.parametrize(("y", "speed"), [(60.0, -14.0), (20.0, -6.0), (-60.0, 14.0)])
def test_it_yields_to_who_comes_into_the_way_ahead(y, speed):
    decision = turns_right(thing("flow", 70.0, y, sideways=speed, yaw=math.copysign(math.pi / 2, speed)))
    assert wait_of(decision) is WaitReason.YIELD
    assert "flow" in decision.rationale


def test_it_yields_to_who_just_crosses():
    decision = turns_right(thing("flow", 70.0, 1.0, sideways=-8.0, yaw=-math.pi / 2))
    assert wait_of(decision) is WaitReason.YIELD


@pytest.mark.parametrize(
    ("x", "y", "speed"),
    [(70.0, -40.0, -14.0), (100.0, 60.0, -14.0), (70.0, 90.0, -14.0), (70.0, 12.0, -2.0)],
    ids=["is past", "crosses farther on", "is far away", "crawls"],
)
def test_it_does_not_yield_to_others(x, y, speed):
    decision = turns_right(thing("other", x, y, sideways=speed, yaw=-math.pi / 2))
    assert decision.analysis.wait is not WaitReason.YIELD


def test_what_stands_in_the_way_is_no_reason_to_yield():
    decision = turns_right(
        thing("flow", 70.0, 60.0, sideways=-14.0, yaw=-math.pi / 2), lead=[thing("lead", 62.0, hazard=True)]
    )
    assert decision.analysis.wait is not WaitReason.YIELD


@pytest.mark.parametrize(("speed", "plans"), [(-10.0, False), (0.0, True)])
def test_nobody_creeps_towards_who_drives_across_whatever_a_passenger_says(speed, plans):
    """Up to one that stands across the way, to show who begins; not up to one of a flow."""
    world = World(TWO_WAY, [thing("flow", 63.0, sideways=speed, yaw=-math.pi / 2)])
    scene = world.scene()
    words = said("Just go, they will brake.")
    ego = scene.ego.model_copy(update={"stopped_for_s": 30.0})
    decision = searched(world, scene.model_copy(update={"ego": ego, "guidance": words}))
    assert (decision.plan is not None) is plans, decision.rationale


# ---- ways past


@pytest.mark.parametrize(
    ("lead", "cause"),
    [
        ({"kind": ObjectKind.CONE}, CauseCode.STATIC_OBSTACLE),
        ({"kind": ObjectKind.DEBRIS}, CauseCode.STATIC_OBSTACLE),
        ({"hazard": True}, CauseCode.DISABLED_VEHICLE),
        ({}, CauseCode.PARKED_VEHICLE),
    ],
)
def test_the_cause_is_named(lead, cause):
    decision = decide(blocked(**lead))
    assert decision.analysis.cause is cause
    assert behaviors_of(decision)[0].past_object_id == "lead"


def test_an_oncoming_car_is_let_pass_first():
    world = blocked()
    world.objects.append(thing("oncoming", 110.0, LANE_M, speed=-10.0))
    decision = decide(world)
    assert "as soon as this is over: car oncoming" in decision.rationale
    verdict, _ = Guard().accept(behaviors_of(decision), world.view(), False)
    assert "oncoming" in {r.object_id for r in verdict.rejects}
    world.objects[1] = thing("oncoming", 44.0, LANE_M, speed=-10.0)
    assert behaviors_of(decide(world))[0].name == "borrow_oncoming_lane"


def test_blocker_with_adjacent_lane_plans_two_lane_changes():
    """With an adjacent lane in its direction, the ego changes there and back."""
    out, back = behaviors_of(decide(World(MULTI, [thing("lead", 64.75)])))
    assert isinstance(out, ChangeLane) and isinstance(back, ChangeLane)
    assert (out.side, back.side) == ("left", "right")


def test_adjacent_lane_stopped_vehicle_blocks_and_moving_does_not():
    """A stopped vehicle in the adjacent lane blocks it; a moving one blocks it only temporarily."""
    stands = World(MULTI, [thing("lead", 64.75), thing("other", 66.0, LANE_M)])
    assert wait_of(decide(stands)) is WaitReason.YIELD
    drives = World(MULTI, [thing("lead", 64.75), thing("quick", 35.0, LANE_M, speed=12.0)])
    assert behaviors_of(decide(drives))[0].name == "change_lane"
    verdict, _ = Guard().accept(behaviors_of(decide(drives)), drives.view(), False)
    assert RejectCode.LANE_ENTRY in {r.code for r in verdict.rejects}


def test_without_a_lane_to_go_round_in_it_says_so():
    decision = decide(World(straight_road(oncoming=None), [thing("lead", 64.75)]))
    assert wait_of(decision) is WaitReason.NO_SAFE_WAY
    assert decision.analysis.cause is CauseCode.PARKED_VEHICLE


@pytest.mark.parametrize("offers", [("wait",), ("wait", "keep_lane", "change_lane")])
def test_only_what_the_stack_offers_is_planned(offers):
    world = World(TWO_WAY, [thing("lead", 64.75)], offers=offers)
    assert wait_of(decide(world)) is WaitReason.NO_SAFE_WAY


def test_observation_names_relevant_road_users_with_intents():
    """The observation names the relevant road users and their intents."""
    world = blocked()
    world.objects += [thing("oncoming", 120.0, LANE_M, speed=-8.0), thing("far away", 200.0, -9.0)]
    seen = {p.object_id: p.intent for p in decide(world).observation.participants}
    assert seen == {"lead": Intent.STOPPED, "oncoming": Intent.ONCOMING}


# ---- how it is said


@pytest.mark.parametrize("distance_m", [-0.9, -0.4, -0.04, 0.0, 0.3, 5.0])
def test_rule_texts_have_no_negative_zero_or_distance_ahead(distance_m):
    """No text has a sign before a zero, or an object ahead that is behind."""
    walker = thing("walker", 54.75 - 2.45 + distance_m, 0.0, kind=ObjectKind.PEDESTRIAN, sideways=1.0)
    for world in (World(TWO_WAY, controls=(red_light(distance_m),)), World(TWO_WAY, [walker])):
        decision = decide(world, speed_mps=distance_m / 10.0)
        steps = [step.evidence for step in decision.analysis.steps]
        for said_text in (decision.rationale, decision.analysis.reason, decision.observation.summary, *steps):
            assert not re.search(r"-0(\.0+)?(?![\d.])|-\d+ m ahead", said_text), said_text
