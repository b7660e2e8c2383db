"""Lanes on a real map, without a server: outside of them, and in the wrong one."""

from __future__ import annotations

from functools import cache
from typing import Any

import pytest

carla = pytest.importorskip("carla")

from carlette.maps import DEMO_TOWN  # noqa: E402
from stucksolver_carla.drivers.behavior.routing import trace_route  # noqa: E402
from stucksolver_eval.criteria import EgoTick  # noqa: E402
from stucksolver_eval.criteria.outside_lanes import OutsideLanes, between  # noqa: E402
from stucksolver_eval.criteria.route_position import RouteWalk  # noqa: E402
from stucksolver_eval.routes.route_line import RouteLine  # noqa: E402

LENGTH = 60


@cache
def town() -> Any:
    return carla.Map("demo_town", DEMO_TOWN.read_text(encoding="utf-8"))


@cache
def line() -> RouteLine:
    """60 m of a two-way street with an oncoming lane beside it."""
    for start in town().generate_waypoints(10.0):
        end = start
        for _ in range(LENGTH):
            following = [] if end.is_junction else end.next(1.0)
            end = following[0] if following else end
        left = start.get_left_lane()
        straight = not end.is_junction and end.road_id == start.road_id and end.s != start.s
        if (
            straight
            and left is not None
            and left.lane_id * start.lane_id < 0
            and left.lane_type == carla.LaneType.Driving
        ):
            return RouteLine.along(trace_route(town(), start.transform.location, end.transform.location))
    raise AssertionError("the town has no two-way street")


def driven(aside_m: float, suspended: frozenset[str] = frozenset(), back_at: int = LENGTH) -> OutsideLanes:
    """Along the street, `aside_m` to the left of the lane's center from its tenth meter on."""
    walk, points = RouteWalk(line()), line().waypoints
    criterion = OutsideLanes(town(), walk, points[0].transform.location)
    for k, waypoint in enumerate(points):
        transform = waypoint.transform
        left = -aside_m if 10 <= k < back_at else 0.0
        right = transform.get_right_vector()
        ahead = transform.get_forward_vector()
        place = transform.location + carla.Location(left * right.x + 0.1 * ahead.x, left * right.y + 0.1 * ahead.y, 0.0)
        here = carla.Transform(place, transform.rotation)
        criterion.update(EgoTick(k, 0.05 * k, here, carla.Vector3D(), suspended=suspended))
    return criterion


def test_in_the_lane_nothing_is_noted() -> None:
    assert driven(0.0).infractions == []


def test_wrong_lane_oncoming_lane_counts_with_its_share() -> None:
    """The oncoming lane is a wrong lane, and the infraction states the share of the route in it."""
    (infraction,) = driven(float(line().waypoints[0].lane_width)).infractions
    assert infraction.percentage == pytest.approx(100.0 * (LENGTH - 9) / LENGTH, abs=4.0)


def test_coming_back_ends_it() -> None:
    (infraction,) = driven(float(line().waypoints[0].lane_width), back_at=30).infractions
    assert infraction.percentage == pytest.approx(100.0 * 20 / LENGTH, abs=4.0)


def test_a_scenario_may_allow_the_oncoming_lane() -> None:
    assert driven(float(line().waypoints[0].lane_width), frozenset({"wrong_lane"})).infractions == []


@pytest.mark.parametrize(("angle", "inside"), [(119, True), (-119, True), (121, False), (241, True), (180, False)])
def test_angles_wrap(angle: float, inside: bool) -> None:
    assert between(angle, 120.0) is inside
