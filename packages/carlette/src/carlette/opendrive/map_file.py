"""Reads an OpenDRIVE file, with the checks that keep the client's own parser from failing."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from xml.etree import ElementTree

from carlette.errors import MapError
from carlette.opendrive.document import UnreadableDocumentError, decode, parse
from carlette.opendrive.value_limits import check_bounds
from carlette.safe_files import read_regular

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
"""Possible positions of towns in a folder: directly in it, or as in CARLA's `Maps`, its packages or its sources."""
LARGEST_MAP_BYTES = 128 << 20
"""Largest OpenDRIVE text (bytes). Town04 has 3.4 MB. Ours."""
OPTIMIZED = "_Opt"
"""Suffix of CARLA's variants with layers, which have the same roads."""


@dataclass(frozen=True)
class MapFile:
    """The name of a town and its OpenDRIVE text."""

    name: str
    text: str
    path: Path | None = None
    """Its file, if it comes from one."""

    @property
    def source(self) -> str:
        """Its file, else its name: for messages."""
        return self.name if self.path is None else str(self.path)


def map_folders(extra: Sequence[str]) -> list[Path]:
    """Return the folders in which a town is searched: `extra`, the environment's, the package's own."""
    from_environment = os.environ.get(MAPS_VARIABLE, "").split(os.pathsep)
    own = Path(__file__).resolve().parent.parent / "maps"
    return [Path(item) for item in (*extra, *from_environment) if item] + [own]


def available_towns(folders: Sequence[Path]) -> dict[str, Path]:
    """Return files by town name. The first folder that contains a town wins. A folder may be a CARLA installation."""
    towns: dict[str, Path] = {}
    for path in _files(folders):
        towns.setdefault(path.stem, path)
    return towns


def _files(folders: Sequence[Path]) -> Iterator[Path]:
    for folder in folders:
        for layout in LAYOUTS:
            yield from (path for path in sorted(folder.glob(layout)) if path.is_file())


def find_town(town_or_path: str, folders: Sequence[Path]) -> MapFile:
    """Return the map that a client names: by its town, or by the path of a town's file in one of the folders.

    Raises `MapError`, with the same message for a file outside the folders as for one that does not exist. So clients
    learn nothing about other files on this machine.
    """
    if town_or_path.endswith(".xodr"):
        wanted = os.path.normpath(town_or_path)
        path = next((item for item in _files(folders) if os.path.normpath(item) == wanted), None)
        if path is None:
            known = ", ".join(sorted(available_towns(folders))) or "none"
            raise MapError(f"'{town_or_path}' is not a town of this server (it has {known}); name one of them")
        return load_map(path)
    return find_map(town_or_path, folders)


def find_map(town_or_file: str, folders: Sequence[Path]) -> MapFile:
    """Return the map of a town's name (a path such as `Carla/Maps/Town01` counts too) or of a file.

    Raises `MapError` with the name and the searched folders.
    """
    if town_or_file.endswith(".xodr"):
        return load_map(Path(town_or_file))
    name = town_or_file.rsplit("/", 1)[-1]
    towns = available_towns(folders)
    path = file_of(name, towns)
    if path is None:
        known = ", ".join(sorted(towns)) or "none"
        raise MapError(
            f"map '{name}' not found in {named(folders)} (towns there: {known}); name one of them or a .xodr file"
        )
    return replace(load_map(path), name=name)


def file_of(town: str, towns: Mapping[str, Path]) -> Path | None:
    """Return the file of a town's name among `available_towns`. A variant with layers has the file of its town."""
    return towns.get(town) or towns.get(town.removesuffix(OPTIMIZED))


def named(folders: Sequence[Path]) -> str:
    """Return the searched folders, for messages."""
    return ", ".join(f"{folder}" if folder.is_dir() else f"{folder} (no such folder)" for folder in folders)


def load_map(path: Path) -> MapFile:
    """Read and check a file. Raises `MapError`."""
    try:
        text = decode(read_regular(path, LARGEST_MAP_BYTES))
    except FileNotFoundError:
        raise MapError(f"map file '{path}' does not exist; give the path of an OpenDRIVE .xodr file") from None
    except OSError as error:
        raise MapError(f"map file '{path}' cannot be read: {error.strerror}; give a readable OpenDRIVE file") from None
    except UnreadableDocumentError as error:
        raise MapError(f"map file '{path}' cannot be read: {error}") from None
    check_bounds(check_opendrive(text, str(path)), str(path))
    return MapFile(path.stem, text, path)


def check_opendrive(text: str, source: str) -> ElementTree.Element:
    """Return the root element. Raises `MapError` if `text` is not a map with driving lanes."""
    if not text.strip():
        raise MapError(f"map file '{source}' is empty; give an OpenDRIVE file with roads")
    try:
        root = parse(text)
    except UnreadableDocumentError as error:
        raise MapError(f"map file '{source}' {error}") from None
    if root.tag != "OpenDRIVE":
        raise MapError(f"map file '{source}' has the root <{root.tag}>, not <OpenDRIVE>; {_root_remedy(root.tag)}")
    if root.find("road") is None:
        raise MapError(f"map file '{source}' has no <road>, so no lane of type 'driving'; give one with roads")
    lanes = root.iterfind("road/lanes/laneSection/*/lane")
    if not any(lane.get("type", "").lower() == "driving" for lane in lanes):
        raise MapError(f"map file '{source}' has no lane of type 'driving'; carlette needs one to put cars on")
    return root


def _root_remedy(tag: str) -> str:
    prefix, _, name = tag.rpartition(":")
    if name == "OpenDRIVE":
        return f"the carla library reads no prefixes: remove '{prefix}:', as in <OpenDRIVE xmlns=...>"
    return "give an OpenDRIVE file"
