"""What every map that ships promises, read through CARLA's own map and, for signals, through the server's reader."""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from functools import cache
from xml.etree import ElementTree

import networkx as nx
import pytest

from carlette.maps import SHIPPED
from carlette.opendrive.map_file import load_map

carla = pytest.importorskip("carla")

from carlette.opendrive.road_network import RoadNetwork  # noqa: E402 (needs carla)
from carlette.opendrive.signals import read_signals  # noqa: E402

MAPS = ("grid_town", "interurban", "motorway")
CARRIAGEWAYS = {"grid_town": 1, "interurban": 1, "motorway": 2}
BROKEN, SOLID = carla.LaneMarkingType.Broken, carla.LaneMarkingType.Solid
DRIVING = carla.LaneType.Driving
CARLAS_SPEED_SIGNS = {"30", "40", "50", "60", "70", "80", "90", "100", "110", "120"}
"""Subtypes of type 274 for which CARLA has a sign to put up (`TrafficLightManager.cpp`)."""


@cache
def document(name):
    return ElementTree.parse(SHIPPED / f"{name}.xodr").getroot()


@cache
def town(name):
    return RoadNetwork(load_map(SHIPPED / f"{name}.xodr"))


@cache
def signals(name):
    return read_signals(town(name), document(name))


def roads(name):
    return {int(road.get("id")): road for road in document(name).findall("road")}


def driving_lanes(name):
    for road_id, road in roads(name).items():
        for lane in road.iter("lane"):
            if lane.get("type") == "driving":
                yield road_id, int(lane.get("id"))


def lane_end(name, road, lane):
    length_m = float(roads(name)[road].get("length"))
    return town(name).map.get_waypoint_xodr(road, lane, length_m - 1e-4 if lane < 0 else 1e-4)


@pytest.mark.parametrize("name", MAPS)
def test_map_driving_lanes_are_reachable_within_carriageway(name):
    """Every driving lane can be reached from every other one of its carriageway."""
    graph = nx.DiGraph()
    graph.add_nodes_from(driving_lanes(name))
    for start, end in town(name).map.get_topology():
        graph.add_edge((start.road_id, start.lane_id), (end.road_id, end.lane_id))
        for side, flag in (
            (start.get_left_lane, carla.LaneChange.Left),
            (start.get_right_lane, carla.LaneChange.Right),
        ):
            if start.lane_change & flag:
                graph.add_edge((start.road_id, start.lane_id), (start.road_id, side().lane_id))
    assert nx.number_strongly_connected_components(graph) == CARRIAGEWAYS[name]


@pytest.mark.parametrize("name", MAPS)
def test_lanes_meet_without_dead_ends_gaps_or_kinks(name):
    for road, lane in driving_lanes(name):
        end = lane_end(name, road, lane)
        assert end.next(1.0), (road, lane)
        for following in end.next(2e-4):
            assert end.transform.location.distance(following.transform.location) < 0.05
            turn_deg = following.transform.rotation.yaw - end.transform.rotation.yaw
            assert abs(math.remainder(turn_deg, 360)) < 0.5, (road, lane)


@pytest.mark.parametrize("name", MAPS)
def test_broken_lines_permit_lane_changes_and_others_forbid_them(name):
    changes = Counter()
    for waypoint in town(name).map.generate_waypoints(20.0):
        for flag, marking, neighbor in (
            (carla.LaneChange.Left, waypoint.left_lane_marking, waypoint.get_left_lane()),
            (carla.LaneChange.Right, waypoint.right_lane_marking, waypoint.get_right_lane()),
        ):
            same_way = neighbor is not None and neighbor.lane_id * waypoint.lane_id > 0
            permitted = bool(waypoint.lane_change & flag)
            assert permitted == (same_way and marking is not None and marking.type == BROKEN)
            changes[permitted] += 1
    assert changes[False]
    assert changes[True] or name == "interurban"


