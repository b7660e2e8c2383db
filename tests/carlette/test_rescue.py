"""A client that hangs in its own traffic manager is freed by the server; nobody else is touched."""

from __future__ import annotations

import contextlib
import multiprocessing
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from typing import Any

import msgpack
import pytest
from serving import running_server
from test_raw import Raw
from test_traffic import VERSION, serve, traffic

from carlette import rescue
from carlette.rescue import FAR_STALLED_S, STALLED_S, Rescue
from carlette.stillness import is_still

pytestmark = pytest.mark.integration

HEALTH, SYNCHRONOUS = "health_check_remote_TM", "set_synchronous_mode"
WAKING = [(HEALTH, []), (SYNCHRONOUS, [False]), (SYNCHRONOUS, [True])]
LOCKSTEP = [True, False, [True, 0.05], True, 0.01, 10, 0.0, True, 3000.0, 2000.0, True]


class FakeManager:
    """What listens on a traffic manager's port: notes its calls, and answers if it is told to."""

    def __init__(self, answers: bool = True) -> None:
        self.calls: list[tuple[str, list[Any]]] = []
        self.times: list[float] = []
        self._answers = answers
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port = int(self._listener.getsockname()[1])
        threading.Thread(target=self._serve, daemon=True).start()

    def _serve(self) -> None:
        with contextlib.suppress(OSError):
            while True:
                peer, _ = self._listener.accept()
                self._talk(peer)

    def _talk(self, peer: socket.socket) -> None:
        unpacker = msgpack.Unpacker()
        with peer:
            while data := peer.recv(4096):
                unpacker.feed(data)
                for _, number, method, arguments in unpacker:
                    self.times.append(time.monotonic())
                    self.calls.append((method, arguments))
                    if self._answers:
                        peer.sendall(msgpack.packb([1, number, None, None]))

    def close(self) -> None:
        self._listener.close()


@pytest.fixture
def manager() -> Iterator[FakeManager]:
    fake = FakeManager()
    yield fake
    fake.close()


@pytest.fixture
def mute() -> Iterator[FakeManager]:
    fake = FakeManager(answers=False)
    yield fake
    fake.close()


def settled(look: Any, limit_s: float = 5.0) -> bool:
    """Waits until something is true."""
    end = time.monotonic() + limit_s
    while time.monotonic() < end:
        if look():
            return True
        time.sleep(0.01)
    return False


def no_rescue_runs() -> bool:
    return not any(thread.name == "carlette-rescue" for thread in threading.enumerate())


def test_a_silent_client_is_woken_once_and_not_before_the_stall_time(manager: FakeManager) -> None:
    watch = Rescue()
    watch.published(100.0, "127.0.0.1", [manager.port])
    watch.look(100.0 + STALLED_S - 0.01)
    assert settled(no_rescue_runs) and manager.calls == []
    # This very process is at work, so it might only be late.
    watch.look(100.0 + STALLED_S + 0.01)
    assert settled(no_rescue_runs) and manager.calls == []
    watch.look(100.0 + FAR_STALLED_S + 0.01)
    assert settled(lambda: watch.count == 1)
    assert manager.calls == WAKING
    watch.look(200.0)
    assert settled(no_rescue_runs) and len(manager.calls) == 3


def test_every_manager_of_a_silent_client_is_woken_even_where_one_does_not_answer(
    manager: FakeManager, mute: FakeManager, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rescue, "ANSWER_S", 0.2)
    watch = Rescue()
    watch.published(0.0, "127.0.0.1", [mute.port, manager.port])
    watch.look(FAR_STALLED_S + 0.1)
    assert settled(lambda: watch.count == 1 and no_rescue_runs())
    assert manager.calls == WAKING


def test_a_client_that_calls_again_is_left_alone(manager: FakeManager) -> None:
    watch = Rescue()
    watch.published(0.0, "127.0.0.1", [manager.port])
    watch.heard()
    watch.look(10.0)
    assert settled(no_rescue_runs) and manager.calls == []


def test_a_client_without_managers_is_left_alone() -> None:
    watch = Rescue()
    watch.published(0.0, "127.0.0.1", [])
    watch.look(10.0)
    assert no_rescue_runs() and watch.count == 0


def test_a_manager_that_does_not_answer_is_left_in_its_mode_and_nothing_hangs(
    mute: FakeManager, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rescue, "ANSWER_S", 0.2)
    watch = Rescue()
    watch.published(0.0, "127.0.0.1", [mute.port])
    began = time.monotonic()
    watch.look(FAR_STALLED_S + 0.1)
    assert time.monotonic() - began < 0.1
    assert settled(no_rescue_runs)
    assert mute.calls == [(HEALTH, [])]
    assert watch.count == 0


