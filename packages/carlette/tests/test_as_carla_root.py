"""A folder that tools take for a CARLA installation: they find its towns, and what they start listens where told."""

from __future__ import annotations

import os
import socket
import subprocess
import time
from pathlib import Path

import pytest

from carlette.carla_root import write_carla_root
from carlette.cli import main
from carlette.errors import StartupError
from carlette.maps import DEMO_TOWN
from serving import free_port

STARTS_WITHIN_S = 200.0


@pytest.mark.integration
def test_towns_lie_where_benchmarks_look_for_them(tmp_path, capsys):
    assert main(["--as-carla-root", str(tmp_path / "carla")]) == 0
    assert "demo_town" in capsys.readouterr().out
    copied = tmp_path / "carla/CarlaUE4/Content/Carla/Maps/OpenDrive/demo_town.xodr"
    assert copied.read_bytes() == DEMO_TOWN.read_bytes()


@pytest.mark.integration
def test_the_same_folder_can_be_written_again(tmp_path):
    for _ in range(2):
        assert write_carla_root(tmp_path, [DEMO_TOWN.parent], "0.9.16")


def test_carla_root_without_town_or_writable_folder_names_remedy(tmp_path):
    """Without a town or a writable folder, the error says what to do."""
    with pytest.raises(StartupError, match="STUCKSOLVER_MAPS"):
        write_carla_root(tmp_path, [tmp_path], "0.9.16")
    (tmp_path / "file").touch()
    with pytest.raises(StartupError, match="file/carla"):
        write_carla_root(tmp_path / "file/carla", [DEMO_TOWN.parent], "0.9.16")


@pytest.mark.integration
def test_carla_root_script_starts_server_on_given_port(tmp_path):
    """The script of the folder starts a server on the port of its command line."""
    folder = tmp_path / "with a space"
    write_carla_root(folder, [DEMO_TOWN.parent], "0.9.16")
    port = free_port()
    command = [folder / "CarlaUE4.sh", "-RenderOffScreen", "-nosound", f"-carla-rpc-port={port}", "-graphicsadapter=0"]
    process = subprocess.Popen(command, env={**os.environ, "PYTHONPATH": "/nowhere"}, cwd=Path("/"))
    try:
        assert _listens(port, process)
    finally:
        process.kill()
        process.wait()


def _listens(port: int, server: subprocess.Popen[bytes]) -> bool:
    """True once somebody does; False if the server has ended, or takes too long."""
    end = time.monotonic() + STARTS_WITHIN_S
    while time.monotonic() < end and server.poll() is None:
        with socket.socket() as one:
            if one.connect_ex(("127.0.0.1", port)) == 0:
                return True
        time.sleep(0.1)
    return False
