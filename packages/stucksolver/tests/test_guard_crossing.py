"""Those on roads that cross or join ours: foretold in the plane, and let by where one may not stay."""

from __future__ import annotations

import math

import numpy as np
import pytest

from stucksolver.guard import Guard, RejectCode
from stucksolver.plan import Execute, RecoveryPlan
from stucksolver.plan.behaviors import AbortAction, BorrowOncomingLane, KeepLane, Wait
from stucksolver.scene import LaneDirection, LineKind, ObjectKind, Zone, ZoneKind
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.solver.state_machine.execution import Execution
from stucksolver.solver.state_machine.execution_steps import ExecutionOutcome
from worlds import LANE_M, World, bent_road, straight_road, strip, thing

pytestmark = pytest.mark.usefixtures("alike")
GUARD = Guard()
JUNCTION = straight_road(zones=(Zone(kind=ZoneKind.JUNCTION, start_m=60.0, end_m=85.0),))
ON = KeepLane(distance_m=60.0, speed_mps=5.0)


def crossing(y: float, speed: float = 9.0, name: str = "crosser"):
    """On a road that crosses ours at x = 72, from the right; it drives along y."""
    return thing(name, 72.0, y, sideways=speed, yaw=math.pi / 2)


def codes(world, behavior=ON):
    return {r.code for r in GUARD.accept([behavior], world.view(), False)[0].rejects}


def under_way(x: float, speed: float):
    """A plan through the junction, and the world at a place of it."""
    world = World(JUNCTION)
    proven = GUARD.accept([ON], world.view(), False)[1]
    assert proven is not None and proven.committed(x)
    world.x, world.speed = x, speed
    return world, proven


def test_collision_crossing_vehicle_in_ego_path_rejects():
    """A vehicle that crosses when the ego is there rejects the start of the plan."""
    assert codes(World(JUNCTION)) == set()
    assert RejectCode.COLLISION in codes(World(JUNCTION, [crossing(-50.0)]))


def test_who_has_crossed_before_is_none():
    assert codes(World(JUNCTION, [crossing(-8.0, speed=12.0)])) == set()


def test_traffic_flow_with_short_gaps_is_not_entered():
    """A traffic flow with gaps shorter than the ego needs is not entered."""
    flow = [crossing(-9.0 * 2.7 * k, name=f"c{k}") for k in range(6)]
    assert codes(World(JUNCTION, flow))


@pytest.mark.parametrize(
    ("ours", "theirs", "found"), [(0.0, 1.5, set()), (3.0, 1.5, {RejectCode.GAP}), (0.0, 3.0, {RejectCode.GAP})]
)
def test_clearance_creeping_beside_slow_vehicle_is_stationary_gap(ours, theirs, found):
    """Beside a crawling vehicle, a creeping ego needs only the gap to a stationary object."""
    # They slant past our front corner, 0.4 m away where our short way ends.
    yaw = -math.radians(25.0)
    speed = {"speed": theirs * math.cos(yaw), "sideways": theirs * math.sin(yaw), "yaw": yaw}
    beside = thing("beside", 54.0, 3.05, **speed)
    assert codes(World(JUNCTION, [beside], x=52.0, speed=ours), KeepLane(distance_m=0.8, speed_mps=5.0)) == found


TURN_M = 12.0


def left_turn():
    """60 m along x, to the left in a junction with a radius of 12 m, and 60 m along y; an oncoming lane all along."""
    bend = math.pi / 2 * TURN_M
    s = np.arange(0.0, 120.0 + bend)
    turned = np.clip((s - 60.0) / TURN_M, 0.0, math.pi / 2)
    x = np.minimum(s, 60.0) + TURN_M * np.sin(turned)
    y = TURN_M * (1 - np.cos(turned)) + np.maximum(s - 60.0 - bend, 0.0)
    lanes = (
        strip("own", 0.0, LaneDirection.SAME, LineKind.NONE, len(s)),
        strip("oncoming", LANE_M, LaneDirection.OPPOSITE, LineKind.BROKEN, len(s)),
    )
    zone = Zone(kind=ZoneKind.JUNCTION, start_m=60.0, end_m=60.0 + bend)
    return straight_road().model_copy(
        update={
            "key": "left turn",
            "reference": tuple(zip(x.tolist(), y.tolist(), strict=True)),
            "lanes": lanes,
            "zones": (zone,),
        }
    )


def test_through_traffic_at_turn_is_predicted_straight_on():
    """Where the route turns, oncoming traffic is predicted to go straight on."""
    # Down the street that we turn into: on its way along our lanes it would turn, too, and leave us alone.
    down = {"x": 72.0 - LANE_M, "sideways": -8.0, "yaw": -math.pi / 2}
    assert codes(World(left_turn())) == set()
    assert RejectCode.COLLISION in codes(World(left_turn(), [thing("straight", y=50.0, **down)]))
    assert codes(World(left_turn(), [thing("gone", y=-14.0, **down)])) == set()


def test_predict_vehicle_beside_bend_goes_straight_on():
    """A vehicle beside a bend is predicted to go straight on and not to follow the ego's lane."""
    # In road coordinates it seems to cross the arc's lane; in the plane it leaves us alone.
    away = thing("away", -20.0, 15.0, speed=-8.0, yaw=math.pi)
    road = bent_road(30.0)
    assert codes(World(road, [away], x=0.0), KeepLane(distance_m=20.0, speed_mps=4.0)) == set()


