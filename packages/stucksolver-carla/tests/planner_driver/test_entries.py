"""The planner through `attach`, and behind the entry for Bench2Drive's evaluator."""

from __future__ import annotations

import enum
import importlib.util
import json
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import carla
import pytest
from planner_stage import LEFT, LitWorld, drive

import stucksolver_bridge
import stucksolver_carla
from stucksolver_bridge import in_process_planner
from stucksolver_bridge.in_process_planner import InProcessPlanner, PlannerError
from stucksolver_carla.drivers.behavior import DriverOptions
from stucksolver_carla.drivers.planner import PlannerDriver

ENTRY = Path(stucksolver_bridge.__file__).parent / "leaderboard" / "stucksolver_entry.py"


class RoadOption(enum.Enum):
    """As in CARLA's agents."""

    LANEFOLLOW = 4


def plan_along(world, start_m, end_m):
    """The left lane, a waypoint each meter."""
    points = [carla.Location(float(x), LEFT, 0.0) for x in range(start_m, end_m)]
    return [(world.map.get_waypoint(point), RoadOption.LANEFOLLOW) for point in points]


def stubbed(monkeypatch, **modules):
    for name, content in modules.items():
        module = ModuleType(name.replace("__", "."))
        vars(module).update(content)
        monkeypatch.setitem(sys.modules, module.__name__, module)


@pytest.fixture
def entry(monkeypatch):
    """The entry's module, as the evaluator's process loads it."""
    stubbed(
        monkeypatch,
        agents={},
        agents__navigation={},
        agents__navigation__behavior_agent={"BehaviorAgent": object},
        leaderboard={},
        leaderboard__autoagents={},
        leaderboard__autoagents__autonomous_agent={"AutonomousAgent": object, "Track": SimpleNamespace(SENSORS="S")},
        srunner={},
        srunner__scenariomanager={},
        srunner__scenariomanager__carla_data_provider={"CarlaDataProvider": SimpleNamespace()},
    )
    spec = importlib.util.spec_from_file_location("stucksolver_entry", ENTRY)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_entry_with_planner_in_config_drives_with_planner(entry, tmp_path) -> None:
    """The entry drives with the planner if its configuration selects it."""
    world = LitWorld()
    ego = world.add_ego(10.0, LEFT)
    entry.CarlaDataProvider.get_map = lambda: world.map
    config = tmp_path / "config.json"
    config.write_text(json.dumps({"driver": "planner", "sensors": False}), encoding="utf-8")
    agent = entry.StuckSolverAgent()
    agent.hero_actor, agent._dense_plan = ego, []
    agent._dense_plan = [(w.transform, option) for w, option in plan_along(world, 10, 120)]
    agent.get_metric_info = dict
    agent.setup(f"{config}+RouteScenario_1_rep0_Town01")
    for tick in range(300):
        ego.apply_control(agent.run_step({}, 0.05 * tick))
        world.tick()
    assert isinstance(agent._driver.driver, PlannerDriver)
    assert ego.x > 80.0
    assert abs(ego.y - LEFT) < 0.1


def test_planner_does_not_brake_for_end_of_plan() -> None:
    """The planner does not brake for the end of the plan, where the evaluator ends the run."""
    world = LitWorld()
    ego = world.add_ego(10.0, LEFT, 0.0, 8.0)
    driver = InProcessPlanner(ego, "normal", world.map)
    driver.set_plan(plan_along(world, 10, 120))
    drive(world, ego, driver, 10.0)
    assert ego.x > 95.0
    assert ego.speed > 8.0


def test_a_python_without_stucksolver_is_told_what_to_do(monkeypatch) -> None:
    monkeypatch.setattr(in_process_planner, "MODULE", "nowhere_to_be_found")
    with pytest.raises(PlannerError, match="leave 'driver' at 'agent'"):
        InProcessPlanner(None, "normal", None)


def test_a_plan_of_one_point_is_refused() -> None:
    world = LitWorld()
    driver = InProcessPlanner(world.add_ego(10.0, LEFT), "normal", world.map)
    with pytest.raises(ValueError, match="two waypoints"):
        driver.set_plan(plan_along(world, 10, 11))


@pytest.mark.integration
def test_attach_planner_leaves_its_driving_unchanged() -> None:
    ways = []
    for attached in (False, True):
        world = LitWorld()
        ego = world.add_ego(10.0, LEFT)
        planner = PlannerDriver(ego, "normal", DriverOptions(ignore_traffic_lights=True), world.map)
        planner.set_destination(carla.Location(200.0, LEFT, 0.0))
        agent = stucksolver_carla.attach(planner, clock="lockstep") if attached else planner
        ways.append(drive(world, ego, agent, 10.0))
        if attached:
            assert agent.driver is planner
            agent.close()
    assert ways[0] == ways[1]


def test_an_attached_planner_takes_the_plan_of_an_evaluator() -> None:
    world = LitWorld()
    planner = PlannerDriver(world.add_ego(10.0, LEFT), "normal", None, world.map)
    agent = stucksolver_carla.attach(planner, clock="lockstep")
    agent.set_global_plan(plan_along(world, 10, 60))
    assert len(planner.route) == 50
    assert not agent.done()
    agent.close()
