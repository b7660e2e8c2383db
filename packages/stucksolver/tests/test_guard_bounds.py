"""Where each bound lies: refused a little on one side of it, accepted a little on the other."""

from __future__ import annotations

from dataclasses import replace

import pytest

from stucksolver.guard import Approvals, Guard, GuardPolicy, RejectCode, passable_obstacles
from stucksolver.guard.context import CheckContext
from stucksolver.guard.policy import QueuePolicy
from stucksolver.plan.behaviors import BorrowOncomingLane, DriveOver, KeepLane
from stucksolver.scene import ControlKind, LightState, ObjectKind, TrafficControl, Zone, ZoneKind
from worlds import LANE_M, World, red_light, straight_road, thing

C, K = RejectCode, ObjectKind
ROAD = straight_road()
GUARD = Guard()
BORROW = BorrowOncomingLane(past_object_id="lead", speed_mps=5.0)
OVER = DriveOver(object_id="bag")
BUMPER_X = 50.0 + 4.9 / 2
LEAD_X, LEAD_FRONT_M = 62.0, 62.0 + 4.6 / 2 - BUMPER_X
"""The lead's front is so far before our bumper."""
A_LITTLE = 0.01


def rejects(behavior, world, approvals=None, guided=False, guard=GUARD):
    return guard.accept([behavior], world.view(), guided, approvals or Approvals())[0].rejects


def waits(*objects, controls=(), guided=False, guard=GUARD, **lead):
    """Must a plan that passes the lead alone wait for it? Whether there is room to return is another question."""
    alone = World(ROAD, [thing("lead", LEAD_X, stationary_s=30.0)]).view()
    path = replace(guard.lay_out([BORROW], alone, False, Approvals()).path, passes=("lead",))
    first = thing("lead", LEAD_X, **({"stationary_s": 30.0} | lead))
    view = World(ROAD, [first, *objects], controls=tuple(controls)).view()
    found = passable_obstacles.check_wait_elapsed(CheckContext(view, path, guard.policy, guided))
    assert all(r.code is C.WAIT_FIRST and r.object_id == "lead" for r in found)
    return bool(found)


def light(distance_m, state=LightState.RED, applies=True):
    return red_light(distance_m, state, applies)


# ---- queues


@pytest.mark.parametrize(
    ("distance_m", "holds"),
    [
        (LEAD_FRONT_M - 2.0 - A_LITTLE, False),
        (LEAD_FRONT_M - 2.0 + A_LITTLE, True),
        (LEAD_FRONT_M + 15.0 - A_LITTLE, True),
        (LEAD_FRONT_M + 15.0 + A_LITTLE, False),
    ],
)
def test_wait_first_light_near_stopped_vehicle_counts(distance_m, holds):
    """A vehicle may wait for a light within 15 m ahead of it or 2 m behind its front."""
    assert waits(controls=[light(distance_m)]) is holds


@pytest.mark.parametrize(
    ("control", "holds"),
    [
        (light(20.0), True),
        (light(20.0, LightState.YELLOW), True),
        (light(20.0, LightState.GREEN), False),
        (light(20.0, applies=None), True),
        (light(20.0, applies=False), False),
        (TrafficControl(kind=ControlKind.STOP_SIGN, distance_m=20.0, applies=True), True),
        (TrafficControl(kind=ControlKind.STOP_SIGN, distance_m=20.0, applies=False), False),
    ],
    ids=str,
)
def test_wait_first_red_light_or_stop_sign_counts(control, holds):
    """A red or yellow light or a stop sign holds a vehicle, unless it applies to others."""
    assert waits(controls=[control]) is holds


def test_of_several_lights_one_that_holds_is_enough():
    assert waits(controls=[light(20.0, LightState.GREEN), light(21.0)])
    assert waits(controls=[light(21.0), light(20.0, LightState.GREEN)])


NEXT_HALF_M = 4.6 / 2


