"""The scenario types of the CARLA leaderboard under their public names, and our own, on the `carla` client API."""

from stucksolver_eval.scenario_context import Setting
from stucksolver_eval.scenarios.player import Play, PlayEvent
from stucksolver_eval.scenarios.registry import SCENARIOS, load_all, scenario_type
from stucksolver_eval.scenarios.scenario import Scenario, ScenarioError, Unsupported

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
