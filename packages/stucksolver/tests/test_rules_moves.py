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


def test_bag_in_adjacent_lane_is_driven_over_in_pass():
    """A bag in the adjacent lane is driven over during the pass."""
    out, over, back = behaviors_of(decide(beyond_the_lead()))
    assert (out.name, over.name, back.name) == ("change_lane", "drive_over", "change_lane")
    assert (out.side, over.object_id, back.side) == ("left", "it", "right")


@pytest.mark.integration
def test_drive_over_in_adjacent_lane_is_completed():
    """The path over a bag in the adjacent lane is proven and driven to its end."""
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
def test_stranded_before_bag_drives_over_and_returns(lead_x):
    """An ego before a bag in the adjacent lane drives over the bag and returns."""
    over, back = behaviors_of(decide(stranded(lead_x)))
    assert (over.name, over.object_id, back.name, back.side) == ("drive_over", "it", "change_lane", "right")
    world = stranded(lead_x)
    seen = drive(world, 40.0)
    assert "the plan is done" in seen.texts(EventKind.FINISHED)
    assert world.x > 80.0 and abs(world.y) < 0.5


@pytest.mark.parametrize("more", [{"height": 0.4}, {"kind": K.DEBRIS}], ids=str)
def test_stranded_before_hard_object_does_not_drive_over(more):
    """An ego before a hard object in the adjacent lane does not drive over it."""
    decision = decide(stranded(**more))
    assert decision.plan is None or "drive_over" not in names(decision)


def test_stranded_before_uncertain_object_approaches_it():
    """In sensor mode, an ego in the adjacent lane drives up to an object to perceive it better."""
    (up_to,) = behaviors_of(decide(stranded(height=0.25, position_sd_m=0.05)))
    assert (up_to.name, up_to.distance_m) == ("keep_lane", pytest.approx(16.0 - 2.45 - 0.15 - 4.0, abs=0.2))
    near = decide(stranded(height=0.25, position_sd_m=0.05, x=58.0))
    assert "to see it better" not in near.rationale


@pytest.mark.integration
def test_stranded_with_free_lane_goes_on_and_returns():
    """An ego in the adjacent lane that is free again goes on and returns."""
    world = World(MULTI, [thing("lead", 52.0, hazard=True, position_sd_m=0.05)], y=LANE_M)
    on, back = behaviors_of(decide(world))
    assert (on.name, back.name, back.side) == ("keep_lane", "change_lane", "right")
    seen = drive(world, 40.0)
    assert "the plan is done" in seen.texts(EventKind.FINISHED)
    assert world.x > 65.0 and abs(world.y) < 0.5


@pytest.mark.parametrize("sd_m, again", [(0.05, True), (None, False)])
def test_drive_over_rejected_for_traffic_is_tried_again(sd_m, again):
    """A rejection for a passing vehicle does not rule out driving over, in sensor mode."""
    told = after(bag(position_sd_m=sd_m), RejectCode.COLLISION, "drive_over", ago_s=5.0)
    assert (names(told) == ["drive_over"]) == again
    assert names(after(bag(position_sd_m=sd_m), RejectCode.NOT_PASSABLE, "drive_over", ago_s=5.0)) != ["drive_over"]


def test_hard_object_in_adjacent_lane_is_not_waited_for():
    """A rock in the adjacent lane is no reason to wait: there is no safe plan."""
    decision = decide(beyond_the_lead(kind=K.DEBRIS))
    assert (decision.plan, decision.analysis.wait) == (None, WaitReason.NO_SAFE_WAY)
    assert names(decide(beyond_the_lead(kind=K.DEBRIS), stopped_s=121.0)) == ["request_assistance"]


@pytest.mark.parametrize(
    "y, sd_m, passed",
    [(1.9, 0.05, True), (1.9, None, False), (2.2, 0.05, False)],
    ids=["sensed", "exact", "further in"],
)
def test_cone_uncertain_near_line_does_not_block_lane(y, sd_m, passed):
    """A cone that sensors place just over the line does not block the lane."""
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
def test_gap_rejected_with_uncertain_lead_backs_up_first(sd_m, moves):
    """In sensor mode, after a gap that was too small, the ego swings out from farther back."""
    world = World(TWO_WAY, [thing("lead", 50.0 + 2.45 + 5.5 + 2.3, position_sd_m=sd_m)])
    assert names(decide(world)) == ["borrow_oncoming_lane"]
    # So long ago that it is not the same moment, but not forgotten.
    assert names(after(world, RejectCode.GAP, "borrow_oncoming_lane", ago_s=10.0)) == moves