@pytest.mark.parametrize(
    ("gap_m", "offset_m", "queue"),
    [
        (15.0 - A_LITTLE, 0.0, True),
        (15.0 + A_LITTLE, 0.0, False),
        (A_LITTLE, 0.0, True),
        (5.0, 0.4 - A_LITTLE, True),
        (5.0, 0.4 + A_LITTLE, False),
        (5.0, -0.4 - A_LITTLE, False),
    ],
)
def test_queue_two_aligned_vehicles_within_15_m_is_found(gap_m, offset_m, queue):
    """Two stopped vehicles in line within 15 m are a queue, unless one is offset like a parked vehicle."""
    following = thing("next", BUMPER_X + LEAD_FRONT_M + gap_m + NEXT_HALF_M, offset_m, stationary_s=30.0)
    assert waits(following) is queue


@pytest.mark.parametrize(("offset_m", "queue"), [(1.5 - A_LITTLE, True), (1.5 + A_LITTLE, False)])
def test_queue_recently_moved_vehicle_within_1_5_m_counts(offset_m, queue):
    """A vehicle that moved recently makes a queue within 1.5 m beside the line."""
    moved = thing("next", 81.0, offset_m, stationary_s=5.0, moved_s_ago=5.0)
    assert waits(moved) is queue


@pytest.mark.parametrize(("moved_s_ago", "queue"), [(0.0, True), (60.0 - A_LITTLE, True), (60.0, False), (None, False)])
def test_who_has_moved_within_a_minute_waits(moved_s_ago, queue):
    assert waits(moved_s_ago=moved_s_ago) is queue


@pytest.mark.parametrize("kind", [K.CONE, K.PEDESTRIAN, K.BARRIER])
def test_only_vehicles_make_a_queue(kind):
    assert not waits(thing("next", 70.0, kind=kind, stationary_s=30.0))


@pytest.mark.parametrize("who", ["lead", "next"])
def test_lights_that_say_otherwise_make_no_queue_whoever_shows_them(who):
    following = thing("next", 70.0, stationary_s=30.0, hazard=who == "next")
    assert not waits(following, hazard=who == "lead")
    flashing = thing("next", 70.0, stationary_s=30.0, kind=K.EMERGENCY, emergency_lights=True)
    assert not waits(flashing)


def test_how_far_a_queue_reaches_is_the_policys():
    near = Guard(GuardPolicy(queues=QueuePolicy(reach_m=5.0)))
    following = thing("next", BUMPER_X + LEAD_FRONT_M + 14.0 + NEXT_HALF_M, stationary_s=30.0)
    assert waits(following) and not waits(following, guard=near)


# ---- how long one is waited for


@pytest.mark.parametrize(
    ("stood_s", "more", "refused"),
    [
        (10.0 - A_LITTLE, {}, True),
        (10.0, {}, False),
        (3.0 - A_LITTLE, {"hazard": True}, True),
        (3.0, {"hazard": True}, False),
        (3.0, {"y": 0.4 - A_LITTLE}, True),
        (3.0, {"y": 0.4 + A_LITTLE}, False),
        (3.0, {"y": -0.4 - A_LITTLE}, False),
    ],
)
def test_wait_first_vehicle_is_passed_after_required_standstill(stood_s, more, refused):
    """A vehicle is passed after 10 s, or after 3 s with hazard lights or parked.

    With guidance, it is passed at once.
    """
    assert waits(stationary_s=stood_s, **more) is refused
    assert not waits(stationary_s=stood_s, guided=True, **more)


def test_wait_first_unknown_standstill_counts_as_0_s():
    """A vehicle that was never perceived as stationary has been stationary for 0 s."""
    lead = thing("lead", LEAD_X).model_copy(update={"stationary_s": None})
    (found,) = (r for r in rejects(BORROW, World(ROAD, [lead])) if r.code is C.WAIT_FIRST)
    assert found.detail == "car lead has been stationary for 0 s; 10 s are required"


@pytest.mark.parametrize(("speed", "refused"), [(0.5 - A_LITTLE, False), (0.5, True), (2.0, True)])
def test_wait_first_bicycle_from_0_5_mps_is_followed(speed, refused):
    """A bicycle that moves along the road at 0.5 m/s or more is followed and not passed."""
    assert waits(kind=K.BICYCLE, speed=speed) is refused


