"""How near a plan may come to what is there: a centimeter on either side of each bound, and what a verdict says."""

from __future__ import annotations

import math

import pytest

from stucksolver.guard import Approvals, Guard, RejectCode
from stucksolver.plan.behaviors import Creep, KeepLane
from stucksolver.scene import ControlKind, LightState, ObjectKind, TrafficControl
from worlds import World, red_light, straight_road, thing

C, K = RejectCode, ObjectKind
ROAD = straight_road()
GUARD = Guard()
HALF_WIDTH_M = 1.85 / 2
HALF_LENGTH_M = 4.9 / 2
BUMPER_X = 50.0 + 4.9 / 2
ON, SLOW = KeepLane(distance_m=40.0, speed_mps=5.0), KeepLane(distance_m=40.0, speed_mps=2.0)
BESIDE = {K.BARRIER: 0.95, K.CAR: 0.95, K.BICYCLE: 0.3, K.PEDESTRIAN: 0.25}
"""Half widths."""
A_LITTLE = 0.01
DRAWN_M = 0.05 + 0.25 * (0.3 + 5.0 / 3.0)
"""What a fault of 0.25 m/s that is seen at 5 cm still adds at 5 m/s until the vehicle stands: 0.54 m."""


def rejects(behavior, *objects, approvals=None, **world):
    view = World(ROAD, list(objects), **world).view()
    return GUARD.accept([behavior], view, False, approvals or Approvals())[0].rejects


def codes(behavior, *objects, **world):
    return {r.code for r in rejects(behavior, *objects, **world)}


def at(gap_m, kind=K.BARRIER, side=1.0, x=75.0, **more):
    """Something whose side is so far beside the ego's way along the lane's middle."""
    return thing("it", x, side * (HALF_WIDTH_M + BESIDE[kind] + gap_m), kind=kind, **more)


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize(
    ("behavior", "least_m", "code", "more"),
    [
        (ON, DRAWN_M, C.GAP, {}),
        (SLOW, 0.3, C.GAP, {}),
        (ON, 1.0, C.CLEARANCE, {"kind": K.BICYCLE}),
        (ON, DRAWN_M, C.GAP, {"kind": K.CAR, "speed": -5.0, "x": 120.0}),
        (SLOW, 0.5, C.GAP, {"kind": K.CAR, "speed": -5.0, "x": 120.0}),
        (ON, DRAWN_M, C.GAP, {"kind": K.CAR, "speed": -2.0, "x": 90.0}),
        (SLOW, 0.3, C.GAP, {"kind": K.CAR, "speed": -2.0, "x": 90.0}),
        (ON, 1.0, C.CLEARANCE, {"kind": K.BICYCLE, "speed": -4.0, "x": 120.0}),
    ],
    ids=[
        "stands",
        "stands, we creep",
        "cyclist stands",
        "comes",
        "comes, we creep",
        "creeps, we drive",
        "both creep",
        "cyclist comes",
    ],
)
def test_each_kind_of_neighbor_is_given_its_gap(behavior, least_m, code, more, side):
    assert code in codes(behavior, at(least_m - A_LITTLE, side=side, **more))
    assert not codes(behavior, at(least_m + A_LITTLE, side=side, **more)) & {C.GAP, C.CLEARANCE, C.COLLISION}


@pytest.mark.parametrize("sideways", [-0.2, 0.2])
def test_who_drifts_aside_in_their_lane_is_given_more(sideways):
    """v rho + v^2 / (2 b_lat), 0.22 m at 0.2 m/s, beside the 0.5 m."""
    drifts = {"kind": K.CAR, "speed": -5.0, "sideways": sideways, "x": 120.0}
    assert C.GAP in codes(ON, at(0.72 - A_LITTLE, **drifts))
    assert not codes(ON, at(0.72 + A_LITTLE, **drifts))


def test_recheck_leaves_15_cm_of_gap_to_tracking_error():
    """While a plan runs, tracking errors may use up 15 cm of each gap."""
    for plan, least_m in ((ON, DRAWN_M - 0.15), (SLOW, 0.15)):
        _, proven = GUARD.accept([plan], World(ROAD).view(), False)
        near = World(ROAD, [at(least_m - A_LITTLE)]).view()
        assert {r.code for r in GUARD.recheck(proven, near).rejects} == {C.GAP}
        assert GUARD.recheck(proven, World(ROAD, [at(least_m + A_LITTLE)]).view()).accepted


def test_clearance_object_too_near_is_left_but_not_approached():
    """An object that is too near already may be left but not approached."""
    beside = at(0.2, x=50.0)
    assert C.GAP not in codes(ON, beside)
    assert C.GAP in codes(ON, beside, at(0.2).model_copy(update={"id": "other"}))


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize("kind", [K.CAR, K.VAN, K.TRUCK, K.EMERGENCY])
def test_doors_reach_out_90_cm(kind, side):
    def car(gap_m):
        return thing("it", 75.0, side * (HALF_WIDTH_M + 0.95 + gap_m), kind=kind, hazard=True)

    assert C.DOOR in codes(ON, car(0.9 - A_LITTLE))
    assert C.DOOR not in codes(ON, car(0.9 + A_LITTLE))
    assert C.DOOR not in codes(SLOW, car(0.5))


