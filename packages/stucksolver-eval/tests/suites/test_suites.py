"""The suites that ship are complete, valid on their maps, and what the script makes."""

from __future__ import annotations

import math
from collections import Counter
from functools import cache

import networkx as nx
import numpy as np
import pytest

carla = pytest.importorskip("carla")

from stucksolver_eval.guidance import read_script  # noqa: E402 (needs carla)
from stucksolver_eval.guidance.assignment import draw_script  # noqa: E402
from stucksolver_eval.routes.route_line import RouteLine  # noqa: E402 (needs carla)
from stucksolver_eval.scenarios import SCENARIOS  # noqa: E402
from stucksolver_eval.sites.parameter_draws import IntervalDraw, RideDistanceDraw, WordDraw  # noqa: E402
from stucksolver_eval.suites import SuiteError, build, shipped_guidance, suite, suite_names  # noqa: E402
from stucksolver_eval.suites.weather_presets import FIELDS, PRESETS  # noqa: E402

FLOWS = {
    "EnterActorFlow",
    "HighwayExit",
    "InterurbanActorFlow",
    "InterurbanAdvancedActorFlow",
    "MergerIntoSlowTraffic",
    "MergerIntoSlowTrafficV2",
}
LONGER_M = {"ClosedRoad": 500, "RoundaboutLoop": 1750}
ON_MAP = ("start_actor_flow", "end_actor_flow", "other_actor_location")
BENCH = suite("bench220")
PLACED = build.placed_in("bench220")
OURS = build.placed_in("immobilized")


@cache
def towns():
    return {town.name: town for town in build.load_towns()}


@cache
def traced(route_id):
    route = next(item for item in BENCH.routes if item.id == route_id)
    return RouteLine.trace(towns()[route.town].map, route.waypoints)


def of_type(kind):
    return [route for route in suite("immobilized").routes if route.scenarios[0].type == kind]


def by_type(routes):
    return Counter(scenario.type for route in routes for scenario in route.scenarios)


def test_bench220_has_five_routes_per_type_and_dev_subset():
    """The suite bench220 has five routes for each of 44 types, and dev has one for every second type."""
    assert set(by_type(BENCH.routes).values()) == {5}
    assert len(by_type(BENCH.routes)) == 44
    dev = suite("dev").routes
    assert len(dev) == len(by_type(dev)) == 22
    assert all(route in BENCH.routes for route in dev)
    assert {route.town for route in dev} == {"grid_town", "interurban", "motorway"}


def test_no_two_types_are_given_the_same_ids():
    ids = [placed.first_id for placed in (*PLACED.values(), *OURS.values())]
    assert len(set(ids)) == len(ids) and all(object_id % 10 == 0 for object_id in ids)


def test_suite_excludes_type_that_only_inherits_placement():
    """A type that inherits its placement from another type is in no suite."""

    class Heir(SCENARIOS["ParkedObstacle"]):
        type = "Heir"

    SCENARIOS["Heir"] = Heir
    try:
        assert build.placed_in("bench220") == PLACED
    finally:
        del SCENARIOS["Heir"]


def test_suite_digest_identifies_version_and_maps_are_listed(tmp_path):
    """A suite has a digest of its content and lists the maps that it requires."""
    assert {"bench220", "dev"} <= set(suite_names())
    copy = tmp_path / "own.xml"
    copy.write_bytes((build.DATA / "dev.xml").read_bytes())
    assert suite(str(copy)).digest == suite("dev").digest != BENCH.digest
    assert BENCH.maps == ("grid_town", "interurban", "motorway")
    assert all((build.MAPS / f"{name}.xodr").exists() for name in BENCH.maps)


def test_an_unknown_suite_is_refused_with_those_there_are():
    with pytest.raises(SuiteError, match=r"no such shipped suite: 'bench2drive'\. Choose from bench220, dev"):
        suite("bench2drive")


@pytest.mark.release
@pytest.mark.integration
def test_the_committed_files_are_what_the_script_writes():
    assert build.main(["--check"]) == 0


@pytest.mark.parametrize("route", suite("dev").routes, ids=lambda route: route.scenarios[0].type)
def test_each_route_of_dev_can_be_driven_past_its_trigger(route):
    check_line(route)


@pytest.mark.integration
def test_each_route_of_bench220_can_be_driven_past_its_trigger():
    for route in BENCH.routes:
        check_line(route)


