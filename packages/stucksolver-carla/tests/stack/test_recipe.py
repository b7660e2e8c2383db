"""The recipe of docs/integrate.md: the example arrives with each form of CARLA's `agents`, else it exits with 1."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("carla")

from agents_package import agents_folders
from small_agent import package

from stucksolver_eval.simulator_server import carlette_server

pytestmark = pytest.mark.integration

EXAMPLE = Path(__file__).resolve().parents[4] / "examples" / "behavior_agent.py"
LONG_S = 400.0
OLD = """
class Planner:
    _waypoints_queue = ()


class BehaviorAgent:
    def __init__(self, vehicle, ignore_traffic_light=False, behavior="normal"):
        self._local_planner = Planner()

    def set_destination(self, start_location, end_location, clean=False):
        pass
"""
NEVER = """
import carla
import small_agent
from agents.navigation.local_planner import LocalPlanner


class BehaviorAgent(small_agent.Agent):
    stops_m, gain, planner_class = 5.0, 1.2, LocalPlanner

    def __init__(self, vehicle, behavior="normal"):
        super().__init__(vehicle)

    def run_step(self, debug=False):
        return carla.VehicleControl(hand_brake=True, brake=1.0)
"""


@pytest.fixture(scope="module")
def server():
    with carlette_server("demo_town") as running:
        yield running


def run(server, folder: Path, script: Path = EXAMPLE) -> subprocess.CompletedProcess[str]:
    """Run the example with the agents of a folder."""
    places = [str(folder), str(Path(__file__).parent), *sys.path]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, places))}
    command = [sys.executable, str(script), server.host, str(server.port)]
    return subprocess.run(command, capture_output=True, text=True, env=environment, timeout=LONG_S, check=False)


def short(folder: Path) -> Path:
    """Write the example with a limit of 2 s of driving."""
    path = folder / "short.py"
    path.write_text(
        EXAMPLE.read_text(encoding="utf-8").replace("LIMIT_TICKS = 2400", "LIMIT_TICKS = 40"), encoding="utf-8"
    )
    return path


@pytest.mark.parametrize(
    ("variant", "stops_m", "gain"),
    [
        ("hints", 4.3, 1.2),
        pytest.param("plain", 4.3, 1.2, marks=pytest.mark.release),
        pytest.param("plain", 5.3, 0.45, marks=pytest.mark.release),
    ],
)
def test_example_with_each_form_of_agents_arrives(server, tmp_path, variant, stops_m, gain):
    """One steers late. The others stop near the parked car."""
    done = run(server, package(tmp_path, variant, stops_m, gain))
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.endswith("\narrived\n") and "recovered:" in done.stdout


@pytest.mark.parametrize("folder", agents_folders(), ids=lambda folder: Path(folder).name)
def test_example_with_a_public_copy_arrives(server, folder):
    """For the folders that `CARLA_AGENTS` names: public copies are not part of this repository."""
    done = run(server, Path(folder))
    assert done.returncode == 0, done.stdout + done.stderr


def test_example_that_does_not_arrive_exits_with_one(server, tmp_path):
    folder = package(tmp_path, "plain", 5.0, 1.2)
    (folder / "agents/navigation/behavior_agent.py").write_text(NEVER, encoding="utf-8")
    done = run(server, folder, short(tmp_path))
    assert (done.returncode, done.stdout.splitlines()[-1]) == (1, "did not arrive")


def test_example_with_agents_that_are_too_old_says_so(server, tmp_path):
    """Also it leaves no vehicle behind: the next example would find its place taken."""
    folder = package(tmp_path, "plain", 5.0, 1.2)
    (folder / "agents/navigation/behavior_agent.py").write_text(OLD, encoding="utf-8")
    done = run(server, folder)
    assert done.returncode == 1
    assert re.fullmatch(r"the BehaviorAgent of .* has no get_local_planner; use .*\n", done.stderr), done.stderr
    (folder / "agents/navigation/behavior_agent.py").write_text(NEVER, encoding="utf-8")
    assert run(server, folder, short(tmp_path)).stdout.endswith("did not arrive\n")
