"""A hang fails instead of hanging; maps that are not part of the repository are optional."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest


@pytest.fixture(scope="session", autouse=True)
def own_state(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Servers keep their recordings away from those of the user who runs the tests."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_STATE_HOME", str(tmp_path_factory.mktemp("state")))
        yield


@pytest.fixture(scope="session")
def town01() -> Path:
    """CARLA's Town01, which is not part of this repository."""
    for folder in os.environ.get("STUCKSOLVER_MAPS", "").split(os.pathsep):
        path = Path(folder) / "Town01.xodr"
        if folder and path.is_file():
            return path
    pytest.skip("needs Town01.xodr in a folder of STUCKSOLVER_MAPS")
