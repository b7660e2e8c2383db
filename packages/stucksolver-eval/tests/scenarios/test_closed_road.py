"""The closed streets of the suite are closed from kerb to kerb, at their mouth."""

from __future__ import annotations

import itertools

import pytest

carla = pytest.importorskip("carla")

from stucksolver_eval.routes.route_line import RouteLine  # noqa: E402
from stucksolver_eval.scenarios.families.lane_places import FOR_VEHICLES, SPACING_M, row_across  # noqa: E402
from stucksolver_eval.suites import build, suite  # noqa: E402

ROUTES = [route for route in suite("immobilized").routes if route.scenarios[0].type == "ClosedRoad"]


@pytest.fixture(scope="module")
def town():
    return next(town for town in build.load_towns() if town.name == "grid_town").map


def closed_at(town, route):
    """The route's waypoint where it is closed, and those after it."""
    line, spec = RouteLine.trace(town, route.waypoints), route.scenarios[0]
    trigger = spec.trigger.position
    first = line.project(carla.Location(trigger.x_m, trigger.y_m, trigger.z_m))
    distance_m = float(spec.parameters["distance"]["value"])
    index = line.index_at(float(line.s_m[first]) + distance_m)
    return line.waypoints[index], line.waypoints[index:]


@pytest.mark.parametrize("route", ROUTES, ids=lambda item: item.id)
def test_closed_road_barriers_span_street_at_its_mouth(town, route):
    """The barriers close the street at its mouth, from curb to curb."""
    here, after = closed_at(town, route)
    row = row_across(town, here)
    places = [item.location for item in row]
    assert here.is_junction and any(place.distance(here.transform.location) < 0.1 for place in places)
    steps = [a.distance(b) for a, b in itertools.pairwise(places)]
    assert steps == pytest.approx([SPACING_M] * len(steps), abs=0.01)
    for edge, inner in ((places[0], places[1]), (places[-1], places[-2])):
        beyond = carla.Location(2 * edge.x - inner.x, 2 * edge.y - inner.y, edge.z)
        assert town.get_waypoint(beyond, False, FOR_VEHICLES) is None
    street = next(item for item in after if not item.is_junction)
    widths = {item.lane_id: item.lane_width for item, _ in town.get_topology() if item.road_id == street.road_id}
    assert len(widths) >= 2 and len(row) * SPACING_M > sum(widths.values())


@pytest.mark.parametrize("route", ROUTES, ids=lambda item: item.id)
def test_the_row_stands_square_to_the_closed_street(town, route):
    here, after = closed_at(town, route)
    street = next(item for item in after if not item.is_junction).transform.get_forward_vector()
    row = row_across(town, here)
    along = row[-1].location - row[0].location
    assert abs(along.x * street.x + along.y * street.y) < 0.05 * row[-1].location.distance(row[0].location)
