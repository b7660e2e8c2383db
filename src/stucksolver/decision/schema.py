"""The one versioned JSON form of all that crosses the boundary, as JSON Schemas."""

from __future__ import annotations

from typing import Any

from pydantic import TypeAdapter

from stucksolver.decision.decision import Decision
from stucksolver.decision.directive import directive_adapter
from stucksolver.scene import Scene, Status, Surroundings

VERSION = 1
"""Raised whenever a record written before can no longer be read."""

ADAPTERS: dict[str, TypeAdapter[Any]] = {
    "status": TypeAdapter(Status),
    "surroundings": TypeAdapter(Surroundings),
    "scene": TypeAdapter(Scene),
    "decision": TypeAdapter(Decision),
    "directive": directive_adapter,
}


def schemas() -> dict[str, dict[str, Any]]:
    """The five schemas by name, each a document of its own with the version in its `$id`."""
    return {name: {"$id": f"stucksolver/v{VERSION}/{name}", **a.json_schema()} for name, a in ADAPTERS.items()}
