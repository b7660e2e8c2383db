"""`stucksolver demo` as a user meets it: what cannot be done is one line, and nobody is left behind."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import time
import uuid
from collections.abc import Callable, Iterator
from pathlib import Path

import psutil
import pytest

from carlette.maps import DEMO_TOWN
from stucksolver.commands import main

pytestmark = pytest.mark.integration

pytest.importorskip("carla")

MARK = "STUCKSOLVER_TEST_MARK"
HANGS_S = 200.0
"""Who takes longer than that hangs; a busy machine may need a minute."""
PROGRAM = "import sys; from stucksolver.commands import main; sys.exit(main())"
EMPTY_MAP = '<?xml version="1.0"?><OpenDRIVE><header revMajor="1" revMinor="4" name="none"/></OpenDRIVE>'


@pytest.fixture
def mark() -> Iterator[str]:
    """Every process that carries this in its environment belongs to the test; at its end there must be none."""
    name = uuid.uuid4().hex
    yield name
    deadline = time.monotonic() + HANGS_S
    while left := marked(name):
        assert time.monotonic() < deadline, [item.cmdline() for item in left]
        time.sleep(0.05)


def marked(name: str) -> list[psutil.Process]:
    return [item for item in psutil.process_iter() if is_marked(item, name)]


def is_marked(process: psutil.Process, name: str) -> bool:
    try:
        return process.environ().get(MARK) == name and process.status() != psutil.STATUS_ZOMBIE
    except psutil.Error:
        return False


def start(mark: str, *arguments: str, program: str = PROGRAM) -> subprocess.Popen[str]:
    command = [sys.executable, "-c", program, *arguments]
    environment = os.environ | {MARK: mark}
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    return subprocess.Popen(command, env=environment, text=True, start_new_session=True, **pipes)


def one_line(errors: str, out: Path) -> str:
    """The line of a refusal; there is no other, and no report."""
    lines = errors.splitlines()
    assert len(lines) == 1 and lines[0].startswith("error: "), errors
    assert not (out / "report.html").exists()
    return lines[0]


def exit_code(*arguments: str) -> int | str | None:
    """What a process with these arguments would end with."""
    try:
        return main(arguments)
    except SystemExit as ended:
        return ended.code


@pytest.fixture
def refused(mark: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> Callable[..., str]:
    """What the command says when it refuses, without a process of its own; its children are marked."""
    monkeypatch.setenv(MARK, mark)

    def refuse(out: Path, *arguments: str) -> str:
        assert exit_code("demo", "--out", str(out), *arguments) == 2
        said, errors = capfd.readouterr()
        assert said == ""
        return one_line(errors, out)

    return refuse


@pytest.fixture
def out(tmp_path: Path) -> Path:
    return tmp_path / "out"


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "is empty"),
        (b"\xff\xfe\xfa", "cannot be read"),
        (b"<OpenDRIVE><road>", "not valid XML"),
        (b"<html/>", "OpenDRIVE"),
        (EMPTY_MAP.encode(), "driving"),
    ],
    ids=["empty", "unreadable", "broken XML", "not OpenDRIVE", "no driving lane"],
)
def test_a_bad_map_file_is_named_with_what_is_wrong(refused, out: Path, tmp_path: Path, content, words) -> None:
    path = tmp_path / "town.xodr"
    path.write_bytes(content)
    line = refused(out, "--map", str(path))
    assert str(path) in line and words in line


def test_demo_map_that_crashes_the_library_is_named_with_its_fault(refused, out: Path, tmp_path: Path) -> None:
    """The library crashes on this road, after a warning about the missing geoReference."""
    path = tmp_path / "late.xodr"
    late = '<laneOffset s="5" a="0" b="0" c="0" d="0"/><laneSection'
    path.write_text(DEMO_TOWN.read_text("utf-8").replace("<laneSection", late).replace("+proj=", "+form="), "utf-8")
    line = refused(out, "--map", str(path))
    assert str(path) in line and "the first <laneOffset> is at s=5" in line and "georeference" not in line


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_a_map_file_without_permission_is_named(refused, out: Path, tmp_path: Path) -> None:
    path = tmp_path / "town.xodr"
    path.write_text(EMPTY_MAP, encoding="utf-8")
    path.chmod(0o000)
    assert str(path) in refused(out, "--map", str(path))


def test_demo_unknown_town_error_names_searched_folder(refused, out: Path, tmp_path: Path) -> None:
    """The error for an unknown town names the town and the folder that was searched."""
    line = refused(out, "--map", "Nowhere", "--maps", str(tmp_path))
    assert "'Nowhere'" in line and str(tmp_path) in line


def test_demo_map_without_suitable_street_names_remedy(refused, out: Path, tmp_path: Path) -> None:
    """A map without a suitable street is an error that says what was searched and how to go on."""
    path = tmp_path / "short.xodr"
    path.write_text(SHORT_ROAD, encoding="utf-8")
    line = refused(out, "--map", str(path))
    assert "Searched" in line and "use another map" in line


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--driver", "autopilot"), ("'autopilot'", "behavior")),
        (("--driver", "behavior:reckless"), ("'behavior:reckless'", "cautious, normal, aggressive")),
        (("--clock", "sundial"), ("sundial", "lockstep")),
        (("--clock", "latency:-1"), ("latency:-1",)),
    ],
)
def test_a_bad_choice_is_told_with_the_good_ones(refused, out: Path, arguments, words) -> None:
    line = refused(out, *arguments)
    for word in words:
        assert word in line


def test_demo_unwritable_folder_fails_before_any_run(refused, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A folder that cannot be written is reported before any simulator starts."""
    (tmp_path / "file").write_text("I am a file", encoding="utf-8")
    monkeypatch.setattr(subprocess, "Popen", None)  # no simulator can be started
    line = refused(tmp_path / "file" / "out")
    assert str(tmp_path / "file") in line and "--out" in line


