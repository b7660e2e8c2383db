"""Cases in which rules of the guard differ that mostly lead to the same: each decides here, and alone."""

from __future__ import annotations

import math

import numpy as np
import pytest

from guard_cases import CAR_M, GUARD, LENGTH_M, MULTI, POLICY, WIDTH_M, on_way
from stucksolver.guard import Guard, RejectCode
from stucksolver.guard.collision_mitigation import least_harmful_option
from stucksolver.guard.context import CheckContext
from stucksolver.guard.occluded_traffic import phantom_vehicles
from stucksolver.guard.through_traffic import goes_straight
from stucksolver.plan import Execute, RecoveryPlan
from stucksolver.plan.behaviors import AbortAction, KeepLane, TurnAround
from stucksolver.plan.multi_point_turn import corners
from stucksolver.scene import LaneDirection, LaneSight, LineKind, ObjectKind, Zone, ZoneKind
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.solver.state_machine.execution import Execution
from stucksolver.solver.state_machine.execution_steps import ExecutionOutcome
from worlds import LANE_M, World, straight_road, strip, thing

C, K = RejectCode, ObjectKind
ON = KeepLane(distance_m=60.0, speed_mps=5.0)
JUNCTION = Zone(kind=ZoneKind.JUNCTION, start_m=60.0, end_m=85.0)


def zoned(kind: ZoneKind, start_m: float = 55.0, end_m: float = 95.0):
    return straight_road(left=LineKind.BROKEN, zones=(Zone(kind=kind, start_m=start_m, end_m=end_m),))


# ---- a turn: for how long nobody may come


def wide_road():
    """One lane of 5 m each way."""
    road = straight_road()
    lanes = tuple(
        lane.model_copy(update={"width_m": (5.0,) * 401, "offset_m": (k * 5.0,) * 401})
        for k, lane in enumerate(road.lanes)
    )
    return road.model_copy(update={"key": "wide for a turn", "lanes": lanes})


@pytest.mark.parametrize("speed", [6.0, 9.0, 12.0])
@pytest.mark.parametrize("begun", [False, True])
def test_turn_needs_free_road_for_all_legs_until_begun(begun: bool, speed: float) -> None:
    """Require the gap for all legs from a vehicle in its lane, and for the next leg once it is across the road."""
    turn, start = TurnAround(), World(wide_road(), x=200.0)
    if begun:
        x, y, yaw = turn.legs(start.view())[0].end
        start = World(wide_road(), x=x, y=y, yaw=yaw)
    legs = turn.legs(start.view())
    verdict, proven = GUARD.accept_turn(turn, start.view())
    assert proven is not None, str(verdict)
    takes_s = proven.expected_s + (0.0 if begun else proven.after_s)
    assert proven.after_s > 5.0
    edge_m = max(float(corners(start.view(), leg.x_m, leg.y_m, leg.yaw_rad)[0].max()) for leg in legs)
    needed_m = (speed + POLICY.oncoming.speedup_mps) * (takes_s + POLICY.oncoming.time_gap_s)
    for gap_m, refused in ((needed_m - 0.5, True), (needed_m + 0.5, False)):
        comes = thing("comes", edge_m + CAR_M / 2 + gap_m, 5.0, speed=-speed)
        start.objects = [comes]
        verdict, _ = GUARD.accept_turn(turn, start.view())
        assert (C.ONCOMING_GAP in verdict.codes) is refused, str(verdict)


# ---- harm: persons, then rails, then speed


def test_least_harm_spares_a_person_before_rails() -> None:
    """Stop on rails, where a slow car touches the vehicle, rather than drive on into a pedestrian."""
    world = World(zoned(ZoneKind.LEVEL_CROSSING), x=65.0, speed=4.0)
    world.objects = [
        thing("walker", 76.0, kind=K.PEDESTRIAN),
        thing("crossing", 68.5, -9.0, sideways=3.0, yaw=math.pi / 2),
    ]
    way = least_harmful_option(running(world), giving_way=False)
    assert way.abort is AbortAction.YIELD


def test_least_harm_leaves_rails_before_it_lowers_an_impact() -> None:
    """Drive on off the rails into a parked car rather than stop on them for a slower touch."""
    world = World(zoned(ZoneKind.LEVEL_CROSSING), x=65.0, speed=4.0)
    world.objects = [
        thing("parked", 76.0),
        thing("crossing", 68.5, -9.0, sideways=3.0, yaw=math.pi / 2),
    ]
    assert least_harmful_option(running(world), giving_way=False).abort is AbortAction.FINISH
    world.road = zoned(ZoneKind.JUNCTION)
    assert least_harmful_option(running(world), giving_way=False).abort is AbortAction.YIELD


