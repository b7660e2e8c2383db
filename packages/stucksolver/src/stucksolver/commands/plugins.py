"""`stucksolver plugins`: lists the installed plug-ins with version and status."""

from __future__ import annotations

import argparse

from stucksolver.commands.arguments import add_json, print_json
from stucksolver.plugins import Plugin, PluginError, all_plugins


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    add_json(parser, '[{"group", "name", "distribution", "version", "loads", "error"}]')


def run(options: argparse.Namespace) -> int:
    """Load and print every plug-in. Returns 1 if one of them cannot be loaded, else 0."""
    errors = {plugin: _error(plugin) for plugin in all_plugins()}
    if options.json:
        print_json([_row(plugin, error) for plugin, error in errors.items()])
    elif not errors:
        print("no plug-ins are installed; stucksolver[all] installs those of this project")
    else:
        width = max(len(f"{plugin.group} {plugin.name}") for plugin in errors)
        for plugin, error in errors.items():
            label = f"{plugin.group} {plugin.name}".ljust(width)
            print(f"{label}  {plugin.distribution} {plugin.version}  {'loads' if error is None else error}")
    return int(any(errors.values()))


def _error(plugin: Plugin) -> str | None:
    try:
        plugin.load()
    except PluginError as error:
        return str(error)
    return None


def _row(plugin: Plugin, error: str | None) -> dict[str, object]:
    return {
        "group": plugin.group,
        "name": plugin.name,
        "distribution": plugin.distribution,
        "version": plugin.version,
        "loads": error is None,
        "error": error,
    }
