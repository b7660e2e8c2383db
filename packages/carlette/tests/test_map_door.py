"""Through `load_world` and `generate_opendrive_world` comes no file but a town's, and no map that harms the server."""

from __future__ import annotations

import os
import socket
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from carlette.errors import MapError
from carlette.opendrive.map_file import LARGEST_MAP_BYTES, MapFile, find_map, find_town, load_map, map_folders
from carlette.safe_files import read_regular
from carlette.world import map_trial
from raw_client import Raw
from serving import running_server
from straight import straight_road

pytest.importorskip("carla")

ROAD = straight_road()
LATE = ROAD.replace("<laneSection", '<laneOffset s="5" a="0" b="0" c="0" d="0"/><laneSection')
"""A map on which the library crashes."""
PARAMETERS = [2.0, 50.0, 1.0, 0.6, True, True, True]


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """Of towns: one that is good, and what else may lie there."""
    here: Path = tmp_path_factory.mktemp("towns")
    (here / "Good.xodr").write_text(ROAD, "utf-8")
    (here / "Late.xodr").write_text(LATE, "utf-8")
    os.mkfifo(here / "Pipe.xodr")
    (here / "Folder.xodr").mkdir()
    (here / "Zero.xodr").symlink_to("/dev/zero")
    with socket.socket(socket.AF_UNIX) as sock:
        sock.bind(str(here / "Socket.xodr"))
    with (here / "Huge.xodr").open("wb") as huge:
        huge.truncate(LARGEST_MAP_BYTES + 1)
    return here


@pytest.fixture(scope="module")
def port(folder: Path) -> Iterator[int]:
    with running_server("--maps", str(folder)) as port:
        yield port


@pytest.fixture
def raw(port: int) -> Iterator[Raw]:
    client = Raw(port)
    client.socket.settimeout(60.0)
    yield client
    client.socket.close()


def refusal(answer) -> str:
    error, ((failed, *text),) = answer
    assert error is None and failed is True, answer
    return str(text[0][0])


def load(raw: Raw, name: str) -> str:
    return refusal(raw.call("load_new_episode", name, True, 0xFFFF))


def generate(raw: Raw, text: str):
    return raw.call("copy_opendrive_to_file", text, PARAMETERS)


@pytest.mark.parametrize("inside", [False, True], ids=["elsewhere", "beside the folder"])
def test_load_world_file_outside_folders_is_rejected_like_missing(
    raw: Raw, folder: Path, tmp_path: Path, inside: bool
) -> None:
    """A file outside the folders is not read, and its error is the same as for a missing file."""
    secret = folder.parent / "secret.xodr" if inside else tmp_path / "secret.xodr"
    secret.write_text(ROAD, "utf-8")
    for name in (str(secret), f"{folder}/../{secret.name}", f"../{secret.name}"):
        told = load(raw, name)
        assert "is not a town of this server" in told and "Good" in told
        assert told.replace("secret", "nothing") == load(raw, name.replace("secret", "nothing"))
    assert raw.call("get_map_info")[1][0][1][0] != "Carla/Maps/secret"


@pytest.mark.parametrize("name", ["Pipe", "Zero", "Folder", "Socket", "Huge"])
def test_load_world_irregular_or_huge_file_is_rejected_by_name(raw: Raw, folder: Path, name: str) -> None:
    """A file that is irregular or larger than a map may be is rejected at once, and the error names it."""
    for asked in (name, str(folder / f"{name}.xodr")):
        assert name in load(raw, asked)
    assert raw.call("version") == (None, [[1, "0.9.16"]])


def test_load_world_town_that_crashes_the_library_is_rejected_by_fault(raw: Raw, folder: Path) -> None:
    """The server survives, and the present episode goes on."""
    before = raw.call("get_episode_info")[1]
    told = load(raw, "Late")
    assert str(folder / "Late.xodr") in told and "road 7: the first <laneOffset> is at s=5" in told
    assert raw.call("get_episode_info")[1] == before


def test_load_world_accepts_town_name_and_path(raw: Raw, folder: Path) -> None:
    """A town is loaded by its name and by its path."""
    for name in ("Good", str(folder / "Good.xodr"), "/Game/Carla/Maps/Good"):
        assert raw.call("load_new_episode", name, True, 0xFFFF) == (None, [[False]])
        assert raw.call("get_map_info")[1][0][1][0] == "Carla/Maps/Good"
        raw.call("load_new_episode", "demo_town", True, 0xFFFF)


def test_only_files_are_listed_as_towns(raw: Raw) -> None:
    names = {item.rsplit("/", 1)[-1] for item in raw.call("get_available_maps")[1][0][1]}
    assert {"Good", "demo_town"} <= names
    assert not names & {"Pipe", "Folder", "Zero", "Socket"}


