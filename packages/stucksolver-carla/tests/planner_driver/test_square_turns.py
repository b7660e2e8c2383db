"""Left turns across a stream that brakes for nobody: steeply, in a proven gap, and never with a stop in the stream."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import carla
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from planner_stage import RIGHT, LitWorld
from test_streams import MODEL, PROFILE

from stucksolver_carla.drivers.behavior.acceleration_limits import USUAL
from stucksolver_carla.drivers.behavior.conflict_paths import ConflictPath, JunctionConflicts
from stucksolver_carla.drivers.behavior.junction_yield import EgoSpeeds
from stucksolver_carla.drivers.behavior.nearby_objects import NearbyObjects
from stucksolver_carla.drivers.behavior.path import limited_speed, make_path
from stucksolver_carla.drivers.behavior.route_line import curve_speed
from stucksolver_carla.drivers.planner import PlannerDriver, unprotected_turn
from stucksolver_carla.drivers.planner.square_turns import RADIUS_M, oncoming_paths, with_square_turn
from stucksolver_carla.drivers.planner.unprotected_turn import UnprotectedTurnYield

WIDE_M = 20.0
"""Radius of the lanes' own arc."""
ONCOMING_Y = -3.5
"""The oncoming lane, left of the route's first part."""
WAIT_S = 58.0


def anywhere(x, y, z):
    return True


def wide_turn():
    """Sixty meters ahead, a wide arc to the left, and on; CARLA's frame, in which left is towards smaller y."""
    angle = np.linspace(0.0, np.pi / 2.0, 40)[1:-1]
    x = np.concatenate([np.arange(0.0, 60.5), 60.0 + WIDE_M * np.sin(angle), np.full(60, 60.0 + WIDE_M)])
    y = np.concatenate([np.zeros(61), WIDE_M * (np.cos(angle) - 1.0), -WIDE_M - np.arange(60.0)])
    return make_path(x, y, np.full(len(x), 100.0))


def oncoming(line):
    """A straight oncoming way that meets the line where that is near its lane."""
    near = line.s[np.abs(line.y - ONCOMING_Y) < 2.2]
    s = np.arange(0.0, 200.0)
    x = 180.0 - s
    meets, parts = (180.0 - float(np.interp(item, line.s, line.x)) for item in (near[-1], near[0]))
    return ConflictPath(
        x=x, y=0.0 * s + ONCOMING_Y, yaw=0.0 * s + np.pi, s=s, inside_s=90.0, meets_s=meets, parts_s=parts,
        route_meets_s=float(near[0]), route_parts_s=float(near[-1]), straight=True, bend_mps=70.0, joins=False,
        approach=(1, 0, 1), goes_first=True, lights=(),
    )  # fmt: skip


def met_on(line):
    return JunctionConflicts(WAIT_S, (oncoming(line),))


def square_line():
    line = wide_turn()
    found = with_square_turn(line, met_on(line), 1.0, anywhere)
    assert found is not None
    bounds = limited_speed(found.line.s, curve_speed(found.line.curvature, PROFILE.lateral_accel), 2.5)
    return replace(found.line, speed=bounds)


SQUARE = square_line()


def cars(*places):
    """Cars that come at 9 m/s along the oncoming lane, with their centers at these x."""
    n = len(places)
    one = np.ones(n)
    return NearbyObjects(
        tuple(range(10, 10 + n)), np.zeros(n, np.bool_), np.array(places, dtype=np.float64), one * ONCOMING_Y,
        one * np.pi, one * 2.4, one * 0.95, one * 0.0, one * 1.5, -9.0 * one, 0.0 * one,
    )  # fmt: skip


def watch():
    return UnprotectedTurnYield([met_on(SQUARE)], PROFILE, MODEL, SQUARE, WAIT_S)


def look(gives_way, front, speed, around):
    return gives_way.decide(SQUARE, front - MODEL.half_length, EgoSpeeds(speed, 12.0), around, 0.05)


