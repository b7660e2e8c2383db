"""The scenario types of the CARLA leaderboard, by their public names, over the `carla` client API."""

from stucksolver_eval.scenarios.base import Scenario, ScenarioError, Unsupported
from stucksolver_eval.scenarios.play import Play, PlayEvent
from stucksolver_eval.scenarios.registry import SCENARIOS, load_all, scenario_type
from stucksolver_eval.setting import Setting

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