def test_the_command_refuses_a_pipe_too(folder: Path) -> None:
    with pytest.raises(MapError, match="regular file"):
        find_map(str(folder / "Pipe.xodr"), map_folders([str(folder)]))


def test_map_file_without_size_is_read_only_to_limit() -> None:
    """A file that reports no size is read only up to the limit."""
    with pytest.raises(OSError, match="larger than 10 bytes"):
        read_regular(Path("/proc/self/status"), 10)


def test_town_symlink_in_folder_is_followed(tmp_path: Path) -> None:
    """A symbolic link in a folder of towns leads to its town."""
    (tmp_path / "towns").mkdir()
    (tmp_path / "far.xodr").write_text(ROAD, "utf-8")
    (tmp_path / "towns" / "Far.xodr").symlink_to(tmp_path / "far.xodr")
    assert find_town("Far", [tmp_path / "towns"]).text == ROAD


def swapped(old: str, new: str) -> str:
    assert old in ROAD
    return ROAD.replace(old, new)


HARMFUL = {
    "a road that never ends": swapped('length="2000.0"', 'length="1e15"'),
    "a road of no number": swapped(' x="0"', ' x="nan"'),
    "a road at infinity": swapped(' y="0"', ' y="inf"'),
    "a road beyond float32": swapped(' x="0"', ' x="1e300"'),
    "a lane of no width": swapped('a="3.5"', 'a="nan"'),
    "a lane wider than the world": swapped('a="3.5"', 'a="1e20"'),
    "words for a number": swapped('a="3.5"', 'a="wide"'),
    "a slope of no number": swapped('<elevation s="0" a="0"', '<elevation s="0" a="nan"'),
    "a bend of no number": swapped("<line/>", '<arc curvature="nan"/>'),
    "a spiral of no number": swapped("<line/>", '<spiral curvStart="0" curvEnd="-inf"/>'),
    "a curve that runs away": swapped(
        "<line/>", '<paramPoly3 aU="0" bU="1" cU="1e10" dU="0" aV="0" bV="0" cV="0" dV="0"/>'
    ),
    "a lane number that overflows": swapped('lane id="-1"', 'lane id="-999999999999"'),
    "a sign for all lanes there could be": swapped(
        "<signals>",
        '<signals><signal id="5" s="9" t="0" type="1000001"><validity fromLane="-2000000000" toLane="2000000000"/>'
        "</signal>",
    ),
    "a road without a line": ROAD[: ROAD.index("<planView>")] + ROAD[ROAD.index("</planView>") + len("</planView>") :],
    "entities that multiply": ROAD.replace('<?xml version="1.0"?>', '<!DOCTYPE x [<!ENTITY a "aaaa">]>'),
    "garbage": "\x00\x01\x02" * 1000,
    "half of a map": ROAD[: len(ROAD) // 2],
}
"""Without a check, some hang the carla library, some crash it, and some put NaN into the world."""


@pytest.mark.parametrize("text", HARMFUL.values(), ids=HARMFUL.keys())
def test_generate_world_harmful_map_is_rejected_with_reason(raw: Raw, text: str) -> None:
    """A map that would harm the server is rejected with a reason, and the present episode continues."""
    before = raw.call("get_episode_info")[1]
    told = refusal(generate(raw, text))
    assert "OpenDriveMap" in told and len(told) < 600
    assert raw.call("get_episode_info")[1] == before, "the episode that ran goes on"


def test_a_file_with_such_a_map_is_refused_as_well(tmp_path: Path) -> None:
    path = tmp_path / "Far.xodr"
    path.write_text(HARMFUL["a road that never ends"], "utf-8")
    with pytest.raises(MapError, match=r"<road>.*length.*1e15"):
        load_map(path)


@pytest.mark.parametrize("more", ["", "<a>" * 100_000 + "</a>" * 100_000], ids=["as it is", "with deep additions"])
def test_a_sound_text_is_loaded(raw: Raw, more: str) -> None:
    text = ROAD.replace("</OpenDRIVE>", more + "</OpenDRIVE>")
    assert generate(raw, text) == (None, [[False]])
    assert raw.call("get_map_data")[1] == [[1, text]]


def test_a_map_that_is_not_built_in_time_is_refused(monkeypatch) -> None:
    monkeypatch.setattr(map_trial, "_reason", lambda text: time.sleep(3600.0))
    with pytest.raises(MapError, match="not built within"):
        map_trial.try_out(MapFile("Slow", ROAD), longest_s=0.1)


@pytest.mark.integration
def test_map_trial_crashing_map_is_rejected() -> None:
    """A map that crashes its builder is rejected, even if it exceeds no limit."""
    with pytest.raises(MapError, match="crashes"):
        map_trial.try_out(MapFile("Bad", HARMFUL["a road without a line"]))
