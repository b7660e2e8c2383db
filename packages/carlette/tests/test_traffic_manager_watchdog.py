"""A client that hangs in its own traffic manager is freed by the server; nobody else is touched."""

from __future__ import annotations

import contextlib
import ctypes
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

from carlette.watchdog import traffic_manager as watchdog
from carlette.watchdog.threads import is_still, waits_for_itself
from carlette.watchdog.traffic_manager import FAR_STALLED_S, MOST_TRIES, STALLED_S, TrafficManagerWatchdog
from serving import free_port, running_server
from test_raw import Raw
from test_traffic import VERSION, serve, traffic

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


class Step:
    """The condition variables of a traffic manager's step: side by side, as two threads may wait on them."""

    CONDITION_BYTES, MUTEX_BYTES = 48, 40

    def __init__(self) -> None:
        self._c = ctypes.CDLL("libc.so.6")
        self._conditions = ctypes.create_string_buffer(2 * self.CONDITION_BYTES)
        self._mutexes = ctypes.create_string_buffer(2 * self.MUTEX_BYTES)
        self._threads: list[threading.Thread] = []

    def wait(self, which: int) -> None:
        """Lets a thread wait: on 0 as the worker for a step, on 1 as its client for the end of one."""
        self._threads.append(threading.Thread(target=self._wait, args=(which,), daemon=True))
        self._threads[-1].start()

    def _wait(self, which: int) -> None:
        mutex = ctypes.byref(self._mutexes, which * self.MUTEX_BYTES)
        self._c.pthread_mutex_lock(mutex)
        self._c.pthread_cond_wait(ctypes.byref(self._conditions, which * self.CONDITION_BYTES), mutex)
        self._c.pthread_mutex_unlock(mutex)

    def end(self) -> None:
        while any(thread.is_alive() for thread in self._threads):
            for which in (0, 1):
                self._c.pthread_cond_broadcast(ctypes.byref(self._conditions, which * self.CONDITION_BYTES))
            time.sleep(0.001)


@pytest.fixture
def step() -> Iterator[Step]:
    """Nobody waits yet."""
    one = Step()
    yield one
    one.end()


@pytest.fixture
def lost(step: Step) -> None:
    """This process looks like a client that hangs in its own traffic manager."""
    step.wait(0)
    step.wait(1)


@pytest.fixture
def unknown(monkeypatch: pytest.MonkeyPatch) -> None:
    """The system does not tell for what a thread waits."""
    monkeypatch.setattr(watchdog, "waits_for_itself", lambda port: None)


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


def settled(look: Any, limit_s: float = 60.0) -> bool:
    """Waits until something is true."""
    end = time.monotonic() + limit_s
    while time.monotonic() < end:
        if look():
            return True
        time.sleep(0.01)
    return False


def no_rescue_runs() -> bool:
    return not any(thread.name == "carlette-rescue" for thread in threading.enumerate())


def test_watchdog_silent_client_is_woken_after_stall_time(manager: FakeManager, lost: None) -> None:
    """A silent client is woken after the stall time, and not earlier."""
    watch = TrafficManagerWatchdog()
    watch.published(100.0, "127.0.0.1", [manager.port])
    watch.free_if_silent(100.0 + STALLED_S - 0.01)
    assert settled(no_rescue_runs) and manager.calls == []
    watch.free_if_silent(100.0 + STALLED_S + 0.01)
    assert settled(lambda: watch.count == 1)
    assert manager.calls == WAKING


def test_a_client_is_woken_whatever_it_called_before_it_hung(manager: FakeManager, lost: None) -> None:
    watch = TrafficManagerWatchdog()
    watch.published(100.0, "127.0.0.1", [manager.port])
    watch.note_call()
    watch.free_if_silent(110.0)
    watch.free_if_silent(110.0 + STALLED_S - 0.01)
    assert settled(no_rescue_runs) and manager.calls == []
    watch.free_if_silent(110.0 + STALLED_S + 0.01)
    assert settled(lambda: watch.count == 1)


def test_watchdog_hanging_client_is_woken_limited_times(manager: FakeManager, lost: None) -> None:
    """A client that continues to hang is woken again, up to the limit of attempts."""
    watch = TrafficManagerWatchdog()
    watch.published(0.0, "127.0.0.1", [manager.port])
    for i in range(1, 2 * MOST_TRIES):
        watch.free_if_silent(100.0 * i)
        assert settled(no_rescue_runs)
    assert watch.count == MOST_TRIES


