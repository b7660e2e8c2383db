"""Maps of CARLA, where there are any, and the simulator."""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any

import pytest

carla = pytest.importorskip("carla")


def town_file(name: str) -> Path:
    """The OpenDRIVE file of a town, or a skip that says what is missing."""
    for folder in filter(None, os.environ.get("STUCKSOLVER_MAPS", "").split(os.pathsep)):
        file = Path(folder) / f"{name}.xodr"
        if file.is_file():
            return file
    pytest.skip(f"{name}.xodr is in no folder of STUCKSOLVER_MAPS")


@lru_cache(maxsize=4)
def _load(name: str, file: Path) -> Any:
    return carla.Map(name, file.read_text(encoding="utf-8"))


@pytest.fixture(scope="session")
def town() -> Callable[[str], Any]:
    """Loads a town of CARLA's as `carla.Map` without a server."""
    return lambda name: _load(name, town_file(name))