def running(world: World) -> CheckContext:
    """A plan straight on for 40 m, from where the vehicle is."""
    case = on_way(speed=world.speed, x=world.x)
    return CheckContext(world.view(), case.path, POLICY, running=True)


# ---- giving way with old surroundings


@pytest.mark.parametrize("x", [62.0, 70.0, 78.0])
@pytest.mark.parametrize("more_s", [0.01, 0.5, 3.0])
def test_recheck_at_rest_keeps_standing_on_stale_surroundings(x: float, more_s: float) -> None:
    """A vehicle that gave way and stands does not set off by what it saw too long ago."""
    world = World(straight_road(zones=(JUNCTION,)))
    proven = GUARD.accept([ON], world.view(), False)[1]
    assert proven is not None and proven.committed(x)
    world.x, world.speed = x, 0.0
    assert GUARD.recheck(proven, world.view(), True).accepted
    world.age_s = POLICY.max_age_s + more_s
    verdict = GUARD.recheck(proven, world.view(), True)
    assert verdict.abort is AbortAction.YIELD and verdict.codes == (C.STALE,)


def test_execution_stands_while_surroundings_are_stale_and_then_goes_on() -> None:
    """Hold the plan where it gave way until the surroundings are fresh again."""
    world = World(straight_road(zones=(JUNCTION,)), dt=0.1)
    execution = Execution(RecoveryPlan(behaviors=(ON,)), Guard(), False)
    assert execution.start(world.view(), 0.0).accepted
    told: object = None
    while world.x < 61.0 or world.speed > 0.05:
        if world.x >= 61.0 and not world.objects:
            world.objects = [thing("crosser", 72.0, -14.0, sideways=6.0, yaw=math.pi / 2)]
        told = execution.tick(world.view(), world.time_s)
        assert isinstance(told, Execute) and world.time_s < 30.0
        world.drive(told)
    world.objects, world.age_s, at = [], POLICY.max_age_s + 0.2, world.x
    for _ in range(10):
        told = execution.tick(world.view(), world.time_s)
        assert isinstance(told, Execute) and told.behavior.name == "wait"
        world.drive(told)
    assert world.x == pytest.approx(at, abs=0.05)
    world.age_s = 0.0
    for _ in range(30):
        told = execution.tick(world.view(), world.time_s)
        assert not isinstance(told, ExecutionOutcome)
        world.drive(told)
    assert world.x > at + 1.0


# ---- a vehicle off its proven path


@pytest.mark.parametrize("giving_way", [False, True])
@pytest.mark.parametrize("aside_m", [0.95, 1.2])
@pytest.mark.parametrize("crosser", [(-16.0, 6.0), (-24.0, 9.0), (-32.0, 12.0)])
def test_recheck_off_the_proven_path_computes_harm(
    crosser: tuple[float, float], aside_m: float, giving_way: bool
) -> None:
    """Let others by on the proven path only: off it, compute the harm of each way out, and how hard to brake."""
    world = World(straight_road(zones=(JUNCTION,)))
    proven = GUARD.accept([ON], world.view(), False)[1]
    assert proven is not None
    world.x, world.speed = 61.0, 4.0
    world.objects = [thing("crosser", 72.0, crosser[0], sideways=crosser[1], yaw=math.pi / 2)]
    on = GUARD.recheck(proven, world.view(), giving_way)
    assert (on.abort, on.brake_mps2) == (AbortAction.YIELD, None)
    world.y = -aside_m
    off = GUARD.recheck(proven, world.view(), giving_way)
    assert C.DEVIATION in off.codes
    assert (off.abort, off.brake_mps2) == (AbortAction.YIELD, world.ego().limits.comfort_braking_mps2)


# ---- doors, on a way so short that only the quicker of two vehicles gets fast


