"""A route laid on a map, without a server."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest

carla = pytest.importorskip("carla")

from carlette.maps import DEMO_TOWN  # noqa: E402
from stucksolver_carla.stack.route_road import new_ground  # noqa: E402
from stucksolver_eval.routes import Position  # noqa: E402
from stucksolver_eval.routes.route_line import RouteLine  # noqa: E402


@pytest.fixture(scope="module")
def line() -> RouteLine:
    town = carla.Map("demo_town", DEMO_TOWN.read_text(encoding="utf-8"))
    here = min((w for w, _ in town.get_topology() if not w.is_junction), key=lambda w: (w.road_id, w.lane_id))
    places = [here]
    for _ in range(2):
        places.append(_onward(places[-1], 80))
    return RouteLine.trace(town, [_position(w) for w in places])


def _onward(waypoint: Any, steps: int) -> Any:
    for _ in range(steps):
        waypoint = waypoint.next(1.0)[0]
    return waypoint


def _position(waypoint: Any) -> Position:
    place = waypoint.transform.location
    return Position(place.x, place.y, place.z)


def test_points_lie_about_a_metre_apart_and_arc_lengths_grow(line: RouteLine) -> None:
    steps = np.diff(line.s_m)
    assert steps.min() > 0.2 and steps.max() < 2.1
    assert line.length_m == pytest.approx(160.0, rel=0.05)
    assert len(line.waypoints) == len(line.s_m) == len(line.commands) == len(line.points)


def test_a_place_is_found_again_at_its_arc_length(line: RouteLine) -> None:
    for index in range(0, len(line.waypoints), 7):
        place = line.waypoints[index].transform.location
        assert line.project(place, max(index - 5, 0)) == index == line.index_at(float(line.s_m[index]))


def test_a_jump_is_followed(line: RouteLine) -> None:
    last = len(line.waypoints) - 1
    assert line.project(line.waypoints[last].transform.location, 0) == last


def test_beyond_its_ends_the_ends_are_meant(line: RouteLine) -> None:
    assert line.waypoint_at(-5.0) is line.waypoints[0]
    assert line.waypoint_at(1e6) is line.waypoints[-1]


def test_headings_point_along_the_line(line: RouteLine) -> None:
    for k, (a, b) in enumerate(pairwise(line.xyz)):
        assert (b - a) @ line.forward[k] > 0.0


def test_route_line_replanned_part_joins_first_part(line: RouteLine) -> None:
    """A replanned line continues the first one at the index where the ego left it."""
    other = RouteLine.along(line.points[20:])
    joined = line.joined(50, other)
    assert joined.length_m == pytest.approx(line.length_m, abs=1.0)
    assert joined.waypoints[:51] == line.waypoints[:51]
    assert joined.waypoints[-1].transform.location == line.waypoints[-1].transform.location


def test_laps_of_a_roundabout_are_new_ground_once() -> None:
    angle = np.linspace(0.0, 6.0 * np.pi, 240)
    ring = np.column_stack([22.0 * np.cos(angle), 22.0 * np.sin(angle)])
    into, out = np.column_stack([np.full(50, 22.0), np.linspace(-100.0, -2.0, 50)]), ring[-1] + [[60.0, 0.0]]
    points = np.vstack([into, ring, out])
    arc = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    new_m = new_ground(points, arc)
    lap_m = 2.0 * np.pi * 22.0
    assert np.all(np.diff(new_m) >= 0.0) and np.allclose(new_m[:50], arc[:50])
    assert new_m[-2] == pytest.approx(100.0 + lap_m, abs=12.0)
    assert new_m[-1] == pytest.approx(new_m[-2] + 60.0)