def test_a_manager_that_is_gone_is_no_error() -> None:
    with socket.create_server(("127.0.0.1", 0)) as gone:
        port = int(gone.getsockname()[1])
    watch = Rescue()
    watch.published(0.0, "127.0.0.1", [port])
    watch.look(FAR_STALLED_S + 0.1)
    assert settled(no_rescue_runs) and watch.count == 0


def in_lockstep(port: int, *managers: FakeManager) -> Raw:
    """A client of the server that has registered traffic managers."""
    client = Raw(port)
    assert client.call("set_episode_settings", LOCKSTEP)[1][0][0] == 1
    for one in managers:
        assert client.call("add_traffic_manager_running", ["127.0.0.1", one.port]) == (None, [[1, True]])
    return client


def test_the_server_wakes_the_client_that_cued_a_tick_and_fell_silent(manager: FakeManager) -> None:
    with running_server() as port:
        client = in_lockstep(port, manager)
        client.call("tick_cue")
        began = time.monotonic()
        assert settled(lambda: len(manager.calls) == 3)
        assert manager.calls == WAKING
        assert STALLED_S - 0.05 < manager.times[0] - began < FAR_STALLED_S + 1.0
        # The next tick is watched as the first was.
        client.call("tick_cue")
        assert settled(lambda: manager.calls == WAKING * 2)
        client.socket.close()


def test_the_server_leaves_alone_who_goes_on_who_waits_and_who_leaves(manager: FakeManager) -> None:
    with running_server() as port:
        ticking, waiting = in_lockstep(port, manager), in_lockstep(port)
        for _ in range(8):
            ticking.call("tick_cue")
            time.sleep(0.1)
            ticking.call("get_episode_settings")
        time.sleep(STALLED_S * 1.6)
        assert manager.calls == []
        waiting.call("tick_cue")
        time.sleep(STALLED_S * 1.6)
        assert manager.calls == []
        ticking.call("tick_cue")
        ticking.socket.close()
        time.sleep(STALLED_S * 1.6)
        assert manager.calls == []
        waiting.socket.close()


def test_other_clients_are_served_while_a_manager_does_not_answer(mute: FakeManager) -> None:
    with running_server() as port:
        client, other = in_lockstep(port, mute), Raw(port)
        client.call("tick_cue")
        assert settled(lambda: mute.calls == [(HEALTH, [])])
        began = time.monotonic()
        assert other.call("version")[0] is None
        assert time.monotonic() - began < 0.5
        client.socket.close()
        other.socket.close()


LISTEN = "import socket, sys, time; s = socket.create_server(('127.0.0.1', int(sys.argv[1]))); print(1, flush=True); "


@pytest.mark.parametrize(("then", "still"), [("time.sleep(60)", True), ("[None for _ in iter(int, 1)]", False)])
def test_a_process_is_still_when_all_its_threads_sleep(then: str, still: bool) -> None:
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = int(free.getsockname()[1])
    command = [sys.executable, "-c", LISTEN + then, str(port)]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as process:
        try:
            assert process.stdout is not None and process.stdout.readline()
            assert settled(lambda: is_still(port) is still)
        finally:
            process.kill()


def test_nothing_is_known_of_a_port_where_nobody_listens() -> None:
    with socket.create_server(("127.0.0.1", 0)) as gone:
        port = int(gone.getsockname()[1])
    assert is_still(port) is None


IMPATIENT = "from carlette import cli, rescue, server; rescue.STALLED_S = server.IDLE_S = 0.0; cli.main()"


def test_a_client_that_is_merely_late_drives_as_if_nobody_watched() -> None:
    """A server that takes every client for silent at once looks at its threads, and leaves it alone."""
    pytest.importorskip("carla")
    arguments = ("--map", "demo_town", "--client-version", VERSION, "--seed", "11")
    with running_server(*arguments) as port:
        patient = traffic(port, 10, 150)
    with running_server(*arguments, program=("-c", IMPATIENT)) as port:
        impatient = traffic(port, 10, 150)
    assert patient["digest"] == impatient["digest"]


def burn() -> None:
    while True:
        pass


def test_traffic_goes_on_while_all_cores_are_busy() -> None:
    pytest.importorskip("carla")
    context = multiprocessing.get_context("spawn")
    burners = [context.Process(target=burn, daemon=True) for _ in range(2)]
    try:
        for one in burners:
            one.start()
        with serve("demo_town") as port:
            result = traffic(port, 5, 1500)
    finally:
        for one in burners:
            one.kill()
            one.join()
    assert result["moved"] == 5
