"""What the evaluator's process offers an agent, in as little code as the entry needs: the leaderboard's base class,
scenario runner's registry and CARLA's `agents`, none of which is part of this repository."""

from __future__ import annotations

import importlib.util
import sys
import types
from pathlib import Path
from typing import Any, ClassVar

import stucksolver_bridge.leaderboard as entry_folder


class AutonomousAgent:
    """As Bench2Drive's: it knows the hero, from the registry."""

    def __init__(self, host: str = "localhost", port: int = 2000) -> None:
        self.track: Any = None
        (self.hero_actor,) = CarlaDataProvider._carla_actor_pool.values()

    def set_global_plan(self, gps: Any, world: Any) -> None:
        """Bench2Drive thins it out here."""

    def get_metric_info(self) -> dict[str, Any]:
        return {}


class CarlaDataProvider:
    """Is told of one world and one hero."""

    _carla_actor_pool: ClassVar[dict[int, Any]] = {}
    _world: Any = None

    @classmethod
    def set_client(cls, client: Any) -> None:
        """Not asked for."""

    @classmethod
    def set_world(cls, world: Any) -> None:
        cls._world = world
        cls._carla_actor_pool.clear()

    @classmethod
    def register_actor(cls, actor: Any, transform: Any) -> None:
        """Places are not asked for."""

    @classmethod
    def on_carla_tick(cls) -> None:
        """Nothing is kept."""

    @classmethod
    def get_map(cls) -> Any:
        return cls._world.get_map()


def modules() -> dict[str, types.ModuleType]:
    """Stand-ins by the names under which the entry imports them."""
    named = {
        "agents": {},
        "agents.navigation": {},
        "agents.navigation.behavior_agent": {"BehaviorAgent": object},
        "leaderboard": {},
        "leaderboard.autoagents": {},
        "leaderboard.autoagents.autonomous_agent": {
            "AutonomousAgent": AutonomousAgent,
            "Track": types.SimpleNamespace(SENSORS="SENSORS"),
        },
        "srunner": {},
        "srunner.scenariomanager": {},
        "srunner.scenariomanager.carla_data_provider": {"CarlaDataProvider": CarlaDataProvider},
    }
    found = {}
    for name, holds in named.items():
        found[name] = types.ModuleType(name)
        found[name].__dict__.update(holds)
    return found


def entry_class(monkeypatch: Any) -> Any:
    """`StuckSolverAgent`, loaded as the evaluator does: from its file."""
    for name, module in modules().items():
        monkeypatch.setitem(sys.modules, name, module)
    path = Path(entry_folder.__path__[0]) / "stucksolver_entry.py"
    spec = importlib.util.spec_from_file_location("stucksolver_entry", path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return getattr(module, module.get_entry_point())
