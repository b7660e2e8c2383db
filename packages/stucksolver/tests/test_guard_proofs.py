"""What an accepted plan promises: driven as proven, it meets nothing that moves as assumed."""

from __future__ import annotations

import os

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, event, given, settings
from hypothesis import strategies as st
from shapely import affinity
from shapely.geometry import box

from guard_cases import commit_s
from stucksolver.guard import Guard
from stucksolver.guard.context import CheckContext
from stucksolver.guard.path_tracking import tracked_path
from stucksolver.plan.behaviors import BorrowOncomingLane, ChangeLane, KeepLane
from stucksolver.scene import LaneDirection, LightState, LineKind, ObjectKind
from stucksolver.scene.boxes import separation
from stucksolver.scene.frenet_scene import FrenetScene
from worlds import LANE_M, World, red_light, straight_road, thing

TWO_WAY = straight_road()
MULTI = straight_road(left=LineKind.BROKEN)
GUARD = Guard()
BRAKING_MPS2, CROSSING_MPS = 3.5, 0.3
"""How others may brake, and from which lateral speed on they are taken to cross: docs/SAFETY.md."""
MANY = int(os.environ.get("GUARD_EXAMPLES", "25"))
FEW = MANY // 2
"""`make integration` looks at more of them than `make unit`: the count is arbitrary, the promise is not."""
many = settings(max_examples=MANY, suppress_health_check=list(HealthCheck))

speeds = st.floats(2.0, 11.0)
behaviors = st.one_of(
    st.builds(BorrowOncomingLane, past_object_id=st.just("lead"), speed_mps=speeds),
    st.builds(KeepLane, distance_m=st.floats(10.0, 60.0), speed_mps=speeds),
    st.builds(ChangeLane, side=st.sampled_from(["left", "right"]), distance_m=st.floats(20.0, 60.0), speed_mps=speeds),
)
standing = st.builds(
    thing,
    st.sampled_from(["a", "b"]),
    st.floats(60.0, 110.0),
    st.floats(-4.0, 5.0),
    kind=st.sampled_from([ObjectKind.CAR, ObjectKind.CONE, ObjectKind.PEDESTRIAN]),
    yaw=st.floats(-0.4, 0.4),
)
oncoming = st.builds(thing, st.just("c"), st.floats(90.0, 350.0), st.just(LANE_M), speed=st.floats(-13.0, -1.0))
crossing = st.builds(
    thing,
    st.just("d"),
    st.floats(60.0, 110.0),
    st.floats(-25.0, 25.0),
    kind=st.sampled_from([ObjectKind.PEDESTRIAN, ObjectKind.BICYCLE, ObjectKind.CAR]),
    sideways=st.floats(-4.0, 4.0),
)
riders = st.builds(
    thing, st.just("lead"), st.floats(62.0, 75.0), kind=st.just(ObjectKind.BICYCLE), speed=st.floats(0.0, 4.0)
)
leads = st.builds(thing, st.just("lead"), st.floats(58.0, 75.0), st.floats(-1.0, 1.0)) | riders
worlds = st.builds(
    World,
    st.sampled_from([TWO_WAY, MULTI]),
    st.tuples(leads, st.lists(standing | oncoming | crossing, max_size=3)).map(lambda x: [x[0], *x[1]]),
    speed=st.just(0.0) | st.floats(0.0, 6.0),
    y=st.floats(-0.3, 0.3),
)


def accepted(behavior, world, guided=True):
    """The proven plan as a case; examples whose plan is refused are left out."""
    view = world.view()
    verdict, proven = GUARD.accept([behavior], view, guided)
    event(str(verdict).split(":", maxsplit=1)[0])
    assume(proven is not None)
    return CheckContext(view, proven.path, GUARD.policy, guided), proven


def body(x, y, yaw, length, width):
    flat = box(-length / 2, -width / 2, length / 2, width / 2)
    return affinity.translate(affinity.rotate(flat, yaw, origin=(0, 0), use_radians=True), x, y)


def where(o, t, braking):
    """An object that goes on as it does, or brakes to a stop along its lane."""
    if braking:
        speed = abs(o.vx_mps)
        until = min(t, speed / BRAKING_MPS2)
        return o.x_m + np.sign(o.vx_mps) * (speed * until - 0.5 * BRAKING_MPS2 * until**2), o.y_m
    sideways = o.vy_mps if abs(o.vy_mps) > CROSSING_MPS else 0.0
    return o.x_m + o.vx_mps * t, o.y_m + sideways * t