def test_a_client_that_waits_for_something_else_is_left_alone(manager: FakeManager, step: Step) -> None:
    step.wait(0)
    step.wait(0)
    watch = TrafficManagerWatchdog()
    watch.published(0.0, "127.0.0.1", [manager.port])
    for now in (1.0, 10.0, 100.0):
        watch.free_if_silent(now)
        assert settled(no_rescue_runs)
    assert manager.calls == []


def test_watchdog_unknown_threads_are_woken_once_after_longer_time(manager: FakeManager, unknown: None) -> None:
    """If the state of its threads is unknown, a silent client is woken once and after a longer time."""
    watch = TrafficManagerWatchdog()
    watch.published(100.0, "127.0.0.1", [manager.port])
    watch.free_if_silent(100.0 + STALLED_S - 0.01)
    assert settled(no_rescue_runs) and manager.calls == []
    # This very process is at work, so it might only be late.
    watch.free_if_silent(100.0 + STALLED_S + 0.01)
    assert settled(no_rescue_runs) and manager.calls == []
    watch.free_if_silent(100.0 + FAR_STALLED_S + 0.01)
    assert settled(lambda: watch.count == 1)
    assert manager.calls == WAKING
    watch.free_if_silent(200.0)
    assert settled(no_rescue_runs) and len(manager.calls) == 3


def test_watchdog_unknown_threads_are_ignored_after_step_began(manager: FakeManager, unknown: None) -> None:
    """If the state of its threads is unknown, a client whose step has begun is not woken."""
    watch = TrafficManagerWatchdog()
    for has_begun, calls in ((True, []), (False, WAKING)):
        watch.published(0.0, "127.0.0.1", [manager.port])
        watch.note_call(has_begun=has_begun)
        watch.free_if_silent(10.0)
        watch.free_if_silent(20.0)
        assert settled(no_rescue_runs) and manager.calls == calls