def told(*others, **lead):
    world = World(ROAD, [thing("lead", LEAD_X, **lead), *others])
    return [r.detail for r in rejects(BORROW, world) if r.code is C.WAIT_FIRST]


def test_why_one_waits_is_told():
    assert told(kind=K.BICYCLE, speed=2.0) == ["bicycle lead is moving: follow it, do not pass it"]
    assert told(moved_s_ago=5.0) == ["car lead may be in a queue"]
    assert told(stationary_s=2.0) == ["car lead has been stationary for 2 s; 10 s are required"]


def test_wait_first_oncoming_vehicle_changes_nothing():
    """An oncoming vehicle does not change whether a bicycle is followed."""
    by = thing("by", 20.0, LANE_M, speed=-5.0)
    assert told(by, kind=K.BICYCLE, speed=2.0) and told(by, kind=K.BICYCLE, speed=0.4) == []


def test_wait_first_cone_hides_no_waiting_vehicle():
    """A cone ahead of a vehicle does not hide that the vehicle may be waiting."""
    cone = thing("cone", 59.0, kind=K.CONE)
    assert waits(cone, stationary_s=2.0) and not waits(cone)


def test_a_line_is_beside_a_vehicle_and_not_mirrored():
    """1.7 m apart, though both are near the middle of the lane."""
    assert not waits(thing("next", 81.0, 1.4, stationary_s=5.0, moved_s_ago=5.0), y=-0.3)
    assert waits(thing("next", 81.0, 1.1, stationary_s=5.0, moved_s_ago=5.0), y=-0.3)


def test_things_are_not_waited_for():
    assert not waits(kind=K.BARRIER, stationary_s=0.0)


# ---- what is driven over


def bag(*others, **more):
    usual = {"kind": K.BAG, "height": 0.1, "kind_confidence": 0.9, "seen_for_s": 2.0}
    return World(ROAD, [thing("bag", 60.0, 0.0, **(usual | more)), *others])


def passable(world, approvals=None):
    found = [r for r in rejects(OVER, world, approvals) if r.code is C.NOT_PASSABLE]
    assert all(r.object_id == "bag" for r in found)
    return not found


@pytest.mark.parametrize(
    ("more", "soft"),
    [
        ({"kind_confidence": 0.8}, True),
        ({"kind_confidence": 0.8 - A_LITTLE}, False),
        ({"height": 0.15}, True),
        ({"height": 0.15 + A_LITTLE}, False),
        ({"length": 1.2}, True),
        ({"length": 1.2 + A_LITTLE}, False),
        ({"width": 1.2}, True),
        ({"width": 1.2 + A_LITTLE}, False),
        ({"seen_for_s": 1.0}, True),
        ({"seen_for_s": 1.0 - A_LITTLE}, False),
        ({"seen_for_s": None}, False),
        ({"kind": K.LITTER, "length": 0.3, "width": 0.3}, True),
        ({"speed": 0.1 - A_LITTLE}, True),
        ({"speed": 0.1 + A_LITTLE}, False),
        ({"sideways": 0.1 + A_LITTLE}, False),
    ],
    ids=str,
)
def test_passable_bag_within_each_bound_is_accepted(more, soft):
    """A bag is driven over within each bound and not beyond it."""
    assert passable(bag(**more)) is soft


@pytest.mark.parametrize("who", ["passenger", "operator"])
def test_passable_bag_confirmed_by_person_needs_0_5_confidence(who):
    """A confidence of 0.5 is enough if a person has confirmed the bag."""
    yes = Approvals(**{who: frozenset({"drive_over"})})
    assert passable(bag(kind_confidence=0.5), yes)
    assert not passable(bag(kind_confidence=0.5 - A_LITTLE), yes)
    assert not passable(bag(kind_confidence=None), yes)
    assert not passable(bag(kind_confidence=0.5), Approvals(**{who: frozenset({"solid_line"})}))


BAG_HALF_M = 0.15
WALKER_HALF_M = 0.25