@pytest.mark.parametrize(("kind", "there"), [(ObjectKind.CAR, True), (ObjectKind.PEDESTRIAN, False)])
def test_only_vehicles_have_roads_of_their_own(kind, there):
    world = World(JUNCTION, [thing("who", 72.0, -30.0, kind=kind, sideways=1.5, yaw=math.pi / 2)])
    assert world.view().elsewhere.tolist() == [there]


def test_view_vehicle_behind_known_road_is_in_ego_lane():
    """A vehicle that comes from before the known road is in the ego's lane."""
    assert World(JUNCTION, [thing("behind", -20.0, speed=8.0)]).view().elsewhere.tolist() == [False]


def test_in_a_junction_way_is_given_to_who_crosses_ahead():
    world, proven = under_way(61.0, 3.0)
    world.objects.append(crossing(-22.0))
    verdict = GUARD.recheck(proven, world.view())
    assert verdict.abort is AbortAction.YIELD
    assert RejectCode.COLLISION in {r.code for r in verdict.rejects}


def test_recheck_stop_in_conflict_path_finishes_plan():
    """Where a stop would be hit as well, the path is finished."""
    world, proven = under_way(71.0, 1.0)
    world.objects.append(crossing(-9.0))
    assert GUARD.recheck(proven, world.view()).abort is AbortAction.FINISH


def test_who_is_met_only_much_later_is_not_waited_for():
    world, proven = under_way(61.0, 4.0)
    world.objects.append(thing("far", 110.0, -75.0, sideways=9.0, yaw=math.pi / 2))
    assert GUARD.recheck(proven, world.view()).abort in (None, AbortAction.FINISH)


def giving_way(now_s: float):
    """A plan in the junction, somebody who crosses, and what is to be done at a time."""
    world = World(JUNCTION)
    execution = Execution(RecoveryPlan(behaviors=(ON,)), GUARD, False)
    assert execution.start(world.view(), 0.0).accepted
    world.x, world.speed = 61.0, 3.0
    world.objects.append(crossing(-22.0))
    return world, execution, execution.tick(FrenetScene(world.surroundings()), now_s)


def test_way_is_not_given_for_ever():
    _, _, ended = giving_way(now_s=500.0)
    assert isinstance(ended, ExecutionOutcome) and not ended.finished


def test_after_giving_way_the_plan_goes_on():
    world, execution, given = giving_way(now_s=1.0)
    assert isinstance(given, Execute) and isinstance(given.behavior, Wait)
    world.objects.clear()
    on = execution.tick(FrenetScene(world.surroundings()), 1.05)
    assert isinstance(on, Execute) and on.behavior == ON and on.path[0].x_m >= 60.0


TWO_WAY = straight_road()


def borrowing(x: float, speed: float, *others):
    """Past a car at x = 75 through the oncoming lane, some way on."""
    world = World(TWO_WAY, [thing("lead", 75.0)])
    proven = GUARD.accept([BorrowOncomingLane(past_object_id="lead", speed_mps=5.0)], world.view(), False)[1]
    assert proven is not None
    world.x, world.y, world.speed = x, float(np.interp(x, proven.path.s, proven.path.d)), speed
    world.objects += others
    return GUARD.recheck(proven, world.view())


@pytest.mark.parametrize("turned_deg", [0.0, 15.0, 21.0, 30.0, 45.0])
def test_recheck_vehicle_turning_into_borrowed_lane_is_oncoming(turned_deg):
    """A vehicle that turns into the borrowed lane counts as oncoming traffic."""
    yaw = math.pi + math.radians(turned_deg)
    coming = thing("coming", 100.0, 3.5, speed=8.0 * math.cos(yaw), sideways=8.0 * math.sin(yaw), yaw=yaw)
    assert borrowing(59.0, 4.0, coming).abort in (AbortAction.RETURN_TO_LANE, AbortAction.FINISH)


@pytest.mark.integration
def test_recheck_in_oncoming_lane_yields_only_against_contact():
    """In an oncoming lane, the ego stops to yield only if going on would touch a vehicle."""
    crosser = thing("crosser", 66.0, -14.0, sideways=8.0, yaw=math.pi / 2)
    for x in np.arange(52.0, 66.0, 1.0):
        verdict = borrowing(float(x), 2.5, crosser)
        assert verdict.abort is not AbortAction.YIELD or verdict.brake_mps2 is not None


@pytest.mark.parametrize("speed", [1.0, 2.0, 3.0])
def test_who_is_across_our_lane_may_stop_there(speed):
    across = thing("across", 78.0, -1.0, sideways=speed, yaw=math.pi / 2)
    assert codes(World(JUNCTION, [across], x=40.0), KeepLane(distance_m=60.0, speed_mps=5.0))


def test_nobody_stands_to_let_by_what_does_not_move():
    world, proven = under_way(61.0, 3.0)
    world.objects.append(thing("person", 70.0, -1.6, kind=ObjectKind.PEDESTRIAN))
    assert GUARD.recheck(proven, world.view()).abort is not AbortAction.YIELD


def test_recheck_stop_close_to_crossing_vehicle_prevents_contact():
    """A stop that would end just beside a crossing vehicle is made only against a contact."""
    world, proven = under_way(66.5, 4.0)
    world.objects.append(crossing(-14.0))
    verdict = GUARD.recheck(proven, world.view())
    assert verdict.abort is AbortAction.YIELD and verdict.brake_mps2 is not None


def test_whoever_gives_way_goes_on_only_into_a_longer_gap():
    world, proven = under_way(61.0, 1.0)
    world.objects.append(crossing(-40.0))
    assert GUARD.recheck(proven, world.view(), giving_way=False).abort in (None, AbortAction.FINISH)
    assert GUARD.recheck(proven, world.view(), giving_way=True).abort is AbortAction.YIELD
