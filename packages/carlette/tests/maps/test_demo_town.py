"""What the demo town promises to those who drive in it, read through CARLA's own map."""

from __future__ import annotations

import math
from collections import Counter
from itertools import pairwise
from xml.etree import ElementTree

import networkx as nx
import pytest

from carlette.maps import DEMO_TOWN

carla = pytest.importorskip("carla")

STREET_ROADS = (11, 12, 13)
AVENUE_ROADS = (1, 2, 3, 4, 5, 21, 22, 23, 24, 25)
JUNCTION_ARMS = {100: {1: 1, 11: 1, 21: 1}, 200: {5: -1, 13: -1, 25: -1}}
"""Roads that enter each junction, with the sign of their incoming lanes."""


@pytest.fixture(scope="module")
def document():
    return ElementTree.parse(DEMO_TOWN).getroot()


@pytest.fixture(scope="module")
def town():
    return carla.Map("demo_town", DEMO_TOWN.read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def length_m(document):
    return {int(road.get("id")): float(road.get("length")) for road in document.findall("road")}


def driving_lanes(document):
    for road in document.findall("road"):
        for lane in road.iter("lane"):
            if lane.get("type") == "driving":
                yield int(road.get("id")), int(lane.get("id"))


def lane_end(town, length_m, road, lane):
    """The last waypoint of a lane, in driving direction."""
    return town.get_waypoint_xodr(road, lane, length_m[road] - 1e-4 if lane < 0 else 1e-4)


def samples(town, length_m, roads, lane, every_m=10.0):
    for road in roads:
        for step in range(1, int(length_m[road] // every_m)):
            yield town.get_waypoint_xodr(road, lane, step * every_m)


def test_every_driving_lane_can_be_reached_from_every_other(town, document):
    graph = nx.DiGraph()
    graph.add_nodes_from(driving_lanes(document))
    for start, end in town.get_topology():
        graph.add_edge((start.road_id, start.lane_id), (end.road_id, end.lane_id))
        for side, flag in (
            (start.get_left_lane, carla.LaneChange.Left),
            (start.get_right_lane, carla.LaneChange.Right),
        ):
            if start.lane_change & flag:
                graph.add_edge((start.road_id, start.lane_id), (start.road_id, side().lane_id))
    assert nx.is_strongly_connected(graph)


def test_traffic_never_meets_a_dead_end(town, document, length_m):
    for road, lane in driving_lanes(document):
        assert lane_end(town, length_m, road, lane).next(1.0), (road, lane)


def test_lanes_meet_without_gaps_or_kinks(town, document, length_m):
    joints = 0
    for road, lane in driving_lanes(document):
        end = lane_end(town, length_m, road, lane)
        for following in end.next(2e-4):
            assert end.transform.location.distance(following.transform.location) < 0.05
            turn_deg = following.transform.rotation.yaw - end.transform.rotation.yaw
            assert abs(math.remainder(turn_deg, 360)) < 0.5
            joints += 1
    assert joints > 60


def test_the_street_is_long_with_one_gentle_bend(town, length_m):
    assert sum(length_m[road] for road in STREET_ROADS) >= 450
    yaws = [w.transform.rotation.yaw for w in samples(town, length_m, STREET_ROADS, -1)]
    steps = [math.remainder(b - a, 360) for a, b in pairwise(yaws)]
    assert sum(steps) == pytest.approx(-10, abs=0.5)
    assert Counter(abs(step) > 0.1 for step in steps)[False] > 0.75 * len(steps)


@pytest.mark.parametrize("lane", [-1, 1])
def test_the_street_permits_passing_and_has_no_second_lane(town, length_m, lane):
    for waypoint in samples(town, length_m, STREET_ROADS, lane):
        assert waypoint.lane_width == pytest.approx(3.5)
        assert waypoint.left_lane_marking.type == carla.LaneMarkingType.Broken
        assert waypoint.lane_change == carla.LaneChange.NONE
        assert waypoint.get_left_lane().lane_id == -lane
        shoulder = waypoint.get_right_lane()
        assert shoulder.lane_type == carla.LaneType.Shoulder
        assert shoulder.right_lane_marking.type == carla.LaneMarkingType.Curb
        assert shoulder.get_right_lane().lane_type == carla.LaneType.Sidewalk


@pytest.mark.parametrize("sign", [-1, 1])
def test_demo_town_ring_has_two_lanes_and_solid_double_line(town, length_m, sign):
    """The ring has two lanes in each direction and a double solid line, which forbids crossing."""
    for inner in samples(town, length_m, AVENUE_ROADS, sign):
        assert inner.left_lane_marking.type == carla.LaneMarkingType.SolidSolid
        assert inner.right_lane_marking.type == carla.LaneMarkingType.Broken
        assert inner.lane_change == carla.LaneChange.Right
        outer = inner.get_right_lane()
        assert outer.lane_type == carla.LaneType.Driving
        assert outer.lane_change == carla.LaneChange.Left
        assert outer.right_lane_marking.type == carla.LaneMarkingType.Solid


def test_the_ring_has_a_straight_of_350_m(length_m):
    assert max(length_m[road] for road in AVENUE_ROADS) >= 350


@pytest.mark.parametrize(("road", "mph"), [(11, 30), (13, 30), (3, 40), (23, 40)])
def test_roads_state_their_speed_limit_with_its_unit(document, road, mph):
    speed = document.find(f"road[@id='{road}']/type/speed")
    assert (speed.get("max"), speed.get("unit")) == (str(mph), "mph")


def test_demo_town_junction_arms_have_one_light_and_phase(document):
    """Each arm of a junction has one light with its own phase."""
    controlled = {c.get("id"): c.find("control").get("signalId") for c in document.findall("controller")}
    assert len(set(controlled.values())) == len(controlled) == 6
    for junction in document.findall("junction"):
        entries = junction.findall("controller")
        assert [entry.get("sequence") for entry in entries] == ["0", "1", "2"]
        lit = {c.get("incomingRoad"): light_of(document, c) for c in junction.findall("connection")}
        assert sorted(lit.values()) == sorted(controlled[entry.get("id")] for entry in entries)


def light_of(document, connection):
    road = document.find(f"road[@id='{connection.get('connectingRoad')}']")
    return road.find("signals/signalReference").get("id")


def test_demo_town_lights_are_landmarks_before_junction(town, document, length_m):
    """A car before the junction finds the light of its arm as a landmark, and no other."""
    for arms in JUNCTION_ARMS.values():
        for road, sign in arms.items():
            lane_s = 30.0 if sign > 0 else length_m[road] - 30.0
            waypoint = town.get_waypoint_xodr(road, sign, lane_s)
            found = waypoint.get_landmarks_of_type(60.0, "1000001")
            assert {light.id for light in found} == {document.find(f"road[@id='{road}']//signal").get("id")}


def test_junctions_are_junctions_to_carla(town, document):
    inside = [start for start, _ in town.get_topology() if start.is_junction]
    assert {waypoint.get_junction().id for waypoint in inside} == set(JUNCTION_ARMS)
    crosswalk_points = 5
    assert len(town.get_crosswalks()) == 6 * crosswalk_points


def test_ids_of_each_kind_are_unique(document):
    for tag in ("road", "junction", "signal", "object"):
        ids = [element.get("id") for element in document.iter(tag)]
        assert len(ids) == len(set(ids))
