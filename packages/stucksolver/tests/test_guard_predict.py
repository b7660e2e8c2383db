"""Where others may be, against a plain reckoning: one body at a time, one hypothesis, one instant after the other."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest

from grids import sample
from stucksolver.guard import GuardPolicy, prediction
from stucksolver.guard.context import CheckContext
from stucksolver.plan.frenet_path import FrenetPath
from stucksolver.scene import LineKind, ObjectKind
from stucksolver.scene.boxes import separation
from worlds import World, straight_road, thing

POLICY = GuardPolicy()
HALF = (4.9 / 2, 1.85 / 2)
FAR_M = 2.0
KINDS = [ObjectKind.CAR, ObjectKind.BICYCLE, ObjectKind.PEDESTRIAN, ObjectKind.TRUCK, ObjectKind.BARRIER]


def some_case(draw, count=5, running=False, over=()):
    """A way that may go aside, at some speed, among objects that do this and that."""
    objects = []
    for k in range(count):
        slow = draw.random() < 0.3
        across = draw.random() < 0.3
        speed = draw.uniform(-0.6, 0.6) if slow else draw.uniform(-9.0, 11.0)
        sideways = draw.uniform(-5.0, 5.0) if across else draw.choice([0.0, 0.2, -0.29, 0.31, -0.45])
        objects.append(
            thing(
                f"o{k}",
                draw.uniform(10.0, 110.0),
                draw.uniform(-12.0, 12.0),
                kind=draw.choice(KINDS),
                speed=0.0 if across and not slow else speed,
                sideways=sideways,
                yaw=math.copysign(math.pi / 2, sideways) if across else 0.0,
            )
        )
    stations = draw.randrange(8, 70)
    d = draw.choice([0.0, 0.0, 1.2, -1.0]) * np.clip(np.arange(stations) / 20.0, 0.0, 1.0)
    world = World(straight_road(left=LineKind.BROKEN), objects, speed=draw.uniform(0.0, 5.0))
    path = FrenetPath(50.0 + 0.5 * np.arange(stations), d, np.full(stations, draw.uniform(1.0, 5.5)), over=over)
    return CheckContext(world.view(), path, POLICY, running=running)


def braked(speed, t):
    """Way until `t` of one who brakes by 3.5 m/s² from now on, to a stand."""
    until = min(t, speed / 3.5)
    return speed * until - 3.5 * until**2 / 2


def beside(case, i):
    """True if object `i` is not past the ego's front yet, and the ego can stop before it is in that one's way."""
    view, ego = case.view, case.view.ego
    if view.s[i] - view.along[i] > view.ego_s + ego.length_m / 2:
        return False
    way_m = ego.speed_mps * 0.3 + ego.speed_mps**2 / (2 * ego.limits.comfort_braking_mps2)
    for s, d, reach in zip(case.path.s, case.path.d, case.reach, strict=True):
        if abs(d - view.d[i]) - reach - view.across[i] < 0.3:
            return s - case.path.s[0] > way_m
    return True


def places(case, i, t):
    """Where object `i` may be at `t`: (x, y, heading, longer by), one for each hypothesis."""
    view, thing_ = case.view, case.view.objects[i]
    x, y, vx, vy = thing_.x_m, thing_.y_m, thing_.vx_mps, thing_.vy_mps
    found, yaw, heading = [], float(view.yaw[i]), math.atan2(vy, vx)
    if view.elsewhere[i]:
        speed = math.hypot(vx, vy)
        ux, uy = vx / speed, vy / speed
        early = speed * (0.3 if case.running else 1.0)
        found.append((x + vx * t, y + vy * t, heading, early))
        found.append((x + ux * braked(speed, t), y + uy * braked(speed, t), heading, 0.0))
        if speed < 3.0 and not view.on_foot[i]:
            # It has just set off: 2 m/s² up to 30 km/h.
            faster = min(t, (30 / 3.6 - speed) / 2.0)
            on = speed * t + 2.0 * (faster * t - faster**2 / 2)
            found.append((x + ux * on, y + uy * on, heading, 0.0))
    if not view.elsewhere[i] or view.on_lane[i]:
        found.append((x + vx * t, y, yaw, 0.0))
        overtakes = vx > case.view.ego.speed_mps + 1.0 and abs(vy) < 0.3 and (x <= case.view.ego_s or beside(case, i))
        if abs(vx) > 0.3 and not overtakes:
            found.append((x + math.copysign(braked(abs(vx), t), vx), y, yaw, 0.0))
        if abs(vy) > 0.3:
            found.append((x + vx * t, y + vy * t, yaw, 0.0))
    return found


def least_gap(case, i, stations, t):
    """The least gap between object `i` and the ego at (profiles, instants) `stations`."""
    view, least = case.view, math.inf
    for k, when in enumerate(t):
        for x, y, heading, longer in places(case, i, float(when)):
            for s in stations[:, k]:
                ego = (s, np.interp(s, case.path.s, case.path.d), np.interp(s, case.path.s, case.heading))
                half = (view.half_length[i] + longer, view.half_width[i])
                least = min(least, float(separation(ego, HALF, (x, y, heading), half)))
    return least


@pytest.mark.parametrize("number", sample(range(60), 20))
def test_moving_gaps_match_each_hypothesis_computed_separately(number):
    """Gaps to moving objects are those of each hypothesis, computed one by one."""
    draw = random.Random(number)
    case = some_case(draw, running=bool(number % 2))
    t = prediction.times(case)
    stations = prediction.profiles(case, t)
    which = np.flatnonzero(case.view.moving)
    if not len(which):
        return
    gaps = prediction.moving_gaps(case, stations, which, t).min(axis=(0, 1))
    for i, gap in zip(which, gaps, strict=True):
        expected = least_gap(case, int(i), stations, t)
        if expected < FAR_M - 0.1:
            assert gap == pytest.approx(expected, abs=0.02)
        else:
            assert gap > FAR_M - 0.2


@pytest.mark.parametrize("number", sample(range(120), 40))
def test_whoever_comes_near_is_looked_at_but_those_who_follow(number):
    draw = random.Random(1000 + number)
    case = some_case(draw, running=bool(number % 2))
    view, t = case.view, prediction.times(case)
    stations = prediction.profiles(case, t)
    which = np.arange(len(view.objects))
    near = prediction.moving_gaps(case, stations, which, t).min(axis=(0, 1)) < FAR_M
    stands = prediction.stationary_gaps(case, which).min(axis=0) < FAR_M
    rear = view.ego_s - HALF[0]
    follows = (view.s + view.along < rear) & (view.vs > -0.5) & (np.abs(view.vd) < 0.6) & ~view.elsewhere
    found = set(prediction.relevant(case).tolist())
    for i in which:
        if (near[i] or (stands[i] and not view.moving[i])) and not follows[i]:
            assert i in found, view.objects[i]
        if follows[i]:
            assert i not in found, view.objects[i]


def test_relevant_follower_is_left_out_and_reversing_vehicle_is_not():
    """A follower is left out. A vehicle that backs up or comes across is not."""

    def looked_at(**more):
        path = FrenetPath(50.0 + 0.5 * np.arange(40), np.zeros(40), np.full(40, 5.0))
        view = World(straight_road(), [thing("it", **{"x": 40.0, "y": 0.0, "speed": 6.0} | more)]).view()
        return len(prediction.relevant(CheckContext(view, path, POLICY))) == 1

    edge = 50.0 - HALF[0] - 2.3
    assert not looked_at() and not looked_at(x=edge - 0.02) and looked_at(x=edge + 0.02)
    assert not looked_at(speed=-0.49, x=edge - 0.5) and looked_at(speed=-0.51, x=edge - 0.5)
    assert not looked_at(sideways=0.59) and looked_at(sideways=0.61)


@pytest.mark.parametrize(("x", "counts"), [(112.0, True), (300.0, False)])
def test_who_is_far_off_is_left_out(x, counts):
    path = FrenetPath(50.0 + 0.5 * np.arange(20), np.zeros(20), np.full(20, 5.0))
    view = World(straight_road(), [thing("it", x, 0.0, speed=-11.0)]).view()
    assert (len(prediction.relevant(CheckContext(view, path, POLICY))) == 1) is counts
    aside = World(straight_road(), [thing("it", 55.0, 9.0)]).view()
    assert len(prediction.relevant(CheckContext(aside, path, POLICY))) == 0
    cross = World(straight_road(), [thing("it", 55.0, 200.0, sideways=-5.0, yaw=-math.pi / 2)]).view()
    assert len(prediction.relevant(CheckContext(cross, path, POLICY))) == 0
    assert len(prediction.relevant(CheckContext(cross, path, POLICY), 60.0)) == 1, "a longer span reaches them"


def test_what_is_driven_over_is_not_looked_at():
    view = World(straight_road(), [thing("bag", 55.0, kind=ObjectKind.BAG), thing("car", 58.0)]).view()
    path = FrenetPath(50.0 + 0.5 * np.arange(40), np.zeros(40), np.full(40, 2.0), over=("bag",))
    assert prediction.relevant(CheckContext(view, path, POLICY)).tolist() == [1]


@pytest.mark.parametrize("number", range(20))
def test_times_last_until_slow_ego_is_at_end(number):
    """A plan is examined until the slow ego is at its end, for at most 30 s."""
    case = some_case(random.Random(2000 + number), count=0)
    t = prediction.times(case)
    assert t[0] == 0.0 and np.allclose(np.diff(t), 0.2)
    assert min(case.slow.duration_s, 30.0) <= t[-1] + 1e-9 < min(case.slow.duration_s, 30.0) + 0.2 + 1e-6
    stations = prediction.profiles(case, t)
    assert np.allclose(stations[0], np.interp(t, case.slow.t, case.path.s))
    assert np.allclose(stations[-1], np.interp(t, case.quick.t, case.path.s))
    between = np.diff(stations, axis=0)
    assert (between >= -1e-9).all() and between.max(initial=0.0) <= 2.5 + 1e-9


def test_a_very_slow_plan_is_foretold_for_half_a_minute():
    path = FrenetPath(50.0 + 0.5 * np.arange(200), np.zeros(200), np.full(200, 0.5))
    assert prediction.times(CheckContext(World(straight_road()).view(), path, POLICY))[-1] == pytest.approx(
        30.0, abs=0.21
    )


@pytest.mark.parametrize(("aside_m", "part"), [(0.0, 1.0), (0.9, 0.5)])
def test_stationary_gaps_match_boxes_at_each_station(aside_m, part):
    """Gaps to stationary objects are those of the boxes at each station."""
    draw = random.Random(7)
    objects = [thing(f"o{k}", draw.uniform(50, 70), draw.uniform(-4, 4), yaw=draw.uniform(0, 3)) for k in range(6)]
    d = np.linspace(0.0, 2.0, 40)
    case = CheckContext(
        World(straight_road(), objects).view(), FrenetPath(50.0 + 0.5 * np.arange(40), d, np.full(40, 2.0)), POLICY
    )
    which = np.array([4, 1, 2])
    gaps = prediction.stationary_gaps(case, which, aside_m, part)
    for k in range(40):
        for j, i in enumerate(which):
            one = case.view.objects[i]
            ego = (case.path.s[k], d[k], case.heading[k])
            expected = separation(ego, HALF, (one.x_m, one.y_m, one.yaw_rad), (part * 2.3, 0.95 + aside_m))
            assert gaps[k, j] == pytest.approx(float(expected), abs=1e-9)


def hypotheses(speed, x, ego_mps=3.0, sideways=0.0, y=0.0, over_at_m=None, across_sd_m=None):
    """How many ways somebody may go on. The ego keeps to its lane, or is in theirs from `over_at_m` on."""
    it = thing("it", x, y, speed=speed, sideways=sideways).model_copy(update={"across_sd_m": across_sd_m})
    view = World(straight_road(), [it], speed=ego_mps).view()
    d = np.zeros(40) if over_at_m is None else np.where(0.5 * np.arange(40) < over_at_m, 0.0, y)
    path = FrenetPath(50.0 + 0.5 * np.arange(40), d, np.full(40, 5.0))
    t = np.arange(0.0, 4.0, 0.2)
    which = np.array([0])
    return len(list(prediction.predictions(CheckContext(view, path, POLICY), which, t, which)))


def test_hypotheses_overtaking_vehicle_does_not_brake():
    """A vehicle that is overtaking the ego is not assumed to brake; one that is only faster is."""
    assert hypotheses(4.1, 45.0) == 1, "overtaking: goes on"
    assert hypotheses(3.9, 45.0) == 2, "goes on, or brakes"
    assert hypotheses(2.5, 45.0) == 2
    assert hypotheses(4.1, 51.0) == 2, "past us: a leader"
    assert hypotheses(4.1, 45.0, sideways=0.4) == 3, "cuts in"
    assert hypotheses(0.2, 60.0) == 1, "as good as stands"


def test_hypotheses_vehicle_alongside_overtakes_while_ego_can_stop():
    """A vehicle alongside still overtakes while the ego can stop out of its path."""
    assert hypotheses(7.0, 53.0, y=3.5) == 1, "passes beside us"
    assert hypotheses(7.0, 53.0, y=3.5, over_at_m=6.0) == 1, "we enter their way later, and can stop before"
    assert hypotheses(7.0, 53.0, y=3.5, over_at_m=1.0) == 2, "we could not stop any more"
    assert hypotheses(7.0, 53.0, y=3.5, over_at_m=6.0, ego_mps=5.9) == 2, "nor at this speed"
    assert hypotheses(7.0, 56.0, y=3.5, over_at_m=6.0) == 2, "past our front: a leader"
    assert hypotheses(3.5, 53.0, y=3.5, over_at_m=6.0) == 2, "not quicker than we are"


@pytest.mark.parametrize(("gap_m", "ways"), [(0.4, 1), (0.35, 1), (0.15, 2)])
def test_hypotheses_uncertain_vehicle_needs_gap_or_uncertainty(gap_m, ways):
    """Beside an uncertain vehicle, the gap is not kept in addition to the uncertainty.

    0.3 m beside the estimated place, or none if the vehicle is nearer by two standard deviations.
    """
    y = 1.85 / 2 + 1.9 / 2 + gap_m
    assert hypotheses(7.0, 53.0, y=y, ego_mps=0.0, over_at_m=6.0, across_sd_m=0.1) == ways
    assert hypotheses(7.0, 53.0, y=y, ego_mps=0.0, over_at_m=6.0) == (1 if gap_m > 0.3 else 2)


def test_gap_to_passing_vehicle_is_reduced_by_uncertainty():
    """The gap to a passing vehicle is that of the policy or the uncertainty, whichever is larger."""
    objects = [thing("it", 53.0, 3.5).model_copy(update={"across_sd_m": sd}) for sd in (None, 0.1, 0.2)]
    path = FrenetPath(50.0 + 0.5 * np.arange(40), np.zeros(40), np.full(40, 5.0))
    case = CheckContext(World(straight_road(), objects).view(), path, POLICY)
    assert [case.room_m(i) for i in range(3)] == pytest.approx(
        [POLICY.entry.beside_m, POLICY.entry.beside_m - 0.2, 0.0]
    )
