"""Where towns are looked for, and what is said when they are not there."""

from __future__ import annotations

import pytest

from carlette.errors import MapError
from carlette.opendrive.map_file import available_towns, find_map, map_folders
from straight import straight_road

MAPS = "CarlaUE4/Content/Carla/Maps"


@pytest.mark.parametrize(
    "place",
    [
        "Far.xodr",
        "OpenDrive/Far.xodr",
        "Far/OpenDrive/Far.xodr",
        f"{MAPS}/OpenDrive/Far.xodr",
        f"{MAPS}/Far/OpenDrive/Far.xodr",
        f"Unreal/{MAPS}/OpenDrive/Far.xodr",
    ],
)
def test_town_is_found_in_folder_and_carla_installation(tmp_path, place: str) -> None:
    """A town is found in a folder and in an installation of CARLA."""
    path = tmp_path / place
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(straight_road(), "utf-8")
    folders = map_folders([str(tmp_path)])
    assert available_towns(folders)["Far"] == path
    for name in ("Far", "Carla/Maps/Far", "/Game/Carla/Maps/Far"):
        assert find_map(name, folders).name == "Far"


def test_the_first_folder_that_has_a_town_wins(tmp_path) -> None:
    for folder in ("one", "two"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "Far.xodr").write_text(straight_road(), "utf-8")
    folders = map_folders([str(tmp_path / "two"), str(tmp_path / "one")])
    assert available_towns(folders)["Far"] == tmp_path / "two" / "Far.xodr"


def test_a_town_with_layers_has_the_roads_of_the_town(tmp_path) -> None:
    (tmp_path / "Far.xodr").write_text(straight_road(), "utf-8")
    found = find_map("Far_Opt", map_folders([str(tmp_path)]))
    assert (found.name, found.text) == ("Far_Opt", straight_road())


def test_missing_map_error_lists_folders_and_available_towns(tmp_path) -> None:
    """The error for a missing map lists the searched folders and the available towns."""
    folders = map_folders([str(tmp_path), str(tmp_path / "gone")])
    with pytest.raises(MapError) as error:
        find_map("Atlantis", folders)
    for part in ("Atlantis", str(tmp_path), f"{tmp_path / 'gone'} (no such folder)", "demo_town"):
        assert part in str(error.value)
