"""Turning round on the road: only where it is wide enough, nobody comes, and no leg meets anybody."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from stucksolver.guard import Approvals, Guard, GuardPolicy, RejectCode
from stucksolver.plan import RecoveryPlan
from stucksolver.plan.behaviors import BackUp, NoPathError, TurnAround
from stucksolver.plan.multi_point_turn import corners, leg_driving_line, multi_point_turn
from stucksolver.scene import LineKind, ObjectKind, Zone, ZoneKind
from stucksolver.solver.state_machine.admission import MissingApproval, admit
from stucksolver.solver.state_machine.execution import Execution
from stucksolver.solver.state_machine.history import AttemptHistory
from worlds import World, straight_road, thing

C, K = RejectCode, ObjectKind
TURN = TurnAround()


def road_of(lane_m, *, line=LineKind.BROKEN, zones=()):
    """One lane each way, each so wide."""
    road = straight_road(oncoming=line, zones=zones)
    lanes = tuple(
        lane.model_copy(update={"width_m": (lane_m,) * 401, "offset_m": (k * lane_m,) * 401})
        for k, lane in enumerate(road.lanes)
    )
    return road.model_copy(update={"key": f"{road.key}-{lane_m}", "lanes": lanes})


WIDE = road_of(5.0)


def judged(world, *, policy=None, approvals=None):
    verdict, leg = Guard(policy).accept_turn(TURN, world.view(), approvals or Approvals())
    assert (leg is not None) == verdict.accepted
    return {r.code for r in verdict.rejects}


@pytest.mark.parametrize(("lane_m", "legs"), [(6.0, 3), (5.0, 3), (4.5, 5)])
def test_the_wider_the_road_the_fewer_legs(lane_m, legs):
    found = multi_point_turn(World(road_of(lane_m)).view())
    assert [leg.reverse for leg in found] == [bool(k % 2) for k in range(legs)]
    assert math.degrees(found[-1].end[2]) > 165.0


def test_multi_point_turn_stays_on_road_and_turns_like_car():
    """No corner leaves the road, and the body moves as a car does."""
    view = World(WIDE).view()
    radius = view.ego.limits.min_turn_radius_m
    for leg in multi_point_turn(view):
        _, d = corners(view, leg.x_m, leg.y_m, leg.yaw_rad)
        assert d.min() > -2.5 and d.max() < 7.5
        rear_x, rear_y = leg.x_m - 1.45 * np.cos(leg.yaw_rad), leg.y_m - 1.45 * np.sin(leg.yaw_rad)
        steps = np.hypot(np.diff(rear_x), np.diff(rear_y))
        slip = np.diff(rear_x) * -np.sin(leg.yaw_rad[1:]) + np.diff(rear_y) * np.cos(leg.yaw_rad[1:])
        assert (np.diff(leg.yaw_rad) <= steps / radius + 1e-6).all()
        assert np.abs(slip).max() < 0.01 * steps.max() + 1e-3


def test_each_leg_begins_where_the_last_one_ended():
    legs = multi_point_turn(World(WIDE).view())
    for leg, other in itertools.pairwise(legs):
        assert leg.end == pytest.approx((other.x_m[0], other.y_m[0], other.yaw_rad[0]))


@pytest.mark.parametrize("lane_m", [3.0, 3.5])
def test_a_road_that_is_too_narrow_is_refused(lane_m):
    with pytest.raises(NoPathError, match="turn around"):
        multi_point_turn(World(road_of(lane_m)).view())
    assert judged(World(road_of(lane_m))) == {C.NO_PATH}


def test_leg_driving_line_in_reverse_ends_at_leg_end():
    """In reverse, the line ends with the body where the leg ends."""
    leg = multi_point_turn(World(WIDE).view())[1]
    x, y, speed = leg_driving_line(leg, 2.9, 1.4)
    assert (x[0], y[0]) == pytest.approx((leg.x_m[0], leg.y_m[0]))
    rear = (leg.x_m[-1] - 1.45 * math.cos(leg.yaw_rad[-1]), leg.y_m[-1] - 1.45 * math.sin(leg.yaw_rad[-1]))
    assert (x[-1], y[-1]) == pytest.approx(rear) and speed[-1] == 0.0
    driven = np.hypot(np.diff(x), np.diff(y)).cumsum()[int(np.argmax(speed < 0.1)) - 1]
    assert (speed[:-1] > 0.0).all() and driven == pytest.approx(leg.length_m, abs=0.15)


def test_on_a_free_road_it_is_accepted():
    assert judged(World(WIDE)) == set()


@pytest.mark.parametrize(
    ("others", "code"),
    [
        ([thing("comes", 130.0, 5.0, speed=-8.0)], C.ONCOMING_GAP),
        ([thing("behind", 0.0, speed=8.0)], C.ONCOMING_GAP),
        ([thing("cyclist", 20.0, kind=K.BICYCLE, speed=4.0)], C.ONCOMING_GAP),
        ([thing("walker", 53.0, 9.0, kind=K.PEDESTRIAN, sideways=-1.2)], C.COLLISION),
    ],
    ids=["oncoming", "from behind", "a cyclist", "one who steps into the road"],
)
def test_not_while_somebody_comes(others, code):
    assert code in judged(World(WIDE, others))


@pytest.mark.parametrize(
    "other",
    [thing("gone", 36.0, 5.0, speed=-8.0), thing("far", 390.0, 5.0, speed=-4.0), thing("ahead", 75.0, speed=8.0)],
    ids=lambda o: o.id,
)
def test_who_does_not_come_in_time_is_no_reason(other):
    assert judged(World(WIDE, [other])) == set()


def test_what_stands_shortens_the_legs_or_forbids_them():
    at_kerb = thing("parked", 56.0, 6.5)
    legs = multi_point_turn(World(WIDE, [at_kerb]).view())
    assert legs[0].length_m < multi_point_turn(World(WIDE).view())[0].length_m
    walls = [thing("a", 55.5), thing("b", 44.5), thing("c", 50.0, 5.0)]
    assert judged(World(WIDE, walls)) == {C.NO_PATH}


@pytest.mark.parametrize("kind", [ZoneKind.JUNCTION, ZoneKind.CROSSWALK, ZoneKind.LEVEL_CROSSING])
def test_not_in_a_junction_or_at_a_crossing(kind):
    def at(start):
        return road_of(5.0, zones=(Zone(kind=kind, start_m=start, end_m=start + 5.0),))

    assert C.ZONE in judged(World(at(57.0)))
    assert judged(World(at(80.0))) == set()


def test_a_solid_line_needs_the_yes_that_the_policy_says():
    solid = World(road_of(5.0, line=LineKind.SOLID))
    assert judged(solid) == {C.SOLID_LINE}
    assert judged(solid, approvals=Approvals(passenger=frozenset({"solid_line"}))) == set()
    assert judged(solid, policy=GuardPolicy(solid_line="autonomous")) == set()
    assert judged(solid, policy=GuardPolicy(solid_line="forbid")) == {C.SOLID_LINE}


def test_what_is_not_seen_is_not_free():
    assert judged(World(WIDE, behind_m=30.0)) == {C.PATH_NOT_VISIBLE}
    assert judged(World(WIDE, sight_m=20.0)) == {C.PATH_NOT_VISIBLE}


def test_behind_the_barriers_of_a_closed_road_nobody_comes():
    row = [thing(f"b{k}", 72.0, -2.0 + 1.2 * k, kind=K.BARRIER, length=0.4, width=1.2) for k in range(8)]
    assert judged(World(WIDE, row, sight_m=21.5)) == set()


def test_it_must_stand_first():
    assert judged(World(WIDE, speed=2.0)) == {C.NO_PATH}


def running(objects, k):
    """The verdict on the first leg, at its pose `k`, with others about."""
    world = World(WIDE)
    _, leg = Guard().accept_turn(TURN, world.view())
    pose = leg.leg
    later = World(WIDE, objects, x=float(pose.x_m[k]), y=float(pose.y_m[k]), yaw=float(pose.yaw_rad[k]), speed=1.0)
    return Guard().recheck_turn(leg, later.view())


def test_while_it_turns_it_stops_for_who_comes_near():
    assert running([], 30).accepted
    found = running([thing("walker", 55.0, 7.0, kind=K.PEDESTRIAN, sideways=-1.0)], 30)
    assert found.abort.value == "give_way"


def test_off_its_leg_it_stops():
    world = World(WIDE)
    _, leg = Guard().accept_turn(TURN, world.view())
    astray = World(WIDE, x=52.0, y=-0.9, yaw=0.0, speed=1.0)
    assert {r.code for r in Guard().recheck_turn(leg, astray.view()).rejects} == {C.DEVIATION}


BACKS_UP_FIRST = RecoveryPlan(behaviors=(BackUp(distance_m=6.0, speed_mps=1.5), TURN), replan_route=True)


def begun(world, policy=None, approvals=None):
    return Execution(BACKS_UP_FIRST, Guard(policy), False, approvals or Approvals()).start(world.view(), 0.0)


def solid_at(stretch):
    """A road of broken lines, with a solid one between two arc lengths (m)."""
    road = road_of(5.0)
    own, other = road.lanes
    lines = tuple(LineKind.SOLID if stretch[0] <= k <= stretch[1] else line for k, line in enumerate(other.line))
    other = other.model_copy(update={"line": lines})
    return road.model_copy(update={"key": f"{road.key}-solid-{stretch}", "lanes": (own, other)})


def test_solid_line_approval_is_needed_before_step_to_turn():
    """The approval for the line is needed before the step that leads to the turn."""
    solid = World(road_of(5.0, line=LineKind.SOLID))
    assert begun(solid).codes == (C.SOLID_LINE,)
    assert begun(solid, approvals=Approvals(passenger=frozenset({"solid_line"}))).accepted
    assert begun(solid, GuardPolicy(solid_line="autonomous")).accepted
    assert begun(solid, GuardPolicy(solid_line="forbid")).codes == (C.SOLID_LINE,)
    assert begun(World(WIDE)).accepted


@pytest.mark.parametrize(("stretch", "needed"), [((30, 50), True), ((70, 100), False), ((0, 25), False)])
def test_solid_line_approval_counts_only_at_turn(stretch, needed):
    """Only the line at the place of the turn needs an approval."""
    assert begun(World(solid_at(stretch))).codes == ((C.SOLID_LINE,) if needed else ())


def test_the_missing_yes_is_the_passengers_for_the_line():
    solid = World(road_of(5.0, line=LineKind.SOLID))
    told = {"guard": Guard(), "scene": None, "history": AttemptHistory(3), "guided": False, "approvals": Approvals()}
    found = admit(BACKS_UP_FIRST, solid.view(), 0.0, **told)
    assert found.need == MissingApproval("passenger", ("solid_line",))
