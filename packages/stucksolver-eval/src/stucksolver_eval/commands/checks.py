"""Checks of `stucksolver doctor` for the simulator, maps and optional packages of evaluations."""

from __future__ import annotations

import importlib.util
import os
from collections.abc import Iterator
from pathlib import Path

from stucksolver.commands.doctor import Check, Finding, package

ANSWERS_S = 20.0
"""Time limit of the first call to a new simulator (s). Ours."""


def _simulator() -> Iterator[Finding]:
    """Start the simulator and query it, because the client's library may be installed and still fail to load."""
    if importlib.util.find_spec("carla") is None:
        return
    try:
        from stucksolver_carla.client_connection import connect
        from stucksolver_eval.simulator_server import carlette_server

        with carlette_server("demo_town") as server:
            town = connect(server, ANSWERS_S).get_world().get_map().name
    except Exception as error:  # noqa: BLE001 - report whatever the foreign library raises
        why = str(error).splitlines()[0] if str(error) else type(error).__name__
        yield Finding("carlette", "broken", why, "install carlette again (README, Install)", needed=True)
        return
    yield Finding("carlette", "ok", f"the embedded simulator started and answered with {town}", needed=True)


def _maps() -> Iterator[Finding]:
    configured = os.environ.get("STUCKSOLVER_MAPS", "")
    folders = [Path(folder) for folder in configured.split(":") if folder]
    towns = sorted({path.stem for folder in folders for path in folder.glob("*.xodr")})
    gone = [str(folder) for folder in folders if not folder.is_dir()]
    if gone:
        yield Finding("maps", "broken", f"STUCKSOLVER_MAPS: no such folder: {', '.join(gone)}", "correct the variable")
    elif towns:
        yield Finding("maps", "ok", f"{len(towns)} towns in addition to the shipped ones: {', '.join(towns)}")
    else:
        remedy = "for CARLA's towns set STUCKSOLVER_MAPS to the folder with their .xodr files"
        yield Finding("maps", "absent", "the shipped towns only", remedy)


CHECKS: tuple[Check, ...] = (
    _simulator,
    package("matplotlib", "plots of evaluations", "report"),
    package("distributed", "evaluations on a cluster", "cluster"),
    _maps,
)
