"""What the search finds: over a bag, aside, back, on at a dark light, and the call for help."""

from __future__ import annotations

import math

import pytest

from stucksolver.guard import Guard
from stucksolver.plan import CauseCode, WaitReason
from stucksolver.scene import FailedAttempt, LightState, LineKind, ObjectKind
from stucksolver.solver import EventKind
from test_duties import behaviors_of, decide
from worlds import LANE_M, World, drive, red_light, said, searched, straight_road, thing

TWO_WAY = straight_road()
NARROW = straight_road(oncoming=None)
MULTI = straight_road(left=LineKind.BROKEN)
K = ObjectKind


def names(decision):
    return [b.name for b in behaviors_of(decision)]


def after(world, code, *behaviors, ago_s=0.0, **ego):
    """The decision once a plan has been refused."""
    scene = world.scene()
    ego = scene.ego.model_copy(update={"stopped_for_s": 30.0, **ego})
    attempt = FailedAttempt(time_s=scene.time_s - ago_s, behaviors=behaviors, codes=(code,), outcome="")
    return searched(world, scene.model_copy(update={"ego": ego, "attempts": (attempt,)}))


def bag(*others, x=60.0, **more):
    usual = {"kind": K.BAG, "height": 0.1, "seen_for_s": 2.0, "kind_confidence": 0.95}
    return World(TWO_WAY, [thing("bag", x, **{**usual, **more}), *others])


def test_a_flat_bag_is_driven_over():
    assert names(decide(bag())) == ["drive_over"]


@pytest.mark.parametrize(
    "more", [{"height": 0.4}, {"kind": K.DEBRIS}, {"kind_confidence": None}, {"seen_for_s": 0.5}], ids=str
)
def test_what_may_not_be_driven_over_is_gone_round(more):
    assert names(decide(bag(**more, x=65.0))) == ["borrow_oncoming_lane"]


def test_with_somebody_beside_the_bag_it_is_not_driven_over():
    decision = decide(bag(thing("walker", 60.0, -2.0, kind=K.PEDESTRIAN)))
    assert decision.plan is None or names(decision) != ["drive_over"]


def beyond_the_lead(**more):
    """A disabled car in the right lane, and something a little further on in the left one."""
    usual = {"kind": K.BAG, "height": 0.1, "seen_for_s": 2.0, "kind_confidence": 0.95}
    return World(MULTI, [thing("lead", 60.0, hazard=True), thing("it", 73.0, LANE_M, **{**usual, **more})])


def test_bag_in_adjacent_lane_pass_is_planned():
    """A bag in the adjacent lane does not hold up the pass."""
    world = beyond_the_lead()
    decision = decide(world)
    assert names(decision)[0] == "change_lane"
    assert Guard().accept(list(decision.plan.behaviors[:1]), world.view(), False)[0].accepted


@pytest.mark.integration
def test_bag_in_adjacent_lane_pass_is_completed():
    """The ego passes, whatever it does about the bag."""
    world = beyond_the_lead()
    seen = drive(world, 60.0)
    assert "the plan is done" in seen.texts(EventKind.FINISHED)
    assert world.x > 90.0 and abs(world.y) < 0.5


def stranded(lead_x=52.0, **more):
    """In the left lane, where a pass of a disabled car was given up before a bag."""
    usual = {"kind": K.BAG, "height": 0.1, "seen_for_s": 2.0, "kind_confidence": 0.95, "x": 66.0}
    lead = thing("lead", lead_x, hazard=True)
    return World(MULTI, [lead, thing("it", y=LANE_M, **{**usual, **more})], y=LANE_M)


@pytest.mark.integration
@pytest.mark.parametrize("lead_x", [52.0, 60.0])
def test_stranded_before_bag_gets_on_and_returns(lead_x):
    """An ego before a bag in the adjacent lane gets on and returns to its lane."""
    world = stranded(lead_x)
    seen = drive(world, 40.0)
    assert "the plan is done" in seen.texts(EventKind.FINISHED)
    assert world.x > 80.0 and abs(world.y) < 0.5


@pytest.mark.parametrize("more", [{"height": 0.4}, {"kind": K.DEBRIS}], ids=str)
def test_stranded_before_hard_object_does_not_drive_over(more):
    """An ego before a hard object in the adjacent lane does not drive over it."""
    decision = decide(stranded(**more))
    assert decision.plan is None or "drive_over" not in names(decision)


@pytest.mark.integration
def test_stranded_with_free_lane_goes_on_and_returns():
    """An ego in the adjacent lane that is free again goes on and returns."""
    world = World(MULTI, [thing("lead", 52.0, hazard=True, position_sd_m=0.05)], y=LANE_M)
    on, back = behaviors_of(decide(world))
    assert (on.name, back.name, back.side) == ("keep_lane", "change_lane", "right")
    seen = drive(world, 40.0)
    assert "the plan is done" in seen.texts(EventKind.FINISHED)
    assert world.x > 65.0 and abs(world.y) < 0.5