def test_square_turn_has_shorter_conflict_and_same_end() -> None:
    """A square turn is shorter in the path of the flow and ends where the wide turn does."""
    line = wide_turn()
    assert np.abs(SQUARE.curvature).max() == pytest.approx(1.0 / RADIUS_M, rel=0.05)
    before, after = oncoming(line), oncoming(SQUARE)
    assert after.route_parts_s - after.route_meets_s < 0.7 * (before.route_parts_s - before.route_meets_s)
    assert (SQUARE.x[-1], SQUARE.y[-1]) == pytest.approx((line.x[-1], line.y[-1]))


def test_square_turn_moves_later_places_by_added_length() -> None:
    """Places beyond the turn move by as much as the line is longer."""
    line = wide_turn()
    found = with_square_turn(line, met_on(line), 1.0, anywhere)
    assert found is not None
    assert found.arc_lengths_on_new(np.array([10.0, line.length])) == pytest.approx([10.0, found.line.length])


def test_square_turn_at_road_end_joins_lane_arc() -> None:
    """Where the road ends at the junction, the square turn joins the arc of the lane."""
    line = wide_turn()

    def near_the_lanes(x, y, z):
        return y > -8.75 or float(np.hypot(line.x - x, line.y - y).min()) < 1.75

    found = with_square_turn(line, met_on(line), 0.9, near_the_lanes)
    assert found is not None
    assert 0.0 < found.longer_m < SQUARE.length - line.length


def test_square_turn_leaving_road_is_not_used() -> None:
    """A turn that would leave the road stays as it is."""
    line = wide_turn()
    assert with_square_turn(line, met_on(line), 1.0, lambda x, y, z: False) is None


def test_square_turn_changes_only_left_turns() -> None:
    """A straight path and a right turn stay as they are."""
    line, right = make_path(np.arange(150.0), np.zeros(150), np.full(150, 30.0)), wide_turn()
    right = make_path(right.x, -right.y, right.speed)
    meeting = met_on(wide_turn())
    assert with_square_turn(line, meeting, 1.0, anywhere) is None
    assert with_square_turn(right, meeting, 1.0, anywhere) is None


def test_stream_ways_are_oncoming_through_traffic_with_priority() -> None:
    """Only straight oncoming traffic with the right of way is a traffic flow."""
    way = oncoming(SQUARE)
    others = (replace(way, straight=False), replace(way, joins=True), replace(way, goes_first=False))
    assert oncoming_paths(SQUARE, JunctionConflicts(WAIT_S, (way, *others))) == [way]


def sets_off(spacing_m):
    """True if there is a moment at which it sets off between cars so far apart."""
    trains = [cars(*np.arange(first, 220.0, spacing_m)) for first in np.arange(spacing_m, 0.0, -0.5)]
    return any(look(watch(), WAIT_S - 1.0, 0.0, train).wait_m is None for train in trains)


def test_turn_yield_accepts_gaps_that_fit_vehicle() -> None:
    """The ego crosses in gaps in which its body fits, and in no shorter ones."""
    assert sets_off(26.0)
    assert not sets_off(15.0)


@pytest.mark.integration
@given(st.floats(WAIT_S - 2.0, 90.0), st.floats(0.0, 8.0), st.floats(60.0, 110.0), st.booleans())
def test_it_never_stops_in_the_stream(front, speed, car_x, going) -> None:
    gives_way = watch()
    if going:
        look(gives_way, WAIT_S - 1.0, 0.0, cars())
    found = look(gives_way, front, speed, cars(car_x, car_x + 10.0, car_x - 10.0))
    meets_s = oncoming(SQUARE).route_meets_s
    if found.wait_m is not None:
        assert front + found.wait_m < meets_s
    if going and front > meets_s:
        assert found.wait_m is None


def test_turn_yield_started_ego_stops_before_late_flow() -> None:
    """An ego that has set off stops before the flow if a vehicle comes after all."""
    gives_way = watch()
    assert look(gives_way, WAIT_S - 1.0, 0.0, cars()).wait_m is None
    assert look(gives_way, WAIT_S + 1.0, 3.0, cars(*np.arange(50.0, 130.0, 11.0))).wait_m is not None
    assert not gives_way.has_started


