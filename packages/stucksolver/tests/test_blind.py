"""Perception that fails past the commit point: no faster than then, on the proven path, to a stop."""

from __future__ import annotations

import itertools
import math

import pytest

from stucksolver import StuckSolver
from stucksolver.guard import Guard, RejectCode
from stucksolver.plan import Execute
from stucksolver.plan.behaviors import AbortAction, BorrowOncomingLane, KeepLane
from stucksolver.scene import Zone, ZoneKind
from stucksolver.solver import EventKind
from worlds import LANE_M, World, straight_road, stubborn, thing

GUARD = Guard()
LATE_S = 0.7
"""Surroundings of this age are stale for the guard."""
JUNCTION = straight_road(zones=(Zone(kind=ZoneKind.JUNCTION, start_m=60.0, end_m=85.0),))


def passing(x_m: float, y_m: float, speed_mps: float):
    """A pass of a parked car, and the world at a place of it."""
    world = World(straight_road(), [thing("parked", 75.0, stationary_s=60.0, hazard=True)], x=64.0)
    proven = GUARD.accept([BorrowOncomingLane(past_object_id="parked", speed_mps=5.0)], world.view(), False)[1]
    assert proven is not None
    world.x, world.y, world.speed = x_m, y_m, speed_mps
    return world, proven


def drive_blind(world: World, seconds: float, fails, **options):
    """Drive with a solver; perception is lost for good once `fails(world)`. Return events and (time, speed) since."""
    told, speeds, lost = [], [], []

    def seen():
        if lost or fails(world):
            lost.append(world.time_s)
            return None
        return world.surroundings()

    with StuckSolver(
        world.scene, clock="lockstep", on_event=told.append, **{"ladder": stubborn(), **options}
    ) as solver:
        for _ in range(round(seconds / world.dt)):
            directive = solver.step(world.status(), seen)
            world.drive(directive)
            if lost and world.time_s > lost[0] + GUARD.policy.max_age_s + 2 * world.dt:
                speeds.append((world.time_s, world.speed, world.y, directive))
    return told, speeds


def test_recheck_stale_past_commit_point_leads_to_a_stop():
    world, proven = passing(75.0, LANE_M, 4.0)
    world.age_s = LATE_S
    verdict = GUARD.recheck(proven, world.view())
    assert verdict.abort is AbortAction.STOP_SOON and verdict.codes == (RejectCode.STALE,)


def test_recheck_stale_while_giving_way_keeps_braking():
    """At any speed: whoever brakes for others does not go on without seeing them."""
    world, proven = passing(75.0, LANE_M, 2.0)
    world.age_s = LATE_S
    assert GUARD.recheck(proven, world.view(), frozenset({"somebody"})).abort is AbortAction.YIELD


@pytest.mark.parametrize("speed_mps", [0.5, 2.0, 4.0, 5.0])
def test_stopping_soon_in_oncoming_lane_ends_in_own_lane(speed_mps):
    """The path ends at rest in the ego's lane and is never faster than the ego was."""
    world, proven = passing(76.0, LANE_M, speed_mps)
    path = GUARD.stopping_soon(proven.path, world.view())
    assert path is not None
    assert path.speed.max() <= speed_mps and path.speed[-1] == 0.0
    assert abs(path.end_d) < 0.4


@pytest.mark.parametrize("speed_mps", [1.0, 3.0, 5.0])
def test_stopping_soon_in_junction_ends_beyond_it(speed_mps):
    world = World(JUNCTION)
    proven = GUARD.accept([KeepLane(distance_m=60.0, speed_mps=5.0)], world.view(), False)[1]
    assert proven is not None
    world.x, world.speed = 70.0, speed_mps
    path = GUARD.stopping_soon(proven.path, world.view())
    assert path is not None and path.speed.max() <= speed_mps
    assert path.end_s - 4.9 / 2 >= 85.0 and path.end_s < 85.0 + 4.9 / 2 + 2.0


def test_stopping_soon_slower_ego_would_be_met_brakes_at_once():
    """At the planned speed the ego is through before the other arrives; at the present one it would be hit."""
    world = World(JUNCTION)
    proven = GUARD.accept([KeepLane(distance_m=60.0, speed_mps=5.0)], world.view(), False)[1]
    assert proven is not None
    world.x, world.speed = 60.5, 1.0
    world.objects.append(thing("crosser", 68.0, -16.0, sideways=4.0, yaw=math.pi / 2))
    assert GUARD.stopping_soon(proven.path, world.view()) is None


@pytest.mark.integration
@pytest.mark.parametrize("lost_y_m", [0.6, 1.5, 2.5])
def test_solver_blind_in_pass_is_never_faster_and_stands(lost_y_m):
    """Perception dies anywhere in a pass: from then on the ego only slows down, and stands in its own lane."""
    world = World(straight_road(), [thing("lead", 75.0)], x=66.0)
    told, after = drive_blind(world, 60.0, lambda w: w.y > lost_y_m)
    assert EventKind.STARTED in [e.kind for e in told] and after
    led = [(speed, y) for _, speed, y, directive in after if isinstance(directive, Execute)]
    speeds = [speed for speed, _ in led]
    assert all(later <= before + 0.01 for before, later in itertools.pairwise(speeds))
    assert speeds[-1] < 0.4 and abs(led[-1][1]) < 0.5
    texts = [e.text for e in told if e.kind is EventKind.ABORTED]
    assert any("nothing has been seen" in text or "stale" in text for text in texts)


@pytest.mark.integration
def test_solver_blind_pedestrian_ahead_is_met_no_faster_than_then():
    """Somebody who steps out unseen is met at walking pace, not at the speed that the plan would have reached."""
    world = World(straight_road(), [thing("lead", 75.0)], x=66.0)
    lost_mps = []

    def fails(w):
        if w.y > 0.6:
            lost_mps.append(w.speed)
            return True
        return False

    _, after = drive_blind(world, 30.0, fails)
    executing = [speed for _, speed, _, directive in after if isinstance(directive, Execute)]
    assert max(executing) <= lost_mps[0] + 1.5 * (GUARD.policy.max_age_s + 3 * world.dt)


@pytest.mark.integration
def test_solver_sight_returns_plan_goes_on():
    """A second without surroundings slows the pass down and does not end it."""
    world = World(straight_road(), [thing("lead", 75.0)], x=66.0)
    lost = []

    def seen():
        if world.y > 2.0 and not lost:
            lost.append(world.time_s)
        return None if lost and world.time_s < lost[0] + 1.0 else world.surroundings()

    told = []
    with StuckSolver(world.scene, clock="lockstep", on_event=told.append, ladder=stubborn()) as solver:
        for _ in range(round(60.0 / world.dt)):
            world.drive(solver.step(world.status(), seen))
    kinds = [e.kind for e in told]
    assert lost and EventKind.ABORTED not in kinds and EventKind.RECOVERED in kinds
