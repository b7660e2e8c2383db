"""Ways past a blocker, in the route's frame: wide enough, back again, and never into whoever comes."""

from __future__ import annotations

import carla
import numpy as np
import pytest
from planner_stage import RIGHT, LitWorld

from stucksolver_carla.drivers.behavior.nearby_objects import NearbyObjects
from stucksolver_carla.drivers.behavior.path import make_path
from stucksolver_carla.drivers.behavior.route_bodies import objects_on_route
from stucksolver_carla.drivers.behavior.vehicle_model import VehicleModel
from stucksolver_carla.drivers.planner import PlannerDriver
from stucksolver_carla.drivers.planner.adjacent_lane_widths import AdjacentLaneWidths
from stucksolver_carla.drivers.planner.blockers import Blockers
from stucksolver_carla.drivers.planner.pass_planner import (
    PassContext,
    cost_s,
    is_clear,
    objects_to_pass,
    pass_candidates,
    pass_path,
    rollout,
)

MODEL = VehicleModel(2.4, 1.0, 2.9, 1.2)
LINE = make_path(np.arange(0.0, 400.0), np.zeros(400), np.full(400, 30.0))
NOBODY = (-60.0, 30.0, 2.4, 0.9, 0.0, 0.0)


def bodies(*rows):
    """Boxes x, y, half length, half width, vx, vy on a straight road along +x; right is +y."""
    columns = np.array(rows, dtype=np.float64).reshape(len(rows), 6).T
    x, y, length, width, vx, vy = columns
    flat = np.zeros(len(rows))
    return NearbyObjects(
        actor_id=tuple(range(len(rows))),
        is_walker=np.zeros(len(rows), np.bool_),
        x=x,
        y=y,
        yaw=flat,
        half_length=length,
        half_width=width,
        bottom=flat,
        top=flat + 1.5,
        vx=vx,
        vy=vy,
    )


def situation(*rows, s=50.0, speed=0.0, left_same=0.0, left_oncoming=3.5, right_same=0.0):
    widths = np.tile([1.75, left_same, left_oncoming, right_same], (400, 1))
    sides = AdjacentLaneWidths(np.arange(0.0, 400.0), widths)
    return PassContext(s, 0.0, speed, 13.0, objects_on_route(LINE, s, bodies(*rows)), sides, MODEL)


def ways(here, first=0):
    return list(pass_candidates(here, objects_to_pass(here, first, 1.7)))


def test_bodies_are_where_they_are_along_and_beside_the_route() -> None:
    found = objects_on_route(LINE, 50.0, bodies((80.0, -3.5, 2.4, 0.9, -8.0, 0.5)))
    assert found.s[0] == pytest.approx(80.0, abs=1e-6)
    assert found.d[0] == pytest.approx(-3.5, abs=1e-6)
    assert (found.vs[0], found.vd[0]) == pytest.approx((-8.0, 0.5))


@pytest.mark.parametrize("aside", [-0.6, 0.0, 1.2])
def test_pass_keeps_gap_to_object_and_returns(aside) -> None:
    here = situation((65.0, aside, 2.4, 0.9, 0.0, 0.0))
    found = ways(here)
    assert found
    for way in found:
        drive = rollout(here, way)
        beside = np.abs(drive.s - 65.0) < 2.4 + 2.4
        assert (np.abs(drive.d[beside] - aside) > 0.9 + 1.0 + 0.3).all()
        assert abs(drive.d[-1]) < 0.05


def test_without_a_lane_beside_there_is_no_way() -> None:
    assert not ways(situation((65.0, 0.0, 2.4, 0.9, 0.0, 0.0), left_oncoming=0.0))


def test_nothing_is_passed_by_leaving_the_lanes_on_the_right() -> None:
    here = situation((65.0, 0.0, 2.4, 0.9, 0.0, 0.0), right_same=3.5)
    assert {way.offset_m > 0 for way in ways(here)} == {True, False}
    assert all(way.offset_m < 0 for way in ways(situation((65.0, 0.0, 2.4, 0.9, 0.0, 0.0))))


@pytest.mark.parametrize("speed", [6.0, 10.0, 15.0, 20.0])
def test_no_pass_is_clear_that_would_meet_who_comes(speed) -> None:
    """For each distance: where a pass is called clear, nobody's box is touched as both drive on."""
    for far in range(70, 260, 5):
        here = situation((65.0, 0.0, 2.4, 0.9, 0.0, 0.0), (float(far), -3.5, 2.4, 0.9, -speed, 0.0))
        for way in ways(here):
            drive = rollout(here, way)
            theirs = far - speed * drive.t
            meets = (np.abs(theirs - drive.s) < 4.8) & (np.abs(drive.d + 3.5) < 1.9)
            assert not (is_clear(here, way) and meets.any())
    near = situation((65.0, 0.0, 2.4, 0.9, 0.0, 0.0), (90.0, -3.5, 2.4, 0.9, -speed, 0.0))
    assert not any(is_clear(near, way) for way in ways(near))
    assert all(is_clear(here, way) for here in [situation((65.0, 0.0, 2.4, 0.9, 0.0, 0.0))] for way in ways(here))


def test_pass_lets_fast_traffic_in_adjacent_lane_pass() -> None:
    """A vehicle that approaches from behind in the adjacent lane passes first."""
    here = situation(
        (65.0, 0.0, 2.4, 0.9, 0.0, 0.0), (30.0, -3.5, 2.4, 0.9, 12.0, 0.0), left_same=3.5, left_oncoming=0.0
    )
    assert ways(here)
    assert not any(is_clear(here, way) for way in ways(here))


