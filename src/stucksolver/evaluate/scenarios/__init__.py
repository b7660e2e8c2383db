"""The scenario types of the CARLA leaderboard, by their public names, over the `carla` client API."""

from stucksolver.evaluate.scenarios.base import Scenario, ScenarioError, Unsupported
from stucksolver.evaluate.scenarios.play import Play, PlayEvent
from stucksolver.evaluate.scenarios.registry import SCENARIOS, load_all, scenario_type
from stucksolver.evaluate.scenarios.setting import Setting

__all__ = [
    "SCENARIOS",
    "Play",
    "PlayEvent",
    "Scenario",
    "ScenarioError",
    "Setting",
    "Unsupported",
    "load_all",
    "scenario_type",
]
