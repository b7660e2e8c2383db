"""The guard against an oracle that knows nothing of it: a brute-force simulation of the ego and everybody else.

The ego is simulated step by step on the accepted path, as quick or as sluggish as the vehicle may be; others do what
`docs/SAFETY.md` assumes of them. Nobody may be touched, and each bound that is written there must hold.
"""

from __future__ import annotations

import math
import os
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from shapely import affinity
from shapely.geometry import box

from stucksolver.guard import Guard
from stucksolver.plan.behaviors import (
    BackUp,
    BorrowOncomingLane,
    ChangeLane,
    Creep,
    DriveOver,
    KeepLane,
    Nudge,
    PullOver,
    RejoinRoute,
)
from stucksolver.scene import LineKind, ObjectKind, Zone, ZoneKind
from worlds import LANE_M, World, straight_road, thing

K = ObjectKind
GUARD = Guard()
DT = 0.1
LENGTH_M = 4.9
WIDTH_M = 1.85
A_MPS2, B_MPS2 = 1.5, 3.0
"""Comfort of the ego's limits."""
OTHERS_BRAKE_MPS2 = 3.5
HORIZON_S = 30.0
ZONES = st.sampled_from([(), *(((kind, s),) for kind in ZoneKind for s in (46.0, 60.0, 75.0, 100.0))])
EXAMPLES = int(os.environ.get("GUARD_EXAMPLES", "20"))
some = settings(max_examples=EXAMPLES, suppress_health_check=list(HealthCheck))

speeds = st.floats(1.0, 5.5)
sides = st.sampled_from(["left", "right"])
moving = st.one_of(
    st.builds(BorrowOncomingLane, past_object_id=st.just("lead"), speed_mps=speeds),
    st.builds(KeepLane, distance_m=st.floats(10.0, 60.0), speed_mps=speeds),
    st.builds(ChangeLane, side=sides, distance_m=st.floats(20.0, 60.0), speed_mps=speeds),
    st.builds(
        Nudge, side=st.sampled_from(["left", "right"]), offset_m=st.floats(0.2, 1.5), distance_m=st.floats(4, 30)
    ),
    st.builds(Creep, distance_m=st.floats(1.0, 15.0)),
    st.builds(BackUp, distance_m=st.floats(1.0, 8.0) | st.floats(8.0, 40.0)),
    st.builds(PullOver, distance_m=st.floats(10.0, 40.0)),
    st.builds(RejoinRoute),
    st.just(DriveOver(object_id="bag")),
)
bags = st.builds(
    thing,
    st.just("bag"),
    st.floats(56.0, 75.0),
    st.floats(-1.5, 1.5),
    kind=st.sampled_from([K.BAG, K.LITTER, K.DEBRIS, K.UNKNOWN]),
    height=st.floats(0.05, 0.3),
    kind_confidence=st.none() | st.floats(0.5, 1.0),
    seen_for_s=st.floats(0.0, 3.0),
)
leads = st.builds(
    thing, st.just("lead"), st.floats(58.0, 75.0), st.floats(-0.8, 0.8), stationary_s=st.floats(0.0, 40.0)
)
standing = st.builds(
    thing,
    st.sampled_from(["a", "b"]),
    st.floats(30.0, 110.0),
    st.floats(-5.0, 5.0),
    kind=st.sampled_from([K.CAR, K.CONE, K.PEDESTRIAN, K.VAN]),
)
movers = st.builds(thing, st.just("c"), st.floats(90.0, 350.0), st.just(LANE_M), speed=st.floats(-13.0, -1.0)) | (
    st.builds(
        thing,
        st.just("d"),
        st.floats(40.0, 110.0),
        st.floats(-25.0, 25.0),
        kind=st.sampled_from([K.PEDESTRIAN, K.BICYCLE, K.CAR]),
        sideways=st.floats(-4.0, 4.0),
    )
)


def world_of(kind, zones, objects, speed, y):
    marked = tuple(Zone(kind=k, start_m=s, end_m=s + 8.0) for k, s in zones)
    road = straight_road(left=LineKind.BROKEN, zones=marked) if kind == "multi" else straight_road(zones=marked)
    return World(road, objects, speed=speed, y=y)


