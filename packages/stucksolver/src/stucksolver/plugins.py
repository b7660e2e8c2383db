"""Finds the additions of other installed distributions by their entry points.

A distribution names its additions in its `pyproject.toml`:

| group | object that the entry point loads |
|---|---|
| `stucksolver.commands` | commands of the `stucksolver` program: a `dict` of name to `Command` |
| `stucksolver.checks` | checks of `stucksolver doctor`: a tuple of functions without arguments that yield `Finding`s |
| `stucksolver.reasoners` | a kind of reasoner: a `stucksolver.reasoners.registry.ReasonerKind` |
| `stucksolver.interpreters` | a function without arguments that returns an `Interpreter` of utterances |
| `stucksolver.perception` | the vehicle's own sensors: a `stucksolver_carla.perception_interface.PerceptionPlugin` |
| `stucksolver.drivers` | a driver that an evaluation can name: a class such as `BehaviorDriver` |
| `stucksolver.criteria` | a criterion for every run of an evaluation: see `stucksolver_eval.criteria.monitor` |
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any

GROUPS = ("commands", "checks", "reasoners", "interpreters", "perception", "drivers", "criteria")
PREFIX = "stucksolver."


class PluginError(RuntimeError):
    """Failed import of an installed plug-in. The message has its name, its distribution and the reason."""


@dataclass(frozen=True)
class Plugin:
    """Entry point of an installed distribution.

    Attributes:
        group: One of `GROUPS`.
        name: Name of the entry point.
        distribution: Name of the distribution.
        version: Version of the distribution.
        entry: The entry point.
    """

    group: str
    name: str
    distribution: str
    version: str
    entry: EntryPoint

    def load(self) -> Any:
        """Import the plug-in.

        Raises:
            PluginError: The import fails for any reason.
        """
        try:
            return self.entry.load()
        except Exception as error:
            raise PluginError(
                f"plug-in {self.name!r} of {self.distribution} {self.version} ({self.entry.value}) cannot be loaded: "
                f"{type(error).__name__}: {error}; {_remedy(error)}"
            ) from error


@cache
def plugins(group: str) -> tuple[Plugin, ...]:
    """Return the installed plug-ins of a group, sorted by name, without importing them.

    Raises:
        ValueError: The group is unknown.
    """
    if group not in GROUPS:
        raise ValueError(f"unknown group of plug-ins {group!r}: expected one of {', '.join(GROUPS)}")
    installed = [_plugin(group, entry) for entry in entry_points(group=PREFIX + group)]
    return tuple(sorted(installed, key=lambda plugin: (plugin.name, plugin.distribution)))


def all_plugins() -> tuple[Plugin, ...]:
    """Return the installed plug-ins of all groups."""
    return tuple(plugin for group in GROUPS for plugin in plugins(group))


def _plugin(group: str, entry: EntryPoint) -> Plugin:
    # An entry point that was not found through an installed distribution has no distribution.
    origin = entry.dist
    return Plugin(group, entry.name, origin.name if origin else "unknown", origin.version if origin else "0", entry)


def _remedy(error: Exception) -> str:
    if isinstance(error, ModuleNotFoundError) and not str(error.name).startswith("stucksolver"):
        return f"install the package {str(error.name).partition('.')[0]!r}"
    return "reinstall or remove the distribution"
