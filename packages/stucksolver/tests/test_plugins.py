"""Plug-ins of other distributions: found by entry points, and named with a remedy if they cannot be loaded."""

from __future__ import annotations

from importlib.metadata import EntryPoint

import pytest

from stucksolver import plugins as module
from stucksolver.commands import main
from stucksolver.plugins import GROUPS, Plugin, PluginError, all_plugins, plugins
from stucksolver.reasoners import registry
from stucksolver.reasoners.registry import ReasonerKind


def plugin(value: str, group: str = "reasoners") -> Plugin:
    return Plugin(group, "mine", "my-package", "1.2", EntryPoint("mine", value, f"stucksolver.{group}"))


def test_plugins_of_this_project_load():
    assert {found.group for found in all_plugins()} <= set(GROUPS)
    assert all(found.load() is not None for found in plugins("commands"))


def test_plugins_unknown_group_is_rejected_by_name():
    with pytest.raises(ValueError, match="unknown group of plug-ins 'wheels': expected one of commands, checks"):
        plugins("wheels")


@pytest.mark.parametrize(
    ("value", "remedy"),
    [
        ("no_such_package.part:KIND", "install the package 'no_such_package'"),
        ("stucksolver.nothing:KIND", "reinstall or remove the distribution"),
        ("json:nothing", "reinstall or remove the distribution"),
    ],
)
def test_plugin_that_cannot_load_names_distribution_and_remedy(value, remedy):
    with pytest.raises(PluginError, match=rf"plug-in 'mine' of my-package 1.2 \({value}\) cannot be loaded.*{remedy}"):
        plugin(value).load()


def test_plugins_command_reports_a_broken_plugin_and_fails(monkeypatch, capsys):
    monkeypatch.setattr("stucksolver.commands.plugins.all_plugins", lambda: (plugin("no_such_package:KIND"),))
    assert main(["plugins"]) == 1
    assert "reasoners mine  my-package 1.2  plug-in 'mine'" in capsys.readouterr().out


def test_broken_reasoner_plugin_leaves_the_built_in_search(monkeypatch):
    """A vehicle must not lose its own reasoner because another distribution is broken."""
    monkeypatch.setattr(registry, "plugins", lambda group: (plugin("no_such_package:KIND"),))
    before = dict(registry.KINDS)
    registry.load_plugins()
    assert before == registry.KINDS and "search" in before


def test_reasoner_plugin_registers_its_kind(monkeypatch):
    kind = ReasonerKind("mine", "mine", lambda rest, exchanges: None)
    monkeypatch.setattr(registry, "KINDS", dict(registry.KINDS))
    monkeypatch.setattr(registry, "plugins", lambda group: (plugin("json:KIND"),))
    monkeypatch.setattr(module.Plugin, "load", lambda self: kind)
    registry.load_plugins()
    assert registry.KINDS["mine"] is kind
