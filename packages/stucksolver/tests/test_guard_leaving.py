"""Plans that begin where the ego must not stand, and leave: rules against entering and waiting do not bind them."""

from __future__ import annotations

import math

import pytest

from places import BACK_OFF, CROSSING, CROSSWALK, GUARD, HALF_M, QUEUE, codes, gate, street
from stucksolver.guard import Guard, GuardPolicy, RejectCode
from stucksolver.plan.behaviors import BackUp, ChangeLane, Creep, KeepLane, PullOver
from stucksolver.scene import LineKind, ObjectKind, ZoneKind
from worlds import World, red_light, thing

C, K, Z = RejectCode, ObjectKind, ZoneKind

# ---- backwards off the rails


def test_back_up_off_long_crossing_is_accepted():
    assert codes(World(CROSSING, [QUEUE]), BACK_OFF) == set()


def test_back_up_within_rails_is_rejected():
    assert C.STOPPING_PLACE in codes(World(CROSSING, [QUEUE]), BackUp(distance_m=8.0))


def test_back_up_off_crossing_past_its_gates_is_accepted():
    """The gates have come down while the ego stands on the rails between them."""
    gates = [gate(18.0), gate(58.0, 5.0)]
    assert codes(World(CROSSING, [thing("queue", 48.0), *gates], x=39.0), BackUp(distance_m=24.0)) == set()


def test_closed_crossing_is_not_backed_across():
    """The ego is beyond the rails. With the gates down, the way back over them needs the operator's approval."""
    assert codes(World(CROSSING, [QUEUE, gate(18.0)]), BACK_OFF) == {C.AUTHORITY}


@pytest.mark.parametrize("x", [18.0, 24.0, 30.0])
def test_ego_waiting_at_closed_gate_within_zone_does_not_cross(x):
    """The zone is longer than the way from the gate to the rails: a waiting ego has its front in it."""
    for gates in ([gate(x + 4.0)], [gate(x + 4.0), gate(58.0, 5.0)], [gate(58.0, 5.0)]):
        found = codes(World(CROSSING, gates, x=x), KeepLane(distance_m=60.0, speed_mps=5.0))
        assert C.AUTHORITY in found
        back = BackUp(distance_m=x - 16.0 + HALF_M, speed_mps=2.0)
        assert codes(World(CROSSING, gates, x=x), back) == set()


@pytest.mark.parametrize(("x", "asks"), [(34.0, True), (43.0, True), (47.0, False), (60.0, False)])
def test_two_crosses_mark_one_crossing_once_the_ego_is_past_the_first(x, asks):
    """A cross on either side of the rails has a zone of 24 m each. An ego that waits before the first one enters."""
    crossing = street((Z.LEVEL_CROSSING, 36.0, 60.0), (Z.LEVEL_CROSSING, 48.0, 72.0))
    found = codes(World(crossing, x=x), KeepLane(distance_m=80.0 - x, speed_mps=4.0))
    assert found == ({C.AUTHORITY} if asks else set())


def test_ego_with_nose_in_junction_does_not_pass_officer():
    officer = thing("officer", 64.0, 2.5, kind=K.FLAGGER, length=0.5, width=0.5)
    junction = street((Z.JUNCTION, 52.0, 72.0))
    assert C.AUTHORITY in codes(World(junction, [officer]), KeepLane(distance_m=30.0, speed_mps=2.0))
    assert codes(World(junction, [officer]), BackUp(distance_m=4.0)) == set()
    assert C.AUTHORITY not in codes(World(junction, [officer], x=61.0), KeepLane(distance_m=20.0, speed_mps=2.0))


def test_back_up_into_closed_gate_is_rejected():
    """A boom across the lane is an obstacle like any other."""
    boom = thing("boom", 18.0, -0.5, kind=K.CROSSING_GATE, length=0.2, width=3.0)
    assert codes(World(CROSSING, [QUEUE, boom]), BACK_OFF) >= {C.COLLISION}


@pytest.mark.parametrize("behind_m", [20.0, 36.0, 40.0])
def test_back_up_off_crossing_without_sight_is_rejected(behind_m):
    assert codes(World(CROSSING, [QUEUE], behind_m=behind_m), BACK_OFF) == {C.PATH_NOT_VISIBLE}


@pytest.mark.parametrize(
    "behind",
    [
        thing("car", 10.0, speed=5.0),
        thing("parked", 30.0, 0.5),
        thing("walker", 25.0, 3.5, kind=K.PEDESTRIAN, sideways=-0.4),
        thing("child", 30.0, -1.2, kind=K.PEDESTRIAN),
        thing("cyclist", 5.0, -1.0, kind=K.BICYCLE, speed=4.0),
    ],
    ids=lambda o: o.id,
)
def test_back_up_off_crossing_toward_someone_is_rejected(behind):
    found = codes(World(CROSSING, [QUEUE, behind]), BACK_OFF)
    assert found & {C.COLLISION, C.GAP, C.CLEARANCE}, found


