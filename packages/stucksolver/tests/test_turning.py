"""A turn, from its proposal before a closed road to its end: each leg is laid out from where the last one ended."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest

from stucksolver.guard import Guard, RejectCode
from stucksolver.plan import RecoveryPlan
from stucksolver.plan.behaviors import TurnAround
from stucksolver.scene import CandidateWaypoint, FailedAttempt, ObjectKind, PlanFailure
from stucksolver.solver.state_machine.execution import Execution
from stucksolver.solver.state_machine.execution_steps import ExecutionOutcome
from test_guard_turning import WIDE, road_of
from test_other_roads import row
from worlds import World, searched, straight_road, thing

K = ObjectKind
GUARD = Guard()
LEVER_M = 1.45


@dataclass
class Turner(World):
    """A car that keeps to the line of a leg: its center ahead, its rear axle backing up; with an error at will."""

    line: tuple = ()
    driven: float = 0.0
    error_m: float = 0.0

    def drive(self, directive):
        if not isinstance(getattr(directive, "behavior", None), TurnAround):
            super().drive(directive)
            return
        if directive.path != self.line:
            self.line, self.driven = directive.path, 0.0
        x, y = (np.array([getattr(p, name) for p in self.line]) for name in ("x_m", "y_m"))
        s = np.concatenate([[0.0], np.hypot(np.diff(x), np.diff(y)).cumsum()])
        bound = float(np.interp(self.driven, s, [p.speed_mps for p in self.line]))
        step = min(bound, abs(self.speed) + 1.5 * self.dt) * self.dt
        self.driven += step
        self.speed = (-step if directive.reverse else step) / self.dt
        if directive.reverse:
            self._back_to(x, y, s)
        else:
            self._on_to(x, y, s, step)
        self.objects = [self._moved(o) for o in self.objects]
        self.time_s, self.frame = round(self.time_s + self.dt, 6), self.frame + 1

    def _on_to(self, x, y, s, step):
        ahead = [float(np.interp(self.driven + 0.3, s, column)) for column in (x, y)]
        here = [float(np.interp(self.driven, s, column)) for column in (x, y)]
        course = math.atan2(ahead[1] - here[1], ahead[0] - here[0]) if self.driven + 0.3 < s[-1] else self.yaw
        self.yaw += math.sin(course - self.yaw) / LEVER_M * step
        self.x, self.y = here[0], here[1] + self.error_m * self.driven / s[-1]

    def _back_to(self, x, y, s):
        axle = [float(np.interp(self.driven + LEVER_M, s, column)) for column in (x, y)]
        before = [float(np.interp(self.driven + LEVER_M - 0.3, s, column)) for column in (x, y)]
        self.yaw = math.atan2(before[1] - axle[1], before[0] - axle[0])
        self.x, self.y = axle[0] + LEVER_M * math.cos(self.yaw), axle[1] + LEVER_M * math.sin(self.yaw)


def carry_out(world, seconds=90.0, every_tick=None):
    """The outcome, the orders' directions in turn, and the nearest that anybody was."""
    execution = Execution(RecoveryPlan(behaviors=(TurnAround(),)), GUARD, guided=False)
    verdict = execution.start(world.view(), world.time_s)
    assert verdict.accepted, str(verdict)
    ways, nearest = [], math.inf
    while world.time_s < seconds:
        result = execution.tick(world.view(), world.time_s)
        if isinstance(result, ExecutionOutcome):
            return result, ways, nearest
        if result.path and (not ways or ways[-1] != result.reverse):
            ways.append(result.reverse)
        world.drive(result)
        nearest = min(nearest, world.clearance())
        if every_tick is not None:
            every_tick(execution, world)
    raise AssertionError(f"it never ended: {result}")


@pytest.mark.parametrize(("lane_m", "legs"), [(6.0, 3), (5.0, 3), (4.5, 5)])
def test_it_turns_round_in_legs_ahead_and_back(lane_m, legs):
    world = Turner(road_of(lane_m))
    outcome, ways, _ = carry_out(world)
    assert outcome.finished, outcome.text
    assert ways == [bool(k % 2) for k in range(len(ways))] and legs <= len(ways) <= legs + 2
    assert math.cos(world.yaw) < -0.9
    assert lane_m / 2 - 1.0 < world.y < 1.5 * lane_m


