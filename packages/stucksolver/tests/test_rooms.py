"""The house keeps its arrows: which distribution and which room imports which, and that the core needs no simulator."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from functools import cache
from pathlib import Path

import networkx
import pytest

import stucksolver

ROOT = Path(stucksolver.__file__).parent
HOUSE = Path(__file__).parents[3]
CORE = {"scene", "plan", "immobilization", "reasoners", "guard", "ladder", "word_safeguards"}
MAY_IMPORT = {
    "scene": set(),
    "plan": {"scene"},
    "immobilization": {"scene"},
    "privacy": set(),
    "plugins": set(),
    "query_budget": {"scene"},
    "reasoners": {"scene", "plan", "plugins", "privacy", "query_budget"},
    "guard": {"scene", "plan"},
    "ladder": {"scene", "plan", "guard", "query_budget"},
    "word_safeguards": {"scene"},
    "interpreter": {"scene", "plugins"},
    "solver": CORE | {"interpreter", "query_budget"},
    "record": (CORE - {"word_safeguards"}) | {"solver", "privacy"},
    "commands": {"scene", "ladder", "record", "plugins", "privacy", "optional_dependencies"},
}
"""The design's table of the core's rooms."""
ARROWS = {
    "carlette": set(),
    "stucksolver": set(),
    "stucksolver_bridge": set(),
    "stucksolver_carla": {"stucksolver", "stucksolver_bridge"},
    "stucksolver_perception": {"stucksolver", "stucksolver_carla", "stucksolver_bridge"},
    "stucksolver_language": {"stucksolver"},
    "stucksolver_passenger": {"stucksolver", "stucksolver_language"},
    "stucksolver_eval": {
        "stucksolver",
        "stucksolver_bridge",
        "stucksolver_carla",
        "stucksolver_perception",
        "stucksolver_language",
        "stucksolver_passenger",
        "carlette",
    },
}
"""What each package may import of the others. `lab` may import all; none of them imports `lab`."""
SIMULATORS = {"carla", "carlette"}
WITHOUT_SIMULATOR = ("stucksolver", "stucksolver_language", "stucksolver_passenger")


def modules(room):
    folder = ROOT / room
    return sorted(folder.rglob("*.py")) if folder.is_dir() else [ROOT / f"{room}.py"]


def folder_of(package):
    (found,) = HOUSE.glob(f"packages/*/src/{package}")
    return found


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
    known = {path.name.removesuffix(".py") for path in ROOT.iterdir()}
    parts = [name.split(".") for name in names]
    return {part[1] for part in parts if part[0] == "stucksolver" and len(part) > 1 and part[1] in known}


@pytest.mark.parametrize("package", ARROWS)
def test_distribution_imports_follow_the_arrows(package):
    ours = {*ARROWS, "lab"}
    for file in sorted(folder_of(package).rglob("*.py")):
        beyond = {name.split(".")[0] for name in imports_of(file)} & ours - ARROWS[package] - {package}
        assert not beyond, f"{file.relative_to(HOUSE)} imports {', '.join(sorted(beyond))}"


@pytest.mark.parametrize("room", MAY_IMPORT)
def test_room_imports_follow_the_design(room):
    for file in modules(room):
        beyond = rooms_of(imports_of(file)) - MAY_IMPORT[room] - {room}
        assert not beyond, f"{file.relative_to(ROOT)} imports {', '.join(sorted(beyond))}"


@pytest.mark.parametrize("package", WITHOUT_SIMULATOR)
def test_package_without_simulator_imports_none(package):
    for file in sorted(folder_of(package).rglob("*.py")):
        if file.name != "doctor.py":
            assert not {name.split(".")[0] for name in imports_of(file)} & SIMULATORS, file.name


FACES = {"solver", "guard", "ladder", "immobilization", "record"}
"""Rooms of which the evaluation uses only what their `__init__` offers."""


@pytest.mark.integration
def test_evaluation_uses_public_interfaces_only():
    for file in sorted(folder_of("stucksolver_eval").rglob("*.py")):
        tree = ast.parse(file.read_text(encoding="utf-8"))
        froms = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.module]
        for node in froms:
            parts = str(node.module).split(".")
            if parts[0] != "stucksolver" or len(parts) < 2:
                continue
            assert parts[1] not in FACES or len(parts) == 2, f"{file.name} imports {node.module}"
            assert not any(alias.name.startswith("_") for alias in node.names), f"{file.name}: {node.module}"


@pytest.mark.integration
@pytest.mark.parametrize("package", ARROWS)
def test_package_rooms_have_no_import_cycle(package):
    folder = folder_of(package)
    graph = networkx.DiGraph()
    for file in sorted(folder.rglob("*.py")):
        room = file.relative_to(folder).parts[0].removesuffix(".py")
        if room == "__init__":
            continue
        for name in imports_of(file):
            parts = name.split(".")
            if parts[0] == package and len(parts) > 1 and parts[1] != room:
                graph.add_edge(room, parts[1], why=f"{file.relative_to(folder)} imports {name}")
    cycles = [sorted(cycle) for cycle in networkx.strongly_connected_components(graph) if len(cycle) > 1]
    assert not cycles, [data["why"] for *_, data in graph.subgraph(cycles[0]).edges(data=True)]


@pytest.mark.integration
def test_core_import_loads_no_simulator():
    """One room after the other in one process, so that the first one to load a simulator is named."""
    rooms = ["stucksolver", *(f"stucksolver.{room}" for room in MAY_IMPORT)]
    code = f"""
import importlib, sys
for room in {rooms!r}:
    importlib.import_module(room)
    if loaded := sorted(set(sys.modules) & {SIMULATORS!r}):
        sys.exit(f"{{room}} loads {{loaded}}")
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("room", MAY_IMPORT)
def test_core_file_stays_short(room):
    for file in modules(room):
        assert len(file.read_text(encoding="utf-8").splitlines()) < 400, file.name


def test_architecture_page_matches_the_checks():
    page = (HOUSE / "ARCHITECTURE.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `(\w+)` \|[^|]*\| ([^|]*) \|$", page, re.MULTILINE)
    documented = {room: set() if names == "–" else set(names.split(", ")) for room, names in rows}
    folders = {room: names for room, names in MAY_IMPORT.items() if (ROOT / room).is_dir()}
    assert {room: documented.get(room) for room in folders} == folders
    files = re.findall(r"`((?:\w+/)+\w+\.py)`", page)
    assert files and all((ROOT / file).is_file() or (HOUSE / file).is_file() for file in files)
