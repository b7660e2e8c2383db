"""A folder that replaces a CARLA installation, for tools that start the server themselves.

CARLA's leaderboard and Bench2Drive run `$CARLA_ROOT/CarlaUE4.sh -carla-rpc-port=N ...` and read the OpenDRIVE files
under `CarlaUE4/Content/Carla/Maps/OpenDrive`.
"""

from __future__ import annotations

import os
import shlex
import stat
import sys
from collections.abc import Sequence
from pathlib import Path

from carlette.errors import MapError, StartupError
from carlette.opendrive.map_file import available_towns, load_map

MAPS = Path("CarlaUE4/Content/Carla/Maps/OpenDrive")
START = "CarlaUE4.sh"
SCRIPT = """#!/bin/sh
# Starts carlette in place of CARLA. Options that it does not support (graphics, sound) are accepted and ignored.
port=2000
for argument in "$@"; do
    case "$argument" in
        -carla-rpc-port=*|-carla-port=*|-carla-world-port=*) port="${{argument#*=}}" ;;
    esac
done
unset PYTHONPATH PYTHONHOME
exec {python} -m carlette --port "$port" --map {town} --maps {maps} --client-version {version}
"""


def write_carla_root(folder: Path, map_folders: Sequence[Path], version: str) -> list[str]:
    """Write the folder and return the names of its towns.

    Raises:
        StartupError: There is no town, or the folder cannot be written.
    """
    towns = {name: path for name, path in available_towns(map_folders).items() if _is_map(path)}
    if not towns:
        raise StartupError("no town found. Name folders with .xodr files in --maps or STUCKSOLVER_MAPS")
    try:
        _write(folder, towns, version)
    except OSError as error:
        raise StartupError(f"cannot write folder: {folder}: {error.strerror}. Name a writable folder") from error
    return sorted(towns)


def _write(folder: Path, towns: dict[str, Path], version: str) -> None:
    maps = folder / MAPS
    maps.mkdir(parents=True, exist_ok=True)
    for name, path in towns.items():
        target = maps / f"{name}.xodr"
        if path.resolve() != target.resolve():
            target.write_bytes(path.read_bytes())
    start = folder / START
    script = SCRIPT.format(
        python=shlex.quote(sys.executable),
        town=shlex.quote(min(towns)),
        maps=shlex.quote(os.fspath(maps.resolve())),
        version=version,
    )
    start.write_text(script, encoding="utf-8")
    start.chmod(start.stat().st_mode | stat.S_IXUSR | stat.S_IXGRP | stat.S_IXOTH)


def _is_map(path: Path) -> bool:
    try:
        load_map(path)
    except MapError:
        # Files that are no maps are ignored.
        return False
    return True
