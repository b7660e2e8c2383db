"""Maps as other tools write them: those that the client's library loads are loaded; each other fault is named."""

from __future__ import annotations

import gzip
import subprocess
import sys
from pathlib import Path

import pytest

from carlette import cli
from carlette.camera.environment.static_scene import build_static_scene
from carlette.errors import MapError
from carlette.maps import DEMO_TOWN
from carlette.opendrive.document import id_as_read, number_as_read, parse
from carlette.opendrive.faults import find_faults, warning_of
from carlette.opendrive.map_file import MapFile, load_map
from carlette.opendrive.signals import read_signals
from carlette.world import map_trial
from carlette.world.map_trial import open_roads
from carlette.world.world import World
from maps_of_others import (
    DECLARATION,
    SCHEMA,
    connection,
    document,
    lane,
    light,
    road,
    section,
    with_prefix,
)

carla = pytest.importorskip("carla")

WIDE = '<width sOffset="10" a="3.5" b="0" c="0" d="0"/>'
BORDER = '<border sOffset="0" a="3.5" b="0" c="0" d="0"/>'
DOCTYPE = '<?xml version="1.0"?><!DOCTYPE OpenDRIVE SYSTEM "opendrive.dtd">'
CHAIN = road("Main Street", to="Högatan") + road("Högatan", x=200.0)

LOADED = {
    "default namespace": document(attributes=f' xmlns="{SCHEMA}"'),
    "schema location": document(
        attributes=' xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:noNamespaceSchemaLocation="x.xsd"'
    ),
    "additions with a prefix": document(road() + '<a:note xmlns:a="urn:a" s="x"/>'),
    "no declaration": document(declaration=""),
    "document type": document(declaration=DOCTYPE),
    "header offset": document(header='<offset x="688000" y="-1e7" z="0" hdg="0"/>'),
    "numbers in user data": document(road() + '<userData code="date" value="20261129120000"/>'),
    "another projection": document(reference="+proj=utm +zone=32"),
    "no projection": document(reference=""),
    "coordinates of a UTM zone": document(road(x=688000.0, y=5330000.0)),
    "coordinates far down left": document(road(x=-2.0e7, y=-1.0e7)),
    "id is a word": document(road("Kalle")),
    "ids with digits and words": document(road("12 north", to="13 south") + road("13 south", x=200.0)),
    "ids with blanks and umlauts": document(CHAIN),
    "ids of floating point": document(road("1.0", to="2.0") + road("2.0", x=200.0)),
    "junction id is a word": document(
        road(to="Kreuz") + road("2", x=200.0, junction="Kreuz") + connection("2", number="Kreuz")
    ),
    "light ids are words": document(road(signals=light("Ampel Süd") + light("") + light("ä" * 20))),
    "lane type in capitals": document(road(lanes=section(right=lane(-1, kind="Driving")))),
    "link to a missing road": document(road(to="77")),
    "empty attribute": document(road().replace('x="0.0"', 'x=""')),
    "section that begins late": document(road(lanes=section(20.0))),
    "comment in a geometry": document(road().replace("<line/>", "<!-- straight --><line/>")),
    **{f"revision 1.{minor}": document(revision=minor) for minor in (4, 5, 6, 7, 8)},
}