@pytest.mark.parametrize("way_m", [2.2, 2.6])
@pytest.mark.parametrize(("speed", "refused"), [(5.0, True), (2.0, False)])
def test_doors_are_checked_at_the_highest_speed_there(way_m: float, speed: float, refused: bool) -> None:
    """Refuse where a keen vehicle exceeds walking pace beside a door, although a sluggish one does not."""
    car = thing("parked", 50.0 + LENGTH_M / 2 + CAR_M / 4 + 0.5, WIDTH_M / 2 + 0.95 + 0.7)
    plan = [KeepLane(distance_m=way_m, speed_mps=speed)]
    view = World(MULTI, [car]).view()
    path = GUARD.lay_out(plan, view, False, frozenset()).path
    case = CheckContext(view, path, POLICY)
    assert case.slow.v.max() <= POLICY.speeds.creep_mps
    assert bool(case.quick.v.max() > POLICY.speeds.creep_mps) is refused
    assert (C.DOOR in GUARD.accept(plan, view, False)[0].codes) is refused


# ---- a junction that the route crosses straight on, or in which it turns


def turning_route(turn_rad: float):
    """150 m along x, a junction of 16 m in which the route turns left, and on; the oncoming lane ends there."""
    s = np.arange(0.0, 301.0)
    heading = np.clip((s - 150.0) / 16.0, 0.0, 1.0) * turn_rad
    step = (heading[1:] + heading[:-1]) / 2
    x = np.concatenate([[0.0], np.cumsum(np.cos(step))])
    y = np.concatenate([[0.0], np.cumsum(np.sin(step))])
    own = strip("own", 0.0, LaneDirection.SAME, LineKind.NONE, len(s))
    other = strip("other", LANE_M, LaneDirection.OPPOSITE, LineKind.BROKEN, len(s))

    def part(name: str, first: int, last: int):
        fields = {key: getattr(other, key)[first:last] for key in ("offset_m", "width_m", "line")}
        return other.model_copy(update={"id": name, "start": first, **fields})

    return straight_road().model_copy(
        update={
            "key": f"turns by {turn_rad:.3f}",
            "reference": tuple(zip(x.tolist(), y.tolist(), strict=True)),
            "lanes": (own, part("near", 0, 151), part("beyond", 166, 301)),
            "zones": (Zone(kind=ZoneKind.JUNCTION, start_m=150.0, end_m=166.0),),
        }
    )


TURNS = [(0.0, False), (0.15, False), (0.9, True), (math.pi / 2, True)]


@pytest.mark.parametrize(("turn_rad", "turns"), TURNS)
def test_unseen_traffic_uses_the_far_lane_only_straight_on(turn_rad: float, turns: bool) -> None:
    """Trust the sight through a junction only if the route crosses it straight on: then the far lane leads to it."""
    world = World(turning_route(turn_rad), [thing("lead", 65.0)])
    sights = (("own", 300.0), ("near", 100.0), ("beyond", 220.0))
    sight = tuple(LaneSight(lane_id=name, ahead_m=ahead, behind_m=50.0) for name, ahead in sights)
    case = CheckContext(
        FrenetScene(world.surroundings().model_copy(update={"sight": sight})),
        GUARD.lay_out([KeepLane(distance_m=20.0, speed_mps=5.0)], world.view(), False, frozenset()).path,
        POLICY,
    )
    near = next(lane for lane in case.view.frame.lanes if lane.strip.id == "near")
    assert (POLICY.prediction.turns_rad < turn_rad) is turns
    found = phantom_vehicles(case, near)
    assert [item.at_m for item in found] == ([100.0] if turns else [100.0, 220.0])


@pytest.mark.parametrize(("turn_rad", "turns"), TURNS)
def test_oncoming_vehicle_goes_straight_only_where_the_route_turns(turn_rad: float, turns: bool) -> None:
    """Predict an oncoming vehicle straight on, off its lane, only if the route turns off in the junction."""
    road = turning_route(turn_rad)
    x, y = (float(value) for value in road.reference[190])
    beside = turn_rad + math.pi / 2
    where = x + LANE_M * math.cos(beside), y + LANE_M * math.sin(beside)
    comes = thing("comes", *where, speed=-6.0 * math.cos(turn_rad), sideways=-6.0 * math.sin(turn_rad))
    comes = comes.model_copy(update={"yaw_rad": turn_rad + math.pi})
    view = World(road, [comes], x=140.0).view()
    path = GUARD.lay_out([KeepLane(distance_m=30.0, speed_mps=5.0)], view, False, frozenset()).path
    assert goes_straight(CheckContext(view, path, POLICY), 0) is turns
