"""A hang fails instead of hanging; maps that are not part of the repository are optional."""

from __future__ import annotations

import faulthandler
import os
from collections.abc import Iterator
from pathlib import Path

import pytest

LONGEST_TEST_S = 150


@pytest.fixture(autouse=True)
def no_hang() -> Iterator[None]:
    """The client library waits in C++, where nothing but the end of the process reaches it."""
    faulthandler.dump_traceback_later(LONGEST_TEST_S, exit=True)
    yield
    faulthandler.cancel_dump_traceback_later()


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
