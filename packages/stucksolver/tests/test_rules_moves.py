"""The small moves of the rules: over a bag, aside, back, on at a dark light, and the call for help."""

from __future__ import annotations

import math

import pytest

from stucksolver.guard import Guard
from stucksolver.plan import CauseCode, WaitReason
from stucksolver.reasoners import ReasonerRequest, RuleReasoner
from stucksolver.scene import FailedAttempt, LightState, LineKind, ObjectKind, RejectCode
from stucksolver.solver import EventKind
from test_rules import behaviors_of, blocked, decide
from worlds import LANE_M, World, drive, red_light, said, straight_road, thing

TWO_WAY = straight_road()
NARROW = straight_road(oncoming=None)
MULTI = straight_road(left=LineKind.BROKEN)
K = ObjectKind


BACK = ("back_up", "keep_lane", "borrow_oncoming_lane")
LOOK = ("back_up", "back_up", "borrow_oncoming_lane")


def standing_for_long(scene):
    return scene.model_copy(update={"ego": scene.ego.model_copy(update={"stopped_for_s": 30.0})})


def names(decision):
    return [b.name for b in behaviors_of(decision)]


def after(world, code, *behaviors, ago_s=0.0, **ego):
    """What the rules say once a plan has been refused."""
    scene = world.scene()
    ego = scene.ego.model_copy(update={"stopped_for_s": 30.0, **ego})
    attempt = FailedAttempt(time_s=scene.time_s - ago_s, behaviors=behaviors, codes=(code,), outcome="")
    return (
        RuleReasoner().decide(ReasonerRequest(scene.model_copy(update={"ego": ego, "attempts": (attempt,)}))).decision
    )


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


def test_a_bag_in_the_lane_beside_is_driven_over_on_the_way_past():
    out, over, back = behaviors_of(decide(beyond_the_lead()))
    assert (out.name, over.name, back.name) == ("change_lane", "drive_over", "change_lane")
    assert (out.side, over.object_id, back.side) == ("left", "it", "right")


@pytest.mark.integration
def test_the_way_over_a_bag_in_the_lane_beside_is_proven_and_driven_to_its_end():
    world = beyond_the_lead()
    seen = drive(world, 40.0)
    assert "the plan is done" in seen.texts(EventKind.FINISHED)
    assert world.x > 90.0 and abs(world.y) < 0.5


def stranded(lead_x=52.0, **more):
    """In the left lane, where a pass of a disabled car was given up before a bag."""
    usual = {"kind": K.BAG, "height": 0.1, "seen_for_s": 2.0, "kind_confidence": 0.95, "x": 66.0}
    lead = thing("lead", lead_x, hazard=True)
    return World(MULTI, [lead, thing("it", y=LANE_M, **{**usual, **more})], y=LANE_M)


@pytest.mark.integration
@pytest.mark.parametrize("lead_x", [52.0, 60.0])
def test_in_the_lane_beside_before_a_bag_it_drives_over_it_and_returns(lead_x):
    over, back = behaviors_of(decide(stranded(lead_x)))
    assert (over.name, over.object_id, back.name, back.side) == ("drive_over", "it", "change_lane", "right")
    world = stranded(lead_x)
    seen = drive(world, 40.0)
    assert "the plan is done" in seen.texts(EventKind.FINISHED)
    assert world.x > 80.0 and abs(world.y) < 0.5


@pytest.mark.parametrize("more", [{"height": 0.4}, {"kind": K.DEBRIS}], ids=str)
def test_in_the_lane_beside_before_what_is_not_soft_it_does_not(more):
    decision = decide(stranded(**more))
    assert decision.plan is None or "drive_over" not in names(decision)


def test_in_the_lane_beside_it_drives_up_to_what_sensors_see_to_see_it_better():
    (up_to,) = behaviors_of(decide(stranded(height=0.25, position_sd_m=0.05)))
    assert (up_to.name, up_to.distance_m) == ("keep_lane", pytest.approx(16.0 - 2.45 - 0.15 - 4.0, abs=0.2))
    near = decide(stranded(height=0.25, position_sd_m=0.05, x=58.0))
    assert "to see it better" not in near.rationale