worlds = st.builds(
    world_of,
    st.sampled_from(["multi", "two way"]),
    ZONES,
    st.tuples(leads | bags, st.lists(standing | movers, max_size=2, unique_by=lambda o: o.id)).map(
        lambda x: [x[0], *x[1]]
    ),
    st.just(0.0) | st.floats(0.0, 5.0),
    st.floats(-0.3, 0.3),
)


@dataclass
class Ego:
    """One tick of the simulated ego, in the world's own frame."""

    t: float
    x: float
    y: float
    yaw: float
    v: float
    bound: float


def accepted(behavior, world):
    _, proven = GUARD.accept([behavior], world.view(), False)
    assume(proven is not None)
    return proven


def local_path(proven, world):
    """(x, y, speed) of the path in the world's frame: on a straight road that is arc length and offset."""
    turn = -1.0 if proven.reverse else 1.0
    return turn * proven.path.s, turn * proven.path.d, proven.path.speed


def simulate(proven, world, eager, keen, stop_at_s=None, braking=B_MPS2):
    """The ego's ticks along the path. `eager`, `keen` in [0, 1]: how much of its acceleration and speed it uses.

    From `stop_at_s` on it brakes to a stop.
    """
    x, y, bound = local_path(proven, world)
    way = np.abs(x - x[0])
    allowed = (0.85 + 0.15 * keen) * bound
    acceleration = (0.6 + 0.4 * eager) * A_MPS2
    done, v, t = 0.0, max(abs(world.speed), 0.0), 0.0
    heading = np.arctan2(np.gradient(y), np.gradient(x))
    ticks = []
    while t < HORIZON_S:
        at = lambda column: float(np.interp(done, way, column))  # noqa: B023, E731
        ticks.append(Ego(t, at(x), at(y), at(heading), v, at(bound)))
        if done >= way[-1] - 1e-6 or (stop_at_s is not None and t >= stop_at_s and v <= 0.0):
            break
        if stop_at_s is not None and t >= stop_at_s:
            v = max(v - braking * DT, 0.0)
        else:
            ahead = done + np.linspace(0.0, max(v * v / (2 * B_MPS2), 0.5), 12)
            least = np.sqrt(np.interp(ahead, way, allowed) ** 2 + 2 * B_MPS2 * (ahead - done)).min()
            v = max(min(v + acceleration * DT, float(least)), v - B_MPS2 * DT, 0.05)
        done += v * DT
        t += DT
    return ticks


def rectangle(x, y, yaw, length, width):
    flat = box(-length / 2, -width / 2, length / 2, width / 2)
    return affinity.translate(affinity.rotate(flat, yaw, origin=(0, 0), use_radians=True), x, y)


def ego_body(tick):
    return rectangle(tick.x, tick.y, tick.yaw, LENGTH_M, WIDTH_M)


def other_body(o, t=0.0, brakes_from_s=math.inf, brakes_mps2=0.0):
    """An actor after `t` s: steadily on, along and across its lane, braking along it from some moment on."""
    before = min(t, brakes_from_s)
    speed, since = abs(o.vx_mps), max(t - brakes_from_s, 0.0)
    since = min(since, speed / brakes_mps2) if brakes_mps2 else 0.0
    way = speed * before + speed * since - 0.5 * brakes_mps2 * since**2
    across = o.vy_mps if abs(o.vy_mps) > 0.3 else 0.0
    return rectangle(o.x_m + math.copysign(way, o.vx_mps), o.y_m + across * t, o.yaw_rad, o.length_m, o.width_m)


def still(o):
    return math.hypot(o.vx_mps, o.vy_mps) <= 0.1


def comes_from_behind(o, world, proven):
    """Left to themselves: those behind who go our way (ahead of us when we back up)."""
    if proven.reverse:
        return o.x_m - o.length_m / 2 > world.x + LENGTH_M / 2 and o.vx_mps < 0.5
    return o.x_m + o.length_m / 2 < world.x - LENGTH_M / 2 and o.vx_mps > -0.5


def over(behavior):
    return {behavior.object_id} if isinstance(behavior, DriveOver) else set()