def test_group_includes_close_vehicle_and_excludes_far_vehicle() -> None:
    """A vehicle close behind the passed one is passed with it; a farther one is not."""
    close = situation((65.0, 0.0, 2.4, 0.9, 0.0, 0.0), (78.0, 0.0, 2.4, 0.9, 0.0, 0.0))
    far = situation((65.0, 0.0, 2.4, 0.9, 0.0, 0.0), (85.0, 0.0, 2.4, 0.9, 0.0, 0.0))
    assert objects_to_pass(close, 0, 1.7).sum() == 2
    assert objects_to_pass(far, 0, 1.7).sum() == 1


def test_pass_parked_car_keeps_door_clearance_and_bicycle_none() -> None:
    """A parked vehicle is passed beyond its door where the lane is wide enough. A bicycle has no door."""

    def nearest(row, **lanes):
        here = situation(row, **lanes)
        return min(ways(here), key=lambda way: cost_s(here, way))

    parked = nearest((65.0, 0.0, 2.4, 0.9, 0.0, 0.0), left_same=3.5, left_oncoming=0.0)
    assert abs(parked.offset_m) - 0.9 - 1.0 > 1.0
    narrow = nearest((65.0, 0.0, 2.4, 0.9, 0.0, 0.0), left_oncoming=1.9)
    assert narrow.by_doors
    assert not nearest((65.0, 0.0, 0.9, 0.3, 0.0, 0.0)).by_doors


def test_the_path_is_the_line_with_the_pass_in_it() -> None:
    here = situation((70.0, 0.0, 2.4, 0.9, 0.0, 0.0))
    way = ways(here)[0]
    path = pass_path(LINE, here, way, 3.0, 2.5)
    assert path.y.min() == pytest.approx(way.offset_m, abs=0.1)
    assert abs(path.y[0]) < 0.05
    assert abs(path.y[-1]) < 0.01
    assert (path.speed <= np.sqrt(3.0 / np.maximum(np.abs(path.curvature), 1e-9)) + 1e-6).all()


@pytest.mark.parametrize(
    ("row", "stood_s", "hazard", "line_m", "is_worth"),
    [
        ((65.0, 0.0, 2.4, 0.9, 0.0, 0.0), 1.0, frozenset(), np.inf, False),
        ((65.0, 0.0, 2.4, 0.9, 0.0, 0.0), 4.0, frozenset(), np.inf, True),
        ((65.0, 0.0, 2.4, 0.9, 0.0, 0.0), 4.0, frozenset(), 80.0, False),
        ((65.0, 0.0, 2.4, 0.9, 0.0, 0.0), 0.0, frozenset({0}), 80.0, True),
        ((65.0, 0.0, 0.9, 0.3, 3.0, 0.0), 0.0, frozenset(), np.inf, True),
        ((65.0, 0.0, 2.4, 0.9, 5.0, 0.0), 0.0, frozenset(), np.inf, False),
        ((65.0, 3.5, 2.4, 0.9, 0.0, 0.0), 9.0, frozenset(), np.inf, False),
    ],
)
def test_blocker_stopped_for_own_reason_is_passed_and_queue_not(row, stood_s, hazard, line_m, is_worth) -> None:
    """A vehicle that is slow for a reason of its own is passed; a queue is not."""
    here, blockers = situation(row), Blockers()
    here = here._replace(sides=AdjacentLaneWidths(np.arange(0.0, 400.0), np.tile([1.75, 0.0, 3.5, 0.0], (400, 1))))
    blockers.observe(here.bodies, 100.0)
    found = blockers.first_blocker(here, 100.0 + stood_s, line_m, hazard)
    assert (found == 0) == is_worth


def passing_driver(here):
    """One that stands in the right lane and passes what is in the way in this situation."""
    world = LitWorld()
    driver = PlannerDriver(world.add_ego(20.0, RIGHT, 0.0, 0.0))
    driver.set_destination(world.map.get_waypoint(carla.Location(150.0, RIGHT, 0.0)).transform.location)
    driver._pass = ways(here)[0]
    return world, driver


@pytest.mark.parametrize(("far_m", "is_past"), [(62.0, True), (110.0, False)])
def test_oncoming_vehicle_past_before_swing_out_is_no_obstacle(far_m, is_past) -> None:
    """An oncoming vehicle that will be past before the ego swings out is no obstacle where it is now."""
    here = situation((75.0, 0.0, 2.4, 0.9, 0.0, 0.0), (far_m, -3.5, 2.4, 0.9, -12.0, 0.0))
    _, driver = passing_driver(here)
    driver._clear_oncoming(here)
    assert driver._cleared_ids == (frozenset({1}) if is_past else frozenset())


def test_planner_sets_off_despite_vehicle_proven_past_in_time() -> None:
    """The ego sets off although a vehicle that is proven to be past in time is in its path now."""
    world, driver = passing_driver(situation((75.0, 0.0, 2.4, 0.9, 0.0, 0.0)))
    comes = world.add("vehicle.a.b", 30.0, RIGHT, np.pi, speed=8.0)
    driver._choose_line = lambda *_: None
    brakes = driver.run_step().throttle
    driver._cleared_ids = frozenset({comes.id})
    assert driver.run_step().throttle > brakes + 0.2
