"""Places that go from one process to the other are found again, at the ends of roads too."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

carla = pytest.importorskip("carla")

from carlette.maps import DEMO_TOWN  # noqa: E402
from stucksolver_bridge import recovery_client  # noqa: E402
from stucksolver_bridge.world_data import waypoint_at, waypoint_numbers  # noqa: E402
from stucksolver_carla.drivers.behavior.lane_graph import lane_graph  # noqa: E402


@pytest.fixture(scope="module")
def town():
    return carla.Map("demo_town", DEMO_TOWN.read_text(encoding="utf-8"))


def lost(town):
    """Waypoints that the map itself does not find again."""
    return [w for w in lane_graph(town).samples if town.get_waypoint_xodr(*waypoint_numbers(w)) is None]


def test_every_waypoint_is_found_again(town):
    assert lost(town), "the test needs a road's end that the map does not find"
    for waypoint in lane_graph(town).samples:
        found = waypoint_at(town, waypoint_numbers(waypoint))
        assert found.transform.location.distance(waypoint.transform.location) < 0.01


def test_a_place_that_is_on_no_road_is_none(town):
    assert waypoint_at(town, [10_000, -1, 1.0]) is None


class FakeSolver:
    """Says one thing once."""

    alive, fault, late_ticks = True, None, 0

    def __init__(self, python, hello, path=None, **limits):
        self.answers = []

    def step(self, tick, give):
        return self.answers.pop(0) if self.answers else {}


class FakeDriver:
    vehicle, route, acceleration_mps2 = None, (), 3.0

    def __init__(self):
        self.plans = []

    def set_plan(self, plan):
        self.plans.append(plan)

    def run_step(self):
        return "control"


@pytest.fixture
def helped(town, monkeypatch):
    facts = SimpleNamespace(opening=lambda *_: {}, tick=dict, give=None)
    monkeypatch.setattr(recovery_client, "SolverProcess", FakeSolver)
    monkeypatch.setattr(recovery_client, "WorldData", lambda *_: facts)
    return recovery_client.RecoveryClient(FakeDriver(), town, carla, {}, "python")


def test_a_route_to_the_end_of_a_road_is_driven(town, helped):
    end = lost(town)[0]
    spots = [
        [*waypoint_numbers(end), "lane_follow"],
        [*waypoint_numbers(end)[:2], end.s - 1.0, "lane_follow"],
        [10_000, -1, 0.0, "left"],
    ]
    helped.solver.answers.append({"orders": [["route", spots]]})
    assert helped.run_step() == "control"
    ((first, second),) = helped._driver.plans
    assert all(waypoint is not None for waypoint, _ in (first, second))


def test_route_of_unknown_places_keeps_present_route(helped):
    helped.solver.answers.append({"orders": [["route", [[10_000, -1, 0.0, "left"]]]]})
    assert helped.run_step() == "control"
    assert helped._driver.plans == []