@pytest.mark.integration
@some
@given(world=worlds, behavior=moving, eager=st.floats(0, 1), keen=st.floats(0, 1), data=st.data())
def test_oracle_accepted_plan_touches_no_assumed_road_user(world, behavior, eager, keen, data):
    """The ego of an accepted plan touches no road user that behaves as assumed."""
    proven = accepted(behavior, world)
    ticks = simulate(proven, world, eager, keen)
    start = ego_body(ticks[0])
    when = data.draw(st.just(math.inf) | st.floats(0.0, 8.0), label="brakes from")
    how = data.draw(st.floats(0.5, OTHERS_BRAKE_MPS2), label="brakes with")
    others = [o for o in world.objects if o.id not in over(behavior) and not comes_from_behind(o, world, proven)]
    anyway: set[str] = set()
    for tick in ticks:
        body = ego_body(tick)
        for o in others:
            other = other_body(o) if still(o) else other_body(o, tick.t, when, how)
            if o.id in anyway or start.intersects(other):
                anyway.add(o.id)  # it hits the ego where it stands: no plan brings that about
                continue
            touched = body.intersects(other) and not start.distance(other_body(o)) < 0.35
            assert not touched, (o.id, tick)


@pytest.mark.integration
@some
@given(world=worlds, behavior=moving, eager=st.floats(0, 1), share=st.floats(0, 1))
def test_oracle_stop_before_commit_point_is_safe(world, behavior, eager, share):
    """A stop at any time before the commit point is safe."""
    proven = accepted(behavior, world)
    free = simulate(proven, world, eager, eager)
    turn = -1.0 if proven.reverse else 1.0
    before = [tick for tick in free if not proven.committed(turn * tick.x)]
    assume(before)
    moment = before[min(int(share * len(before)), len(before) - 1)].t
    ticks = simulate(proven, world, eager, eager, stop_at_s=moment)
    end = ego_body(ticks[-1])
    for zone in world.road.zones:
        assert not end.intersects(box(zone.start_m, -20.0, zone.end_m, 20.0)), (zone.kind, moment)
    for lane in world.road.lanes:
        if lane.direction.value == "opposite":
            assert end.bounds[3] <= lane.offset_m[0] - LANE_M / 2 + 0.1, moment
    start = ego_body(ticks[0])
    for tick in ticks:
        for o in world.objects:
            if o.id in over(behavior) or comes_from_behind(o, world, proven) or tick.v <= 0.0:
                continue
            other = other_body(o, 0.0 if still(o) else tick.t)
            assert not ego_body(tick).intersects(other) or start.distance(other_body(o)) < 0.35, (o.id, tick)


def held(zone, world):
    """True if the ego stands in a zone at the start."""
    return abs(world.x - (zone.start_m + zone.end_m) / 2) < (zone.end_m - zone.start_m + LENGTH_M) / 2


def forbidden(behavior, world):
    """Zones in which a path may not end. One that creeps or backs up may end where it began, except on rails."""
    zones = world.road.zones
    if behavior.name not in {"back_up", "creep"}:
        return zones
    return [z for z in zones if z.kind is ZoneKind.LEVEL_CROSSING or not held(z, world)]


@pytest.mark.integration
@some
@given(world=worlds, behavior=moving)
def test_each_bound_of_an_accepted_plan_holds(world, behavior):
    proven = accepted(behavior, world)
    ticks = simulate(proven, world, 1.0, 1.0)
    assert proven.path.speed.max() <= 20 / 3.6 + 1e-9
    if behavior.name in {"creep", "back_up", "drive_over"}:
        assert proven.path.speed.max() <= 8 / 3.6
    bodies = [ego_body(tick) for tick in ticks]
    low, high = -LANE_M / 2 - 0.2, max(lane.offset_m[0] for lane in world.road.lanes) + LANE_M / 2 + 0.2
    assert all(low <= body.bounds[1] and body.bounds[3] <= high for body in bodies)
    if behavior.name in {"creep", "nudge", "back_up", "pull_over"}:
        end = ego_body(ticks[-1])
        assert not any(end.intersects(box(z.start_m + 0.5, -20, z.end_m - 0.5, 20)) for z in forbidden(behavior, world))
    if behavior.name == "nudge":
        assert all(body.bounds[3] <= LANE_M / 2 + 0.15 and body.bounds[1] >= -LANE_M / 2 - 0.15 for body in bodies)
    for z in world.road.zones:
        if z.kind is ZoneKind.LEVEL_CROSSING:
            driven = bodies[-1:] if held(z, world) else bodies
            assert not any(body.intersects(box(z.start_m, -20, z.end_m, 20)) for body in driven)