@pytest.mark.parametrize(("stood_s", "opens"), [(3.0, True), (3.0 - A_LITTLE, False), (0.0, False)])
def test_door_may_open_after_standstill_of_3_s(stood_s, opens):
    assert (C.DOOR in codes(ON, at(0.6, K.CAR, stationary_s=stood_s))) is opens


def test_door_may_open_if_standstill_is_unknown():
    unknown = at(0.6, K.CAR).model_copy(update={"stationary_s": None})
    assert C.DOOR in codes(ON, unknown)


@pytest.mark.parametrize("kind", [K.BUS, K.MOTORCYCLE, K.BARRIER])
def test_what_has_no_doors_to_the_side_opens_none(kind):
    assert C.DOOR not in codes(ON, thing("it", 75.0, HALF_WIDTH_M + 0.95 + 0.6, kind=kind))


@pytest.mark.parametrize(("x", "reached"), [(73.55, True), (73.65, False)])
def test_doors_are_on_the_middle_half_of_a_vehicle(x, reached):
    """The plan's end brings our bumper to 72.45 m; the middle half of 4.6 m begins 1.15 m before the middle."""
    door = at(0.6, K.CAR, x=x)
    assert (C.DOOR in codes(KeepLane(distance_m=20.0, speed_mps=5.0), door)) is reached


def test_door_rejection_names_car_and_time():
    """A door that may open is reported with its car and the time at which it would matter."""
    (found,) = (r for r in rejects(ON, at(0.6, K.CAR)) if r.code is C.DOOR)
    assert (
        found.object_id == "it"
        and found.detail.startswith("car it: gap ")
        and "to an open door, required " in found.detail
    )
    assert found.time_s == pytest.approx(reached_s(75.0 - 1.15 - BUMPER_X), abs=0.3)


def reached_s(way_m, cap_mps=0.85 * 5.0, acceleration_mps2=0.6 * 1.5, start_mps=0.3):
    """When a sluggish ego that starts from rest has driven so far."""
    gaining_m = (cap_mps**2 - start_mps**2) / (2 * acceleration_mps2)
    if way_m <= gaining_m:
        return (math.sqrt(start_mps**2 + 2 * acceleration_mps2 * way_m) - start_mps) / acceleration_mps2
    return (cap_mps - start_mps) / acceleration_mps2 + (way_m - gaining_m) / cap_mps


@pytest.mark.parametrize(("gap_m", "code"), [(-0.5, C.COLLISION), (0.2, C.GAP)])
def test_a_verdict_names_who_is_met_when_and_how_near(gap_m, code):
    (found,) = rejects(ON, at(gap_m))
    assert found.code is code and found.object_id == "it"
    assert found.gap_m == pytest.approx(gap_m, abs=0.02)
    assert found.time_s == pytest.approx(reached_s(75.0 - 2.3 - BUMPER_X), abs=0.4)
    assert found.detail == f"barrier it: gap {found.gap_m:.2f} m, required 0.54 m at {found.time_s:.1f} s"


def test_a_verdict_names_the_three_nearest_the_nearest_first():
    gaps = {"a": 0.25, "b": 0.05, "c": 0.2, "d": 0.1, "e": 0.15}
    things = [
        at(gap_m, x=60.0 + 6.0 * k).model_copy(update={"id": name}) for k, (name, gap_m) in enumerate(gaps.items())
    ]
    assert [r.object_id for r in rejects(ON, *things)] == ["b", "d", "e"]


# ---- speeds


@pytest.mark.parametrize(("guided", "cap_mps"), [(False, 20 / 3.6), (True, 40 / 3.6)])
def test_speed_cap_is_20_kmh_or_40_kmh_guided(guided, cap_mps):
    """The cap on speed is 20 km/h, and 40 km/h for a guided plan."""

    def accepted(speed_mps):
        return GUARD.accept([KeepLane(distance_m=30.0, speed_mps=speed_mps)], World(ROAD).view(), guided)[0].accepted

    assert accepted(min(cap_mps, 11.0)) and (cap_mps > 11.0 or not accepted(cap_mps + A_LITTLE))


# ---- lines


def dark(distance_m, kind=ControlKind.TRAFFIC_LIGHT, applies=True):
    state = LightState.OFF if kind is ControlKind.TRAFFIC_LIGHT else None
    return TrafficControl(kind=kind, distance_m=distance_m, applies=applies, state=state)


CREEP = KeepLane(distance_m=20.0, speed_mps=2.0)


@pytest.mark.parametrize(
    ("control", "refused"),
    [
        (red_light(20.0 - A_LITTLE), True),
        (red_light(20.0 + A_LITTLE), False),
        (red_light(-1.0), True),
        (red_light(-1.0 - A_LITTLE), False),
        (red_light(10.0, applies=None), True),
        (red_light(10.0, applies=False), False),
        (red_light(10.0, LightState.GREEN), False),
    ],
    ids=str,
)
def test_red_light_from_1_m_behind_bumper_counts(control, refused):
    """A red light counts from 1 m behind the bumper to the end of the plan."""
    assert (C.RED_LIGHT in codes(CREEP, controls=(control,))) is refused