def test_what_leaves_room_in_the_lane_is_passed_within_it():
    world = World(NARROW, [thing("cone", 62.0, -1.2, kind=K.CONE, width=0.4)])
    (nudge,) = behaviors_of(decide(world))
    assert (nudge.name, nudge.side) == ("nudge", "left")


def test_at_a_dark_light_it_creeps_on_after_a_stop():
    world = World(TWO_WAY, controls=(red_light(3.0, LightState.OFF),))
    assert decide(world, stopped_s=4.0).plan is None
    (onward,) = behaviors_of(decide(world, stopped_s=10.0))
    assert (onward.name, onward.speed_mps) == ("keep_lane", 2.2)


def crossing(gap_m=5.0, *others, **more):
    """A car from the right stands with its nose in our way."""
    return World(NARROW, [thing("nose", 50.0 + 2.45 + gap_m + 0.95, -2.3, yaw=math.pi / 2, **more), *others])


def test_vehicle_stopped_across_goes_first_then_ego_creeps():
    """A vehicle across the path goes first. If it does not move, the ego creeps up to it."""
    first = decide(crossing(), stopped_s=7.0)
    assert (first.plan, first.analysis.wait) == (None, WaitReason.YIELD)
    (creep,) = behaviors_of(decide(crossing(), stopped_s=9.0))
    assert (creep.name, creep.distance_m, creep.speed_mps) == ("keep_lane", 4.5, 1.5)
    assert Guard().accept([creep], crossing().view(), False)[0].accepted


def test_vehicle_stopped_across_without_gap_is_not_approached():
    """With no distance left before a vehicle across the path, the ego does not creep."""
    assert decide(crossing(gap_m=2.0)).plan is None


@pytest.mark.parametrize(
    "world",
    [
        crossing(5.0, thing("next", 58.4, 4.0, yaw=math.pi / 2)),
        World(NARROW, crossing().objects, controls=(red_light(2.0),)),
        crossing(hazard=True),
    ],
    ids=["in a queue", "at a red light", "broken down"],
)
def test_creep_to_queue_red_light_or_breakdown_is_not_planned(world):
    assert decide(world).plan is None


def crawling(y=2.6, yaw=-0.2, speed=1.5, **ego):
    """A stream that crawls into our lane from the left, bumper to bumper."""
    stream = [thing(f"car{k}", 50.0 + 8.0 * k, y if k < 1 else 0.4, yaw=yaw, speed=speed) for k in range(3)]
    return decide(World(NARROW, stream), **ego)


def test_crawling_flow_without_gap_is_entered_slowly():
    """The ego noses into a crawling traffic flow that leaves no gap."""
    decision = crawling(y=3.0)
    (nose,) = behaviors_of(decision)
    assert decision.analysis.cause is CauseCode.BLOCKED_ROAD
    assert (nose.name, nose.distance_m, nose.speed_mps) == ("keep_lane", 1.3, 1.5)


def test_crawling_flow_entry_distance_depends_on_clearance():
    """How far the ego noses in depends on the clearance beside the traffic flow."""
    way = [behaviors_of(crawling(y=y))[0].distance_m for y in (2.9, 3.0, 3.1, 4.5)]
    assert way == sorted(way) and way[0] < way[1] < way[2] and way[3] == 3.0


@pytest.mark.parametrize("how", [{"stopped_s": 15.0}, {"speed": 6.0}, {"yaw": 0.0}], ids=str)
def test_crawling_flow_short_stop_or_fast_flow_is_not_entered(how):
    """After a short stop, or beside a fast or parallel traffic flow, the ego does not nose in."""
    decision = crawling(**how)
    assert (decision.plan, decision.analysis.wait) == (None, WaitReason.QUEUE)


def facing(*others):
    """An oncoming car in the middle of a road that is too narrow for two."""
    narrow = [lane.model_copy(update={"width_m": (2.6,) * 401}) for lane in TWO_WAY.lanes]
    road = TWO_WAY.model_copy(update={"key": "narrow", "lanes": tuple(narrow)})
    return World(road, [thing("other", 60.0, 1.2, yaw=math.pi), *others])


def test_oncoming_vehicle_on_narrow_road_is_yielded_to():
    """For a facing vehicle on a narrow road, the ego backs up and yields."""
    back, wait = behaviors_of(decide(facing()))
    assert (back.name, back.distance_m, wait.name, wait.until) == ("back_up", 8.0, "wait", "clear")
    assert decide(facing(thing("behind", 42.0))).plan is None


def test_no_safe_plan_waits_120_s_then_requests_assistance():
    """Without a plan, the ego waits two minutes and then requests assistance."""
    world = World(NARROW, [thing("lead", 65.0)])
    assert decide(world, stopped_s=100.0).analysis.wait is WaitReason.NO_SAFE_WAY
    assert names(decide(world, stopped_s=121.0)) == ["request_assistance"]


@pytest.mark.parametrize(
    ("words", "name"), [("please pull over", "pull_over"), ("back up a little", "back_up"), ("reverse!", "back_up")]
)
def test_a_passenger_may_ask_for_it(words, name):
    world = World(TWO_WAY)
    decision = searched(world, world.scene().model_copy(update={"guidance": said(words)}))
    assert names(decision) == [name]
