"""Public copies of CARLA's agents, from wherever `CARLA_AGENTS` says; they are not part of this repository."""

from __future__ import annotations

import importlib
import os
import sys
from pathlib import Path
from typing import Any

import pytest

WHERE = "CARLA_AGENTS names no folder with CARLA's `agents` package (PythonAPI/carla of an installation)"


def agents_folders() -> list[str]:
    """The folders that `CARLA_AGENTS` names, separated as in PATH. One that holds no agents is an error."""
    named = [folder for folder in os.environ.get("CARLA_AGENTS", "").split(os.pathsep) if folder]
    for folder in named:
        if not Path(folder, "agents", "navigation", "behavior_agent.py").is_file():
            raise ValueError(f"CARLA_AGENTS: {folder} has no agents/navigation/behavior_agent.py; leave it out")
    return named


def behavior_agent_class(folder: str | None = None) -> Any:
    """`BehaviorAgent` of one folder, by default of the first; or a skip that says why."""
    if folder is None:
        folder = next(iter(agents_folders()), None)
    if folder is None:
        pytest.skip(WHERE)
    for name in [name for name in sys.modules if name.partition(".")[0] == "agents"]:
        del sys.modules[name]
    sys.path.insert(0, folder)
    try:
        return importlib.import_module("agents.navigation.behavior_agent").BehaviorAgent
    finally:
        sys.path.remove(folder)
