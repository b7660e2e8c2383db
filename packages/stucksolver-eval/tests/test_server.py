"""Carlette as a process of its own: it is there when it is wanted, and gone when it is not."""

from __future__ import annotations

import socket
import stat
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import psutil
import pytest

pytest.importorskip("carla")

import msgpack

from stucksolver_carla.client_connection import ServerError, connect, remote_server
from stucksolver_eval import simulator_server as servers
from stucksolver_eval.simulator_server import carlette_server, set_synchronous

pytestmark = pytest.mark.integration


def reached(host: str, port: int) -> bool:
    try:
        socket.create_connection((host, port), timeout=60.0).close()
    except OSError:
        return False
    return True


def test_it_listens_on_loopback_while_the_block_lasts() -> None:
    with carlette_server("demo_town") as server:
        assert server.host == "127.0.0.1"
        assert reached(server.host, server.port)
        server.check()
    assert not reached(server.host, server.port)
    assert server.process is not None and server.process.returncode == 0


def test_an_error_in_the_block_ends_it_too() -> None:
    with pytest.raises(ZeroDivisionError), carlette_server("demo_town") as server:
        raise ZeroDivisionError
    assert server.process is not None and not psutil.pid_exists(server.process.pid)


def test_two_of_them_do_not_meet() -> None:
    with carlette_server("demo_town") as one, carlette_server("demo_town") as other:
        assert abs(one.port - other.port) > 1


def test_server_stopped_world_starts_with_first_tick() -> None:
    """A stopped world begins with its first tick, however late the tick comes."""
    with carlette_server("demo_town", stands=True) as server:
        world = connect(server, 60.0).get_world()
        time.sleep(0.5)
        set_synchronous(world, 0.05)
        world.tick()
        # The client library lets two ticks pass to change the settings; by itself the world would be 0.5 s old.
        assert world.get_snapshot().timestamp.elapsed_seconds == pytest.approx(0.15)


def test_server_missing_map_error_is_forwarded_in_one_line(tmp_path: Path) -> None:
    """The error for a missing map is the server's own text, in one line and without a prefix."""
    with pytest.raises(ServerError) as told, carlette_server("Nowhere", maps=str(tmp_path)):
        pass
    message = str(told.value)
    assert message.count("\n") == 0 and not message.startswith(("carlette", "error"))
    assert "'Nowhere'" in message and str(tmp_path) in message


@pytest.mark.parametrize(
    ("output", "code", "message"),
    [
        ("WARNING: cannot parse georeference: 'x'. Using default values.", 139, "ended by SIGSEGV at its start"),
        ("carlette: error: map 'x' is empty\nWARNING: cannot parse georeference: 'x'.", 2, "map 'x' is empty"),
        ("Traceback (most recent call last):\nKeyError: 'x'\nWARNING: odd", 1, "KeyError: 'x'"),
    ],
)
def test_server_start_failure_is_not_a_warning_of_the_library(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, output: str, code: int, message: str
) -> None:
    """The reason is carlette's error, the last line of a traceback, or the signal."""
    end = f"kill -SEGV $$; exit {code}" if code == 139 else f"exit {code}"
    program = tmp_path / "carlette"
    program.write_text(f"#!/bin/sh\ncat >&2 <<'END'\n{output}\nEND\n{end}\n", encoding="utf-8")
    program.chmod(stat.S_IRWXU)
    monkeypatch.setattr(servers, "sys", SimpleNamespace(executable=str(program)))
    with pytest.raises(ServerError) as told, carlette_server("demo_town"):
        pass
    assert message in str(told.value) and "WARNING" not in str(told.value)


def test_a_server_that_died_is_noticed() -> None:
    with carlette_server("demo_town") as server:
        assert server.process is not None
        server.process.kill()
        server.process.wait()
        with pytest.raises(ServerError, match="exit code -9; run the command again"):
            server.check()


def test_a_server_that_never_comes_up_is_given_up(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asleep = tmp_path / "python"
    asleep.write_text("#!/bin/sh\nexec sleep 600\n", encoding="utf-8")
    asleep.chmod(asleep.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setattr(servers, "sys", SimpleNamespace(executable=str(asleep)))
    monkeypatch.setattr(servers, "START_LIMIT_S", 0.3)
    with pytest.raises(ServerError, match="no answer within 0 s"), carlette_server("demo_town"):
        pass


def test_a_server_that_warns_a_lot_goes_on() -> None:
    """More than a pipe holds: somebody must read it."""
    with carlette_server("demo_town") as server, socket.create_connection((server.host, server.port), 60.0) as sock:
        unpacker, answered = msgpack.Unpacker(), 0
        call = msgpack.packb([0, 1, "make_coffee_" * 20, [[False]]])
        for _ in range(1000):
            sock.sendall(call)
            while next(unpacker, None) is None:
                unpacker.feed(sock.recv(65536))
            answered += 1
        assert answered == 1000


def test_remote_server_is_probed_before_client_waits() -> None:
    """A remote server is probed first, so that a closed port is an error at once."""
    with socket.create_server(("127.0.0.1", 0)) as there:
        port = int(there.getsockname()[1])
        server = remote_server("127.0.0.1", port)
        assert (server.host, server.port, server.process) == ("127.0.0.1", port, None)
    with socket.socket() as bound:  # taken, so that nobody else can listen there meanwhile, but not listening
        bound.bind(("127.0.0.1", 0))
        port = int(bound.getsockname()[1])
        with pytest.raises(ServerError, match=f"no CARLA server at 127.0.0.1:{port}: Connection refused"):
            remote_server("127.0.0.1", port)


@pytest.mark.parametrize("beyond", (-65536, 0, 65536))
def test_remote_server_invalid_port_is_rejected(beyond: int) -> None:
    """A port outside 1 to 65535 is rejected and never reduced to another port."""
    with socket.create_server(("127.0.0.1", 0)) as there:
        port = int(there.getsockname()[1]) + beyond if beyond else 0
        with pytest.raises(ServerError, match=f"{port}: a port is a number from 1 to 65535"):
            remote_server("127.0.0.1", port)


def test_the_interpreter_is_our_own() -> None:
    with carlette_server("demo_town") as server:
        assert server.process is not None
        assert Path(psutil.Process(server.process.pid).cmdline()[0]) == Path(sys.executable)