def answers_for_itself(o, case):
    """Left to the stack, which follows, and to those who come from behind."""
    from_behind = o.x_m < case.view.ego_s and o.vx_mps > -0.5
    followed = o.vx_mps > 0.5 and o.id not in case.path.passes
    return from_behind or followed or o.vx_mps == 0.0 == o.vy_mps


@pytest.mark.integration
@many
@given(world=worlds, behavior=behaviors, share=st.floats(0.0, 1.0), braking=st.booleans())
def test_accepted_plan_at_any_profile_touches_no_assumed_mover(world, behavior, share, braking):
    """No profile between the slow and the fast ego touches an object that moves as assumed."""
    case, _ = accepted(behavior, world)
    when = case.slow.t + share * (case.quick.t - case.slow.t)
    movers = [o for o in world.objects if not answers_for_itself(o, case)]
    ego = case.view.ego
    for k in range(0, len(when), 2):
        if when[k] > GUARD.policy.prediction.horizon_s:
            break
        own = body(case.path.s[k], case.path.d[k], case.heading[k], ego.length_m, ego.width_m)
        for o in movers:
            x, y = where(o, when[k], braking)
            other = body(x, y, o.yaw_rad, o.length_m, o.width_m)
            assert not own.intersects(other), (o.id, when[k])


@pytest.mark.integration
@many
@given(world=worlds, behavior=behaviors)
def test_no_accepted_path_leads_into_what_stands(world, behavior):
    case, _ = accepted(behavior, world)
    ego = case.view.ego
    still = [o for o in world.objects if o.vx_mps == o.vy_mps == 0.0]
    bodies = [body(o.x_m, o.y_m, o.yaw_rad, o.length_m, o.width_m) for o in still]
    start = body(case.path.s[0], case.path.d[0], case.heading[0], ego.length_m, ego.width_m)
    for k in range(len(case.path.s)):
        own = body(case.path.s[k], case.path.d[k], case.heading[k], ego.length_m, ego.width_m)
        for other in bodies:
            assert not own.intersects(other) or start.distance(other) < 0.3


@pytest.mark.integration
@settings(max_examples=MANY, suppress_health_check=list(HealthCheck))
@given(sight=st.floats(0.0, 400.0), x=st.floats(60.0, 80.0), speed=st.floats(2.0, 11.0), limit=st.floats(5.0, 25.0))
def test_accepted_lane_borrow_has_required_sight_distance(sight, x, speed, limit):
    """No lane borrow is accepted with less sight than the rule requires."""
    lanes = tuple(lane.model_copy(update={"speed_limit_mps": limit}) for lane in TWO_WAY.lanes)
    road = TWO_WAY.model_copy(update={"lanes": lanes, "key": f"limit-{limit}"})
    world = World(road, [thing("lead", x)], sight_m=sight)
    case, _ = accepted(BorrowOncomingLane(past_object_id="lead", speed_mps=speed), world)
    (lane,) = (lane for lane in case.path.enters if lane.strip.direction is LaneDirection.OPPOSITE)
    inside = np.flatnonzero(case.inside(lane))
    first, last = inside[0], inside[-1]
    # The last station from which the quick ego stops short of the lane, looked at half a second before.
    stops = case.path.s + case.quick.v**2 / (2 * case.view.ego.limits.comfort_braking_mps2)
    commit = int(np.flatnonzero(stops >= case.path.s[first])[0])
    decided = max(case.slow.t[commit] - 0.5, 0.0)
    own_way, time = case.path.s[last] - case.view.ego_s, case.slow.t[last] - decided
    assert sight >= own_way + limit * time + GUARD.policy.oncoming.sight_margin_m - 1e-6


@pytest.mark.integration
@settings(max_examples=FEW, suppress_health_check=list(HealthCheck))
@given(
    world=worlds,
    behavior=behaviors,
    distance=st.floats(-0.9, 2.0) | st.floats(20.0, 90.0),
    state=st.sampled_from([LightState.RED, LightState.YELLOW, LightState.UNKNOWN]),
)
def test_accepted_path_stops_before_light_that_is_not_green(world, behavior, distance, state):
    """No accepted path crosses the line of a light that is not green."""
    world.controls = (red_light(distance, state),)
    case, _ = accepted(behavior, world)
    assert case.path.end_s + case.view.ego.length_m / 2 <= case.view.ego_front_s + distance + 1e-6


@pytest.mark.integration
@many
@given(world=worlds, behavior=behaviors)
def test_stop_before_commit_point_stays_out_of_other_lane(world, behavior):
    """A stop before the commit point keeps the body out of the other lane."""
    case, proven = accepted(behavior, world)
    if commit_s(proven) is None:
        return
    others = [lane for lane in case.path.enters if lane is not case.start_lane]
    first = min(int(np.flatnonzero(case.inside(lane))[0]) for lane in others)
    assume(commit_s(proven) > case.path.s[0])
    speed = float(np.interp(commit_s(proven), case.path.s, case.quick.v))
    stopping = speed**2 / (2 * case.view.ego.limits.comfort_braking_mps2)
    assert commit_s(proven) + stopping <= case.path.s[first] + 1e-6