REFUSED = {
    "prefix": (with_prefix(document()), "remove 'od:'"),
    "no roads": (document("<junction id='1' name=''/>"), "no <road>"),
    "road without line": (document(road() + road("2", plan="")), "road 2 has no <geometry>"),
    "line that begins late": (
        document(road(plan='<geometry s="9" x="0" y="0" hdg="0" length="200"><line/></geometry>')),
        "road 1: the first <geometry> is at s=9",
    ),
    "line without shape": (
        document(road(plan='<geometry s="0" x="0" y="0" hdg="0" length="200"/>')),
        "road 1: a <geometry> has no shape",
    ),
    "arc without curvature": (
        document(road().replace("<line/>", '<arc curvature="0.0"/>')),
        "no lane has a position: road 1: an <arc> has the curvature 0",
    ),
    "lane offset that begins late": (
        document(road(lanes='<laneOffset s="7.5" a="0" b="0" c="0" d="0"/>' + section())),
        "road 1: the first <laneOffset> is at s=7.5",
    ),
    "height that begins late": (
        document(road(profile='<elevation s="3" a="1" b="0" c="0" d="0"/>')),
        "road 1: the first <elevation> is at s=3",
    ),
    "section without center": (document(road(lanes=section(center=""))), "road 1: a <laneSection> has no center lane"),
    "width that begins late": (
        document(road(lanes=section(right=lane(-1, width=WIDE)))),
        "road 1, lane -1: the first <width> is at sOffset=10",
    ),
    "no widths": (document(road(lanes=section(right=lane(-1, width="")))), "road 1, lane -1 has no <width>"),
    "borders only": (document(road(lanes=section(right=lane(-1, width=BORDER)))), "reads no <border>"),
    "gap in the lane numbers": (
        document(road(lanes=section(right=lane(-1) + lane(-3)))),
        "road 1 has lane -3 but no lane -2",
    ),
    "link to a missing lane of a road": (
        document(road("5", to="6", lanes=section(right=lane(-1, to="-4"))) + road("6", x=200.0)),
        "road 5 to road 6: lane -1 has the successor -4",
    ),
    "link to a missing lane of a section": (
        document(road(lanes=section(right=lane(-1, to="-2")) + section(100.0))),
        "road 1: lane -1 has the successor -2",
    ),
    "connection by a missing road": (
        document(road() + connection("99")),
        "junction 10 connects by road 99",
    ),
    "direct junction": (
        document(road() + road("2", x=200.0) + connection("2", key="linkedRoad", kind="direct")),
        "junction 10 links roads directly",
    ),
    "road of a missing junction": (
        document(road() + road("2", junction="55", y=30.0)),
        "road 2 belongs to junction 55",
    ),
    "reference to a missing signal": (
        document(road(signals='<signalReference s="9" t="-5" id="99" orientation="+"/>')),
        "road 1 refers to signal 99",
    ),
    "road of no length": (document(road() + road("2", x=300.0, length=0.0)), 'road 2 has length="0.0"'),
    "origin is a word": (document(reference="+proj=tmerc +lat_0=north +lon_0=0"), "+lat_0=north"),
    "entities": (document(declaration='<!DOCTYPE x [<!ENTITY a "1">]>'), "declares an entity"),
}


def as_map(text: str) -> MapFile:
    return MapFile("Foreign", text)


@pytest.mark.parametrize("text", LOADED.values(), ids=LOADED.keys())
def test_foreign_map_loads_as_in_the_client(tmp_path: Path, text: str) -> None:
    """The server has the waypoints that the client's library has, and its own readers work on the document."""
    path = tmp_path / "Foreign.xodr"
    path.write_text(text, "utf-8")
    roads = open_roads(load_map(path))
    places = [item.transform.location for item in roads.map.generate_waypoints(20.0)]
    wanted = [item.transform.location for item in carla.Map("Foreign", text).generate_waypoints(20.0)]
    assert [(item.x, item.y) for item in places] == [(item.x, item.y) for item in wanted] != []
    World(roads).tick()
    assert build_static_scene(roads).chunks


@pytest.mark.parametrize(("text", "words"), REFUSED.values(), ids=REFUSED.keys())
def test_faulty_map_is_rejected_by_file_and_fault(tmp_path: Path, text: str, words: str) -> None:
    """This process survives the map. The message is one line that names file and fault."""
    path = tmp_path / "Faulty.xodr"
    path.write_text(text, "utf-8")
    with pytest.raises(MapError) as caught:
        open_roads(load_map(path))
    line = str(caught.value)
    assert str(path) in line and words in line and "\n" not in line


def test_command_survives_map_that_crashes_the_library(tmp_path: Path, capsys) -> None:
    """The command ends with its exit code for wrong input and one line, not with a signal."""
    path = tmp_path / "Faulty.xodr"
    path.write_text(REFUSED["lane offset that begins late"][0], "utf-8")
    assert cli.main(["--port", "0", "--map", str(path)]) == 2
    line = capsys.readouterr().err
    assert line.startswith(f"carlette: error: map '{path}' crashes the carla library: road 1: the first <laneOffset>")
    assert line.count("\n") == 1


