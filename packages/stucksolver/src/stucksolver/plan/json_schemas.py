"""JSON schemas of all data that crosses the process boundary, with one version."""

from __future__ import annotations

from typing import Any

from pydantic import TypeAdapter

from stucksolver.plan.decision import Decision
from stucksolver.plan.directive import directive_adapter
from stucksolver.scene import Scene, Status, Surroundings

VERSION = 1
"""Version of the schemas. It is increased when an older record can no longer be read."""

ADAPTERS: dict[str, TypeAdapter[Any]] = {
    "status": TypeAdapter(Status),
    "surroundings": TypeAdapter(Surroundings),
    "scene": TypeAdapter(Scene),
    "decision": TypeAdapter(Decision),
    "directive": directive_adapter,
}


def schemas() -> dict[str, dict[str, Any]]:
    """Return the five schemas by name, each as a separate document with the version in its `$id`."""
    return {name: {"$id": f"stucksolver/v{VERSION}/{name}", **a.json_schema()} for name, a in ADAPTERS.items()}