# ---- forwards off the rails


@pytest.mark.parametrize("behavior", [KeepLane(distance_m=20.0, speed_mps=5.0), Creep(distance_m=10.0)])
def test_driving_off_crossing_past_its_gates_is_accepted(behavior):
    assert codes(World(CROSSING, [gate(18.0), gate(58.0, 5.0)]), behavior) == set()


def test_driving_into_crossing_past_its_gate_needs_approval():
    """An ego before the crossing enters it: the same gates need the operator's approval."""
    world = World(CROSSING, [gate(18.0), gate(58.0, 5.0)], x=12.0)
    assert C.AUTHORITY in codes(world, KeepLane(distance_m=60.0, speed_mps=5.0))


def test_leaving_one_crossing_allows_no_other():
    """Beyond the crossing under the ego is another one, with room to stand between: that one is entered."""
    two = street((Z.LEVEL_CROSSING, 40.0, 56.0), (Z.LEVEL_CROSSING, 70.0, 80.0))
    assert C.AUTHORITY in codes(World(two), KeepLane(distance_m=50.0, speed_mps=5.0))
    assert C.AUTHORITY in codes(World(two, [gate(82.0, 5.0)]), KeepLane(distance_m=50.0, speed_mps=5.0))
    assert codes(World(two), Creep(distance_m=10.0)) == set()


def test_two_tracks_without_room_between_are_left_as_one():
    tracks = street((Z.LEVEL_CROSSING, 46.0, 54.0), (Z.LEVEL_CROSSING, 57.0, 63.0))
    assert codes(World(tracks), KeepLane(distance_m=30.0, speed_mps=5.0)) == set()
    assert C.STOPPING_PLACE in codes(World(tracks), Creep(distance_m=8.0))


# ---- into a less bad place


def test_back_up_off_rails_onto_empty_crosswalk_is_accepted():
    road = street((Z.CROSSWALK, 40.0, 44.0), (Z.LEVEL_CROSSING, 46.0, 56.0))
    back = BackUp(distance_m=8.0)
    assert codes(World(road, [QUEUE]), back) == set()
    person = thing("person", 42.0, -4.0, kind=K.PEDESTRIAN)
    assert C.STOPPING_PLACE in codes(World(road, [QUEUE, person]), back)


def test_back_up_off_rails_into_free_junction_is_accepted():
    road = street((Z.JUNCTION, 30.0, 44.0), (Z.LEVEL_CROSSING, 46.0, 56.0))
    assert codes(World(road, [QUEUE]), BackUp(distance_m=8.0)) == set()
    crosser = thing("crosser", 40.0, -60.0, sideways=6.0, yaw=math.pi / 2)
    assert C.GAP in codes(World(road, [QUEUE, crosser]), BackUp(distance_m=8.0))


@pytest.mark.parametrize("worse", [Z.JUNCTION, Z.LEVEL_CROSSING])
def test_back_up_from_crosswalk_into_worse_place_is_rejected(worse):
    road = street((worse, 30.0, 44.0), (Z.CROSSWALK, 46.0, 56.0))
    assert C.STOPPING_PLACE in codes(World(road, [QUEUE]), BackUp(distance_m=8.0))


# ---- nearer to the exit


FIRE_STATION = street((Z.KEEP_CLEAR, 42.0, 58.0))
"""Area in front of the exit of a fire station. The ego at 50 m stands in its middle."""


@pytest.mark.parametrize(
    "behavior", [BackUp(distance_m=13.0), Creep(distance_m=11.0), KeepLane(distance_m=20.0, speed_mps=4.0)]
)
def test_ego_leaves_exit_of_fire_station(behavior):
    """A fire engine waits in the exit with its lights on, its front at the edge of the lane."""
    engine = thing(
        "engine", 50.0, -5.9, kind=K.EMERGENCY, emergency_lights=True, yaw=math.pi / 2, length=8.0, width=2.5
    )
    assert codes(World(FIRE_STATION, [engine]), behavior) == set()
    assert codes(World(FIRE_STATION, [engine]), behavior, stops=True) == set()


def test_ego_does_not_stop_in_front_of_fire_station():
    assert codes(World(FIRE_STATION, x=34.0), Creep(distance_m=12.0)) == {C.STOPPING_PLACE}
    assert codes(World(FIRE_STATION, x=66.0), BackUp(distance_m=8.0)) == {C.STOPPING_PLACE}
    assert not GUARD.may_stand(World(FIRE_STATION).view())


def test_back_up_further_off_crosswalk_is_accepted():
    """A vehicle behind leaves 5 m: the ego cannot leave the crosswalk, but clears most of it."""
    behind = thing("behind", 37.0)
    world = World(CROSSWALK, [QUEUE, behind])
    assert codes(world, BackUp(distance_m=8.0)) & {C.COLLISION, C.GAP}
    assert codes(world, BackUp(distance_m=5.0, speed_mps=1.0)) == set()


