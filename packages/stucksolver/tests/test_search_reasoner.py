"""The search reasoner: what it proposes follows from the guard, and its reason is the constraint that binds."""

from __future__ import annotations

import math
import random

import pytest

from stucksolver.guard import Guard
from stucksolver.plan import CauseCode, RecoveryPlan
from stucksolver.plan.behaviors import BackUp, BorrowOncomingLane, KeepLane
from stucksolver.reasoners import ReasonerRequest
from stucksolver.reasoners.search import SearchReasoner
from stucksolver.scene import AttemptOutcome, FailedAttempt, ObjectKind
from stucksolver.solver.state_machine.plan_preview import PlanPreview
from worlds import World, straight_road, thing

GUARD = Guard()
ROAD = straight_road()
FRONT_X = 50.0 + 4.9 / 2
"""Position of the front bumper in the test worlds (m)."""


def preview(world, guided=False):
    return PlanPreview(GUARD, world.view(), lambda plan: guided)


def decide(world, *, stopped_s=15.0, attempts=()):
    scene = world.scene()
    ego = scene.ego.model_copy(update={"stopped_for_s": stopped_s})
    scene = scene.model_copy(update={"ego": ego, "attempts": attempts})
    return SearchReasoner().decide(ReasonerRequest(scene, assess=preview(world).assess)).decision


def car_ahead(gap_m, aside_m=0.0, **more):
    length = more.get("length", 4.6)
    return thing("lead", FRONT_X + gap_m + length / 2, aside_m, **more)


def names(plan):
    return [] if plan is None else [behavior.name for behavior in plan.behaviors]


@pytest.mark.parametrize("width", [1.9, 2.16, 2.3])
@pytest.mark.parametrize("aside_m", [-0.06, 0.0, 0.02, 0.3])
@pytest.mark.parametrize("gap_m", [2.0, 3.5, 5.01, 9.0])
def test_search_stationary_vehicle_is_passed(width, aside_m, gap_m):
    """A few centimeters more or less decide about the speed or a longer way back, not about the pass."""
    world = World(ROAD, [car_ahead(gap_m, aside_m, width=width)])
    plan = decide(world).plan
    assert names(plan)[-1] == "borrow_oncoming_lane"
    assert preview(world).assess(plan).accepted


@pytest.mark.parametrize("length", [7.0, 9.5])
def test_search_wide_lorry_is_passed(length):
    world = World(ROAD, [car_ahead(5.0, kind=ObjectKind.TRUCK, width=2.6, length=length, hazard=True)])
    assert names(decide(world).plan)[-1] == "borrow_oncoming_lane"


@pytest.mark.parametrize(
    "kind,size",
    [(ObjectKind.PROP, (0.6, 0.6)), (ObjectKind.BARRIER, (1.5, 0.4)), (ObjectKind.UNKNOWN, (0.5, 0.5))],
)
def test_search_static_object_at_far_edge_is_not_yielded_to(kind, size):
    """An object that never moves is no oncoming traffic."""
    at_edge = thing("edge", 66.0, 3.5 + 1.75 - 0.4, kind=kind, length=size[0], width=size[1])
    plan = decide(World(ROAD, [car_ahead(6.0), at_edge])).plan
    assert names(plan)[-1] == "borrow_oncoming_lane"


def test_search_back_up_comes_first_where_room_is_short():
    plan = decide(World(ROAD, [car_ahead(1.5)])).plan
    assert names(plan) == ["back_up", "borrow_oncoming_lane"]


def test_search_without_room_behind_names_the_blocker():
    """The reason is the vehicle that is too near, not one that is merely there."""
    follower = thing("follower", 50.0 - 4.9 / 2 - 0.7 - 2.3)
    decision = decide(World(ROAD, [car_ahead(0.6), follower, thing("far", 110.0)]))
    assert decision.plan is None
    assert "lead" in decision.analysis.reason or "follower" in decision.analysis.reason
    assert "far" not in decision.analysis.reason


def test_search_pedestrian_at_lane_edge_is_named():
    """What the guard refuses for is the cause, also if it is beside the path."""
    person = thing("walker", FRONT_X + 3.0, -1.35, kind=ObjectKind.PEDESTRIAN)
    wall = [thing(f"wall{k}", FRONT_X + 1.0 + 5.0 * k, 3.2, kind=ObjectKind.BARRIER, length=5.0) for k in range(3)]
    decision = decide(World(straight_road(oncoming=None), [person, *wall, thing("far", FRONT_X + 61.0 + 2.3)]))
    assert decision.plan is None or "walker" not in names(decision.plan)
    if decision.plan is None:
        assert "walker" in decision.analysis.reason
        assert "far" not in decision.analysis.reason


def test_search_short_sight_is_the_reason_with_its_amount():
    decision = decide(World(ROAD, [car_ahead(6.0)], sight_m=40.0))
    assert decision.plan is None
    assert "sight distance" in decision.analysis.reason and " m short" in decision.analysis.reason
    assert decision.analysis.cause is not CauseCode.LOOP


def test_search_free_road_is_driven_on():
    plan = decide(World(ROAD)).plan
    assert names(plan) == ["keep_lane"]
    assert plan.behaviors[0].distance_m >= 15.0


