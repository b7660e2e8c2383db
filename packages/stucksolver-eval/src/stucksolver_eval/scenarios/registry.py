"""Scenario types by their public names."""

from __future__ import annotations

import importlib
import pkgutil
from functools import cache
from typing import TypeVar

from stucksolver_eval.scenarios.scenario import Scenario, ScenarioError

SCENARIOS: dict[str, type[Scenario]] = {}
"""All registered types; complete after a call of `scenario_type` or `load_all`."""

S = TypeVar("S", bound=type[Scenario])


def scenario(cls: S) -> S:
    """Register a type under its name. Raises `ValueError` if the name is taken."""
    known = SCENARIOS.setdefault(cls.type, cls)
    if known is not cls:
        raise ValueError(
            f"duplicate scenario type: {cls.type!r} in {known.__module__} and {cls.__module__}. Rename one"
        )
    return cls


def scenario_type(name: str) -> type[Scenario]:
    """Return the type of this name. Raises `ScenarioError`, which lists the existing types."""
    load_all()
    if name not in SCENARIOS:
        raise ScenarioError(f"unknown scenario type: {name!r}. Choose from {', '.join(sorted(SCENARIOS))}")
    return SCENARIOS[name]


@cache
def load_all() -> None:
    """Import every file of `scenarios.types`, which registers its types."""
    from stucksolver_eval.scenarios import types

    for module in pkgutil.walk_packages(types.__path__, f"{types.__name__}."):
        importlib.import_module(module.name)