@pytest.mark.integration
def test_in_the_lane_beside_that_is_free_again_it_goes_on_and_returns():
    world = World(MULTI, [thing("lead", 52.0, hazard=True, position_sd_m=0.05)], y=LANE_M)
    on, back = behaviors_of(decide(world))
    assert (on.name, back.name, back.side) == ("keep_lane", "change_lane", "right")
    seen = drive(world, 40.0)
    assert "the plan is done" in seen.texts(EventKind.FINISHED)
    assert world.x > 65.0 and abs(world.y) < 0.5


@pytest.mark.parametrize("sd_m, again", [(0.05, True), (None, False)])
def test_a_refusal_for_who_drove_by_does_not_rule_out_driving_over(sd_m, again):
    told = after(bag(position_sd_m=sd_m), RejectCode.COLLISION, "drive_over", ago_s=5.0)
    assert (names(told) == ["drive_over"]) == again
    assert names(after(bag(position_sd_m=sd_m), RejectCode.NOT_PASSABLE, "drive_over", ago_s=5.0)) != ["drive_over"]


def test_a_rock_in_the_lane_beside_is_nothing_to_wait_for():
    decision = decide(beyond_the_lead(kind=K.DEBRIS))
    assert (decision.plan, decision.analysis.wait) == (None, WaitReason.NO_SAFE_WAY)
    assert names(decide(beyond_the_lead(kind=K.DEBRIS), stopped_s=121.0)) == ["request_assistance"]


@pytest.mark.parametrize(
    "y, sd_m, passed",
    [(1.9, 0.05, True), (1.9, None, False), (2.2, 0.05, False)],
    ids=["sensed", "exact", "further in"],
)
def test_a_cone_that_sensors_place_beyond_the_line_does_not_block_the_lane(y, sd_m, passed):
    cone = thing("cone", 66.0, y, kind=K.CONE, position_sd_m=sd_m)
    plan = decide(World(MULTI, [thing("lead", 65.0, hazard=True), cone])).plan
    assert (plan is not None) == passed


def test_a_queue_in_the_lane_beside_is_waited_for():
    decision = decide(beyond_the_lead(kind=K.CAR, height=1.5))
    assert (decision.plan, decision.analysis.wait) == (None, WaitReason.YIELD)


def test_what_leaves_room_in_the_lane_is_passed_within_it():
    world = World(NARROW, [thing("cone", 62.0, -1.2, kind=K.CONE, width=0.4)])
    (nudge,) = behaviors_of(decide(world))
    assert (nudge.name, nudge.side) == ("nudge", "left")


def test_too_near_to_swing_out_it_backs_up_first():
    near = World(TWO_WAY, [thing("lead", 50.0 + 2.45 + 3.0 + 2.3)])
    assert names(decide(near)) == ["back_up", "borrow_oncoming_lane"]
    somebody = World(TWO_WAY, [thing("lead", 57.75), thing("behind", 42.3)])
    assert names(decide(somebody)) == ["borrow_oncoming_lane"]


@pytest.mark.parametrize("sd_m, moves", [(0.1, ["back_up", "borrow_oncoming_lane"]), (None, ["borrow_oncoming_lane"])])
def test_after_a_gap_too_small_beside_what_sensors_widen_it_swings_out_from_further_back(sd_m, moves):
    world = World(TWO_WAY, [thing("lead", 50.0 + 2.45 + 5.5 + 2.3, position_sd_m=sd_m)])
    assert names(decide(world)) == ["borrow_oncoming_lane"]
    # So long ago that it is not the same moment, but not forgotten.
    assert names(after(world, RejectCode.GAP, "borrow_oncoming_lane", ago_s=10.0)) == moves


@pytest.mark.parametrize("sd_m, speed_mps", [(0.1, 3.0), (None, 5.5)])
def test_after_a_gap_too_small_beside_what_sensors_widen_it_changes_lanes_more_slowly(sd_m, speed_mps):
    world = World(MULTI, [thing("lead", 75.0, hazard=True, position_sd_m=sd_m)])
    out, _ = behaviors_of(after(world, RejectCode.GAP, "change_lane", ago_s=10.0))
    assert (out.name, out.speed_mps) == ("change_lane", speed_mps)


