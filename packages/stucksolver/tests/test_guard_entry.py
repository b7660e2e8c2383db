"""Lanes of our direction that are entered: who in them is given how much, by Lemma 2 of RSS."""

from __future__ import annotations

import numpy as np
import pytest

from stucksolver.guard import NOBODY, Guard, RejectCode
from stucksolver.guard.context import CheckContext
from stucksolver.guard.path_tracking import tracked_path
from stucksolver.plan.behaviors import ChangeLane
from stucksolver.scene import LineKind, ObjectKind
from worlds import LANE_M, World, straight_road, thing

C = RejectCode
pytestmark = pytest.mark.usefixtures("alike")
GUARD = Guard()
ROAD = straight_road(left=LineKind.BROKEN, oncoming=None)
LEFT = ChangeLane(side="left", distance_m=30.0, speed_mps=5.0)
A_LITTLE = 0.01


def car(x, speed, y=LANE_M, kind=ObjectKind.CAR):
    return thing("car", x, y, speed=speed, kind=kind)


def entries(*others, **world):
    found = GUARD.accept([LEFT], World(ROAD, list(others), **world).view(), False)[0].rejects
    return [r for r in found if r.code is C.LANE_ENTRY]


def nearest_behind(speed):
    """Where a follower at a speed is at least far enough behind."""
    refused = next(float(x) for x in range(-200, 45, 5) if entries(car(float(x), speed)))
    free = refused - 5.0
    while refused - free > 1e-4:
        middle = (refused + free) / 2
        refused, free = (middle, free) if entries(car(middle, speed)) else (refused, middle)
    return free, entries(car(refused, speed))[0].time_s


@pytest.mark.integration
@pytest.mark.parametrize(("slower", "quicker"), [(10.0, 10.5), (14.0, 14.5)])
def test_lane_entry_gap_to_follower_covers_reaction_and_braking(slower, quicker):
    """A follower has 1 s to react and brakes with 3.5 m/s².

    Each m/s more costs the distance until the ego enters, the distance until the follower reacts, and a longer
    stop.
    """
    near_m, when_s = nearest_behind(slower)
    far_m, again_s = nearest_behind(quicker)
    assert when_s == again_s
    more = quicker - slower
    stops_m = (quicker**2 - slower**2) / (2 * 3.5)
    assert near_m - far_m == pytest.approx(more * when_s + more * 1.0 + stops_m, abs=0.01)


def test_lane_entry_rejection_reports_gap_with_reserve():
    """The rejection reports the required gap to a follower with 1 m in reserve."""
    found = entries(car(12.0, 8.0))[0]
    assert found.object_id == "car" and found.gap_m is not None
    needed = float(found.detail.split("required ")[1].split(" m")[0])
    assert found.detail.startswith(f"car car behind: gap {found.gap_m:.1f} m, ")
    entered_mps = 5.0
    least, most = (8.0 + 64.0 / 7 - v**2 / 16 + 1.0 for v in (entered_mps, 0.0))
    assert least - 0.1 <= needed <= most + 0.1


def test_lane_entry_gap_to_lead_covers_ego_braking():
    """A lead in the entered lane is kept at the distance that the ego needs to brake.

    At 0.5 m/s; the ego is predicted to enter at no more than 5 m/s.
    """
    (found,) = entries(car(60.0, 0.5))
    assert " ahead: " in found.detail and found.object_id == "car"
    needed = float(found.detail.split("required ")[1].split(" m")[0])
    assert 1.0 < needed <= 0.5 * 5.0 + 25.0 / 6 - 0.25 / 16 + 1.0 + 0.05
    assert not entries(car(90.0, 0.5))


def first_ahead(speed):
    """Where one at a speed is at least far enough ahead, with nobody else about."""
    near, far = next((x, x + 0.5) for x in np.arange(90.0, 30.0, -0.5) if entries(car(float(x), speed)))
    while far - near > 1e-3:
        middle = (near + far) / 2
        near, far = (middle, far) if entries(car(middle, speed)) else (near, middle)
    return far