def test_search_vehicle_in_other_lane_returns_to_route():
    """An ego beside the route's lane looks at what is in its own path."""
    road = straight_road(left=ROAD.lanes[1].line[0])
    rock = thing("rock", FRONT_X + 5.0, 3.5, kind=ObjectKind.DEBRIS, length=0.8, width=0.8)
    plan = decide(World(road, [rock], y=3.5)).plan
    assert names(plan)[-1] in ("change_lane", "rejoin_route")


def test_search_aborted_plan_is_not_proposed_again_at_once():
    world = World(ROAD, [car_ahead(8.0)])
    first = decide(world).plan
    failed = FailedAttempt(
        time_s=world.time_s,
        behaviors=tuple(names(first)),
        ended=AttemptOutcome.ABORTED,
        plan=tuple(b.model_dump_json() for b in first.behaviors),
        outcome="aborted",
    )
    assert decide(world, attempts=(failed,)).plan != first


def test_search_without_a_plan_is_not_repeated_while_nothing_changes():
    """It is repeated after ten seconds, and when something stationary moves. Traffic does not matter."""
    reasoner, road = SearchReasoner(), straight_road(oncoming=None)

    def checks(*objects, time_s):
        world = World(road, list(objects))
        scene = world.scene().model_copy(update={"time_s": time_s})
        ego, seen = scene.ego.model_copy(update={"stopped_for_s": 15.0}), preview(world)
        decision = reasoner.decide(ReasonerRequest(scene.model_copy(update={"ego": ego}), assess=seen.assess)).decision
        assert decision.plan is None and "lead" in decision.rationale
        return seen.checks

    lead = car_ahead(6.0)
    assert checks(lead, time_s=0.0) > 0
    assert checks(lead, time_s=2.0) == 0
    assert checks(lead, thing("passer", 90.0, 3.5, speed=-8.0), time_s=4.0) == 0
    assert checks(car_ahead(7.0), time_s=6.0) > 0
    assert checks(car_ahead(7.0), time_s=17.0) > 0


def test_search_is_deterministic():
    world = World(ROAD, [car_ahead(3.0)])
    assert decide(world) == decide(world)


@pytest.mark.parametrize("seed", range(12))
def test_search_proposal_is_accepted_or_waits(seed):
    """In random worlds every proposal is one that the guard accepts now, after traffic, or with an approval."""
    rng = random.Random(seed)
    kinds = [ObjectKind.CAR, ObjectKind.PEDESTRIAN, ObjectKind.CONE, ObjectKind.TRUCK, ObjectKind.BICYCLE]
    objects = [
        thing(
            f"o{k}",
            FRONT_X + rng.uniform(0.5, 50.0),
            rng.uniform(-3.0, 6.0),
            kind=rng.choice(kinds),
            speed=rng.choice([0.0, 0.0, 0.0, 3.0]),
            hazard=rng.random() < 0.4,
        )
        for k in range(rng.randrange(1, 6))
    ]
    world = World(ROAD, objects, sight_m=rng.choice([60.0, 150.0, 300.0]))
    plan = decide(world).plan
    if plan is None or any(b.calls_person or b.directive() is not None for b in plan.behaviors):
        return
    assessment = preview(world).assess(plan)
    assert assessment.accepted or all(item.passing or item.approval for item in assessment.shortfalls)


# ---- whole plans


def test_preview_later_step_is_checked_where_it_begins():
    """After too short a way back the pass is still refused; after a longer one it is accepted."""
    world = World(ROAD, [car_ahead(1.0)])
    passing = BorrowOncomingLane(past_object_id="lead", speed_mps=5.5)
    near = preview(world).assess(RecoveryPlan(behaviors=(BackUp(distance_m=1.0), passing)))
    far = preview(world).assess(RecoveryPlan(behaviors=(BackUp(distance_m=6.0), passing)))
    assert near.step == 1 and not near.accepted
    assert far.accepted and far.back_m == pytest.approx(6.0)


def test_preview_shortfall_has_amount_and_unit():
    found = preview(World(ROAD, [car_ahead(8.0)], sight_m=50.0)).assess(
        RecoveryPlan(behaviors=(BorrowOncomingLane(past_object_id="lead", speed_mps=5.5),))
    )
    sight = next(item for item in found.shortfalls if item.code.value == "oncoming_sight")
    assert sight.unit == "m" and sight.missing is not None and sight.missing > 0.0


def test_preview_traffic_counts_as_passing_and_the_rest_is_checked():
    """A plan that only waits for traffic is checked for everything else as well."""
    oncoming = thing("oncoming", 120.0, 3.5, speed=-10.0)
    plan = RecoveryPlan(behaviors=(BorrowOncomingLane(past_object_id="lead", speed_mps=5.5),))
    waits = preview(World(ROAD, [car_ahead(8.0), oncoming])).assess(plan)
    assert waits.waits_for_traffic and waits.progress_m > 15.0
    blocked = thing("blocked", 66.0, 3.2, kind=ObjectKind.BARRIER, length=1.0, width=2.0)
    assert not preview(World(ROAD, [car_ahead(8.0), oncoming, blocked])).assess(plan).waits_for_traffic


def test_preview_free_distance_is_measured_at_the_end():
    ahead = preview(World(ROAD, [thing("far", 120.0)])).assess(
        RecoveryPlan(behaviors=(KeepLane(distance_m=20.0, speed_mps=5.5),))
    )
    assert ahead.progress_m == pytest.approx(20.0, abs=0.5)
    assert ahead.free_m == pytest.approx(120.0 - 2.3 - FRONT_X - 20.0, abs=0.6)
    assert math.isfinite(ahead.duration_s)
