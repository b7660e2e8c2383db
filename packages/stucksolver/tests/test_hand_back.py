"""A plan that is given up: when the stack may drive on by itself, and when the vehicle is held where it stands."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from given_up import GivesUp, askew
from grids import sample
from stucksolver.guard import Guard
from stucksolver.plan import CONTINUE, Execute, RecoveryPlan
from stucksolver.plan.behaviors import RequestAssistance
from stucksolver.reasoners import SearchReasoner
from stucksolver.scene import LineKind, ObjectKind
from stucksolver.solver import EventKind
from worlds import LANE_M, World, drive, straight_road, stubborn, thing

MULTI = straight_road(left=LineKind.BROKEN, oncoming=None)


@pytest.mark.parametrize(
    ("y", "yaw", "lead_at", "clear"),
    [
        (0.0, 0.0, 56.0, True),  # straight behind it: any driver sees it
        (1.0, 0.5, 56.0, False),  # turned out beside it: the way back leads into its corner
        (1.0, 0.5, 75.0, True),
        (LANE_M, 0.0, 53.0, False),  # in the next lane, level with it
        (LANE_M, 0.0, 90.0, True),
    ],
)
def test_clear_to_hand_back_needs_free_return_path_unless_aligned(y, yaw, lead_at, clear):
    """The path back must be free unless the vehicle has stopped in its lane."""
    world = World(MULTI, [thing("lead", lead_at)], y=y, yaw=yaw)
    assert Guard().clear_to_hand_back(world.view()) is clear


@pytest.mark.parametrize(("gap_m", "clear"), [(0.3, False), (0.8, False), (0.9, True), (5.0, True)])
@pytest.mark.parametrize("yaw", [-0.15, 0.0, 0.15])
def test_stopped_driver_next_second_must_touch_nothing(gap_m, clear, yaw):
    """From rest, 1.5 m/s² lead 0.75 m on within a second; 0.1 m counts as touching."""
    world = World(MULTI, [thing("lead", 50.0 + 2.45 + gap_m + 2.3, width=2.6)], yaw=yaw)
    if yaw:
        world.x -= 0.15  # the front corner of a body askew is further ahead
    assert Guard().clear_to_hand_back(world.view()) is clear


@pytest.mark.integration
@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    speed=st.floats(0.2, 13.0),
    gap_m=st.floats(0.2, 30.0),
    aside_m=st.floats(-1.0, 1.0),
    lead_mps=st.sampled_from([0.0, 0.0, 1.0, 3.0]),
    tick_s=st.sampled_from([0.02, 0.05, 0.1]),
)
def test_watched_driver_that_keeps_on_never_touches(speed, gap_m, aside_m, lead_mps, tick_s):
    """Whoever drives straight on at constant speed is stopped in time, if the first check is early enough for that."""
    guard, brake = Guard(), 6.0
    world = World(MULTI, [thing("lead", 50.0 + 2.45 + gap_m + 2.3, aside_m, speed=lead_mps)], speed=speed, dt=tick_s)
    assume(gap_m > speed * 0.5 + speed**2 / (2 * brake) + 0.15)
    held_s = None
    for _ in range(round(8.0 / tick_s)):
        if held_s is None and guard.about_to_touch(world.view(), 0.0) is not None:
            held_s = world.time_s
        if held_s is not None and world.time_s - held_s > 0.3:
            world.speed = max(world.speed - brake * tick_s, 0.0)
        world.x += world.speed * tick_s
        world.time_s += tick_s
        world.objects = [o.model_copy(update={"x_m": o.x_m + o.vx_mps * tick_s}) for o in world.objects]
        if world.speed == 0.0 or world.x > world.objects[0].x_m:
            break
        assert world.clearance() > 0.0


LEVER_M = 1.45
"""Half a wheelbase: a car's rear axle moves along its heading, its center does not."""


def beside_a_corner(gap_m: float) -> World:
    """The ego, askew, with the rear corner of a parked car this far from its left side."""
    world = World(MULTI, [thing("lead", 53.4)], y=-1.8, yaw=-0.35)
    while abs(world.clearance() - gap_m) > 0.005:
        aside = 0.005 if world.clearance() < gap_m else -0.005
        world.objects = [o.model_copy(update={"y_m": o.y_m + aside}) for o in world.objects]
    return world


