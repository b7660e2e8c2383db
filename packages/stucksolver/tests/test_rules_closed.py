"""A road that is closed from kerb to kerb is left for another one, where there is one."""

from __future__ import annotations

import pytest

from stucksolver.reasoners import ReasonerRequest, RuleReasoner
from stucksolver.scene import CandidateWaypoint, FailedAttempt
from test_rules_moves import MULTI, NARROW, TWO_WAY, K
from worlds import LANE_M, NAMES, World, said, thing


def row(first_m, last_m, kind=K.BARRIER, **more):
    """Barriers 1.2 m wide side by side, 10 m ahead, from the right to the left."""
    count = round((last_m - first_m) / 1.2) + 1
    usual = {"kind": kind, "length": 0.4, "width": 1.2, **more}
    return [thing(f"b{k}", 62.5, first_m + 1.2 * k, **usual) for k in range(count)]


def elsewhere(name, length_m, reaches=True, lane="other"):
    return CandidateWaypoint(
        id=name, lane_id=lane, x_m=4.0, y_m=2.0, distance_m=4.5, reaches_destination=reaches, route_length_m=length_m
    )


def decide(road, things, *waypoints, **more):
    scene = World(road, things, offers=more.pop("offers", NAMES)).scene()
    ego = scene.ego.model_copy(update={"stopped_for_s": 5.0})
    scene = scene.model_copy(update={"ego": ego, "waypoints": waypoints, **more})
    return RuleReasoner().decide(ReasonerRequest(scene)).decision


def replanned(decision):
    """From where the route is planned anew; None where it is not."""
    behaviors = decision.plan.behaviors if decision.plan else ()
    return behaviors[0].route_start if behaviors and behaviors[0].name == "replan" else None


WHOLE = row(-1.2, LANE_M + 1.5)


@pytest.mark.parametrize("kind", [K.BARRIER, K.CONE])
def test_a_closed_road_is_left_by_the_shortest_other_way(kind):
    things = row(-1.2, LANE_M + 1.5, kind)
    decision = decide(TWO_WAY, things, elsewhere("far", 900.0), elsewhere("near", 500.0))
    assert replanned(decision) == "near"
    assert "closed from kerb to kerb" in decision.rationale


@pytest.mark.parametrize("road", [NARROW, MULTI, TWO_WAY], ids=["one lane", "two of ours", "one each way"])
def test_all_lanes_must_be_closed(road):
    things = row(-1.2, 1.2)
    assert replanned(decide(road, things, elsewhere("a", 500.0))) == ("a" if road is NARROW else None)


@pytest.mark.parametrize(("free_m", "closed"), [(1.1, True), (1.4, True), (1.6, False)])
def test_one_lane_is_closed_where_no_car_fits_beside(free_m, closed):
    middle_m = LANE_M / 2 - free_m - 0.6
    things = [thing("b", 62.5, middle_m, kind=K.BARRIER, length=0.4, width=1.2)]
    assert replanned(decide(NARROW, things, elsewhere("a", 500.0))) == ("a" if closed else None)


def test_one_cone_closes_no_lane():
    cone = thing("c", 62.5, 0.0, kind=K.CONE, length=0.6, width=0.6)
    assert replanned(decide(NARROW, [cone], elsewhere("a", 500.0))) is None


@pytest.mark.parametrize(("behind_m", "taken"), [(0.1, True), (0.8, True), (1.5, False)])
def test_a_way_that_starts_abreast_is_taken(behind_m, taken):
    start = elsewhere("a", 500.0).model_copy(update={"x_m": -behind_m})
    assert replanned(decide(TWO_WAY, WHOLE, start)) == ("a" if taken else None)


def test_row_with_gap_for_car_is_not_closed():
    things = [item for item in row(-1.2, LANE_M + 3.0) if not 1.5 < item.y_m < 4.0]
    assert replanned(decide(TWO_WAY, things, elsewhere("a", 500.0))) is None