@pytest.mark.parametrize("sd_m, speed_mps", [(0.1, 3.0), (None, 5.5)])
def test_half_way_past_what_sensors_widen_it_goes_on_more_slowly_after_a_gap_too_small(sd_m, speed_mps):
    world = World(MULTI, [thing("lead", 62.0, hazard=True, position_sd_m=sd_m)], y=LANE_M)
    moves = behaviors_of(after(world, RejectCode.GAP, "keep_lane", ago_s=10.0))
    assert [move.speed_mps for move in moves if move.name == "keep_lane"] == [speed_mps]


def test_it_backs_up_less_where_there_is_less_room_behind():
    free = decide(World(TWO_WAY, [thing("lead", 57.75)]))
    tight = decide(World(TWO_WAY, [thing("lead", 57.75), thing("behind", 40.0)]))
    assert behaviors_of(free)[0].distance_m == 4.0
    assert behaviors_of(tight)[0].distance_m == 2.0


@pytest.mark.parametrize(("sd_m", "back_m"), [(0.05, 1.4), (None, 2.0)])
def test_refused_for_its_sight_behind_it_backs_up_less_by_sensors(sd_m, back_m):
    tight = World(TWO_WAY, [thing("lead", 57.75, position_sd_m=sd_m), thing("behind", 40.0)])
    moves = behaviors_of(after(tight, RejectCode.PATH_NOT_VISIBLE, "back_up", "borrow_oncoming_lane", ago_s=10.0))
    assert moves[0].name == "back_up" and moves[0].distance_m == back_m


def test_with_too_little_sight_it_gets_back_and_aside_and_passes_from_there():
    refused = RejectCode.ONCOMING_SIGHT
    near, far = World(TWO_WAY, [thing("lead", 60.0)]), World(TWO_WAY, [thing("lead", 50.0 + 2.45 + 12.0 + 2.3)])
    assert names(after(near, refused, "borrow_oncoming_lane")) == ["back_up", "nudge", *LOOK]
    assert names(after(far, refused, "borrow_oncoming_lane")) == ["nudge", *LOOK]
    assert names(after(far, refused, "borrow_oncoming_lane", ago_s=2.0)) == ["borrow_oncoming_lane"]


def test_by_sensors_with_too_little_sight_it_backs_up_and_only_if_that_was_in_vain_moves_aside():
    refused, near = RejectCode.ONCOMING_SIGHT, World(TWO_WAY, [thing("lead", 60.0, position_sd_m=0.05)])
    assert names(after(near, refused, "borrow_oncoming_lane")) == list(BACK)
    behind = World(TWO_WAY, [*near.objects, thing("behind", 40.0)])
    assert after(behind, refused, "borrow_oncoming_lane").plan is None

    def looked(*codes):
        attempts = [
            FailedAttempt(time_s=-9.0, behaviors=BACK, codes=codes, outcome=""),
            FailedAttempt(time_s=0.0, behaviors=("borrow_oncoming_lane",), codes=(refused,), outcome=""),
        ]
        scene = standing_for_long(near.scene()).model_copy(update={"attempts": tuple(attempts)})
        return names(RuleReasoner().decide(ReasonerRequest(scene)).decision)

    assert looked(refused) == ["back_up", "nudge", *LOOK]
    assert looked(RejectCode.COLLISION, refused) == list(BACK), "somebody came"


def test_from_beside_what_stands_far_right_it_looks_without_going_further_back_than_to_swing_out():
    van = World(TWO_WAY, [thing("lead", 60.0, -0.6)])
    back, nudge, room, borrow = behaviors_of(after(van, RejectCode.ONCOMING_SIGHT, "borrow_oncoming_lane"))
    assert [b.name for b in (back, nudge, room, borrow)] == ["back_up", "nudge", "back_up", "borrow_oncoming_lane"]
    assert back.distance_m == 8.0 and room.distance_m < 4.0
    wider = World(TWO_WAY, [*van.objects, thing("beyond", 66.0)])
    assert names(after(wider, RejectCode.ONCOMING_SIGHT, "borrow_oncoming_lane")) == ["back_up", "nudge", *LOOK]