def check_line(route):
    """150 to 300 m long, no detour, trigger on it and looking along it, no mark left out."""
    line = traced(route.id)
    assert 145 < line.length_m < 305
    marks = np.array([(mark.x_m, mark.y_m) for mark in route.waypoints])
    steps = np.hypot(*np.diff(marks, axis=0).T)
    assert line.length_m < 1.1 * steps.sum() + 5.0
    for mark in marks:
        assert np.hypot(*(line.xyz[:, :2] - mark).T).min() < 1.0
    trigger = route.scenarios[0].trigger
    gaps = np.hypot(*(line.xyz[:, :2] - (trigger.position.x_m, trigger.position.y_m)).T)
    place = int(gaps.argmin())
    assert gaps[place] < 1.0
    yaw_deg = line.waypoints[place].transform.rotation.yaw
    assert abs(math.remainder(yaw_deg - trigger.yaw_deg, 360)) < 3.0
    assert line.s_m[place] < 60.0


def test_parameters_are_complete_and_within_the_published_ranges():
    for route in BENCH.routes:
        (scenario,) = route.scenarios
        for name, value in PLACED[scenario.type].values.items():
            given = scenario.parameters[name]
            if isinstance(value, IntervalDraw):
                assert value.first[0] <= float(given["from"]) <= value.first[1]
                assert value.last[0] <= float(given["to"]) <= value.last[1]
            elif isinstance(value, WordDraw):
                assert given["value"] in value.words
            else:
                least = 40 if isinstance(value, RideDistanceDraw) else value.low
                assert least <= float(given["value"]) <= value.high
        if scenario.type in FLOWS:
            assert {"start_actor_flow", "end_actor_flow"} <= set(scenario.parameters)
        if scenario.type.startswith("OppositeVehicle"):
            assert scenario.parameters["direction"]["value"] in ("left", "right", "opposite")


def test_parameters_vary_between_the_routes_of_a_type():
    for kind in by_type(BENCH.routes):
        draw_script = [str(dict(r.scenarios[0].parameters)) for r in BENCH.routes if r.scenarios[0].type == kind]
        where = [r.scenarios[0].trigger for r in BENCH.routes if r.scenarios[0].type == kind]
        assert len(set(draw_script)) >= 2 or not PLACED[kind].values or kind in ("ParkingExit", "ParkingCutIn")
        assert len(set(where)) == 5


def test_flows_begin_and_end_on_lanes_and_meet_the_route():
    for route in BENCH.routes:
        (scenario,) = route.scenarios
        kind = carla.LaneType.Biking if scenario.type == "CrossingBicycleFlow" else carla.LaneType.Driving
        for name in ON_MAP:
            if name not in scenario.parameters:
                continue
            place = carla.Location(*(float(scenario.parameters[name][axis]) for axis in "xyz"))
            found = towns()[route.town].map.get_waypoint(place, False, kind)
            assert found is not None, (route.id, name)
            assert not found.is_junction
            assert found.transform.location.distance(place) < 0.5


@pytest.mark.integration
def test_suite_flow_crosses_route_between_its_ends():
    """A traffic flow drives from its start to its end and crosses the route."""
    for route in BENCH.routes:
        (scenario,) = route.scenarios
        if scenario.type not in FLOWS:
            continue
        ends = [carla.Location(*(float(scenario.parameters[n][a]) for a in "xyz")) for n in ON_MAP[:2]]
        flow = trace_flow(route, ends)
        line = traced(route.id)
        gaps = np.hypot(
            line.xyz[:, None, 0] - flow.xyz[None, :, 0],
            line.xyz[:, None, 1] - flow.xyz[None, :, 1],
        )
        assert gaps.min() < 1.0, route.id
        assert 90 < flow.length_m < 320, route.id


def trace_flow(route, ends):
    positions = [build.Position(end.x, end.y, end.z) for end in ends]
    return RouteLine.trace(towns()[route.town].map, positions)


def test_routes_of_a_type_use_different_roads_or_junctions():
    for kind in by_type(BENCH.routes):
        triggers = [r.scenarios[0].trigger.position for r in BENCH.routes if r.scenarios[0].type == kind]
        gaps = [math.dist((a.x_m, a.y_m), (b.x_m, b.y_m)) for a in triggers for b in triggers if a is not b]
        assert min(gaps) > 3.0


def test_all_presets_of_weather_come_up_with_all_fields():
    seen = Counter(tuple(route.weathers[0].values.items()) for route in BENCH.routes)
    assert len(seen) == len(PRESETS)
    assert max(seen.values()) - min(seen.values()) <= 1
    for weather in seen:
        assert tuple(name for name, _ in weather) == FIELDS


@pytest.mark.parametrize("name", ["bench220", "dev", "immobilized"])
def test_suite_guidance_depends_only_on_seed_and_type(name: str) -> None:
    """The guidance of a suite is drawn from the seed and the scenario types alone."""
    assert draw_script(name) == read_script(shipped_guidance(name))
    assert draw_script(name, seed=1) != draw_script(name)


