"""`--driver MODULE:CLASS`: agents of users, as they would write them, in an evaluation."""

from __future__ import annotations

import json
import sys
import time
import weakref
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import ClassVar

import numpy as np
import pytest

pytest.importorskip("carla")

from guests import AsksForSonar, ForLeaderboard

from stucksolver_eval.drivers import AgentError, check_driver
from stucksolver_eval.drivers.agent import checked
from stucksolver_eval.drivers.leaderboard import LeaderboardAgent, _Listening
from stucksolver_eval.drivers.user_agent_driver import UserAgentDriver
from stucksolver_eval.runner.job import RouteJob
from stucksolver_eval.runner.route_process import RouteTask, run_task
from stucksolver_eval.suites import load_routes
from stucksolver_eval.systems.factory import SystemSpecError, check_arm
from stucksolver_eval.systems.spec import SystemSpec

ROOT = Path(__file__).parents[4]

ROUTE = "1242"
"""A parked car in our lane, which traffic overtakes on the left."""


@pytest.fixture(autouse=True)
def found(monkeypatch):
    """The folder of the examples is where modules are looked for, too; this file's folder is already."""
    monkeypatch.setattr(sys, "path", [*sys.path, str(ROOT)])


def driven(driver, folder):
    route = load_routes("dev", (ROUTE,))[0]
    return run_task(RouteTask(RouteJob(route, 1, SystemSpec(driver=driver)), folder))


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ("nowhere:Agent", "No module named 'nowhere'"),
        ("guests:Nobody", "no attribute 'Nobody'"),
        ("guests:AHEAD", "not a class"),
        ("guests:Deaf", "has no set_route"),
        ("guests", "Use behavior or planner, each with :PROFILE, or your own agent as MODULE:CLASS"),
        ("behavior:mad", "cautious, normal, aggressive"),
    ],
)
def test_what_is_no_driver_is_said_before_anything_is_driven(words, told):
    with pytest.raises(SystemSpecError, match=told):
        check_arm(SystemSpec(driver=words))


@pytest.mark.parametrize("words", ["behavior", "behavior:cautious", "guests:ForLeaderboard@x.json", "guests:Nonsense"])
def test_what_can_be_made_is_a_driver(words):
    check_driver(words)


@pytest.mark.parametrize("control", [None, SimpleNamespace(throttle=1.0, steer=0.0), "go", {"throttle": 1.0}])
def test_a_step_gives_a_control_or_is_named(control):
    with pytest.raises(AgentError, match=r"mine:Agent\.run_step returned a"):
        checked(control, "mine:Agent")


class Helper:
    """Says who is asked."""

    route = ("a", "b")

    def __init__(self):
        self.heard = []

    def __getattr__(self, name):
        return lambda *args: self.heard.append(name) or SimpleNamespace(throttle=0.0, steer=0.0, brake=1.0, by="helper")


class Guest:
    """Counts its steps and routes."""

    def __init__(self):
        self.steps, self.routes = 0, []

    def set_route(self, route):
        self.routes.append(tuple(route))

    def run_step(self):
        self.steps += 1
        return SimpleNamespace(throttle=1.0, steer=0.0, brake=0.0, by="guest")


@pytest.mark.parametrize("told", [lambda d: d.follow([]), lambda d: d.hold(), lambda d: d.hold(3.0)])
def test_user_agent_controls_only_while_it_drives(told):
    """The agent is asked for a control only while no path or hold of the solver is active."""
    guest, helper = Guest(), Helper()
    driver = UserAgentDriver(guest, "mine:Agent", helper)
    assert driver.run_step().by == "guest"
    told(driver)
    assert driver.run_step().by == "helper" and guest.steps == 1
    driver.release()
    assert driver.run_step().by == "guest"
    assert helper.heard.count("keep_up") == 2


def test_the_agent_hears_of_every_route():
    guest = Guest()
    driver = UserAgentDriver(guest, "mine:Agent", Helper())
    driver.set_route(("x",))
    driver.set_destination("there")
    assert guest.routes == [("a", "b")] * 2


class Provider:
    """As much of scenario runner's registry as agents look at."""

    _carla_actor_pool: ClassVar[dict] = {}
    told: ClassVar[list] = []

    @classmethod
    def set_client(cls, client):
        cls.told.append(("client", client))

    @classmethod
    def set_world(cls, world):
        cls.told.append(("world", world))

    @classmethod
    def register_actor(cls, actor, transform=None):
        cls.told.append(("actor", actor.id))

    @classmethod
    def on_carla_tick(cls):
        cls.told.append(("tick", None))


class GameTime:
    """Its clock."""

    told: ClassVar[list] = []

    @classmethod
    def on_carla_tick(cls, timestamp):
        cls.told.append(timestamp.elapsed_seconds)