def test_a_look_that_did_not_help_is_not_repeated():
    far = World(TWO_WAY, [thing("lead", 50.0 + 2.45 + 12.0 + 2.3)])
    looked = FailedAttempt(time_s=0.0, behaviors=("nudge", *LOOK), codes=(RejectCode.ONCOMING_SIGHT,), outcome="")
    again = FailedAttempt(
        time_s=0.0, behaviors=("borrow_oncoming_lane",), codes=(RejectCode.ONCOMING_SIGHT,), outcome=""
    )
    decision = (
        RuleReasoner()
        .decide(ReasonerRequest(standing_for_long(far.scene()).model_copy(update={"attempts": (looked, again)})))
        .decision
    )
    assert decision.plan is None
    assert decision.analysis.wait is WaitReason.NO_SAFE_WAY


@pytest.mark.parametrize(("sd_m", "looks"), [(0.05, True), (None, False)])
def test_backing_up_to_swing_out_was_no_look_if_sight_wavers_as_that_of_sensors(sd_m, looks):
    far = World(TWO_WAY, [thing("lead", 50.0 + 2.45 + 12.0 + 2.3, position_sd_m=sd_m)])
    attempts = [
        FailedAttempt(time_s=0.0, behaviors=behaviors, codes=(RejectCode.ONCOMING_SIGHT,), outcome="")
        for behaviors in (("back_up", "borrow_oncoming_lane"), ("borrow_oncoming_lane",))
    ]
    scene = standing_for_long(far.scene()).model_copy(update={"attempts": tuple(attempts)})
    decision = RuleReasoner().decide(ReasonerRequest(scene)).decision
    assert (decision.plan is not None) == looks
    assert not looks or names(decision) == ["nudge", *LOOK]


def test_by_sensors_it_goes_aside_only_as_far_as_the_guard_allows_with_what_localisation_may_be_off():
    aside = []
    for sd_m in (None, 0.05):
        far = World(TWO_WAY, [thing("lead", 50.0 + 2.45 + 12.0 + 2.3, position_sd_m=sd_m)])
        (nudge, *_) = behaviors_of(after(far, RejectCode.ONCOMING_SIGHT, "borrow_oncoming_lane"))
        aside.append(nudge.offset_m)
    scene = far.scene()
    room_m = (LANE_M - scene.ego.width_m) / 2
    assert aside[0] == 0.8
    assert aside[1] == pytest.approx(min(0.8, room_m - 0.25), abs=0.01)


def test_without_room_behind_it_does_not_back_up_to_look():
    world = World(TWO_WAY, [thing("lead", 64.0), thing("behind", 40.0)])
    assert after(world, RejectCode.ONCOMING_SIGHT, "borrow_oncoming_lane").plan is None


@pytest.mark.parametrize("code", [RejectCode.CLEARANCE, RejectCode.DOOR])
def test_refused_for_want_of_clearance_it_tries_at_walking_pace(code):
    (borrow,) = behaviors_of(after(blocked(), code, "borrow_oncoming_lane"))
    assert borrow.speed_mps == pytest.approx(2.2)


@pytest.mark.parametrize(("sd_m", "sight_m", "speed_mps"), [(0.1, 70.0, 5.5), (0.1, 300.0, 2.2), (None, 70.0, 2.2)])
def test_by_sensors_it_tries_at_walking_pace_only_where_enough_is_seen_for_that(sd_m, sight_m, speed_mps):
    world = World(straight_road(oncoming=LineKind.SOLID), [thing("lead", 65.0, position_sd_m=sd_m)], sight_m=sight_m)
    (borrow,) = behaviors_of(after(world, RejectCode.CLEARANCE, "borrow_oncoming_lane", ago_s=10.0))
    assert borrow.speed_mps == pytest.approx(speed_mps)


def test_at_a_dark_light_it_creeps_on_after_a_stop():
    world = World(TWO_WAY, controls=(red_light(3.0, LightState.OFF),))
    assert decide(world, stopped_s=2.0).plan is None
    (onward,) = behaviors_of(decide(world, stopped_s=4.0))
    assert (onward.name, onward.speed_mps) == ("keep_lane", 2.2)


