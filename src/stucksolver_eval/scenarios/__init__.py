"""The scenario types of the CARLA leaderboard under their public names, and our own, on the `carla` client API."""

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