def turn_on(world: World, curvature: float, acceleration: float) -> None:
    """Drive one tick on an arc of the center, as a car does: the rear axle follows the heading."""
    world.speed = max(world.speed + acceleration * world.dt, 0.0)
    way = world.speed * world.dt
    x = world.x - LEVER_M * math.cos(world.yaw)
    y = world.y - LEVER_M * math.sin(world.yaw)
    rear = way * math.cos(math.asin(curvature * LEVER_M))
    middle = world.yaw + curvature * way / 2
    world.yaw += curvature * way
    world.x = x + rear * math.cos(middle) + LEVER_M * math.cos(world.yaw)
    world.y = y + rear * math.sin(middle) + LEVER_M * math.sin(world.yaw)
    world.time_s += world.dt


@pytest.mark.parametrize("curvature", [0.1, 0.13, 1 / 6])
@pytest.mark.parametrize("gap_m", [0.12, 0.17, 0.3])
def test_watched_driver_that_turns_in_beside_a_corner_never_touches(curvature, gap_m):
    """As CARLA's BehaviorAgent did; it is let go five times, and steers the same way each time."""
    world, guard, releases = beside_a_corner(gap_m), Guard(), 0
    held = False
    for _ in range(400):
        brakes = held
        held = held or guard.about_to_touch(world.view(), curvature) is not None
        turn_on(world, curvature, -6.0 if brakes else 4.0)
        assert world.clearance() > 0.0
        if held and world.speed == 0.0:
            held, releases = False, releases + 1
        if releases == 5:
            break
    assert releases


@pytest.mark.parametrize("curvature", [0.0, 0.1])
def test_watched_driver_that_steers_past_is_left_alone(curvature):
    """Ahead of a parked car, 3 m away at 3 m/s: straight on must brake now, a curve that leads past must not."""
    world = World(MULTI, [thing("lead", 50.0 + 2.45 + 2.2 + 2.3, -1.2)], yaw=0.3, speed=3.0)
    touched = Guard().about_to_touch(world.view(), curvature)
    straight = World(MULTI, [thing("lead", 50.0 + 2.45 + 2.2 + 2.3, -0.2)], speed=3.0)
    assert touched is None
    assert Guard().about_to_touch(straight.view(), 0.0) is not None


def test_watched_driver_over_a_flat_bag_is_left_alone():
    bag = thing("bag", 54.0, kind=ObjectKind.BAG, height=0.1)
    assert Guard().about_to_touch(World(MULTI, [bag], speed=5.0).view(), 0.0) is None
    rock = thing("rock", 54.0, kind=ObjectKind.DEBRIS, height=0.1)
    assert Guard().about_to_touch(World(MULTI, [rock], speed=5.0).view(), 0.0) is not None


def test_watched_driver_beside_a_car_it_touches_may_leave():
    """What is touched already counts only if the ego comes nearer."""
    touching = thing("lead", 50.0, 1.9)
    assert Guard().about_to_touch(World(MULTI, [touching], speed=2.0).view(), 0.0) is None


def test_watched_driver_with_old_surroundings_is_left_alone():
    world = World(MULTI, [thing("lead", 56.0)], speed=5.0, age_s=0.6)
    assert Guard().about_to_touch(world.view(), 0.0) is None


def test_who_moves_is_no_reason_to_stay():
    world = World(MULTI, [thing("lead", 56.0, speed=6.0)], y=1.0, yaw=0.5)
    assert Guard().clear_to_hand_back(world.view())


def test_where_nobody_may_stand_the_stack_goes_on():
    world = World(straight_road(), [thing("lead", 53.0)], y=LANE_M)
    assert Guard().clear_to_hand_back(world.view())


