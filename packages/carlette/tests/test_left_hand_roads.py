"""Maps with left-hand traffic: everything on them is the mirror image of the same map with right-hand traffic."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
import pytest

from carlette.errors import MapError
from carlette.in_process import populate
from carlette.maps import DEMO_TOWN
from carlette.opendrive.map_file import MapFile
from carlette.opendrive.road_network import RoadNetwork
from carlette.opendrive.signals import read_signals
from carlette.opendrive.traffic_side import check_traffic_side, runs_back
from carlette.traffic import Traffic
from carlette.traffic.lane_graph import lane_graph
from carlette.world.world import World
from left_hand_maps import left_hand
from straight import straight_road

TEXT = DEMO_TOWN.read_text(encoding="utf-8")
MIRROR = (1.0, -1.0, 1.0)


@pytest.fixture(scope="module")
def towns() -> tuple[RoadNetwork, RoadNetwork]:
    """The demo town, and its mirror image with left-hand traffic."""
    return RoadNetwork(MapFile("demo_town", TEXT)), RoadNetwork(MapFile("demo_left", left_hand(TEXT)))


def test_left_hand_spawn_points_are_mirrored(towns: tuple[RoadNetwork, RoadNetwork]) -> None:
    """Vehicles start in the lanes of their direction, on the left."""

    def rows(roads: RoadNetwork, side: float) -> list[tuple[float, ...]]:
        poses = roads.spawn_points()
        return sorted(
            (round(p.location.x, 2), round(side * p.location.y, 2), round(np.cos(np.radians(p.rotation.yaw)), 2))
            for p in poses
        )

    right, left = rows(towns[0], 1.0), rows(towns[1], -1.0)
    assert len(right) > 20
    assert np.allclose(right, left, atol=0.011)


def test_left_hand_lane_graph_runs_with_the_traffic(towns: tuple[RoadNetwork, RoadNetwork]) -> None:
    """The points of each lane follow each other in its direction of travel, and the same lanes cross."""
    right, left = (lane_graph(roads) for roads in towns)
    for graph in (right, left):
        steps = np.diff(graph.place[:, :2], axis=0)
        same = graph.lane[1:] == graph.lane[:-1]
        assert ((steps * graph.ahead[:-1]).sum(axis=1)[same] > 0.0).all()
    assert sorted(map(len, right.after)) == sorted(map(len, left.after))
    assert sorted(map(len, right.crossing)) == sorted(map(len, left.crossing))


def test_left_hand_signals_are_mirrored(towns: tuple[RoadNetwork, RoadNetwork]) -> None:
    """Each light stands and governs as its mirror image does."""
    texts = (TEXT, left_hand(TEXT))
    right, left = (
        {item.id: item for item in read_signals(roads, ElementTree.fromstring(text))}
        for roads, text in zip(towns, texts, strict=True)
    )
    assert right and right.keys() == left.keys()
    for name, light in right.items():
        other = left[name]
        assert np.allclose(light.pose.location, np.multiply(other.pose.location, MIRROR), atol=1e-3)
        assert light.box.extent == pytest.approx(other.box.extent)


@pytest.mark.integration
def test_left_hand_traffic_keeps_its_lanes_and_distance(towns: tuple[RoadNetwork, RoadNetwork]) -> None:
    """Cars of the simulator's own traffic drive on, in lanes of their direction, and never touch."""
    world = World(towns[1], 3)
    populate(world, 12, 3)
    world.traffic = Traffic(world, seed=3)
    hits: list[object] = []
    world._report = hits.extend
    distance = np.zeros(len(world.fleet))
    for _ in range(1200):
        world.tick()
        distance += np.hypot(*world.bodies.velocity[world.fleet.row, :2].T) * world.step_s
    graph = lane_graph(towns[1])
    for row in world.fleet.row:
        yaw = float(np.radians(world.bodies.rotation[row, 1]))
        assert graph.nearest(world.bodies.position[row], yaw) >= 0
    assert hits == []
    assert distance.mean() > 100.0


def test_runs_back_depends_on_rule() -> None:
    """Lane 1 is left of the reference line: it runs back in right-hand traffic, and along in left-hand traffic."""
    for rule, text in (
        ("RHT", straight_road()),
        ("LHT", straight_road().replace("junction", 'rule="LHT" junction', 1)),
    ):
        town = RoadNetwork(MapFile(rule, text)).map
        ahead = town.get_waypoint_xodr(7, 1, 100.0)
        assert runs_back(ahead) is (rule == "RHT")
        assert abs(ahead.transform.rotation.yaw) == pytest.approx(180.0 if rule == "RHT" else 0.0)


def test_client_that_ignores_the_rule_is_named() -> None:
    """An older client would let left-hand traffic drive on the right: the map is rejected in one line."""
    root = ElementTree.fromstring(left_hand(straight_road()))
    with pytest.raises(MapError, match=r"left-hand traffic.*install carla 0\.9\.16") as caught:
        check_traffic_side(root, "somewhere", object())
    assert "\n" not in str(caught.value)
    check_traffic_side(ElementTree.fromstring(straight_road()), "elsewhere", object())