@pytest.mark.parametrize("name", MAPS)
def test_map_signals_govern_exactly_the_incoming_lanes(name):
    """Every light and sign governs exactly the incoming lanes of its arm.

    The trigger box, as the server makes it, spans the incoming lanes of one arm: clients find the lanes in it.
    """
    for signal in signals(name):
        middle = town(name).carla.Location(*_world(signal))
        waypoint = town(name).map.get_waypoint(middle)
        assert waypoint.transform.location.distance(middle) < waypoint.lane_width
        assert not waypoint.is_junction
        assert waypoint.next(6.0)[0].is_junction
        lanes = 1 + sum(1 for _ in _neighbors(waypoint))
        assert 2 * signal.box.extent.x == pytest.approx(lanes * waypoint.lane_width, abs=0.1)


def _world(signal):
    yaw = math.radians(signal.pose.rotation.yaw)
    x, y, z = signal.box.center
    at = signal.pose.location
    return at.x + x * math.cos(yaw) - y * math.sin(yaw), at.y + x * math.sin(yaw) + y * math.cos(yaw), at.z + z


def _neighbors(waypoint):
    for step in ("get_left_lane", "get_right_lane"):
        lane = getattr(waypoint, step)()
        while lane is not None and lane.lane_type == DRIVING and lane.lane_id * waypoint.lane_id > 0:
            yield lane
            lane = getattr(lane, step)()


@pytest.mark.parametrize("name", MAPS)
def test_map_arm_sign_or_light_is_found_as_landmark(name):
    """A car finds the sign or the light of its arm as a landmark."""
    seen = 0
    for road_id, lane_id in driving_lanes(name):
        end = lane_end(name, road_id, lane_id)
        ahead = end.next(1.0)[0]
        if end.is_junction or not ahead.is_junction:
            continue
        back = end.previous(15.0)[0]
        stated = {s.get("type") for s in roads(name)[road_id].findall("signals/signal") if _valid(s, lane_id)}
        for kind in ("205", "206"):
            found = [landmark for landmark in back.get_landmarks_of_type(20.0, kind) if landmark.road_id == road_id]
            assert bool(found) == (kind in stated)
            seen += bool(found)
        lit = back.get_landmarks_of_type(25.0, "1000001")
        assert len({item.id for item in lit}) <= 1
        seen += bool(lit)
    assert seen


def _valid(signal, lane_id):
    span = signal.find("validity")
    return int(span.get("fromLane")) <= lane_id <= int(span.get("toLane"))


@pytest.mark.parametrize("name", MAPS)
def test_lights_that_are_green_together_face_each_other(name):
    """Each lit junction lists its controllers in turn; a controller has the lights of one arm or of two opposite."""
    controllers = {c.get("id"): c for c in document(name).findall("controller")}
    yaw = {signal.id: signal.pose.rotation.yaw for signal in signals(name)}
    listed = []
    for junction in document(name).findall("junction"):
        entries = [entry.get("id") for entry in junction.findall("controller")]
        assert len(entries) != 1
        listed.extend(entries)
        for entry in entries:
            lit = [control.get("signalId") for control in controllers[entry].findall("control")]
            assert len(lit) in (1, 2)
            assert abs(math.remainder(yaw[lit[0]] - yaw[lit[-1]], 360)) in (0, pytest.approx(180, abs=1))
    assert sorted(listed) == sorted(controllers)


@pytest.mark.parametrize("name", MAPS)
def test_map_speed_signs_match_road_and_have_lane_boxes(name):
    """The signs state the limits of their roads, and the server has a box for each lane."""
    network = town(name)
    stated = {road.get("id"): road.find("type/speed").get("max") for road in document(name).iter("road")}
    boxes = 0
    for landmark in network.map.get_all_landmarks_of_type("274"):
        assert landmark.value == float(stated[str(landmark.road_id)])
        first, last = sorted(landmark.get_lane_validities()[0])
        boxes += last - first + 1
        assert 20 <= landmark.value <= 130
    assert len(network.speed_boxes) == boxes