@pytest.mark.integration
@pytest.mark.parametrize("speed", [1.0, 2.0, 3.0, 5.0, 7.0, 9.0])
def test_lane_entry_lead_braking_hardest_leaves_gap(speed):
    """The lead may brake as hard as possible just when the ego comes in behind it.

    At the entry, the ego reacts half a second later and brakes comfortably.
    """
    ahead = car(first_ahead(speed), speed)
    view = World(ROAD, [ahead]).view()
    path = tracked_path(GUARD.lay_out([LEFT], view, False, NOBODY).path, view, GUARD.policy.tracking, reverse=False)
    case = CheckContext(view, path, GUARD.policy)
    run, k = case.quick, int(np.flatnonzero(case.inside(path.enters[0]))[0])
    ticks = np.arange(0.0, 6.0, 0.01)
    until = np.minimum(np.maximum(ticks - 0.5, 0.0), run.v[k] / 3.0)
    own = run.v[k] * np.minimum(ticks, 0.5) + run.v[k] * until - 1.5 * until**2
    until = np.minimum(ticks, speed / 8.0)
    theirs = speed * until - 4.0 * until**2
    gap = ahead.x_m + speed * run.t[k] + theirs - 4.5 / 2 - (path.s[k] + 4.9 / 2 + own)
    assert gap.min() > 0.0


@pytest.mark.parametrize(("speed", "counts"), [(0.5, True), (0.5 - A_LITTLE, False)])
def test_lane_entry_vehicle_from_0_5_mps_is_traffic(speed, counts):
    """A vehicle at 0.5 m/s is traffic; a slower one is an obstacle."""
    assert bool(entries(car(58.0, speed))) is counts


def test_who_is_in_another_lane_is_no_matter():
    beside = car(12.0, 8.0, y=2 * LANE_M + 0.5).model_copy(update={"id": "beside"})
    assert not entries(beside)
    assert {r.object_id for r in entries(beside, car(12.0, 8.0))} == {"car"}


def entered_at(proven):
    """Arc length at which the body reaches over the border."""
    heading = proven.path.heading()
    reach = 1.85 / 2 * np.cos(heading) + 4.9 / 2 * np.abs(np.sin(heading))
    return float(proven.path.s[np.flatnonzero(proven.path.d + reach > LANE_M / 2 + 0.05)[0]])


@pytest.mark.parametrize(
    ("before_m", "speed", "due"), [(6.0, 0.0, False), (2.0, 0.0, True), (12.0, 3.0, False), (6.0, 3.0, True)]
)
def test_recheck_lane_entry_is_due_at_stopping_distance(before_m, speed, due):
    """While a plan runs, a lane entry must be certain a stop, a second and 3 m before it.

    At 3 m/s a stop takes 1.5 m, a second 3 m. The turn of the body makes a station or two of difference.
    """
    world = World(ROAD)
    _, proven = GUARD.accept([LEFT], world.view(), False)
    s = entered_at(proven) - before_m
    world.x, world.y = s, float(np.interp(s, proven.path.s, proven.path.d))
    world.yaw, world.speed = float(np.interp(s, proven.path.s, proven.path.body(0.0, 2.9))), speed
    world.objects = [car(s - 12.0, 8.0)]
    assert (C.LANE_ENTRY in {r.code for r in GUARD.recheck(proven, world.view()).rejects}) is due


def in_the_left_lane(road):
    """A plan that has just brought the ego into the left lane, on another window of the road, somebody close behind."""
    world = World(ROAD)
    _, proven = GUARD.accept([LEFT], world.view(), False)
    world.x, world.y, world.speed = proven.path.end_s - 8.0, LANE_M, 5.0
    world.road, world.objects = road, [car(world.x - 12.0, 8.0)]
    return GUARD.recheck(proven, world.view())


@pytest.mark.parametrize("key", [ROAD.key, "the next window"])
def test_recheck_entered_lane_is_not_entered_again(key):
    """A lane that was entered does not count as entered again when the road is sent anew."""
    verdict = in_the_left_lane(ROAD.model_copy(update={"key": key}))
    assert verdict.accepted, str(verdict)