@pytest.mark.parametrize("sd_m, speed_mps", [(0.1, 3.0), (None, 5.5)])
def test_gap_rejected_with_uncertain_lead_changes_lane_slowly(sd_m, speed_mps):
    """In sensor mode, after a gap that was too small, the ego changes lanes more slowly."""
    world = World(MULTI, [thing("lead", 75.0, hazard=True, position_sd_m=sd_m)])
    out, _ = behaviors_of(after(world, RejectCode.GAP, "change_lane", ago_s=10.0))
    assert (out.name, out.speed_mps) == ("change_lane", speed_mps)


@pytest.mark.parametrize("sd_m, speed_mps", [(0.1, 3.0), (None, 5.5)])
def test_gap_rejected_halfway_past_uncertain_lead_slows_down(sd_m, speed_mps):
    """In sensor mode, halfway past the lead vehicle, the ego goes on more slowly after such a gap."""
    world = World(MULTI, [thing("lead", 62.0, hazard=True, position_sd_m=sd_m)], y=LANE_M)
    moves = behaviors_of(after(world, RejectCode.GAP, "keep_lane", ago_s=10.0))
    assert [move.speed_mps for move in moves if move.name == "keep_lane"] == [speed_mps]


def test_it_backs_up_less_where_there_is_less_room_behind():
    free = decide(World(TWO_WAY, [thing("lead", 57.75)]))
    tight = decide(World(TWO_WAY, [thing("lead", 57.75), thing("behind", 40.0)]))
    assert behaviors_of(free)[0].distance_m == 4.0
    assert behaviors_of(tight)[0].distance_m == 2.0


@pytest.mark.parametrize(("sd_m", "back_m"), [(0.05, 1.4), (None, 2.0)])
def test_sight_behind_rejected_in_sensor_mode_backs_up_less(sd_m, back_m):
    """After a rejection for the sight behind, the ego backs up less in sensor mode."""
    tight = World(TWO_WAY, [thing("lead", 57.75, position_sd_m=sd_m), thing("behind", 40.0)])
    moves = behaviors_of(after(tight, RejectCode.PATH_NOT_VISIBLE, "back_up", "borrow_oncoming_lane", ago_s=10.0))
    assert moves[0].name == "back_up" and moves[0].distance_m == back_m


def test_oncoming_sight_rejected_backs_up_nudges_and_passes():
    """With too little sight, the ego backs up, nudges aside, and passes from there."""
    refused = RejectCode.ONCOMING_SIGHT
    near, far = World(TWO_WAY, [thing("lead", 60.0)]), World(TWO_WAY, [thing("lead", 50.0 + 2.45 + 12.0 + 2.3)])
    assert names(after(near, refused, "borrow_oncoming_lane")) == ["back_up", "nudge", *LOOK]
    assert names(after(far, refused, "borrow_oncoming_lane")) == ["nudge", *LOOK]
    assert names(after(far, refused, "borrow_oncoming_lane", ago_s=2.0)) == ["borrow_oncoming_lane"]


def test_oncoming_sight_rejected_in_sensor_mode_nudges_only_later():
    """In sensor mode, with too little sight, the ego backs up, and nudges only if that did not help."""
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


def test_oncoming_sight_behind_offset_van_backs_up_just_enough():
    """Behind a vehicle far to the right, the ego backs up no farther than to swing out."""
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
def test_back_up_before_uncertain_sight_does_not_count_as_look(sd_m, looks):
    """Backing up to swing out does not count as a look if the sight is uncertain, as in sensor mode."""
    far = World(TWO_WAY, [thing("lead", 50.0 + 2.45 + 12.0 + 2.3, position_sd_m=sd_m)])
    attempts = [
        FailedAttempt(time_s=0.0, behaviors=behaviors, codes=(RejectCode.ONCOMING_SIGHT,), outcome="")
        for behaviors in (("back_up", "borrow_oncoming_lane"), ("borrow_oncoming_lane",))
    ]
    scene = standing_for_long(far.scene()).model_copy(update={"attempts": tuple(attempts)})
    decision = RuleReasoner().decide(ReasonerRequest(scene)).decision
    assert (decision.plan is not None) == looks
    assert not looks or names(decision) == ["nudge", *LOOK]


def test_nudge_in_sensor_mode_keeps_localization_uncertainty():
    """In sensor mode, the nudge is limited to what the guard allows with the localization uncertainty."""
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
def test_walking_pace_in_sensor_mode_needs_enough_sight(sd_m, sight_m, speed_mps):
    """In sensor mode, walking pace is tried only where the sight distance is enough for it."""
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
    assert crawling(y=2.7).plan is None


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
    scene = World(TWO_WAY).scene()
    decision = RuleReasoner().decide(ReasonerRequest(scene.model_copy(update={"guidance": said(words)}))).decision
    assert names(decision) == [name]