@pytest.mark.parametrize("name", ["bench220", "immobilized"])
def test_suite_guidance_covers_15_percent_of_routes_and_all_kinds(name: str) -> None:
    """A passenger speaks on about 15 % of the routes, with guidance of every kind."""
    known = {route.id for route in suite(name).routes}
    script = read_script(shipped_guidance(name), known)
    assert set(script.routes) <= known
    assert 0.13 < len(script.routes) / len(known) < 0.17
    lines = [line for spoken in script.routes.values() for line in spoken]
    kinds = Counter(line.kind for line in lines)
    assert set(kinds) == {"helpful", "unhelpful", "wrong", "late", "dangerous"}
    assert kinds["helpful"] > len(lines) / 2
    assert all(line.answer or len(set(line.say)) == len(line.say) >= 2 for line in lines)
    assert all(line.help for line in lines)


def test_a_passenger_speaks_on_some_routes_of_dev() -> None:
    spoken = {route.id for route in suite("dev").routes} & set(read_script(shipped_guidance("dev")).routes)
    assert 3 <= len(spoken) <= 6


def test_no_words_ship_for_a_file_of_routes() -> None:
    with pytest.raises(SuiteError, match=r"mine\.xml.*bench220, dev, immobilized.*Give a script"):
        shipped_guidance("mine.xml")


@pytest.mark.integration
def test_suite_immobilized_has_five_routes_per_situation():
    """The maps have five places for each of StuckSolver's own situations."""
    routes = suite("immobilized").routes  # which are what the script writes, as is tested above
    assert by_type(routes) == dict.fromkeys(OURS, 5) and len(OURS) == 25
    assert len({route.id for route in (*routes, *BENCH.routes)}) == 220 + len(routes)
    for route in routes:
        line = RouteLine.trace(towns()[route.town].map, route.waypoints)
        assert 145 < line.length_m < LONGER_M.get(route.scenarios[0].type, 305)


@pytest.mark.integration
def test_a_closed_road_can_be_driven_round():
    """Without the street that is closed, the destination is still within 1200 m by road."""
    for route in of_type("ClosedRoad"):
        check_detour(route)


def check_detour(route):
    """The destination can be reached within 1200 m without the second road of the route."""
    line = RouteLine.trace(towns()[route.town].map, route.waypoints)
    roads = [waypoint.road_id for waypoint in line.waypoints if not waypoint.is_junction]
    before, closed, after = dict.fromkeys(roads)
    graph = nx.DiGraph()
    for start, end in towns()[route.town].map.get_topology():
        length_m = start.transform.location.distance(end.transform.location)
        graph.add_edge(start.road_id, end.road_id, length_m=length_m)
    graph.remove_node(closed)
    assert nx.shortest_path_length(graph, before, after, "length_m") < 1200


@pytest.mark.integration
def test_suite_roundabout_loop_outlasts_run_and_has_direct_exit():
    """A roundabout loop takes longer than a run lasts, and the ego could leave it at once."""
    for route in of_type("RoundaboutLoop"):
        line = RouteLine.trace(towns()[route.town].map, route.waypoints)
        assert line.length_m > 1400
        direct = RouteLine.trace(towns()[route.town].map, (route.waypoints[0], route.waypoints[-1]))
        assert direct.length_m < 320
        assert line.new_ground_m[-1] < 450


def meets(turn, side):
    """Whether somebody from that side who goes straight on crosses or joins the ego's way."""
    return turn == "left" if side == "opposite" else side == "left" or turn != "right"


def test_suite_emergency_vehicles_start_where_they_cross_route():
    """Emergency vehicles come from a direction in which they cross the ego's path."""
    for route in BENCH.routes:
        (scenario,) = route.scenarios
        if scenario.type.startswith("OppositeVehicle"):
            headings = [traced(route.id).waypoints[k].transform.rotation.yaw for k in (0, -1)]
            angle = math.remainder(headings[1] - headings[0], 360.0)
            turn = "straight" if abs(angle) < 35.0 else "right" if angle > 0 else "left"
            assert meets(turn, scenario.parameters["direction"]["value"]), route.id


@pytest.mark.integration
def test_a_closed_street_of_a_report_can_be_driven_round():
    """Without the street that is closed, the destination is still within 1200 m by road."""
    closed = [route for route in suite("reported").routes if SCENARIOS[route.scenarios[0].type].expected == "reroute"]
    assert len(closed) == 6
    for route in closed:
        check_detour(route)
