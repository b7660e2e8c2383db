"""The command says what is wrong in one line, and never outlives those it runs for."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from carlette import cli
from serving import READY, running_server
from straight import straight_road

COMMAND = [sys.executable, "-m", "carlette"]
pytestmark = pytest.mark.integration


def start(*arguments: str, **options) -> subprocess.Popen[str]:
    process = subprocess.Popen(
        [*COMMAND, "--port", "0", *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **options
    )
    assert process.stdout is not None
    assert READY.fullmatch(process.stdout.readline().strip())
    return process


@pytest.fixture
def broken(tmp_path: Path) -> dict[str, str]:
    texts = {
        "empty": "",
        "binary": "\0\1",
        "not xml": "<OpenDRIVE><road>",
        "other xml": "<html/>",
        "no lanes": straight_road(lane="sidewalk"),
        "no roads": "<OpenDRIVE/>",
    }
    for name, text in texts.items():
        (tmp_path / f"{name}.xodr").write_text(text, "utf-8")
    (tmp_path / "latin.xodr").write_bytes(b"\xff\xfe\xfa")
    (tmp_path / "folder.xodr").mkdir()
    return {path.stem: str(path) for path in tmp_path.iterdir()}


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("empty", "is empty"),
        ("binary", "not valid XML"),
        ("not xml", "not valid XML"),
        ("other xml", "<html>"),
        ("no lanes", "driving"),
        ("no roads", "driving"),
        ("latin", "cannot be read"),
        ("folder", "cannot be read"),
        ("missing", "does not exist"),
    ],
)
def test_command_invalid_map_is_one_line_error(broken, capsys, name: str, words: str) -> None:
    """An invalid map is an error of one line that names the file, with exit code 2."""
    path = broken.get(name, "missing.xodr")
    assert cli.main(["--port", "0", "--map", path]) == 2
    out, errors = capsys.readouterr()
    assert out == ""
    assert len(errors.splitlines()) == 1
    assert words in errors and path in errors


def test_command_unknown_town_names_folders_and_available_towns(tmp_path: Path) -> None:
    """The error for an unknown town names the folders that were searched and the towns there."""
    (tmp_path / "Here.xodr").write_text(straight_road(), "utf-8")
    command = [*COMMAND, "--port", "0", "--map", "Nowhere", "--maps", str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert done.returncode == 2
    assert "'Nowhere'" in done.stderr and str(tmp_path) in done.stderr and "Here" in done.stderr


def test_a_busy_port_is_told_in_one_line() -> None:
    with socket.socket() as busy:
        busy.bind(("127.0.0.1", 0))
        busy.listen()
        port = busy.getsockname()[1]
        done = subprocess.run([*COMMAND, "--port", str(port)], capture_output=True, text=True, timeout=120)
    assert done.returncode == 2
    assert str(port) in done.stderr and len(done.stderr.splitlines()) == 1


@pytest.mark.parametrize("stop", [signal.SIGINT, signal.SIGTERM])
def test_signals_end_it_cleanly(stop: signal.Signals) -> None:
    process = start()
    process.send_signal(stop)
    _, errors = process.communicate(timeout=120)
    assert (process.returncode, errors) == (0, "")


def test_it_ends_when_standard_input_closes() -> None:
    process = start("--exit-on-stdin-eof", stdin=subprocess.PIPE)
    process.communicate(timeout=120)
    assert process.returncode == 0


def test_it_ends_when_its_parent_dies() -> None:
    parent = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"])
    process = start("--parent-pid", str(parent.pid))
    assert process.poll() is None
    parent.kill()
    parent.wait()
    process.communicate(timeout=120)
    assert process.returncode == 0


def test_it_listens_on_loopback_unless_told_and_then_warns() -> None:
    process = start("--host", "0.0.0.0")
    process.terminate()
    _, errors = process.communicate(timeout=120)
    assert "no authentication" in errors


def test_a_wrong_python_is_told_with_the_right_ones(monkeypatch, capsys) -> None:
    monkeypatch.setattr(sys, "version_info", (3, 13, 0, "final", 0))
    assert cli.main(["--port", "0"]) == 2
    assert "3.10-3.12" in capsys.readouterr().err


def test_garbage_on_both_ports_does_not_disturb_other_clients() -> None:
    with running_server() as port:
        for number in (port, port + 1):
            with socket.create_connection(("127.0.0.1", number)) as sock:
                sock.sendall(os.urandom(4096))
        with socket.create_connection(("127.0.0.1", port)) as sock:
            sock.sendall(b"\x94\x00\x01\xa7version\x91\x91\xc2")
            sock.settimeout(60)
            assert b"0.9.16" in sock.recv(100)
