"""Lights, signs and speed limits of CARLA's own towns, which are not part of this repository, and of the demo town."""

from __future__ import annotations

import math
from collections import defaultdict
from functools import cache
from pathlib import Path
from xml.etree import ElementTree

import pytest

from carlette.maps import DEMO_TOWN
from carlette.opendrive.document import load_map
from carlette.opendrive.roads import RoadNetwork
from carlette.opendrive.signals import LIGHT_TYPE, Signal, read_signals

carla = pytest.importorskip("carla")

COUNTS = {"Town01": (36, 72), "Town02": (24, 48), "Town04": (43, 121), "Town10HD": (17, 58), "demo_town": (6, 16)}
"""Lights, and pairs of a light and a driving lane that the file makes it govern (Town10HD: 56 and two signals)."""
STOPS = {"Town01": 0, "Town02": 0, "Town10HD": 3, "demo_town": 0}
"""Town04 has eight in CARLA that its file does not hold."""
END_M = 0.01


@pytest.fixture(params=COUNTS)
def town(request, town01: Path) -> str:
    path = DEMO_TOWN if request.param == "demo_town" else town01.with_name(f"{request.param}.xodr")
    if not path.is_file():
        pytest.skip(f"{path.name} is not beside Town01.xodr")
    return str(path)


@cache
def loaded(town: str) -> tuple[RoadNetwork, list[Signal], dict[str, set[tuple[int, int]]]]:
    roads = RoadNetwork(load_map(Path(town)))
    root = ElementTree.fromstring(roads.file.text)
    return roads, read_signals(roads, root), governed(roads, root)


def governed(roads: RoadNetwork, root: ElementTree.Element) -> dict[str, set[tuple[int, int]]]:
    """Signal id to the (road, lane) of driving lanes that its own and its references' validities name."""
    lanes = defaultdict(set)
    for road in root.iter("road"):
        number, length = int(road.get("id", "")), float(road.get("length", ""))
        for mark in [*road.iter("signal"), *road.iter("signalReference")]:
            s = min(float(mark.get("s", "0")), length - END_M)
            for valid in mark.findall("validity"):
                first, last = sorted((int(valid.get("fromLane", "0")), int(valid.get("toLane", "0"))))
                for lane in range(first, last + 1):
                    there = roads.map.get_waypoint_xodr(number, lane, s) if lane else None
                    if there is not None and there.lane_type == carla.LaneType.Driving:
                        lanes[mark.get("id", "")].add((number, lane))
    return lanes


def stops(roads: RoadNetwork, signal: Signal) -> list:
    """Where clients find the stop waypoints: along the box, a metre apart."""
    middle, half = signal.pose.apply(signal.box.center), signal.box.extent.x
    yaw = math.radians(signal.pose.rotation.yaw)
    found, place = [], -0.9 * half
    while place < 0.9 * half:
        point = carla.Location(middle.x + place * math.cos(yaw), middle.y + place * math.sin(yaw), middle.z)
        found.append(roads.map.get_waypoint(point))
        place += 1.0
    return found


def leads_to(waypoint, metres: int = 25) -> set[tuple[int, int]]:
    found, here = set(), [waypoint]
    for _ in range(metres):
        found |= {(one.road_id, one.lane_id) for one in here}
        here = [after for one in here for after in one.next(1.0)]
    return found


def test_there_are_as_many_lights_and_governed_lanes_as_in_the_real_simulator(town: str) -> None:
    _, signals, lanes = loaded(town)
    lights = [one for one in signals if one.type == LIGHT_TYPE]
    pairs = sum(len(lanes[one.id]) for one in lights)
    assert (len(lights), pairs) == COUNTS[Path(town).stem]


def test_there_are_as_many_stop_signs_as_the_file_holds(town: str) -> None:
    _, signals, _ = loaded(town)
    assert sum(one.type == "206" for one in signals) == STOPS.get(Path(town).stem, 0)


def test_each_stop_waypoint_lies_on_a_lane_that_leads_to_one_that_is_governed(town: str) -> None:
    roads, signals, lanes = loaded(town)
    for signal in signals:
        assert stops(roads, signal)
        for stop in stops(roads, signal):
            assert stop.lane_type == carla.LaneType.Driving
            assert leads_to(stop) & lanes[signal.id], f"signal {signal.id}: road {stop.road_id} lane {stop.lane_id}"


def test_each_governed_lane_has_a_stop_waypoint_before_it(town: str) -> None:
    roads, signals, lanes = loaded(town)
    for signal in signals:
        reached = set().union(*(leads_to(stop) for stop in stops(roads, signal)))
        assert lanes[signal.id] <= reached, f"signal {signal.id}"


def test_no_two_lights_govern_the_same_spot(town: str) -> None:
    """Several boxes in one place would count one red light twice."""
    roads, signals, _ = loaded(town)
    lights = [one for one in signals if one.type == LIGHT_TYPE]
    seen: dict[tuple[int, int, int], str] = {}
    for light in lights:
        for lane in {(one.road_id, one.lane_id, round(one.s)) for one in stops(roads, light)}:
            assert seen.setdefault(lane, light.id) == light.id


def test_the_lights_of_a_group_stand_at_one_junction_and_take_turns(town: str) -> None:
    _, signals, _ = loaded(town)
    groups = defaultdict(set)
    for light in signals:
        if light.type == LIGHT_TYPE:
            groups[light.group].update(light.phases)
    assert all(len(places) >= 2 for places in groups.values())


def test_speed_limits_are_those_of_streets_and_motorways(town: str) -> None:
    roads, _, _ = loaded(town)
    limits = {roads.limits.at(one.road_id, one.lane_id, one.s) for one in roads.map.generate_waypoints(10.0)}
    assert 20.0 <= min(limits) <= 65.0
    assert max(limits) <= 120.0