@pytest.mark.parametrize("error_m", [-0.2, 0.2])
def test_each_leg_begins_where_the_last_one_really_ended(error_m):
    outcome, _, _ = carry_out(Turner(WIDE, error_m=error_m))
    assert outcome.finished, outcome.text


@pytest.mark.integration
def test_who_walks_up_while_it_turns_is_let_by():
    stood = []

    def walks_up(execution, world):
        if 3.0 < world.time_s < 3.1 and not world.objects:
            world.objects = [thing("walker", world.x + 5.0, 11.0, kind=K.PEDESTRIAN, sideways=-1.2)]
        if world.objects and abs(world.speed) < 0.1:
            stood.append(world.time_s)

    outcome, _, nearest = carry_out(Turner(WIDE), every_tick=walks_up)
    assert outcome.finished, outcome.text
    assert stood and nearest > 0.9


@pytest.mark.integration
def test_turn_around_passing_car_does_not_hold_ego_forever():
    """A car that comes while the ego is across the road does not keep it there forever."""

    def arrives(execution, world):
        if 12.0 < world.time_s < 12.1 and not world.objects:
            world.objects = [thing("car", 105.0, 5.0, speed=-6.0)]
        if world.objects and world.objects[0].x_m < 66.0:
            world.objects = [thing("car", 65.0, 5.0, yaw=math.pi, stationary_s=1.0)]

    outcome, _, nearest = carry_out(Turner(WIDE), every_tick=arrives)
    assert outcome.finished, outcome.text
    assert nearest > 0.3


def behind(name="back", length_m=600.0, x_m=-9.0):
    return CandidateWaypoint(
        id=name, lane_id=name, x_m=x_m, y_m=5.0, distance_m=12.0, reaches_destination=True, route_length_m=length_m
    )


def decide(things, *waypoints, stopped_s=25.0, road=None, **more):
    world = World(road or straight_road(), things)
    scene = world.scene()
    ego = scene.ego.model_copy(update={"stopped_for_s": stopped_s})
    scene = scene.model_copy(update={"ego": ego, "waypoints": waypoints, **more})
    return searched(world, scene)


CLOSED = row(-1.2, 5.0)


def names(decision):
    return [] if decision.plan is None else [b.name for b in decision.plan.behaviors]


def test_closed_road_turns_around_to_nearest_other_road():
    """Before a closed road, the ego turns around and drives on by another road."""
    decision = decide(CLOSED, behind("far", 900.0), behind("near", 500.0))
    assert names(decision) == ["turn_round"]
    assert decision.plan.replan_route and decision.plan.route_start == "near"


def test_another_way_through_the_junction_comes_before_turning_round():
    other = behind("side", 800.0, x_m=5.0)
    assert names(decide(CLOSED, behind(), other)) == ["replan"]


def test_without_a_way_back_nobody_turns_round():
    lost = behind().model_copy(update={"reaches_destination": False, "route_length_m": None})
    assert "turn_round" not in names(decide(CLOSED))
    assert "turn_round" not in names(decide(CLOSED, lost))


def test_too_near_to_turn_it_backs_up_first():
    near = [item.model_copy(update={"x_m": 56.5}) for item in CLOSED]
    assert names(decide(near, behind())) == ["back_up", "turn_round"]


def test_turn_around_after_no_room_is_not_tried_again():
    """Where the road was too narrow, a turn is not tried again."""
    failed = FailedAttempt(
        time_s=0.0,
        behaviors=("turn_round",),
        codes=(RejectCode.NO_PATH,),
        failures=(PlanFailure.NO_ROOM_TO_TURN,),
        outcome="",
    )
    assert "turn_round" not in names(decide(CLOSED, behind(), attempts=(failed,)))


def test_road_without_a_way_past_is_left_after_20_s():
    """After an object has left no way past for a while, the ego turns around."""
    tree = [thing("tree", 62.0, kind=K.DEBRIS, length=1.0, width=5.0)]
    narrow = straight_road(oncoming=None)
    assert "turn_round" not in names(decide(tree, behind(), road=narrow, stopped_s=15.0))
    assert names(decide(tree, behind(), road=narrow, stopped_s=21.0)) == ["turn_round"]


def test_who_stands_in_a_queue_does_not_turn_round():
    queue = [thing("car", 60.0, stationary_s=200.0), thing("next", 67.0, moved_s_ago=20.0)]
    assert "turn_round" not in names(decide(queue, behind(), road=straight_road(oncoming=None), stopped_s=100.0))