def test_turn_yield_stops_before_other_conflict_path() -> None:
    """The ego stops before the path of a vehicle that comes ahead of the flow."""
    s = np.arange(0.0, 100.0)
    across = replace(
        oncoming(SQUARE), x=0.0 * s + 66.0, y=s - 50.0, yaw=0.0 * s + np.pi / 2.0, s=s, inside_s=40.0, meets_s=48.0,
        parts_s=52.0, route_meets_s=64.0, route_parts_s=68.0,
    )  # fmt: skip
    gives_way = UnprotectedTurnYield(
        [JunctionConflicts(WAIT_S, (oncoming(SQUARE), across))], PROFILE, MODEL, SQUARE, WAIT_S
    )
    comes = replace(cars(66.0), y=np.full(1, -16.0), yaw=np.full(1, np.pi / 2.0), vx=np.zeros(1), vy=np.full(1, 9.0))
    found = look(gives_way, WAIT_S + 1.0, 2.0, comes)
    assert found.wait_m is not None
    assert WAIT_S + 1.0 + found.wait_m < 64.0


def test_it_crosses_faster_than_it_turns_elsewhere() -> None:
    gives_way = watch()
    look(gives_way, WAIT_S - 1.0, 0.0, cars())
    assert gives_way.pace is unprotected_turn.CROSSING_PACE
    assert unprotected_turn.CROSSING_PACE.bends > USUAL.bends


def joining_watch(front):
    """One that drives straight on into a stream of its direction, which it joins at 70 m and whose junction ends at 85;
    it has set off, and its front is at `front`.
    """
    line = make_path(np.arange(0.0, 300.0), np.zeros(300), np.full(300, 30.0))
    s = np.arange(0.0, 200.0)
    way = replace(
        oncoming(SQUARE), x=s, y=0.0 * s, yaw=0.0 * s, inside_s=50.0, meets_s=70.0, parts_s=85.0, route_meets_s=70.0,
        route_parts_s=85.0, joins=True,
    )  # fmt: skip
    gives_way = UnprotectedTurnYield([JunctionConflicts(WAIT_S, (way,))], PROFILE, MODEL, line, WAIT_S)
    ahead = replace(cars(120.0), yaw=np.zeros(1), vx=np.full(1, 14.0), y=np.zeros(1))
    for place, speed in ((WAIT_S - 1.0, 0.0), (front, 8.0)):
        gives_way.decide(line, place - MODEL.half_length, EgoSpeeds(speed, 8.0), ahead, 0.05)
    return gives_way


def test_joined_flow_sets_speed_until_ego_is_in_lane() -> None:
    """A joined flow sets the speed until the ego drives in its lane."""
    assert joining_watch(95.0).flow_mps == pytest.approx(14.0)
    assert joining_watch(120.0).flow_mps == 0.0


def test_it_counts_on_no_more_acceleration_than_the_car_has() -> None:
    assert unprotected_turn.max_acceleration(1.0) > 3.5
    assert unprotected_turn.max_acceleration(12.0) < 2.2


@pytest.mark.parametrize(("ahead_m", "presses"), [(1.0, True), (-1.0, False)])
def test_planner_changes_entry_path_only_before_junction(ahead_m, presses) -> None:
    """The planner selects another path into a flow only before the junction."""
    world = LitWorld()
    driver = PlannerDriver(world.add_ego(20.0, RIGHT, 0.0, 0.0))
    driver.set_destination(world.map.get_waypoint(carla.Location(150.0, RIGHT, 0.0)).transform.location)
    line, front = driver._planner.route_line, driver._planner.route_s + driver._model.half_length
    waits_at = JunctionConflicts(front + ahead_m, (replace(oncoming(SQUARE), joins=True),)), 30.0
    driver._yield = SimpleNamespace(waits_at=waits_at)
    driver._switch_line_for_flow(line, driver._sides, driver._motion())
    assert (driver._flow_wait_s is not None) == presses
