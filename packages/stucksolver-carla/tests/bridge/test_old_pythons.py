"""The bridge runs where others run: on the oldest Python it names, with nothing but the standard library."""

from __future__ import annotations

import ast
import sys
from pathlib import Path

import pytest

import stucksolver_bridge

FOLDER = Path(stucksolver_bridge.__file__).parent
FILES = sorted(FOLDER.rglob("*.py"))
EVALUATORS = {"carla", "agents", "leaderboard", "srunner"}
"""Packages of the process that the entry runs in."""


@pytest.mark.parametrize("path", FILES, ids=[str(p.relative_to(FOLDER)) for p in FILES])
def test_bridge_files_parse_as_python_3_7_with_standard_library(path):
    """A file has the grammar of Python 3.7 and imports only the standard library."""
    tree = ast.parse(path.read_text(encoding="utf-8"), feature_version=(3, 7))
    allowed = set(sys.stdlib_module_names) | {"stucksolver_bridge"}
    if path.parent.name == "leaderboard":
        allowed |= EVALUATORS
    for node in ast.walk(tree):
        named = [a.name for a in node.names] if isinstance(node, ast.Import) else []
        named += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
        assert {name.partition(".")[0] for name in named} <= allowed


@pytest.mark.parametrize("path", FILES, ids=[str(p.relative_to(FOLDER)) for p in FILES])
def test_annotations_are_not_evaluated_where_old_pythons_could_not(path):
    tree = ast.parse(path.read_text(encoding="utf-8"))
    annotated = any(isinstance(node, ast.AnnAssign) or getattr(node, "annotation", None) for node in ast.walk(tree))
    futures = [n for n in tree.body if isinstance(n, ast.ImportFrom) and n.module == "__future__"]
    assert futures or not annotated


def test_the_entrys_folder_holds_nothing_that_could_hide_another_module():
    assert {p.name for p in (FOLDER / "leaderboard").glob("*.py")} == {"__init__.py", "stucksolver_entry.py"}
