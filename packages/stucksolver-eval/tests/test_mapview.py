"""The replay's map shows the lanes and lines that are there, where they are, in little space."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from carlette.maps import DEMO_TOWN

carla = pytest.importorskip("carla")

from stucksolver_eval.run_log.map_view import map_view  # noqa: E402
from stucksolver_eval.streets.finder import find_streets  # noqa: E402

FOLDERS = [Path(folder) for folder in os.environ.get("STUCKSOLVER_MAPS", "").split(os.pathsep) if folder]
DEMO = carla.Map("demo_town", DEMO_TOWN.read_text(encoding="utf-8"))
DRIVING = DEMO.generate_waypoints(25.0)


def xy(waypoint):
    return waypoint.transform.location.x, -waypoint.transform.location.y


def area(lane):
    return shapely.Polygon([*lane.left, *reversed(lane.right)])


@pytest.mark.release
@pytest.mark.integration
@settings(max_examples=25)
@given(st.integers(0, len(DRIVING) - 1))
def test_map_view_driving_lane_points_lie_in_driving_areas(number):
    """Every point of a driving lane lies in a drawn driving area."""
    point = xy(DRIVING[number])
    view = map_view(DEMO, [point], margin_m=20.0)
    driving = [area(lane) for lane in view.lanes if lane.kind == "driving"]
    assert any(polygon.buffer(0.05).contains(shapely.Point(point)) for polygon in driving)
    assert all(polygon.is_valid for polygon in driving)


def test_map_view_lane_widths_match_map():
    """Lanes of every kind are as wide as in the map."""
    view = map_view(DEMO, [xy(DEMO.get_waypoint_xodr(11, -1, 100.0))], margin_m=30.0)
    widths = {lane.kind: area(lane).area / shapely.LineString(lane.left).length for lane in view.lanes}
    assert widths == pytest.approx({"driving": 3.5, "shoulder": 0.5, "sidewalk": 2.5}, abs=0.05)


def test_left_is_left_in_driving_direction():
    for lane_id, ahead in ((-1, 1), (1, -1)):
        center = xy(DEMO.get_waypoint_xodr(11, lane_id, 100.0))
        view = map_view(DEMO, [center], margin_m=10.0)
        lane = next(lane for lane in view.lanes if area(lane).contains(shapely.Point(center)))
        (x0, y0), (x1, _) = lane.left[0], lane.left[-1]
        assert (x1 - x0) * ahead > 0
        assert (y0 - lane.right[0][1]) * ahead > 0


@pytest.mark.parametrize(
    ("road", "lane", "center"),
    [(11, -1, [("broken", "yellow")]), (3, -1, [("solid", "yellow"), ("solid", "yellow")])],
)
def test_the_center_line_is_painted_as_it_is(road, lane, center):
    waypoint = DEMO.get_waypoint_xodr(road, lane, 100.0)
    view = map_view(DEMO, [xy(waypoint)], margin_m=10.0)
    x, y = xy(waypoint.get_left_lane())
    between = shapely.Point((x + xy(waypoint)[0]) / 2, (y + xy(waypoint)[1]) / 2)
    painted = [m for m in view.markings if shapely.LineString(m.points).distance(between) < 0.5]
    assert [(marking.kind, marking.color) for marking in painted] == center


def test_what_is_far_away_is_left_out():
    near = xy(DEMO.get_waypoint_xodr(11, -1, 100.0))
    view = map_view(DEMO, [near], margin_m=30.0)
    assert all(area(lane).distance(shapely.Point(near)) < 31.0 for lane in view.lanes)


def test_the_whole_demo_town_stays_small():
    view = map_view(DEMO, [xy(waypoint) for waypoint in DRIVING])
    assert len(view.model_dump_json()) < 200_000


@pytest.mark.integration
@pytest.mark.parametrize("town", ["Town01", "Town02", "Town04", "Town10HD"])
def test_the_surroundings_of_a_route_are_small(town):
    path = next((folder / f"{town}.xodr" for folder in FOLDERS if (folder / f"{town}.xodr").is_file()), None)
    if path is None:
        pytest.skip(f"{town}.xodr is in none of the folders of STUCKSOLVER_MAPS")
    carla_map = carla.Map(town, path.read_text(encoding="utf-8"))
    site = find_streets(carla_map, "any", seed=0)[0]
    view = map_view(carla_map, [xy(waypoint) for waypoint in site.waypoints])
    assert len(view.model_dump_json()) < 200_000
    driving = shapely.union_all([area(lane) for lane in view.lanes if lane.kind == "driving"]).buffer(0.05)
    assert all(driving.contains(shapely.Point(xy(waypoint))) for waypoint in site.waypoints)


def test_the_name_is_the_towns_without_a_servers_folders():
    served = carla.Map("Carla/Maps/demo_town", DEMO_TOWN.read_text(encoding="utf-8"))
    assert map_view(served, [xy(DRIVING[0])], margin_m=10.0).name == "demo_town"


def test_map_view_default_namespace_changes_nothing() -> None:
    text = DEMO_TOWN.read_text(encoding="utf-8")
    spaced = text.replace("<OpenDRIVE", '<OpenDRIVE xmlns="http://code.asam.net/simulation/standard/opendrive_schema"')
    assert map_view(carla.Map("demo_town", spaced), [xy(DRIVING[0])]) == map_view(DEMO, [xy(DRIVING[0])])


def test_map_view_reads_road_ids_that_are_words() -> None:
    """The library reads a word as 0."""
    text = (
        DEMO_TOWN.read_text(encoding="utf-8")
        .replace('id="25"', 'id="Ring"')
        .replace('elementId="25"', 'elementId="Ring"')
    )
    town = carla.Map("demo_town", text)
    start = next(waypoint for waypoint in town.generate_waypoints(25.0) if waypoint.road_id == 0)
    assert any(lane.kind == "driving" for lane in map_view(town, [xy(start)], margin_m=10.0).lanes)


def test_no_points_are_refused():
    with pytest.raises(ValueError, match="at least one point"):
        map_view(DEMO, [])
