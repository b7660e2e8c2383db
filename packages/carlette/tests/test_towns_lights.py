"""Lights and signs of CARLA's own towns, which are not part of this repository, and of the demo town."""

from __future__ import annotations

import math
from collections import defaultdict
from functools import cache
from pathlib import Path
from xml.etree import ElementTree

import pytest

from carlette.maps import DEMO_TOWN
from carlette.opendrive.map_file import MapFile, load_map
from carlette.opendrive.road_network import RoadNetwork
from carlette.opendrive.signals import LIGHT_TYPE, Signal, read_signals

carla = pytest.importorskip("carla")

COUNTS = {"Town01": (36, 72), "Town02": (24, 48), "Town04": (43, 121), "Town10HD": (15, 56), "demo_town": (6, 16)}
"""Lights, and pairs of a light and a driving lane that the file makes it govern."""
CYCLES = {
    "Town01": {"222": "383 381 382", "332": "395 394 393", "87": "367 368 366", "26": "361 362 360"},
    "Town02": {"349": "476 475 474", "76": "459 460 461"},
    "Town04": {
        "785": "1628 1627 1626 1629",
        "335": "1617 1616 1614 1615",
        "278": "1612 1613 1611",
        "916": "1632 1633 1631 1630",
    },
    "Town10HD": {"468": "953 954", "532": "959 957+958"},
}
"""Junction to its lights in the order in which they get green in CARLA. Light 958 has two controllers, of which CARLA
heeds one; 955 and 956 of junction 468 have none."""
STOPS = {"Town01": 0, "Town02": 0, "Town04": 8, "Town10HD": 3, "demo_town": 0}
"""As in CARLA; the file of Town04 holds none of its eight."""
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
    """Where clients find the stop waypoints: along the box, a meter apart."""
    middle, half = signal.pose.apply(signal.box.center), signal.box.extent.x
    yaw = math.radians(signal.pose.rotation.yaw)
    found, place = [], -0.9 * half
    while place < 0.9 * half:
        point = carla.Location(middle.x + place * math.cos(yaw), middle.y + place * math.sin(yaw), middle.z)
        found.append(roads.map.get_waypoint(point))
        place += 1.0
    return found


def leads_to(waypoint, meters: int = 25) -> set[tuple[int, int]]:
    found, here = set(), [waypoint]
    for _ in range(meters):
        found |= {(item.road_id, item.lane_id) for item in here}
        here = [after for item in here for after in item.next(1.0)]
    return found


@pytest.mark.integration
def test_town_light_and_lane_counts_match_carla(town: str) -> None:
    """A town has as many lights and governed lanes as in CARLA."""
    _, signals, lanes = loaded(town)
    lights = [signal for signal in signals if signal.type == LIGHT_TYPE]
    pairs = sum(len(lanes[light.id]) for light in lights)
    assert (len(lights), pairs) == COUNTS[Path(town).stem]


def test_town_stop_sign_count_matches_carla(town: str) -> None:
    """A town has as many stop signs as in CARLA."""
    _, signals, _ = loaded(town)
    assert sum(signal.type == "206" for signal in signals) == STOPS.get(Path(town).stem, 0)


def test_town_stop_waypoints_lead_to_governed_lanes(town: str) -> None:
    """Each stop waypoint lies on a lane that leads to a governed one."""
    roads, signals, lanes = loaded(town)
    for signal in signals:
        assert stops(roads, signal)
        for stop in stops(roads, signal):
            assert stop.lane_type == carla.LaneType.Driving
            assert not signal.id or leads_to(stop) & lanes[signal.id], (
                f"signal {signal.id}: road {stop.road_id} lane {stop.lane_id}"
            )


def test_each_governed_lane_has_a_stop_waypoint_before_it(town: str) -> None:
    roads, signals, lanes = loaded(town)
    for signal in signals:
        reached = set().union(*(leads_to(stop) for stop in stops(roads, signal)))
        assert lanes[signal.id] <= reached, f"signal {signal.id}"


@pytest.mark.integration
def test_no_two_lights_govern_the_same_spot(town: str) -> None:
    """Several boxes in one place would count one red light twice."""
    roads, signals, _ = loaded(town)
    lights = [signal for signal in signals if signal.type == LIGHT_TYPE]
    seen: dict[tuple[int, int, int], str] = {}
    for light in lights:
        for lane in {(stop.road_id, stop.lane_id, round(stop.s)) for stop in stops(roads, light)}:
            assert seen.setdefault(lane, light.id) == light.id


def test_the_lights_of_a_junction_take_turns(town: str) -> None:
    _, signals, _ = loaded(town)
    groups = defaultdict(set)
    for light in signals:
        if light.type == LIGHT_TYPE:
            groups[light.turn.group].add(light.turn.phase)
    assert all(len(places) >= 2 for places in groups.values())


def test_junctions_cycle_in_the_order_of_the_real_simulator(town: str) -> None:
    _, signals, _ = loaded(town)
    for junction, expected in CYCLES.get(Path(town).stem, {}).items():
        phases = defaultdict(list)
        for light in signals:
            if light.type == LIGHT_TYPE and light.turn.group == junction:
                phases[light.turn.phase].append(light.id)
        assert " ".join("+".join(sorted(phases[place])) for place in sorted(phases)) == expected, junction


def test_map_named_like_town_cycles_in_file_order(town01: Path) -> None:
    """A map that only has the name of a town cycles its lights in the order of the file."""
    text = town01.read_text(encoding="utf-8").replace('"381"', '"9381"')
    signals = read_signals(RoadNetwork(MapFile("Town01", text)), ElementTree.fromstring(text))
    phases = {signal.id: signal.turn.phase for signal in signals if signal.turn.group == "222"}
    assert phases == {"9381": 0, "382": 1, "383": 2}
