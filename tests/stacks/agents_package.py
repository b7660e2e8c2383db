"""CARLA's own agents, from wherever `CARLA_AGENTS` says; they are not part of this repository."""

from __future__ import annotations

import os
import sys
from typing import Any

import pytest

WHERE = "CARLA_AGENTS names no folder with CARLA's `agents` package (PythonAPI/carla of an installation)"


def behavior_agent_class() -> Any:
    """`BehaviorAgent`, or a skip that says why."""
    folder = os.environ.get("CARLA_AGENTS", "")
    if not os.path.isfile(os.path.join(folder, "agents", "navigation", "behavior_agent.py")):
        pytest.skip(WHERE)
    if folder not in sys.path:
        sys.path.insert(0, folder)
    from agents.navigation.behavior_agent import BehaviorAgent

    return BehaviorAgent
