"""A road without a way past is left for another one, where there is one."""

from __future__ import annotations

import pytest

from stucksolver.scene import CandidateWaypoint, FailedAttempt
from test_search_moves import MULTI, NARROW, TWO_WAY, K
from worlds import LANE_M, NAMES, World, said, searched, thing


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
    world = World(road, things, offers=more.pop("offers", NAMES))
    scene = world.scene()
    ego = scene.ego.model_copy(update={"stopped_for_s": 10.0})
    scene = scene.model_copy(update={"ego": ego, "waypoints": waypoints, **more})
    return searched(world, scene)


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
    assert "take another road" in decision.rationale


@pytest.mark.parametrize("road", [NARROW, MULTI, TWO_WAY], ids=["one lane", "two of ours", "one each way"])
def test_all_lanes_must_be_closed(road):
    things = row(-1.2, 1.2)
    assert replanned(decide(road, things, elsewhere("a", 500.0))) == ("a" if road is NARROW else None)


@pytest.mark.parametrize(
    ("behind_m", "names"), [(0.1, ["replan"]), (0.8, ["replan"]), (1.5, ["back_up", "replan"]), (5.0, [])]
)
def test_road_that_starts_abreast_is_taken(behind_m, names):
    """The ego backs up to one that starts a little behind."""
    start = elsewhere("a", 500.0).model_copy(update={"x_m": -behind_m})
    plan = decide(TWO_WAY, WHOLE, start).plan
    assert [behavior.name for behavior in plan.behaviors if plan is not None] == names if names else plan is None


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


def test_single_cone_is_passed_and_no_reason_for_another_road():
    cone = thing("c", 62.5, 0.0, kind=K.CONE, length=0.6, width=0.6)
    assert replanned(decide(TWO_WAY, [cone], elsewhere("a", 500.0))) is None


def test_row_with_a_gap_for_the_ego_is_passed():
    things = [item for item in row(-1.2, LANE_M + 3.0) if not 1.5 < item.y_m < 5.5]
    assert replanned(decide(TWO_WAY, things, elsewhere("a", 500.0))) is None
