"""The scenario types of the CARLA leaderboard under their public names, and additional ones, on CARLA's client API."""

from stucksolver_eval.scenario_context import ScenarioContext
from stucksolver_eval.scenarios.player import PlayEvent, ScenarioPlayer
from stucksolver_eval.scenarios.registry import SCENARIOS, load_all, scenario_type
from stucksolver_eval.scenarios.scenario import Scenario, ScenarioError, UnsupportedScenarioError

__all__ = [
    "SCENARIOS",
    "PlayEvent",
    "Scenario",
    "ScenarioContext",
    "ScenarioError",
    "ScenarioPlayer",
    "UnsupportedScenarioError",
    "load_all",
    "scenario_type",
]
