"""Bench2Drive's entry with perception by sensors: the evaluator's frames cross the bridge, and it drives by them."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from typing import Any

import pytest

carla = pytest.importorskip("carla")
pytest.importorskip("onnxruntime")

from evaluator_stub import entry_class  # noqa: E402

from stucksolver_bridge import SolverError  # noqa: E402
from stucksolver_carla.client_connection import connect  # noqa: E402
from stucksolver_carla.drivers.behavior import RoutePoint  # noqa: E402
from stucksolver_eval.drivers.leaderboard import LeaderboardAgent  # noqa: E402
from stucksolver_eval.simulator_server import carlette_server, set_synchronous  # noqa: E402
from stucksolver_perception.rig import SHIPPED  # noqa: E402

pytestmark = pytest.mark.integration

STOPPED_M, ROUTE_M = 20.0, 45
PAST_M = 6.0
"""So far beyond the other's middle the two no longer overlap."""
LONGEST_TICKS = 250
CAR = "vehicle.tesla.model3"


@pytest.fixture(scope="module")
def client() -> Iterator[Any]:
    with carlette_server("demo_town", scenery=True) as server:
        found = connect(server, 20.0)
        set_synchronous(found.get_world(), 0.05)
        yield found


@pytest.fixture
def drive(client, tmp_path, monkeypatch):
    """Makes the entry drive along a street in which a car stands; gives the agent, the ego and what it touches."""
    world, made = client.get_world(), []
    library, start = world.get_blueprint_library(), world.get_map().get_spawn_points()[0]
    lane = world.get_map().get_waypoint(start.location)

    def begin(entry=None, **config):
        for item in reversed(made):
            _end(item)
        made.clear()
        ego = world.spawn_actor(library.find("vehicle.lincoln.mkz_2020"), start)
        made.append(ego)
        bumps: list[str] = []
        made.append(world.spawn_actor(library.find("sensor.other.collision"), carla.Transform(), attach_to=ego))
        made[-1].listen(lambda event: bumps.append(event.other_actor.type_id))
        there = lane.next(STOPPED_M)[0].transform
        there.location.z += 0.3
        made.append(world.spawn_actor(library.find(CAR), there))
        world.tick()
        found = entry_class(monkeypatch) if entry is None else entry
        path = tmp_path / "config.json"
        given = {"perception": "sensors", "driver": "planner", "python": sys.executable, "events": str(tmp_path)}
        path.write_text(json.dumps({**given, **config}), encoding="utf-8")
        agent = LeaderboardAgent(found, str(path), client, ego, world.get_map())
        made.append(agent)
        route = [RoutePoint(lane if m == 0 else lane.next(float(m))[0], "lane_follow") for m in range(ROUTE_M)]
        agent.set_route(route)
        world.tick()
        return agent, ego, bumps

    yield begin
    for item in reversed(made):
        _end(item)
    world.tick()


def _end(owner):
    """Of an agent or an actor."""
    owner.close() if isinstance(owner, LeaderboardAgent) else owner.destroy()


@pytest.mark.release
@pytest.mark.slow
def test_entry_sensor_mode_passes_stopped_car_without_contact(client, drive, tmp_path):
    """In sensor mode, the entry passes a car that has stopped in its lane, without contact."""
    world = client.get_world()
    agent, ego, bumps = drive(recovery="search")
    begin = ego.get_location()
    for _ in range(LONGEST_TICKS):
        ego.apply_control(agent.run_step())
        world.tick()
        if begin.distance(ego.get_location()) > STOPPED_M + PAST_M:
            break
    assert begin.distance(ego.get_location()) > STOPPED_M + PAST_M
    assert not bumps
    first = json.loads((tmp_path / "route.jsonl").read_text(encoding="utf-8").splitlines()[0])
    assert first["perception"] == "sensors"


class NoLidar:
    """Mixed into the entry: a user's variant that leaves a sensor out."""

    def sensors(self):
        return [sensor for sensor in super().sensors() if sensor["type"] != "sensor.lidar.ray_cast"]


class SmallPictures:
    """One whose camera is another than it says."""

    def run_step(self, input_data, timestamp):
        frame, picture = input_data["CAM_FRONT"]
        return super().run_step({**input_data, "CAM_FRONT": (frame, picture[::2, ::2].copy())}, timestamp)


@pytest.mark.slow
def test_entry_sensor_mismatch_ends_run_with_one_line(drive, monkeypatch, tmp_path):
    """Sensors that do not fit end the run with one clear line before any vehicle has moved."""
    usual = entry_class(monkeypatch)
    with pytest.raises(SolverError, match=r"declares 0 sensors of type sensor\.lidar\.ray_cast"):
        drive(type("Entry", (NoLidar, usual), {}))
    bad = tmp_path / "rig.toml"
    bad.write_text(SHIPPED.read_text(encoding="utf-8").replace("version = 1", "version = 9", 1), encoding="utf-8")
    with pytest.raises(SolverError, match=r"rig\.toml: version 9"):
        drive(usual, rig=str(bad))
    agent, _, _ = drive(type("Entry", (SmallPictures, usual), {}))
    with pytest.raises(SolverError, match="the camera's image is 800 x 450 x 4, the rig has 1600 x 900"):
        agent.run_step()
