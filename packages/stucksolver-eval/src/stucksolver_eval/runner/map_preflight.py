"""Checks before the first drive that carlette has the maps of all routes."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from carlette.opendrive.map_file import MAPS_VARIABLE, available_towns, file_of, map_folders, named
from stucksolver_eval.routes import Route
from stucksolver_eval.suites import SuiteError

_MOST_NAMES = 5
"""Maximum number of towns in a message. Ours."""


def require_maps(routes: Sequence[Route], maps: str | None) -> None:
    """Check that there is a map for each route. `maps` are folders, separated as in a path variable.

    Raises:
        SuiteError: Some maps are missing. The message names them, the searched folders and the option.
    """
    folders = map_folders((maps or "").split(os.pathsep))
    towns = available_towns(folders)
    missing = Counter(route.town for route in routes if not _is_there(route.town, towns))
    if not missing:
        return
    names = ", ".join([*sorted(missing)[:_MOST_NAMES], *(["..."] if len(missing) > _MOST_NAMES else [])])
    raise SuiteError(
        f"no map of {names} for {missing.total()} of {len(routes)} routes, in {named(folders)}. Name the folder "
        f"with their .xodr files in --maps or {MAPS_VARIABLE}, or choose other routes with --routes"
    )


def _is_there(town: str, towns: dict[str, Path]) -> bool:
    return Path(town).is_file() if town.endswith(".xodr") else file_of(town.rsplit("/", 1)[-1], towns) is not None