@pytest.mark.integration
def test_hold_aborted_askew_lasts_until_return_path_is_free():
    """A vehicle that is turned when its plan is aborted is held until the path back is free."""
    world = World(MULTI, [thing("lead", 60.0)])
    stood = []

    def towed_away(world):
        stood.append((world.time_s, world.x, world.speed))
        if world.time_s > 30.0:
            world.objects = []

    seen = drive(world, 40.0, guard=GivesUp(askew), ladder=stubborn(), every_tick=towed_away)
    aborted = next(e for e in seen.events if e.kind is EventKind.ABORTED)
    released = next(e for e in seen.events if e.kind is EventKind.RELEASED)
    assert "it stands" in aborted.text
    assert released.text == "the driver's own next second is clear"
    assert released.time_s == pytest.approx(30.5, abs=0.6)  # what vanishes is believed to be there for a moment
    held = [d for d, (t, _, _) in zip(seen.directives, stood, strict=True) if aborted.time_s < t <= 30.0]
    assert all(isinstance(d, Execute) and d.behavior.name == "wait" for d in held)
    places = [x for t, x, _ in stood if aborted.time_s + 2.0 < t <= 30.0]
    assert max(places) - min(places) < 0.01
    assert seen.directives[-1] == CONTINUE
    assert seen.nearest_m > 0.3


class ThenAsks:
    """The search, and once the plan has been given up, calls for help of five seconds."""

    name = "then asks"

    def __init__(self, guard):
        self._guard, self._search = guard, SearchReasoner()

    def decide(self, request):
        answer = self._search.decide(request)
        if not self._guard.gave_up:
            return answer
        call = RecoveryPlan(behaviors=(RequestAssistance(reason="stuck", duration_s=5.0),))
        return replace(answer, decision=answer.decision.model_copy(update={"plan": call}))


@pytest.mark.integration
def test_hold_after_abort_survives_end_of_assistance_request():
    """The end of a request for assistance does not hand back a vehicle whose plan was aborted."""
    guard = GivesUp(askew)
    world = World(MULTI, [thing("lead", 60.0)])
    seen = drive(world, 40.0, guard=guard, ladder=stubborn(), reasoner=ThenAsks(guard))
    aborted = next(e for e in seen.events if e.kind is EventKind.ABORTED)
    finished = [e for e in seen.events if e.kind is EventKind.FINISHED]
    assert finished and all("it stands" in e.text for e in finished)
    begun = round(aborted.time_s / world.dt) + 2
    assert CONTINUE not in seen.directives[begun:]


@pytest.mark.integration
def test_plan_aborted_for_traffic_at_start_restarts_in_next_gap():
    """A plan aborted for traffic right after its start waits for the next gap."""
    guard = GivesUp(lambda view: view.ego.speed_mps > 0.6)
    seen = drive(World(MULTI, [thing("lead", 75.0)]), 30.0, guard=guard, ladder=stubborn())
    started = [e.time_s for e in seen.events if e.kind is EventKind.STARTED]
    aborted = next(e.time_s for e in seen.events if e.kind is EventKind.ABORTED)
    assert len(started) == 2
    assert started[1] - aborted < 0.2
    assert EventKind.TRIGGERED not in [e.kind for e in seen.events if started[0] < e.time_s <= started[1]]
    assert EventKind.RECOVERED in seen.kinds()


@pytest.mark.integration
@pytest.mark.parametrize("lead_s", sample([0.0, 0.2, 0.5], 1))
def test_plan_cancelled_by_guidance_waits_while_guidance_lasts(lead_s):
    """A plan that guidance has canceled waits as long as the guidance lasts.

    This holds even if the guard aborts it for traffic at that time: without the guidance it would restart in the
    next gap.
    """
    words: dict[float, str] = {}
    for _ in range(2):
        guard = GivesUp(lambda view: view.ego.speed_mps > 0.6)
        world = World(MULTI, [thing("lead", 75.0)])
        seen = drive(world, 45.0, guard=guard, ladder=stubborn(), words=dict(words))
        started = [e.time_s for e in seen.events if e.kind is EventKind.STARTED]
        words = words or {started[0] + lead_s: "wait"}
    said = next(iter(words))
    aborted = [e.time_s for e in seen.events if e.kind is EventKind.ABORTED and e.time_s < said + 1.0]
    assert len(aborted) == (lead_s > 0.0)
    again = [item for item in started if item > said + 0.2]
    assert said + 30.0 < again[0] < said + 31.0


@pytest.mark.integration
def test_other_words_end_the_wait_that_words_asked_for():
    world = World(MULTI, [thing("lead", 75.0)])
    seen = drive(world, 30.0, ladder=stubborn(), words={6.0: "wait", 12.0: "please overtake"})
    started = [e.time_s for e in seen.events if e.kind is EventKind.STARTED]
    assert 12.0 <= started[0] < 12.5