@pytest.mark.parametrize("name", MAPS)
def test_map_speed_sign_subtype_is_limit_that_carla_knows(name):
    """The subtype of a speed sign is its limit, and one of those for which CARLA has a sign."""
    signs = town(name).map.get_all_landmarks_of_type("274")
    assert signs
    assert {sign.sub_type for sign in signs} <= CARLAS_SPEED_SIGNS
    assert all(float(sign.sub_type) == sign.value for sign in signs)
    others = {item.get("subtype") for item in document(name).iter("signal") if item.get("type") != "274"}
    assert others <= {"-1"}, "none of the other types has a subtype"


@pytest.mark.parametrize("name", MAPS)
def test_slopes_are_gentle(name):
    slopes = [abs(waypoint.transform.rotation.pitch) for waypoint in town(name).map.generate_waypoints(10.0)]
    steepest = max(math.remainder(slope, 360) for slope in slopes)
    assert steepest < 6.0
    assert (steepest > 1.0) == (name == "interurban")


@pytest.mark.parametrize("name", MAPS)
def test_map_ids_are_unique_and_differ_between_roads_and_junctions(name):
    """Ids of each kind are unique, and no junction has the id of a road."""
    used = defaultdict(list)
    for path in ("road", "junction", "controller", ".//signal", ".//object"):
        used["road" if path == "junction" else path] += [item.get("id") for item in document(name).findall(path)]
    for ids in used.values():
        assert len(ids) == len(set(ids))


def test_the_town_has_every_kind_of_kerb_and_control():
    kinds = {lane.get("type") for lane in document("grid_town").iter("lane")}
    assert {"driving", "parking", "biking", "restricted", "shoulder", "sidewalk"} <= kinds
    found = Counter(signal.type for signal in signals("grid_town"))
    assert found["1000001"] == 2 * 3 + 2 * 3 + 4 * 4
    assert found["206"] == 2 + 4
    assert found["205"] >= 4 + 3
    assert len(town("grid_town").map.get_crosswalks()) > 5 * 40


def test_bicycle_lanes_lead_through_crossings():
    roads_in_junctions = [road for road in roads("grid_town").values() if road.get("junction") != "-1"]
    through = [road for road in roads_in_junctions if road.find(".//lane[@type='biking']") is not None]
    assert len(through) == 6
    for road in through:
        middle = town("grid_town").map.get_waypoint_xodr(int(road.get("id")), -1, float(road.get("length")) / 2)
        for beyond in (middle.next(40.0), middle.previous(40.0)):
            assert [item.lane_type for item in beyond] == [carla.LaneType.Biking]


def test_one_can_go_round_the_roundabout():
    ring = [int(i) for i, road in roads("grid_town").items() if road.get("name") == "Mill Circle"]
    start = town("grid_town").map.get_waypoint_xodr(ring[0], -1, 1.0)
    waypoint, visited = start, set()
    for _ in range(160):
        waypoint = max(waypoint.next(1.0), key=lambda item: item.road_id in ring or _leads_to(item, ring))
        visited.add(waypoint.road_id)
    assert set(ring) <= visited


def _leads_to(waypoint, ring):
    while waypoint.is_junction:
        waypoint = waypoint.next(1.0)[0]
    return waypoint.road_id in ring


def test_parked_cars_have_room_in_parking_lanes():
    for name in ("grid_town", "interurban"):
        widths = [
            float(lane.find("width").get("a")) for lane in document(name).iter("lane") if lane.get("type") == "parking"
        ]
        assert widths
        assert min(widths) >= 2.4


def test_the_motorway_has_entries_and_exits_on_both_carriageways():
    joints = {
        junction.get("name"): {(c.get("incomingRoad"), c.get("connectingRoad")) for c in junction.findall("connection")}
        for junction in document("motorway").findall("junction")
    }
    assert Counter(name.split()[0] for name in joints) == {"outer": 8, "inner": 8}
    assert all(len(connections) == 4 for connections in joints.values())