@pytest.mark.parametrize("kind", [ControlKind.TRAFFIC_LIGHT, ControlKind.STOP_SIGN])
@pytest.mark.parametrize(
    ("distance_m", "speed", "refused"),
    [(6.0 - A_LITTLE, 0.0, False), (6.0, 0.0, True), (4.0, 0.3 - A_LITTLE, False), (4.0, 0.3, True)],
)
def test_stop_line_counts_as_stopped_at_within_6_m(kind, distance_m, speed, refused):
    """A line has been stopped at if the ego is at rest within 6 m of it."""
    assert (C.STOP_LINE in codes(CREEP, controls=(dark(distance_m, kind),), speed=speed)) is refused


def test_controls_passed_sign_or_green_light_hides_no_other():
    """A sign behind the bumper is passed. A green light says nothing about the next control."""
    sign = dark(-A_LITTLE, ControlKind.STOP_SIGN)
    assert C.STOP_LINE not in codes(ON, controls=(sign,))
    assert C.STOP_LINE in codes(ON, controls=(dark(A_LITTLE, ControlKind.STOP_SIGN),))
    assert C.RED_LIGHT in codes(ON, controls=(red_light(5.0, LightState.GREEN), red_light(12.0)))
    assert C.RED_LIGHT in codes(ON, controls=(sign, red_light(5.0, applies=False), red_light(12.0)))


@pytest.mark.parametrize(("distance_m", "quick_too_early"), [(4.0, True), (3.0, True), (1.0, False)])
def test_stop_line_creep_lasts_1_m_past_line(distance_m, quick_too_early):
    """The ego creeps until the bumper is 1 m over the line.

    The plan is slow for 3 m.
    """
    world = World(ROAD, controls=(dark(distance_m),))
    plan = [Creep(distance_m=3.0), KeepLane(distance_m=20.0, speed_mps=5.0)]
    found = {r.code for r in GUARD.accept(plan, world.view(), False)[0].rejects}
    assert (C.STOP_LINE in found) is quick_too_early


def test_red_light_approval_permits_only_creep():
    """An operator's approval of a red light permits only creeping over it."""
    yes = Approvals(operator=frozenset({"red_light"}))
    assert C.RED_LIGHT not in {r.code for r in rejects(CREEP, controls=(red_light(4.0),), approvals=yes)}
    assert C.RED_LIGHT in {r.code for r in rejects(ON, controls=(red_light(4.0),), approvals=yes)}


def test_control_rejection_reports_its_distance():
    """The rejection for a light or sign reports its distance."""
    (red,) = rejects(CREEP, controls=(red_light(10.0),))
    assert red.detail == "red light 10 m ahead"
    (off,) = rejects(CREEP, controls=(dark(10.0),))
    assert off.detail == "dark light (an all-way stop) 10 m ahead: stop at it first, then creep"
    (sign,) = rejects(CREEP, controls=(dark(10.0, ControlKind.STOP_SIGN),))
    assert sign.detail == "stop sign 10 m ahead: stop at it first, then creep"


@pytest.mark.parametrize(
    ("off_m", "same"), [(2.0 - A_LITTLE, True), (-2.0 + A_LITTLE, True), (2.0, False), (-2.0, False)]
)
def test_recheck_stop_line_is_matched_within_2_m(off_m, same):
    """A line at which a plan started is recognized again within 2 m."""
    start = World(ROAD, controls=(dark(4.0),))
    _, proven = GUARD.accept([CREEP], start.view(), False)
    later = World(ROAD, x=51.0, speed=1.0, controls=(dark(3.0 + off_m),))
    assert GUARD.recheck(proven, later.view()).accepted is same


# ---- edges of the road


def test_drivable_area_body_may_overhang_edge_by_15_cm():
    road = straight_road(oncoming=None)

    def refused(over_m):
        """A lane that narrows beside us on that side, on a path along the middle of the road."""
        width = 2 * (HALF_WIDTH_M - over_m)
        own = road.lanes[0].model_copy(update={"width_m": tuple(width if 58 <= x <= 60 else 3.5 for x in range(401))})
        narrow = road.model_copy(update={"lanes": (own,), "key": f"narrow {over_m}"})
        found = GUARD.accept([KeepLane(distance_m=20.0, speed_mps=2.0)], World(narrow).view(), False)[0].rejects
        return C.OFF_LANES in {r.code for r in found}

    assert not refused(0.15 - A_LITTLE)
    assert refused(0.15 + A_LITTLE)


def test_drivable_area_rejection_reports_distance_off_road():
    """The rejection of a plan that leaves the road reports by how much and where."""
    (found,) = rejects(KeepLane(distance_m=20.0, speed_mps=5.0), y=-2.5)
    assert found.code is C.OFF_LANES and "off the driving lanes" in found.detail
    assert found.gap_m is not None and found.gap_m < 0.0