@pytest.mark.parametrize("kind", [K.PEDESTRIAN, K.ANIMAL, K.UNKNOWN])
@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize(("gap_m", "soft"), [(2.0 - A_LITTLE, False), (2.0 + A_LITTLE, True)])
def test_passable_bag_near_pedestrian_or_unknown_is_rejected(kind, side, gap_m, soft):
    """No pedestrian, animal or unknown object may be within 2 m of an object that is driven over."""
    y = side * (gap_m + BAG_HALF_M + WALKER_HALF_M)
    beside = thing("beside", 60.0, y, kind=kind, length=0.5, width=0.5)
    assert passable(bag(thing("cone", 60.0, 3.0, kind=K.CONE), beside)) is soft
    assert passable(bag(beside, thing("cone", 60.0, 3.0, kind=K.CONE))) is soft


@pytest.mark.parametrize("gap_m", [2.0 - A_LITTLE, 2.0 + A_LITTLE])
def test_so_it_is_along_the_road(gap_m):
    ahead = thing("ahead", 60.0 + gap_m + BAG_HALF_M + WALKER_HALF_M, 0.0, kind=K.UNKNOWN, length=0.5, width=0.5)
    assert passable(bag(ahead)) is (gap_m > 2.0)


@pytest.mark.parametrize("kind", [K.CONE, K.BAG, K.PROP])
def test_dead_things_beside_a_bag_are_no_matter(kind):
    assert passable(bag(thing("beside", 60.0, 1.0, kind=kind, length=0.3, width=0.3)))


def test_passable_object_over_bag_is_reported_at_0_m():
    """An object that lies over the bag is reported at a distance of 0.0 m."""
    (found,) = (
        r for r in rejects(OVER, bag(thing("it", 60.0, 0.0, kind=K.UNKNOWN, length=0.5))) if r.object_id == "bag"
    )
    assert found.detail == "bag has unknown it at 0.0 m, required 2.0 m"


def test_recheck_bag_no_longer_perceived_ends_drive_over():
    _, proven = GUARD.accept([OVER], bag().view(), False)
    assert proven is not None
    found = GUARD.recheck(proven, World(ROAD).view()).rejects
    assert [(r.code, r.detail) for r in found] == [(C.NOT_PASSABLE, "bag is no longer detected")]


def test_what_may_not_be_driven_over_says_why():
    def why(**more):
        return next(r.detail for r in rejects(OVER, bag(**more)) if r.code is C.NOT_PASSABLE)

    assert why(kind=K.DEBRIS) == "bag is classified as debris, which is never driven over"
    assert why(kind_confidence=None) == "bag is classified as bag with confidence 0.00, required 0.80"
    assert why(speed=0.5) == "bag is moving"
    assert why(length=1.5) == "bag is 1.5 m long, allowed 1.2 m"
    assert why(height=0.3) == "bag is 0.30 m high, allowed 0.15 m"
    assert why(seen_for_s=None) == "bag has been tracked for 0.0 s, required 1.0 s"


# ---- the oncoming lane


AHEAD = KeepLane(distance_m=20.0, speed_mps=5.0)


def lanes_end_m():
    _, proven = GUARD.accept([BORROW], World(ROAD, [thing("lead", 65.0)]).view(), False)
    inside = [s for s, d in zip(proven.path.s, proven.path.d, strict=True) if d + 1.85 / 2 > LANE_M / 2 + 0.05]
    return float(inside[0]), float(inside[-1])


@pytest.mark.parametrize("kind", list(ZoneKind))
def test_the_oncoming_lane_is_left_3_m_before_a_zone(kind):
    """The body's end is 2.45 m before its center; a body that turns may reach in by some stations more."""
    _, last = lanes_end_m()

    def refused(start_m):
        road = straight_road(zones=(Zone(kind=kind, start_m=start_m, end_m=start_m + 10.0),))
        return C.ZONE in {r.code for r in rejects(BORROW, World(road, [thing("lead", 65.0)]))}

    assert refused(last + 2.45 + 3.0 - 0.5)
    assert not refused(last + 2.45 + 3.0 + 3.0)