def test_a_server_that_is_not_there_is_told_as_refused(refused, out: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as gone:
        port = int(gone.getsockname()[1])
    line = refused(out, "--host", "127.0.0.1", "--port", str(port))
    assert f"127.0.0.1:{port}" in line and "Connection refused" in line


@pytest.mark.parametrize("port", ["0", "99999"])
def test_a_port_that_is_none_is_told(refused, out: Path, port: str) -> None:
    assert port in refused(out, "--host", "127.0.0.1", "--port", port)


def test_demo_without_carla_package_names_supported_python_versions(mark: str, out: Path) -> None:
    """Without the carla package, the error names the Python versions that have it and the extra to install."""
    process = start(mark, "demo", "--out", str(out), program="import sys; sys.modules['carla'] = None; " + PROGRAM)
    said, errors = process.communicate(timeout=HANGS_S)
    assert (process.returncode, said) == (2, ""), errors
    line = one_line(errors, out)
    assert "carla" in line and "3.10, 3.11 or 3.12" in line and "[carla]" in line


def test_help_needs_neither_carla_nor_a_simulator(mark: str) -> None:
    blocked = "import sys; sys.modules['carla'] = sys.modules['msgpack'] = None; "
    process = start(mark, "demo", "--help", program=blocked + PROGRAM)
    said, errors = process.communicate(timeout=HANGS_S)
    assert (process.returncode, errors) == (0, "")
    assert "--map" in said and "--clock" in said


KEPT = sorted(
    ["RouteScenario_1_rep0_demo_town_ParkedCarInLane.json"] * 2
    + ["RouteScenario_1_rep0_demo_town_ParkedCarInLane.json.gz", "metric_info.json", "report.html"]
)
"""Record and outcome are called alike, in folders of their own."""
ONE_ARM = "import stucksolver_eval.demo as demo; demo.ARMS = demo.ARMS[1:2]; "


def test_demo_run_writes_table_report_and_log(mark: str, out: Path) -> None:
    """A run ends with a table and the path of the report; only the expected files are written."""
    process = start(mark, "demo", "--out", str(out), "--oncoming", "0", program=ONE_ARM + PROGRAM)
    said, errors = process.communicate(timeout=HANGS_S)
    assert process.returncode == 0, errors
    head, _, row = said.splitlines()[:3]
    assert head.startswith("run") and "Completed" in row
    assert said.splitlines()[-1] == f"report: {out / 'report.html'}"
    assert "<html" in (out / "report.html").read_text(encoding="utf-8")
    assert sorted(p.name for p in out.rglob("*") if p.is_file()) == KEPT


@pytest.mark.release
def test_a_map_without_road_marks_is_driven_too(mark: str, out: Path, tmp_path: Path) -> None:
    path = tmp_path / "bare.xodr"
    path.write_text(SHORT_ROAD.replace('length="60"', 'length="900"'), encoding="utf-8")
    told = ("--map", str(path), "--out", str(out), "--oncoming", "0", "--no-pictures")
    process = start(mark, "demo", *told, program=ONE_ARM + PROGRAM)
    said, errors = process.communicate(timeout=HANGS_S)
    assert process.returncode == 0, errors
    assert "Completed" in said.splitlines()[2]


# ---- interrupted


def wait_for(mark: str, words: str) -> None:
    """Until a process with these words in its command is there."""
    deadline = time.monotonic() + HANGS_S
    while time.monotonic() < deadline:
        if any(words in command_of(item) for item in marked(mark)):
            return
        time.sleep(0.02)
    raise AssertionError(f"no process with {words}")


def command_of(process: psutil.Process) -> str:
    try:
        return " ".join(process.cmdline())
    except psutil.Error:
        return ""


RUN, SIMULATOR = "forkserver", "-m carlette"


@pytest.mark.parametrize(
    "moment", [pytest.param(RUN, marks=pytest.mark.slow), SIMULATOR], ids=["while it starts", "during the run"]
)
@pytest.mark.parametrize(
    "everyone", [False, pytest.param(True, marks=pytest.mark.slow)], ids=["alone", "with all of the terminal"]
)
def test_ctrl_c_ends_everything_with_130_and_no_report(mark: str, out: Path, moment, everyone: bool) -> None:
    process = start(mark, "demo", "--out", str(out))
    wait_for(mark, moment)
    time.sleep(1.0 if moment is SIMULATOR else 0.1)
    if everyone:
        os.killpg(process.pid, signal.SIGINT)
    else:
        process.send_signal(signal.SIGINT)
    said, errors = process.communicate(timeout=HANGS_S)
    assert process.returncode == 130, errors
    assert errors.strip().splitlines()[-1] == "interrupted"
    assert "Traceback" not in errors and said == ""
    assert not (out / "report.html").exists()


@pytest.mark.slow
@pytest.mark.parametrize("moment", [RUN, SIMULATOR], ids=["while it starts", "during the run"])
def test_a_kill_leaves_nobody_behind(mark: str, out: Path, moment) -> None:
    process = start(mark, "demo", "--out", str(out))
    wait_for(mark, moment)
    time.sleep(1.0 if moment is SIMULATOR else 0.1)
    process.kill()
    process.communicate(timeout=HANGS_S)
    assert not (out / "report.html").exists()


SHORT_ROAD = """<?xml version="1.0"?><OpenDRIVE><header revMajor="1" revMinor="4" name="short">
<geoReference><![CDATA[+proj=tmerc +lat_0=0 +lon_0=0 +k=1]]></geoReference></header>
<road name="" length="60" id="7" junction="-1"><type s="0" type="town"><speed max="50" unit="km/h"/></type>
<planView><geometry s="0" x="0" y="0" hdg="0" length="60"><line/></geometry></planView>
<lanes><laneSection s="0"><left><lane id="1" type="driving" level="false">
<width sOffset="0" a="3.5" b="0" c="0" d="0"/></lane></left><center><lane id="0" type="none" level="false"/></center>
<right><lane id="-1" type="driving" level="false"><width sOffset="0" a="3.5" b="0" c="0" d="0"/></lane></right>
</laneSection></lanes></road></OpenDRIVE>"""
