"""Who may come out of a junction where the oncoming lane begins: who turns in, and who comes straight on."""

from __future__ import annotations

import math

import numpy as np
import pytest

from stucksolver.guard import Guard, GuardPolicy
from stucksolver.guard.context import CheckContext
from stucksolver.guard.occluded_traffic import PhantomVehicle, phantom_vehicles, turning_mps
from stucksolver.plan.behaviors import BorrowOncomingLane
from stucksolver.scene import LaneDirection, LaneSight, Zone, ZoneKind
from stucksolver.scene.frenet_scene import FrenetScene
from worlds import World, straight_road, thing

POLICY = GuardPolicy()
GUARD = Guard()
START, END = 150, 166
"""The junction, as arc lengths along a straight road."""
LIMIT_MPS = 13.4


def cut(strip, name, first, last):
    part = {key: getattr(strip, key)[first:last] for key in ("offset_m", "width_m", "line")}
    return strip.model_copy(update={"id": name, "start": first, **part})


def crossroads():
    """The oncoming lane ends at the junction, and goes on beyond it."""
    road = straight_road(zones=(Zone(kind=ZoneKind.JUNCTION, start_m=float(START), end_m=float(END)),))
    own, other = road.lanes
    lanes = (own, cut(other, "near", 0, START + 1), cut(other, "beyond", END, 401))
    return road.model_copy(update={"key": "crossroads", "lanes": lanes})


def case_of(*objects, beyond_m=250.0, near_m=100.0, road=None):
    world = World(road or crossroads(), [thing("lead", 65.0), *objects])
    told = (("own", 300.0), ("near", near_m), ("beyond", beyond_m))
    sight = tuple(LaneSight(lane_id=name, ahead_m=ahead, behind_m=50.0) for name, ahead in told)
    view = FrenetScene(world.surroundings().model_copy(update={"sight": sight}))
    path = GUARD.lay_out([BorrowOncomingLane(past_object_id="lead", speed_mps=5.0)], view, False, frozenset()).path
    return CheckContext(view, path, POLICY)


def near_lane(case):
    return next(lane for lane in case.view.frame.lanes if lane.strip.direction is LaneDirection.OPPOSITE)


def may_come(*objects, **told):
    case = case_of(*objects, **told)
    return phantom_vehicles(case, near_lane(case))


WORST = (PhantomVehicle(100.0, LIMIT_MPS, LIMIT_MPS),)


def test_seen_through_a_junction_only_turning_traffic_is_near():
    turning, straight = may_come()
    assert turning.at_m == 100.0 and turning.limit_mps == LIMIT_MPS
    assert turning.speed_mps == pytest.approx(math.sqrt(4.0 * (END - START) / math.sin(1.05)))
    assert straight == PhantomVehicle(250.0, LIMIT_MPS, LIMIT_MPS)


@pytest.mark.parametrize("told", [{"beyond_m": 0.0}, {"beyond_m": 115.0}, {"near_m": 60.0}])
def test_what_is_not_seen_through_keeps_the_worst_case(told):
    edge = told.get("near_m", 100.0)
    assert may_come(**told) == (PhantomVehicle(edge, LIMIT_MPS, LIMIT_MPS),)


def test_phantom_lane_end_without_junction_is_worst_case():
    """A lane that ends without a junction keeps the worst case."""
    road = crossroads().model_copy(update={"key": "no junction", "zones": ()})
    assert may_come(road=road) == WORST


def test_phantom_junction_without_lane_beyond_is_worst_case():
    """A junction without a known lane beyond it keeps the worst case.

    A T-junction, or a route that turns: through traffic is not on a known lane.
    """
    road = crossroads()
    road = road.model_copy(update={"key": "T", "lanes": road.lanes[:2]})
    assert may_come(road=road) == WORST


def test_phantom_fast_vehicle_in_junction_raises_speed():
    """A vehicle that is perceived as faster in the junction raises the assumed speed."""
    turning, _ = may_come(thing("there", 158.0, 8.0, sideways=-10.0))
    assert turning.speed_mps == pytest.approx(10.0)
    assert may_come(thing("there", 158.0, 8.0, sideways=-14.0)) == WORST


def test_turning_speed_keeps_lateral_acceleration_on_each_arc():
    """A turning vehicle stays within the lateral acceleration on every arc that fits.

    An arc that turns into the lane from a road at an angle needs R sin(angle) of the junction's length.
    """
    most = turning_mps(20.0, POLICY.oncoming)
    for angle in np.linspace(POLICY.oncoming.least_crossing_rad, math.pi / 2, 20):
        radius = 20.0 / math.sin(angle)
        assert math.sqrt(POLICY.oncoming.turning_mps2 * radius) <= most + 1e-9


@pytest.mark.parametrize("duration_s", [0.0, 0.7, 3.0, 12.0])
def test_phantom_distance_is_that_of_accelerating_to_limit(duration_s):
    """A phantom vehicle covers the distance of a vehicle that accelerates to the speed limit."""
    one = PhantomVehicle(100.0, 6.0, 13.0, 3.0)
    t = np.linspace(0.0, duration_s, 20001)
    speed = np.minimum(6.0 + 3.0 * t, 13.0)
    assert one.way_m(duration_s) == pytest.approx(float(((speed[1:] + speed[:-1]) / 2 * np.diff(t)).sum()), abs=1e-3)
    assert one.way_m(duration_s) <= PhantomVehicle(100.0, 13.0, 13.0).way_m(duration_s)


def test_phantom_turning_vehicle_distance_covers_simulated_vehicle():
    """The distance of a turning phantom vehicle is at least that of a simulated one until the ego is back.

    With just the required sight, its front is the margin away, or more.
    """
    for length in (8.0, 16.0, 24.0):
        v, x, t = turning_mps(length, POLICY.oncoming), 0.0, 0.0
        turning = PhantomVehicle(0.0, v, LIMIT_MPS, POLICY.oncoming.turned_accelerates_mps2)
        while t < 7.0:
            x, v, t = x + v * 0.001, min(v + 3.0 * 0.001, LIMIT_MPS), t + 0.001
        assert turning.way_m(7.0) >= x - 0.05


def test_sight_beyond_junction_reduces_required_sight_distance():
    """Sight beyond the junction reduces the required sight distance, and the verdict reports by how much.

    Found by trying sight distances: less is required, and never less than turning traffic needs.
    """
    asked = []
    for beyond_m in (0.0, 300.0):
        case = case_of(beyond_m=beyond_m)
        sight = {"near": 100.0, "beyond": beyond_m, "own": 300.0}
        verdict, _ = GUARD.accept(
            [BorrowOncomingLane(past_object_id="lead", speed_mps=5.0)], with_sight(case.view, sight), False
        )
        proof = verdict.sight or verdict.rejects[0]
        asked.append(proof.needed_m)
        assert proof.seen_m == 100.0
    assert asked[1] < asked[0] - 2.0


def with_sight(view, lengths_m):
    sight = tuple(LaneSight(lane_id=name, ahead_m=ahead, behind_m=50.0) for name, ahead in lengths_m.items())
    return FrenetScene(view.surroundings.model_copy(update={"sight": sight}))