@pytest.mark.integration
@settings(max_examples=150, suppress_health_check=list(HealthCheck))
@given(bag=bags, walker=st.none() | st.tuples(st.floats(-4, 4), st.floats(-4, 4)))
def test_whatever_is_driven_over_is_all_that_the_rule_asks(bag, walker):
    objects = [bag]
    if walker is not None:
        objects.append(thing("walker", bag.x_m + walker[0], bag.y_m + walker[1], kind=K.PEDESTRIAN))
    verdict, _ = GUARD.accept([DriveOver(object_id="bag")], World(straight_road(), objects).view(), False)
    soft = bag.kind in (K.BAG, K.LITTER) and (bag.kind_confidence or 0.0) >= 0.8
    low = bag.height_m <= 0.15 and bag.seen_for_s >= 1.0
    alone = walker is None or other_body(objects[1]).distance(other_body(bag)) >= 2.0 - 1e-6
    assert not verdict.accepted or (soft and low and alone)


@pytest.mark.integration
@some
@given(
    y=st.floats(1.6, 5.0),
    kind=st.sampled_from([K.CAR, K.VAN, K.TRUCK]),
    speed=st.floats(1.0, 5.5),
    eager=st.floats(0, 1),
    side=st.sampled_from([-1, 1]),
)
def test_oracle_no_door_opens_into_ego_above_walking_pace(y, kind, speed, eager, side):
    """No door opens into an ego that is faster than walking pace."""
    parked = thing("parked", 68.0, side * y, kind=kind)
    world = World(straight_road(), [parked])
    proven = accepted(KeepLane(distance_m=40.0, speed_mps=speed), world)
    doors = rectangle(parked.x_m, parked.y_m, 0.0, parked.length_m / 2, parked.width_m + 2 * 0.9)
    for tick in simulate(proven, world, eager, 1.0):
        assert tick.v <= 8 / 3.6 + 1e-6 or not ego_body(tick).intersects(doors)


@pytest.mark.parametrize("speed", [2.2, 4.0, 5.5])
@pytest.mark.parametrize("y", [2.2, 2.35, 2.5, 2.65, 3.0])
def test_oracle_pedestrian_stepping_off_is_not_hit_by_front(y, speed):
    """A pedestrian who steps off the curb is never hit by the front.

    Wherever the ego is then, either braking after half a second or going on avoids the contact.
    """
    walker = thing("walker", 75.0, -y, kind=K.PEDESTRIAN)
    world = World(straight_road(), [walker])
    _, proven = GUARD.accept([KeepLane(distance_m=40.0, speed_mps=speed)], world.view(), False)
    if proven is None:
        assert y < 2.7
        return
    on = simulate(proven, world, 1.0, 1.0)
    reach = (LENGTH_M + walker.length_m) / 2
    beside = (WIDTH_M + walker.width_m) / 2

    def front_meets(ticks, steps_s):
        for tick in ticks:
            if abs(walker.x_m - tick.x) < reach and y - 1.4 * max(tick.t - steps_s, 0.0) < beside:
                return tick.v > 1.5 and walker.x_m > tick.x + LENGTH_M / 2 - 0.25
        return False

    for ahead_m in np.arange(0.5, 8.0, 0.5):
        steps_s = next(tick.t for tick in on if tick.x >= walker.x_m - reach - ahead_m)
        braked = simulate(proven, world, 1.0, 1.0, steps_s + 0.5, braking=6.0)
        assert not (front_meets(on, steps_s) and front_meets(braked, steps_s)), ahead_m


@pytest.mark.parametrize("behavior", [KeepLane(distance_m=40.0, speed_mps=5.0), BackUp(distance_m=6.0)])
def test_the_oracle_itself_sees_a_collision(behavior):
    """With a car put into the way after acceptance, it does."""
    world = World(straight_road())
    _, proven = GUARD.accept([behavior], world.view(), False)
    wall = thing("wall", 44.0 if behavior.reverse else 70.0)
    assert any(ego_body(tick).intersects(other_body(wall)) for tick in simulate(proven, world, 1.0, 1.0))
