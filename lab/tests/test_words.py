"""The words of docs/glossary.md: no module is named by a word that says nothing alone, no class name stands twice."""

from __future__ import annotations

import ast
import re
import subprocess
from collections import defaultdict
from functools import cache
from pathlib import Path

import pytest

from lab.releasing.distributions import PROJECTS, ROOT

GLOSSARY = (ROOT / "docs" / "glossary.md").read_text(encoding="utf-8")


@cache
def files() -> tuple[Path, ...]:
    """Every tracked Python file that still exists."""
    listed = subprocess.run(["git", "ls-files", "-z", "*.py"], cwd=ROOT, capture_output=True, text=True, check=True)
    return tuple(path for name in listed.stdout.split("\0") if name and (path := ROOT / name).is_file())


def sources(folder: Path) -> list[Path]:
    return [path for path in files() if path.is_relative_to(folder) and "tests" not in path.relative_to(ROOT).parts]


@cache
def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def forbidden_words() -> set[str]:
    """The words of the glossary's last section."""
    section = GLOSSARY.split("## Words never used alone as a name")[1]
    return set(re.split(r"[,\s]+", section.split(".")[0].strip()))


def test_glossary_lists_the_forbidden_words():
    assert {"told", "seen", "one", "way", "then"} <= forbidden_words()


def test_module_name_is_no_forbidden_word():
    modules = [path for folder in (*PROJECTS.values(), ROOT / "lab") for path in sources(folder)]
    assert len(modules) > 900
    assert [str(path.relative_to(ROOT)) for path in modules if path.stem in forbidden_words()] == []


@pytest.mark.parametrize("name", PROJECTS)
def test_class_name_stands_once_in_a_distribution(name):
    homes = defaultdict(list)
    for path in sources(PROJECTS[name]):
        for node in tree(path).body:
            if isinstance(node, ast.ClassDef):
                homes[node.name].append(str(path.relative_to(PROJECTS[name])))
    assert {found: paths for found, paths in homes.items() if len(paths) > 1} == {}


def test_loop_variable_is_not_called_one():
    found = []
    for path in files():
        for node in ast.walk(tree(path)):
            targets = [node.target] if isinstance(node, ast.comprehension | ast.For | ast.AsyncFor) else []
            names = [name for target in targets for name in ast.walk(target) if isinstance(name, ast.Name)]
            found += [f"{path.relative_to(ROOT)}:{name.lineno}" for name in names if name.id == "one"]
    assert found == []


def test_module_level_name_is_no_forbidden_word():
    words = forbidden_words() - {"one"}
    found = []
    for folder in (*PROJECTS.values(), ROOT / "lab"):
        for path in sources(folder):
            found += [
                f"{path.relative_to(ROOT)}: {node.name}"
                for node in tree(path).body
                if isinstance(node, ast.FunctionDef | ast.ClassDef) and node.name.lower() in words
            ]
    assert found == []
