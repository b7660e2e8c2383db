"""Those of our own direction, when the path moves sideways: nobody abreast or coming up beside us is moved onto."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from stucksolver.guard import Guard, RejectCode
from stucksolver.plan.behaviors import ChangeLane, KeepLane, Nudge, PullOver
from stucksolver.scene import LaneKind, LineKind, ObjectKind
from test_guard_oracle import ego_body, other_body, simulate
from worlds import LANE_M, World, straight_road, thing

K = ObjectKind
pytestmark = pytest.mark.usefixtures("alike")
GUARD = Guard()
MULTI = straight_road(left=LineKind.BROKEN, oncoming=None)
OVER = PullOver(distance_m=20.0)
ASIDE = Nudge(side="right", offset_m=0.8, distance_m=15.0, speed_mps=3.0)
LEFT = ChangeLane(side="left", distance_m=40.0, speed_mps=5.0)


def shoulder_road():
    """Our lane, and a shoulder 2 m wide on its right."""
    road = straight_road()
    own = road.lanes[0]
    right = own.model_copy(
        update={
            "id": "shoulder",
            "kind": LaneKind.SHOULDER,
            "offset_m": (-2.75,) * len(own.offset_m),
            "width_m": (2.0,) * len(own.width_m),
        }
    )
    return road.model_copy(update={"key": "shoulder", "lanes": (*road.lanes, right)})


SHOULDER = shoulder_road()


@pytest.mark.parametrize("x", np.arange(30.0, 60.0, 2.0))
@pytest.mark.parametrize("speed", [2.0, 4.0, 6.0])
def test_pulling_over_is_never_onto_a_cyclist_beside_us(x, speed):
    cyclist = thing("cyclist", x, -1.9, kind=K.BICYCLE, speed=speed)
    world = World(SHOULDER, [cyclist], speed=3.0)
    assert not drives_into(OVER, world)


@pytest.mark.parametrize("x", np.arange(30.0, 60.0, 2.0))
@pytest.mark.parametrize("speed", [3.0, 6.0])
def test_nobody_who_filters_past_in_our_lane_is_cut_up(x, speed):
    bike = thing("bike", x, -1.35, kind=K.MOTORCYCLE, speed=speed, length=2.2, width=0.8)
    assert not drives_into(ASIDE, World(straight_road(), [bike], y=0.6))


@pytest.mark.parametrize("x", np.arange(30.0, 48.0, 2.0))
@pytest.mark.parametrize("y", [-1.3, -1.4, -1.55, -1.7])
def test_pull_over_cyclist_in_narrow_gap_is_not_cut_off(x, y):
    """A cyclist that comes up with less than the required gap beside the ego is not cut off.

    A gap just beside the body is still a way past the ego, and it stays open.
    """
    cyclist = thing("cyclist", x, y, kind=K.BICYCLE, speed=6.0)
    slowly = PullOver(distance_m=45.0, speed_mps=2.2)
    assert not drives_into(slowly, World(straight_road(), [cyclist]))


@pytest.mark.parametrize("x", np.arange(20.0, 75.0, 2.5))
@pytest.mark.parametrize("speed", [1.0, 4.0, 9.0])
def test_a_lane_is_not_changed_into_who_is_in_it(x, speed):
    assert not drives_into(LEFT, World(MULTI, [thing("other", x, LANE_M, speed=speed)], speed=4.0))


@pytest.mark.parametrize(("x", "y"), [(80.0, 0.0), (75.0, 0.4), (60.0, 0.0)])
def test_who_leads_is_followed_as_before(x, y):
    world = World(straight_road(), [thing("leader", x, y, speed=4.0)])
    assert GUARD.accept([KeepLane(distance_m=60.0, speed_mps=5.0)], world.view(), False)[0].accepted


def test_pull_over_cyclist_far_behind_or_past_is_accepted():
    for x in (5.0, 75.0):
        world = World(SHOULDER, [thing("cyclist", x, -1.9, kind=K.BICYCLE, speed=4.0)])
        assert GUARD.accept([OVER], world.view(), False)[0].accepted, x


def test_recheck_cyclist_beside_ego_ends_pull_over():
    """A cyclist that comes up beside the ego ends the move before it is made."""
    world = World(SHOULDER)
    proven = GUARD.accept([OVER], world.view(), False)[1]
    world.objects.append(thing("cyclist", 44.0, -1.9, kind=K.BICYCLE, speed=5.0))
    world.x, world.speed = 51.0, 1.5
    verdict = GUARD.recheck(proven, world.view())
    assert {r.code for r in verdict.rejects} & {RejectCode.LANE_ENTRY, RejectCode.COLLISION, RejectCode.CLEARANCE}


def drives_into(behavior, world):
    """Is an accepted plan driven into someone who goes on steadily, and brakes by 3.5 m/s² from a second after it sees
    us in its way?"""
    proven = GUARD.accept([behavior], world.view(), False)[1]
    if proven is None:
        return False
    for eager in (0.0, 1.0):
        for other in world.objects:
            if touches(simulate(proven, world, eager, eager), other):
                return True
    return False


def touches(ticks, other):
    x, v, seen_s = other.x_m, other.vx_mps, math.inf
    began_behind = other.x_m + other.length_m / 2 < ticks[0].x - 2.45
    start = ego_body(ticks[0])
    for before, tick in itertools.pairwise(ticks):
        body = ego_body(tick)
        here = other_body(other.model_copy(update={"x_m": x}))
        if body.intersects(here):
            # One in whose lane we were from the start, or whom we follow: not this check's business.
            return not (start.bounds[1] < other.y_m < start.bounds[3])
        way = here.bounds[1], here.bounds[3]
        if began_behind and body.bounds[1] < way[1] and body.bounds[3] > way[0] and x < tick.x:
            seen_s = min(seen_s, tick.t)
        if tick.t > seen_s + 1.0:
            v = max(v - 3.5 * (tick.t - before.t), 0.0)
        if not began_behind and x - other.length_m / 2 > tick.x + 2.45:
            return False  # ahead of us: it is followed
        x += v * (tick.t - before.t)
    return False


@pytest.mark.parametrize("kind", [K.PEDESTRIAN, K.ANIMAL])
@pytest.mark.parametrize(
    ("plan", "aside_m"),
    [(PullOver(distance_m=33.0, speed_mps=4.7), -2.4), (KeepLane(distance_m=40.0, speed_mps=4.0), -0.5)],
)
def test_who_walks_along_the_road_is_nobody_to_follow(kind, plan, aside_m):
    """A stack keeps its distance to traffic ahead. Somebody on foot is none."""
    walker = thing("walker", 72.0, aside_m, kind=kind, speed=1.0)
    assert not GUARD.accept([plan], World(SHOULDER, [walker], speed=4.0).view(), False)[0].accepted
    rider = thing("rider", 72.0, aside_m, kind=K.BICYCLE, speed=4.0)
    assert GUARD.accept([plan], World(SHOULDER, [rider], speed=4.0).view(), False)[0].accepted