def crossing(gap_m=5.0, *others, **more):
    """A car from the right stands with its nose in our way."""
    return World(NARROW, [thing("nose", 50.0 + 2.45 + gap_m + 0.95, -2.3, yaw=math.pi / 2, **more), *others])


def test_who_stands_across_goes_first_and_if_it_does_not_we_creep_up_to_it():
    first = decide(crossing(), stopped_s=7.0)
    assert (first.plan, first.analysis.wait) == (None, WaitReason.YIELD)
    (creep,) = behaviors_of(decide(crossing(), stopped_s=9.0))
    assert (creep.name, creep.distance_m, creep.speed_mps) == ("keep_lane", 4.5, 1.5)
    assert Guard().accept([creep], crossing().view(), False)[0].accepted


def test_with_no_room_left_before_who_stands_across_it_does_not_creep():
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
def test_it_does_not_creep_up_to_a_queue_or_at_a_red_light_or_to_a_breakdown(world):
    assert decide(world).plan is None


def crawling(y=2.6, yaw=-0.2, speed=1.5, **ego):
    """A stream that crawls into our lane from the left, bumper to bumper."""
    stream = [thing(f"car{k}", 50.0 + 8.0 * k, y if k < 1 else 0.4, yaw=yaw, speed=speed) for k in range(3)]
    return decide(World(NARROW, stream), **ego)


def test_into_a_crawling_stream_that_leaves_no_gap_it_noses_in():
    decision = crawling(y=3.0)
    (nose,) = behaviors_of(decision)
    assert decision.analysis.cause is CauseCode.BLOCKED_ROAD
    assert (nose.name, nose.distance_m, nose.speed_mps) == ("keep_lane", 1.3, 1.5)


def test_how_far_it_noses_in_depends_on_the_room_beside_the_stream():
    way = [behaviors_of(crawling(y=y))[0].distance_m for y in (2.9, 3.0, 3.1, 4.5)]
    assert way == sorted(way) and way[0] < way[1] < way[2] and way[3] == 3.0
    assert crawling(y=2.7).plan is None


@pytest.mark.parametrize("how", [{"stopped_s": 15.0}, {"speed": 6.0}, {"yaw": 0.0}], ids=str)
def test_who_has_not_stood_long_or_has_a_quick_or_a_parallel_stream_beside_it_does_not_nose_in(how):
    decision = crawling(**how)
    assert (decision.plan, decision.analysis.wait) == (None, WaitReason.QUEUE)


def facing(*others):
    """An oncoming car in the middle of a road that is too narrow for two."""
    narrow = [lane.model_copy(update={"width_m": (2.6,) * 401}) for lane in TWO_WAY.lanes]
    road = TWO_WAY.model_copy(update={"key": "narrow", "lanes": tuple(narrow)})
    return World(road, [thing("other", 60.0, 1.2, yaw=math.pi), *others])


def test_before_who_faces_us_on_a_narrow_road_it_backs_up_and_gives_way():
    back, wait = behaviors_of(decide(facing()))
    assert (back.name, back.distance_m, wait.name, wait.until) == ("back_up", 8.0, "wait", "clear")
    assert decide(facing(thing("behind", 42.0))).plan is None


def test_without_any_way_it_waits_two_minutes_and_then_calls_for_help():
    world = World(NARROW, [thing("lead", 65.0)])
    assert decide(world, stopped_s=100.0).analysis.wait is WaitReason.NO_SAFE_WAY
    assert names(decide(world, stopped_s=121.0)) == ["request_assistance"]


@pytest.mark.parametrize(
    ("words", "name"), [("please pull over", "pull_over"), ("back up a little", "back_up"), ("reverse!", "back_up")]
)
def test_a_passenger_may_ask_for_it(words, name):
    scene = World(TWO_WAY).scene()
    decision = RuleReasoner().decide(ReasonerRequest(scene.model_copy(update={"guidance": said(words)}))).decision
    assert names(decision) == [name]