def test_creep_further_off_crosswalk_is_accepted():
    assert codes(World(CROSSWALK, [thing("queue", 60.0)]), Creep(distance_m=3.5)) == set()
    person = thing("person", 49.0, -4.5, kind=K.PEDESTRIAN)
    assert C.STOPPING_PLACE in codes(World(CROSSWALK, [thing("queue", 60.0), person]), Creep(distance_m=3.5))


@pytest.mark.parametrize("kind", [Z.CROSSWALK, Z.JUNCTION, Z.KEEP_CLEAR])
def test_creep_deeper_into_place_is_rejected(kind):
    """The ego has only its nose in the zone. Further in is further from the nearer exit, behind it."""
    assert C.STOPPING_PLACE in codes(World(street((kind, 52.0, 70.0))), Creep(distance_m=4.0))


def test_creep_nearer_to_exit_of_junction_is_accepted():
    junction = street((Z.JUNCTION, 30.0, 56.0))
    assert codes(World(junction, [thing("queue", 62.0)]), Creep(distance_m=4.0)) == set()


def test_creep_in_junction_into_conflict_path_is_rejected():
    crosser = thing("crosser", 54.0, -40.0, sideways=6.0, yaw=math.pi / 2)
    junction = street((Z.JUNCTION, 30.0, 62.0))
    assert codes(World(junction, [crosser]), Creep(distance_m=4.0)) & {C.GAP, C.COLLISION}


def test_pull_over_onto_crosswalk_is_rejected():
    """The roadside is a place to stay: it is no way off a crosswalk that ends on it."""
    assert codes(World(street((Z.CROSSWALK, 30.0, 62.0))), PullOver(distance_m=10.0, speed_mps=2.0))


# ---- lines


LINE = street((Z.CROSSWALK, 51.0, 54.0), (Z.JUNCTION, 55.0, 70.0))


@pytest.mark.parametrize("distance_m", [-0.4, -2.0, -4.0])
def test_back_up_behind_line_of_red_light_is_accepted(distance_m):
    world = World(LINE, controls=(red_light(distance_m),))
    assert codes(world, BackUp(distance_m=6.0)) == set()


@pytest.mark.parametrize("distance_m", [3.0, 0.5, -0.4])
def test_red_light_ahead_forbids_leaving_forwards(distance_m):
    """The zone under the ego is a crosswalk; the junction beyond the line is another place."""
    world = World(LINE, controls=(red_light(distance_m),))
    assert C.RED_LIGHT in codes(world, KeepLane(distance_m=30.0, speed_mps=5.0))


SOLID = {"left": LineKind.SOLID, "oncoming": None}


def test_solid_line_is_crossed_to_leave_rails():
    world = World(street((Z.LEVEL_CROSSING, 40.0, 56.0), **SOLID), [thing("queue", 66.0)])
    change = ChangeLane(side="left", distance_m=40.0, speed_mps=5.0)
    assert codes(world, change) == set()
    assert C.SOLID_LINE in codes(world, change, guard=Guard(GuardPolicy(solid_line="forbid")))
    for road in (
        street(**SOLID),
        street((Z.CROSSWALK, 46.0, 52.0), **SOLID),
        street((Z.LEVEL_CROSSING, 52.0, 60.0), **SOLID),
    ):
        assert C.SOLID_LINE in codes(World(road, [thing("queue", 66.0)]), change)


# ---- scenes beside the way


def test_back_up_from_beside_flagger_is_accepted():
    """Backing away from a flagger beside the ego does not pass the flagger; driving on does."""
    flagger = thing("flagger", 51.0, -3.2, kind=K.FLAGGER, length=0.5, width=0.5)
    assert codes(World(street(), [flagger]), BackUp(distance_m=5.0)) == set()
    assert C.AUTHORITY in codes(World(street(), [flagger]), KeepLane(distance_m=20.0, speed_mps=4.0))
    behind = flagger.model_copy(update={"x_m": 44.0})
    assert C.AUTHORITY in codes(World(street(), [behind]), BackUp(distance_m=5.0))


@pytest.mark.parametrize("kind", list(Z))
def test_emergency_scene_does_not_hold_ego_in_place(kind):
    """An ambulance with its lights on stands at the exit, half in the lane beside: the ego leaves past it."""
    ambulance = thing("ambulance", 57.0, 2.3, kind=K.EMERGENCY, emergency_lights=True)
    leave = KeepLane(distance_m=25.0, speed_mps=2.0)
    assert C.AUTHORITY not in codes(World(street((kind, 40.0, 56.0)), [ambulance]), leave)
    bus = thing("bus", 57.0, 2.6, kind=K.SCHOOL_BUS)
    assert C.AUTHORITY in codes(World(street((kind, 40.0, 56.0)), [bus]), leave)
