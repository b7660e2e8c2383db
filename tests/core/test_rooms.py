"""The rooms keep their doors: who imports whom, and that the core needs no simulator."""

from __future__ import annotations

import ast
import importlib
import re
import subprocess
import sys
from functools import cache
from pathlib import Path

import networkx
import pytest

import carlette
import stucksolver

ROOT = Path(stucksolver.__file__).parent
CORE = {"scene", "decision", "detect", "reason", "guard", "ladder", "words"}
MAY_IMPORT = {
    "scene": set(),
    "decision": {"scene"},
    "detect": {"scene"},
    "privacy": set(),
    "reason": {"scene", "decision", "privacy"},
    "guard": {"scene", "decision"},
    "ladder": {"scene", "decision", "detect", "reason", "guard"},
    "words": {"scene"},
    "solver": CORE,
    "record": CORE | {"solver", "privacy"},
    "memory": {"scene", "decision", "privacy", "reason", "solver"},
    "perception": {"scene"},
    "passenger": CORE | {"solver", "signals"},
}
"""The design's table; rooms that are not listed may import the product at will."""
IMPORTED_BY_THE_CORE = ["stucksolver", *(f"stucksolver.{room}" for room in MAY_IMPORT)]
SIMULATORS = {"carla", "carlette"}


def modules(room):
    return sorted((ROOT / room).rglob("*.py"))


@cache
def imports_of(file):
    """Every module that a file imports, by full name, wherever in it the import stands."""
    found = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{file.name} imports relatively"
            found |= {node.module} | {f"{node.module}.{alias.name}" for alias in node.names}
    return found


def rooms_of(names):
    return {parts[1] for parts in (name.split(".") for name in names) if parts[0] == "stucksolver" and len(parts) > 1}


@pytest.mark.parametrize("room", [room for room in MAY_IMPORT if (ROOT / room).is_dir()])
def test_a_room_imports_only_what_the_design_lets_it(room):
    for file in modules(room):
        beyond = rooms_of(imports_of(file)) - MAY_IMPORT[room] - {room}
        assert not beyond, f"{file.relative_to(ROOT)} imports {', '.join(sorted(beyond))}"


@pytest.mark.parametrize("room", [room for room in MAY_IMPORT if (ROOT / room).is_dir()])
def test_no_file_of_the_core_names_a_simulator(room):
    for file in modules(room):
        assert not {name.split(".")[0] for name in imports_of(file)} & SIMULATORS, file.name


@pytest.mark.integration
def test_nobody_but_the_one_who_starts_it_imports_the_embedded_simulator():
    """The commands do, and the evaluation, which is a package of its own."""
    for file in sorted(ROOT.rglob("*.py")):
        if "carlette" in {name.split(".")[0] for name in imports_of(file)}:
            assert file.relative_to(ROOT).parts[0] == "cli", file


FACES = {"solver", "guard", "ladder", "detect", "record"}
"""Rooms of which the evaluation uses no more than what they show to everybody."""


@pytest.mark.integration
def test_the_evaluation_needs_the_faces_of_the_solver_and_the_guard_only():
    for file in sorted((ROOT.parent / "stucksolver_eval").rglob("*.py")):
        tree = ast.parse(file.read_text(encoding="utf-8"))
        froms = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.module]
        for node in froms:
            parts = str(node.module).split(".")
            if parts[0] != "stucksolver" or len(parts) < 2:
                continue
            assert parts[1] != "cli", f"{file.name} imports a command"
            assert parts[1] not in FACES or len(parts) == 2, f"{file.name} imports {node.module}"
            assert not any(alias.name.startswith("_") for alias in node.names), f"{file.name}: {node.module}"


@pytest.mark.integration
def test_only_the_commands_know_the_evaluation():
    for package in (ROOT, Path(carlette.__file__).parent, ROOT.parent / "stucksolver_bridge"):
        for file in sorted(package.rglob("*.py")):
            if "stucksolver_eval" in {name.split(".")[0] for name in imports_of(file)}:
                assert package == ROOT and file.relative_to(ROOT).parts[0] == "cli", file


@pytest.mark.integration
@pytest.mark.parametrize("package", ["stucksolver", "stucksolver_eval", "stucksolver_bridge", "carlette"])
def test_no_rooms_need_each_other_in_a_circle(package):
    folder = Path(importlib.import_module(package).__file__).parent
    doors = networkx.DiGraph()
    for file in sorted(folder.rglob("*.py")):
        room = file.relative_to(folder).parts[0].removesuffix(".py")
        if room == "__init__":
            continue
        for name in imports_of(file):
            parts = name.split(".")
            if parts[0] == package and len(parts) > 1 and parts[1] != room:
                doors.add_edge(room, parts[1], why=f"{file.relative_to(folder)} imports {name}")
    circles = [sorted(circle) for circle in networkx.strongly_connected_components(doors) if len(circle) > 1]
    assert not circles, [data["why"] for *_, data in doors.subgraph(circles[0]).edges(data=True)]


@pytest.mark.integration
def test_importing_the_core_or_the_whole_product_loads_no_simulator():
    """One after the other in one process: whoever is the first to load one is named."""
    rooms = [m for m in IMPORTED_BY_THE_CORE if (ROOT / m.rpartition(".")[2]).is_dir()]
    code = f"""
import importlib, sys
for room in {[*rooms, "stucksolver"]!r}:
    importlib.import_module(room)
    if loaded := sorted(set(sys.modules) & {SIMULATORS!r}):
        sys.exit(f"{{room}} loads {{loaded}}")
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("room", [room for room in MAY_IMPORT if (ROOT / room).is_dir()])
def test_a_file_of_the_core_stays_short(room):
    for file in modules(room):
        assert len(file.read_text(encoding="utf-8").splitlines()) < 400, file.name


def test_the_architecture_page_says_what_is_checked_here():
    page = (ROOT.parents[1] / "ARCHITECTURE.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `(\w+)` \|[^|]*\| ([^|]*) \|$", page, re.MULTILINE)
    told = {room: set() if names == "–" else set(names.split(", ")) for room, names in rows}
    assert told == MAY_IMPORT
    named = re.findall(r"`((?:\w+/)+\w+\.py)`", page)
    assert named and all((ROOT / file).is_file() or (ROOT.parents[1] / file).is_file() for file in named)