@pytest.mark.parametrize(
    ("encoding", "declared"),
    [
        ("utf-8-sig", "UTF-8"),
        ("utf-16", "UTF-16"),
        ("utf-16-be", "UTF-16"),
        ("utf-8", "UTF-16"),
        ("latin-1", "ISO-8859-1"),
        ("cp1252", "windows-1252"),
    ],
)
def test_map_file_is_decoded_by_mark_or_declaration(tmp_path: Path, encoding: str, declared: str) -> None:
    text = document(road("Straße"), declaration=DECLARATION.replace("UTF-8", declared))
    data = text.encode(encoding)
    path = tmp_path / "Encoded.xodr"
    path.write_bytes(b"\xfe\xff" + data if encoding == "utf-16-be" else data)
    assert load_map(path).text == text


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (gzip.compress(document().encode()), "compressed (gzip); unpack it"),
        (b"PK\x03\x04" + bytes(100), "compressed (zip); unpack it"),
        (document(road("Straße")).encode("latin-1"), "not UTF-8 text; save it as UTF-8"),
        (document(declaration='<?xml version="1.0" encoding="klingon"?>').encode(), "'klingon' is unknown"),
    ],
    ids=["gzip", "zip", "undeclared", "unknown"],
)
def test_unreadable_map_file_is_rejected_with_remedy(tmp_path: Path, data: bytes, words: str) -> None:
    path = tmp_path / "Unreadable.xodr"
    path.write_bytes(data)
    with pytest.raises(MapError) as caught:
        load_map(path)
    assert str(path) in str(caught.value) and words in str(caught.value)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (document(road(to="77")), "road 1 has the successor road 77, which does not exist"),
        (document(CHAIN), "reads the ids 'Main Street', 'Högatan' of 2 roads as 0"),
        (document(road(y=5.33e6)), "coordinates reach 5.33e+06 m, where clients receive positions in steps of 0.5 m"),
    ],
    ids=["missing road", "same id", "coarse"],
)
def test_doubtful_map_is_loaded_with_warning(text: str, words: str) -> None:
    open_roads(as_map(text))
    assert words in warning_of(parse(text))


def test_lane_without_position_has_no_spawn_point() -> None:
    """The library gives NaN on an arc of curvature 0. The other road can be driven on."""
    bent = road("2", y=50.0).replace("<line/>", '<arc curvature="0.0"/>')
    roads = open_roads(as_map(document(road() + bent)))
    places = roads.spawn_points()
    assert places and all(place.is_finite() for place in places)
    assert "road 2: an <arc> has the curvature 0" in warning_of(parse(roads.file.text))


def test_command_prints_warning_of_doubtful_map(tmp_path: Path) -> None:
    """The warning is one line, and the server listens."""
    path = tmp_path / "Doubtful.xodr"
    path.write_text(document(road(to="77")), "utf-8")
    command = [sys.executable, "-m", "carlette", "--port", "0", "--map", str(path), "--exit-on-stdin-eof"]
    done = subprocess.run(command, input="", capture_output=True, text=True, timeout=60, check=True)
    assert done.stderr.startswith(f"carlette: warning: map '{path}': road 1 has the successor road 77")
    assert "listening on" in done.stdout


@pytest.mark.parametrize(("text", "first"), [("", 0), ("Kalle", 0), ("-5", -5), (" 12a", 12), ("0x1F", 31), ("1.9", 1)])
def test_number_is_read_as_in_the_library(text: str, first: int) -> None:
    assert number_as_read(text) == first
    assert id_as_read(text) == max(first, 0)


@pytest.mark.parametrize("number", ["Kalle", " 7", "12a", "0x1F", "-5", "99999999999", "1.9"])
def test_road_id_is_the_library_s(number: str) -> None:
    found = carla.Map("Foreign", document(road(number))).generate_waypoints(20.0)
    assert {item.road_id for item in found} == {id_as_read(number)}


def test_light_on_road_with_word_id_governs_its_lane() -> None:
    roads = open_roads(as_map(document(road("Kalle", signals=light("Ampel Süd")))))
    (found,) = read_signals(roads, parse(roads.file.text))
    assert found.id == "Ampel Süd" and abs(found.pose.location.x - 20.0) < 3.0


def test_shipped_map_needs_no_trial(monkeypatch) -> None:
    """A shipped town is built at once; another text is tried once."""
    tried: list[str] = []
    monkeypatch.setattr(map_trial, "try_out", lambda file, longest_s: tried.append(file.name))
    monkeypatch.setattr(map_trial, "_tried", set())
    open_roads(load_map(DEMO_TOWN))
    for _ in range(2):
        open_roads(as_map(document()))
    assert tried == ["Foreign"]


def test_shipped_maps_have_no_faults() -> None:
    for path in DEMO_TOWN.parent.glob("*.xodr"):
        assert find_faults(parse(path.read_text("utf-8"))) == [], path