@many
@given(world=worlds, behavior=behaviors, guided=st.booleans())
def test_the_guard_answers_every_plan_in_every_world(world, behavior, guided):
    verdict, proven = GUARD.accept([behavior], world.view(), guided)
    assert (proven is None) == bool(verdict.rejects)
    if proven is not None:
        passes = isinstance(behavior, BorrowOncomingLane) and world.objects[0].vx_mps == 0.0
        cap = GUARD.policy.speeds.guided_mps if guided or passes else GUARD.policy.speeds.recovery_mps
        assert proven.path.speed.max() <= cap
        assert GUARD.recheck(proven, world.view()).accepted


@settings(max_examples=FEW, suppress_health_check=list(HealthCheck))
@given(world=worlds, behavior=behaviors, age=st.floats(0.51, 100.0))
def test_nothing_is_accepted_on_old_news(world, behavior, age):
    world.age_s = age
    assert not GUARD.accept([behavior], world.view(), True)[0].accepted


def test_pedestrian_between_fast_and_slow_ego_is_predicted():
    """A pedestrian between the fast and the slow ego rejects the plan.

    The fast ego has passed before the pedestrian comes, the slow one is not there yet; one in between hits the
    pedestrian.
    """
    found = set()
    for start in np.arange(-30.0, -3.0, 0.5):
        walker = thing("walker", 110.0, float(start), kind=ObjectKind.PEDESTRIAN, sideways=1.5)
        view = FrenetScene(World(TWO_WAY, [walker]).surroundings())
        verdict, proven = GUARD.accept([KeepLane(distance_m=100.0, speed_mps=5.0)], view, guided=False)
        found.add(verdict.accepted)
        if proven is None:
            continue
        case = CheckContext(view, proven.path, GUARD.policy)
        station = int(np.searchsorted(proven.path.s, 110.0))
        in_path = [(-edge - start) / 1.5 for edge in (1.2, -1.2)]
        assert not (case.quick.t[station] < in_path[1] and in_path[0] < case.slow.t[station])
    assert found == {True, False}


REACTION_S, FOLLOWER_MPS2 = 1.0, 3.5
"""What RSS, as the policy has it, expects of who comes from behind."""


@pytest.mark.integration
@many
@given(st.floats(8.0, 60.0), st.floats(1.0, 12.0), st.floats(3.0, 8.0), st.sampled_from(["quick", "slow"]))
def test_follower_of_accepted_lane_change_stops_in_time(behind_m, speed, gap_m, which):
    """A follower stops short of the ego in its lane, whatever its speed and distance.

    It goes on until the ego enters, reacts for a second, and brakes as it must. A vehicle that is past the ego at
    the entry just drives on.
    """
    lead = thing("lead", 52.3 + gap_m + 2.4, hazard=True)
    world = World(MULTI, [lead, thing("follower", 50.0 - behind_m, LANE_M, speed=speed)])
    view = world.view()
    _, proven = GUARD.accept([ChangeLane(side="left", distance_m=40.0, speed_mps=5.0)], view, False)
    event(f"accepted: {proven is not None}")
    assume(proven is not None)
    case = CheckContext(view, tracked_path(proven.path, view, GUARD.policy.tracking), GUARD.policy)
    run, path = getattr(case, which), case.path
    entry = float(run.t[np.flatnonzero(case.inside(path.enters[0]))[0]])
    past = 50.0 - behind_m - 2.3 + speed * entry > np.interp(entry, run.t, path.s) + view.ego.length_m / 2
    t = np.arange(0.0, run.duration_s, 0.05)
    braked = np.clip(t - entry - REACTION_S, 0.0, speed / FOLLOWER_MPS2)
    stopping = speed * np.minimum(t, entry + REACTION_S) + speed * braked - FOLLOWER_MPS2 * braked**2 / 2
    front = 50.0 - behind_m + 2.3 + (speed * t if past else stopping)
    s, d = np.interp(t, run.t, path.s), np.interp(t, run.t, path.d)
    turn = np.interp(t, run.t, case.heading)
    gap = separation(
        (s, d, turn),
        (view.ego.length_m / 2, view.ego.width_m / 2),
        (front - 2.3, np.full(len(t), LANE_M), np.zeros(len(t))),
        (2.3, 0.95),
    )
    assert gap.min() > 0.0
