"""Reading an OpenDRIVE file: enough checks that the client's own parser will not stumble."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from xml.etree import ElementTree

from carlette.errors import MapError

MAPS_VARIABLE = "STUCKSOLVER_MAPS"
LAYOUTS = (
    "*.xodr",
    "OpenDrive/*.xodr",
    "*/OpenDrive/*.xodr",
    "CarlaUE4/Content/Carla/Maps/OpenDrive/*.xodr",
    "CarlaUE4/Content/Carla/Maps/*/OpenDrive/*.xodr",
    "Unreal/CarlaUE4/Content/Carla/Maps/OpenDrive/*.xodr",
    "Unreal/CarlaUE4/Content/Carla/Maps/*/OpenDrive/*.xodr",
)
"""Where towns lie in a folder: loose, or as in CARLA's `Maps` folder, in its packages, or in its sources."""
OPTIMISED = "_Opt"
"""CARLA's variants with layers have this after the town's name, and the same roads."""


@dataclass(frozen=True)
class MapFile:
    """The name of a town and its OpenDRIVE text."""

    name: str
    text: str


def map_folders(extra: Sequence[str]) -> list[Path]:
    """The folders in which a town is looked up: `extra`, the environment's, the package's own."""
    from_environment = os.environ.get(MAPS_VARIABLE, "").split(os.pathsep)
    own = Path(__file__).resolve().parent.parent / "maps"
    return [Path(one) for one in (*extra, *from_environment) if one] + [own]


def available_towns(folders: Sequence[Path]) -> dict[str, Path]:
    """Town name to file; the first folder that has a town wins. A folder may be a CARLA installation."""
    towns: dict[str, Path] = {}
    for folder in folders:
        for layout in LAYOUTS:
            for path in sorted(folder.glob(layout)):
                towns.setdefault(path.stem, path)
    return towns


def find_map(town_or_file: str, folders: Sequence[Path]) -> MapFile:
    """The map of a town's name (a path such as `Carla/Maps/Town01` counts too) or of a file.

    Raises `MapError` with what was looked for and where.
    """
    if town_or_file.endswith(".xodr"):
        return load_map(Path(town_or_file))
    name = town_or_file.rsplit("/", 1)[-1]
    towns = available_towns(folders)
    path = towns.get(name) or towns.get(name.removesuffix(OPTIMISED))
    if path is None:
        places = ", ".join(f"{one}" if one.is_dir() else f"{one} (no such folder)" for one in folders)
        known = ", ".join(sorted(towns)) or "none"
        raise MapError(f"map '{name}' not found in {places} (towns there: {known}); name one of them or a .xodr file")
    return replace(load_map(path), name=name)


def load_map(path: Path) -> MapFile:
    """Reads and checks a file; raises `MapError`."""
    try:
        text = path.read_text("utf-8")
    except FileNotFoundError:
        raise MapError(f"map file '{path}' does not exist; give the path of an OpenDRIVE .xodr file") from None
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "it is not UTF-8 text"
        raise MapError(f"map file '{path}' cannot be read: {reason}; give a readable OpenDRIVE file") from None
    check_opendrive(text, str(path))
    return MapFile(path.stem, text)


def check_opendrive(text: str, source: str) -> ElementTree.Element:
    """The root element; raises `MapError` when `text` is not a map with driving lanes."""
    if not text.strip():
        raise MapError(f"map file '{source}' is empty; give an OpenDRIVE file with roads")
    try:
        root = ElementTree.fromstring(text.encode("utf-8", "surrogateescape"))
    except ElementTree.ParseError as error:
        raise MapError(f"map file '{source}' is not valid XML ({error}); give an OpenDRIVE file") from None
    if root.tag != "OpenDRIVE":
        raise MapError(f"map file '{source}' has the root <{root.tag}>, not <OpenDRIVE>; give an OpenDRIVE file")
    if not any(lane.get("type") == "driving" for lane in root.iter("lane")):
        raise MapError(f"map file '{source}' has no lane of type 'driving'; carlette needs one to put cars on")
    return root