def test_user_agent_scenario_runner_provides_hero_and_time(monkeypatch):
    """An agent that uses ScenarioRunner finds the hero and the time of the run in its classes."""
    for name, parts in (
        ("srunner", {}),
        ("srunner.scenariomanager", {}),
        ("srunner.scenariomanager.carla_data_provider", {"CarlaDataProvider": Provider}),
        ("srunner.scenariomanager.timer", {"GameTime": GameTime}),
    ):
        module = ModuleType(name)
        module.__dict__.update(parts)
        monkeypatch.setitem(sys.modules, name, module)
    stamp = SimpleNamespace(elapsed_seconds=7.0)
    world = SimpleNamespace(get_snapshot=lambda: SimpleNamespace(frame=3, timestamp=stamp))
    hero = SimpleNamespace(id=5, get_world=lambda: world, get_transform=lambda: None)

    class Bench2Drives(ForLeaderboard):
        def __init__(self, carla_host, carla_port, debug=False):
            self.hero = Provider._carla_actor_pool[5]

        def sensors(self):
            return []

        def run_step(self, input_data, timestamp):
            return self.hero.id, input_data, timestamp

    agent = LeaderboardAgent(Bench2Drives, "", "the client", hero, SimpleNamespace())
    agent.set_route([])
    world.get_snapshot = lambda: SimpleNamespace(frame=4, timestamp=SimpleNamespace(elapsed_seconds=7.05))
    assert agent.run_step() == (5, {}, pytest.approx(0.05))
    assert Provider.told == [("client", "the client"), ("world", world), ("actor", 5), ("tick", None)]
    assert GameTime.told == [7.05]


def test_a_sensor_that_the_simulator_does_not_have_is_named():
    library = SimpleNamespace(filter=lambda kind: [])
    snapshot = SimpleNamespace(frame=3, timestamp=SimpleNamespace(elapsed_seconds=7.0))
    world = SimpleNamespace(get_snapshot=lambda: snapshot, get_blueprint_library=lambda: library)
    hero = SimpleNamespace(id=5, get_world=lambda: world)
    agent = LeaderboardAgent(AsksForSonar, "x", "the client", hero, SimpleNamespace())
    with pytest.raises(AgentError, match=r"guests:AsksForSonar requires a sensor 'sensor\.other\.sonar', which this"):
        agent.set_route([])


class Data(SimpleNamespace):
    """A frame's data; one can see whether somebody holds it."""


class Sensor:
    """Gives data when told to."""

    type_id = "sensor.camera.rgb"

    def listen(self, take):
        self.give = take


def test_agent_sensor_unread_keeps_only_latest_data():
    """While a sensor is not read, only its latest data is kept."""
    sensor = Sensor()
    listening = _Listening(sensor, "mine:Agent")
    data = [Data(frame=k) for k in range(600)]
    for item in data:
        sensor.give(item)
    held = [weakref.ref(item) for item in data]
    del data, item
    assert sum(ref() is not None for ref in held) == 1
    with pytest.raises(AgentError, match=r"sensor\.camera\.rgb, which mine:Agent requires, sent no data for frame 600"):
        listening.read(600, time.monotonic())


@pytest.mark.release
@pytest.mark.slow
@pytest.mark.integration
def test_leaderboard_agent_gets_requested_sensors_and_route(tmp_path):
    """An agent for the leaderboard gets the sensors, the time, the map and the route that it requests."""
    told = tmp_path / "told.json"
    outcome = driven(f"guests:ForLeaderboard@{told}", tmp_path / "out")
    assert outcome.state == "crashed" and "that is enough" in outcome.reason
    assert told.with_suffix(".end").read_text(encoding="utf-8") == "200"
    given = json.loads(told.read_text(encoding="utf-8"))
    shapes = given["given"]
    assert shapes["front"] == [60, 80, 4] and shapes["imu"] == [7] and shapes["gnss"] == [3]
    assert shapes["lidar"][1] == 4 and shapes["lidar"][0] > 100
    assert given["frames"] == 1 and given["time_s"] == pytest.approx(1.0) and given["speed"] > 0.1
    assert given["picture"] > 5.0 and "OpenDRIVE" in given["map"] and "LANEFOLLOW" in given["turns"]
    # It steered by GNSS and compass alone, from a parking lane to the middle of its own.
    # (The fixes have the noise that the leaderboard gives them, half a meter each way.)
    assert np.hypot(*given["aside"]) < 1.5 and given["at"] > 10


@pytest.mark.integration
@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("Nonsense", "throttle nan"),
        pytest.param("Breaks", "the user's own fault", marks=pytest.mark.release),
    ],
)
def test_failing_agent_crashes_only_its_route_and_is_named(name, why, tmp_path):
    """An agent that fails makes only its route crash, and the reason names the agent."""
    outcome = driven(f"guests:{name}", tmp_path)
    assert outcome.state == "crashed" and why in outcome.reason and "guests" in outcome.reason