def test_vehicles_close_no_road():
    things = [thing("truck", 62.5, stationary_s=40.0), thing("car", 62.5, LANE_M, stationary_s=40.0)]
    assert replanned(decide(TWO_WAY, things, elsewhere("a", 500.0))) is None


@pytest.mark.parametrize(
    "waypoint",
    [
        elsewhere("lost", None, reaches=False),
        elsewhere("unknown", None, reaches=None),
        elsewhere("here", 500.0, lane="own"),
    ],
    ids=["leads nowhere", "not known where it leads", "in the closed road"],
)
def test_replan_needs_waypoint_beside_route_reaching_destination(waypoint):
    """Only a waypoint beside the route that reaches the destination is used."""
    assert replanned(decide(TWO_WAY, WHOLE, waypoint)) is None


def test_a_stack_that_cannot_plan_anew_is_not_asked_to():
    offers = tuple(name for name in NAMES if name != "replan")
    assert replanned(decide(TWO_WAY, WHOLE, elsewhere("a", 500.0), offers=offers)) is None


def test_another_route_is_planned_once():
    tried = FailedAttempt(time_s=0.0, behaviors=("replan",), outcome="it was done, and the vehicle did not get on")
    assert replanned(decide(TWO_WAY, WHOLE, elsewhere("a", 500.0), attempts=(tried,))) is None


def test_guidance_to_pass_prevents_replan():
    """A passenger who asks to pass is not taken along another route."""
    words = said("overtake on the left")
    assert replanned(decide(TWO_WAY, WHOLE, elsewhere("a", 500.0), guidance=words)) is None


def test_replan_by_guidance_without_other_road_is_explained():
    """Another street is not tried where every route to the destination returns to the same place."""
    back = elsewhere("back", None, reaches=False).model_copy(update={"x_m": -9.0})
    van = [thing("van", 60.0, 0.0, stationary_s=60.0, seen_for_s=60.0)]
    asked = said("Take another street.")
    decision = decide(TWO_WAY, van, back, guidance=asked)
    assert decision.plan is None
    assert "no other road" in decision.rationale
    assert replanned(decide(TWO_WAY, van, back, elsewhere("side", 500.0), guidance=asked)) == "side"


SENSED = {"position_sd_m": 0.05}


def misnamed(kind, **more):
    """A closed road as sensors see it: every second barrier is taken for something else."""
    seen = row(-1.2, LANE_M + 1.5, **SENSED)
    return [item.model_copy(update={"kind": kind, **more}) if k % 2 else item for k, item in enumerate(seen)]


STOOD = {"stationary_s": 20.0, "moved_s_ago": 20.0}


@pytest.mark.parametrize("kind", [K.UNKNOWN, K.PROP, K.DEBRIS])
def test_what_sensors_cannot_name_closes_a_road_between_barriers(kind):
    assert replanned(decide(TWO_WAY, misnamed(kind, **STOOD), elsewhere("a", 500.0))) == "a"


@pytest.mark.parametrize(
    ("kind", "more"),
    [
        (K.CAR, STOOD),
        (K.PEDESTRIAN, STOOD),
        (K.UNKNOWN, {"stationary_s": 8.0, "moved_s_ago": 8.0}),
        (K.DEBRIS, {**STOOD, "width_m": 0.4}),
        (K.UNKNOWN, {**STOOD, "position_sd_m": None}),
    ],
    ids=["a car", "a person", "not for long", "small", "ground truth"],
)
def test_nothing_else_closes_a_road(kind, more):
    assert replanned(decide(TWO_WAY, misnamed(kind, **more), elsewhere("a", 500.0))) is None


def test_without_a_barrier_in_the_row_no_road_is_closed():
    things = [item.model_copy(update={"kind": K.UNKNOWN, **STOOD}) for item in row(-1.2, LANE_M + 1.5, **SENSED)]
    assert replanned(decide(TWO_WAY, things, elsewhere("a", 500.0))) is None
