"""The distributions of this repository and their folders."""

from __future__ import annotations

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
"""Root of the repository."""
PROJECTS = {
    name: ROOT / "packages" / name
    for name in (
        "stucksolver",
        "stucksolver-carla",
        "stucksolver-perception",
        "stucksolver-language",
        "stucksolver-passenger",
        "stucksolver-eval",
        "carlette",
    )
}
"""Folders by name, each after the distributions that it requires."""


def file_name(name: str) -> str:
    """Return a distribution's name as in the names of its files."""
    return name.replace("-", "_")
