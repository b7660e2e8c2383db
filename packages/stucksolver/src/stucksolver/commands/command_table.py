"""List of commands. Only the command that is called is imported, so that `--help` is fast."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module

from stucksolver.plugins import plugins


@dataclass(frozen=True)
class CliCommand:
    """One command. `options` and `run` name the functions of `module` that add its options and run it."""

    about: str
    module: str
    """Full name of the module."""
    options: str = "add_options"
    run: str = "run"
    drives: bool = False
    """True if the command needs CARLA's client package."""
    more: str = ""
    """Longer description for the command's own help."""

    def fill(self, parser: argparse.ArgumentParser) -> None:
        """Import the command and add its options to the parser."""
        module = import_module(self.module)
        getattr(module, self.options)(parser)
        parser.set_defaults(run=getattr(module, self.run), drives=self.drives)


CORE = {
    "replay": CliCommand(
        "recompute every decision and verdict of a record offline, and compare", "stucksolver.commands.replay"
    ),
    "ladder": CliCommand(
        "print a shipped ladder as a starting point, or check your own", "stucksolver.commands.ladder"
    ),
    "doctor": CliCommand("check what is installed, what is missing, and how to get it", "stucksolver.commands.doctor"),
    "plugins": CliCommand("list the installed plug-ins with version and status", "stucksolver.commands.plugins"),
    "config": CliCommand(
        "show the settings in effect, or write a configuration file to start from", "stucksolver.commands.config"
    ),
    "completion": CliCommand(
        "print a script that makes a shell complete commands and options", "stucksolver.commands.shell_completion"
    ),
}
"""Commands of the core."""
FIRST = (
    "demo",
    "ride",
    "evaluate",
    "score",
    "compare",
    "watch",
    "replay",
    "ladder",
    "prompt",
    "words",
    "cases",
    "memory",
)
"""Commands that the help lists first, in this order."""


@cache
def commands() -> Mapping[str, CliCommand]:
    """Return the commands of all installed distributions by name, in the order of the help.

    Raises:
        PluginError: The list of a distribution cannot be loaded.
    """
    # A plug-in cannot replace a command of the core, or of a plug-in before it.
    table = dict(CORE)
    for plugin in plugins("commands"):
        table |= {name: command for name, command in plugin.load().items() if name not in table}
    names = [*(name for name in FIRST if name in table), *(name for name in table if name not in FIRST)]
    return {name: table[name] for name in names}