def test_watchdog_remote_client_is_woken_after_longer_silence(
    manager: FakeManager, lost: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A client on another host is woken after a longer silence."""
    woken: list[tuple[str, int]] = []
    monkeypatch.setattr(watchdog, "wake", lambda host, port, switching: woken.append((host, port)))
    watch = TrafficManagerWatchdog()
    watch.published(0.0, "192.0.2.7", [manager.port])
    watch.free_if_silent(STALLED_S + 0.1)
    assert settled(no_rescue_runs) and woken == []
    watch.free_if_silent(FAR_STALLED_S + 0.1)
    assert settled(no_rescue_runs) and woken == [("192.0.2.7", manager.port)]


def test_watchdog_wakes_all_managers_even_if_one_is_mute(
    manager: FakeManager, mute: FakeManager, lost: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every manager of a silent client is woken, even if one of them does not answer."""
    monkeypatch.setattr(watchdog, "ANSWER_S", 0.2)
    watch = TrafficManagerWatchdog()
    watch.published(0.0, "127.0.0.1", [mute.port, manager.port])
    watch.free_if_silent(STALLED_S + 0.1)
    assert settled(lambda: watch.count == 1 and no_rescue_runs())
    assert manager.calls == WAKING


def test_a_client_that_left_is_left_alone(manager: FakeManager, lost: None) -> None:
    watch = TrafficManagerWatchdog()
    watch.published(0.0, "127.0.0.1", [manager.port])
    watch.note_disconnect()
    watch.free_if_silent(10.0)
    assert settled(no_rescue_runs) and manager.calls == []


def test_a_client_without_managers_is_left_alone() -> None:
    watch = TrafficManagerWatchdog()
    watch.published(0.0, "127.0.0.1", [])
    watch.free_if_silent(10.0)
    assert no_rescue_runs() and watch.count == 0


@pytest.mark.slow
def test_watchdog_mute_manager_keeps_mode_and_blocks_nothing(
    mute: FakeManager, lost: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A manager that does not answer keeps its mode, and the server does not wait for it."""
    monkeypatch.setattr(watchdog, "ANSWER_S", 2.0)
    watch = TrafficManagerWatchdog()
    watch.published(0.0, "127.0.0.1", [mute.port])
    watch.free_if_silent(STALLED_S + 0.1)
    assert not no_rescue_runs(), "nobody waits for the answer but the rescue"
    assert settled(no_rescue_runs)
    assert mute.calls == [(HEALTH, [])]
    assert watch.count == 0


def test_a_manager_that_is_gone_is_no_error() -> None:
    watch = TrafficManagerWatchdog()
    watch.published(0.0, "127.0.0.1", [free_port()])
    watch.free_if_silent(FAR_STALLED_S + 0.1)
    assert settled(no_rescue_runs) and watch.count == 0


def in_lockstep(port: int, *managers: FakeManager) -> Raw:
    """A client of the server that has registered traffic managers."""
    client = Raw(port)
    assert client.call("set_episode_settings", LOCKSTEP)[1][0][0] == 1
    for item in managers:
        assert client.call("add_traffic_manager_running", ["127.0.0.1", item.port]) == (None, [[1, True]])
    return client


@pytest.mark.parametrize(
    "last_call",
    [
        "tick_cue",
        *(pytest.param(x, marks=pytest.mark.slow) for x in ("get_episode_settings", "get_vehicle_light_states")),
    ],
)
def test_server_wakes_client_silent_after_tick_cue(manager: FakeManager, lost: None, last_call: str) -> None:
    """The server wakes a client that cued a tick and then fell silent, also at the next tick."""
    with running_server() as port:
        client = in_lockstep(port, manager)
        if last_call != "tick_cue":
            client.call("tick_cue")
        began = time.monotonic()
        client.call(last_call)
        assert settled(lambda: len(manager.calls) == 3)
        assert manager.calls == WAKING
        assert manager.times[0] - began >= STALLED_S
        # The next tick is watched as the first was.
        client.call("tick_cue")
        assert settled(lambda: manager.calls[3:6] == WAKING)
        client.socket.close()


@pytest.mark.slow
def test_server_does_not_wake_active_waiting_or_gone_client(manager: FakeManager) -> None:
    """The server does not wake a client that continues, one that waits without a manager, or one that has left."""
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


WAITS_LONG = (
    "from carlette import cli; from carlette.watchdog import traffic_manager as it; it.ANSWER_S = 600.0; cli.main()"
)


def test_other_clients_are_served_while_a_manager_does_not_answer(mute: FakeManager, lost: None) -> None:
    with running_server(program=("-c", WAITS_LONG)) as port:
        client, other = in_lockstep(port, mute), Raw(port)
        client.call("tick_cue")
        assert settled(lambda: mute.calls == [(HEALTH, [])])
        # The rescue still waits for an answer, longer than this call may take.
        assert other.call("version")[0] is None
        client.socket.close()
        other.socket.close()


LISTEN = "import socket, sys, time; s = socket.create_server(('127.0.0.1', int(sys.argv[1]))); print(1, flush=True); "


@pytest.mark.parametrize(("then", "still"), [("time.sleep(60)", True), ("[None for _ in iter(int, 1)]", False)])
def test_a_process_is_still_when_all_its_threads_sleep(then: str, still: bool) -> None:
    port = free_port()
    command = [sys.executable, "-c", LISTEN + then, str(port)]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as process:
        try:
            assert process.stdout is not None and process.stdout.readline()
            assert settled(lambda: is_still(port) is still)
        finally:
            process.kill()


def test_watchdog_distinguishes_deadlocked_threads_from_waiting_ones(manager: FakeManager, step: Step) -> None:
    """Threads that wait for each other are distinguished from threads that wait for another reason."""
    step.wait(0)
    assert settled(lambda: waits_for_itself(manager.port) is False)
    step.wait(0)
    assert settled(lambda: waits_for_itself(manager.port) is False)
    step.wait(1)
    assert settled(lambda: waits_for_itself(manager.port) is True)
    step.end()
    assert settled(lambda: waits_for_itself(manager.port) is False)


def test_nothing_is_known_of_a_port_where_nobody_listens() -> None:
    port = free_port()
    assert is_still(port) is None and waits_for_itself(port) is None


IMPATIENT = (
    "from carlette import cli, server; from carlette.watchdog import traffic_manager as watchdog; "
    "watchdog.STALLED_S = server.IDLE_S = 0.0; cli.main()"
)


@pytest.mark.slow
def test_watchdog_late_client_drives_as_if_unwatched() -> None:
    """A client that is only late drives as without a watchdog.

    A server that takes every client for silent at once looks at its threads, and leaves it alone.
    """
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


@pytest.mark.release
@pytest.mark.slow
def test_traffic_goes_on_while_all_cores_are_busy() -> None:
    pytest.importorskip("carla")
    context = multiprocessing.get_context("spawn")
    burners = [context.Process(target=burn, daemon=True) for _ in range(2)]
    try:
        for burner in burners:
            burner.start()
        with serve("demo_town") as port:
            result = traffic(port, 5, 500)
    finally:
        for burner in burners:
            burner.kill()
            burner.join()
    assert result["moved"] == 5
