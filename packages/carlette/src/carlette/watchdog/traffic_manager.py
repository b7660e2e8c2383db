"""Frees clients that hang because their own traffic manager has lost a wake-up.

Pacing makes the loss rare, but on a loaded machine a thread may be late by any amount of time. A client that lost the
wake-up makes no more calls: its main thread waits inside `world.tick()` for a worker that waits to be woken. The
traffic manager still answers on its own port, and leaving synchronous mode there wakes the worker
(`TrafficManagerLocal` of CARLA 0.9.15 and 0.9.16), which then makes the step that was missed. So a silent client is
asked whether it responds, told to leave synchronous mode, and told to enter it again.

The other half of a step may be lost as well: the worker ends it and also notifies the main thread without the mutex.
Then the same rescue makes the worker step once more (its cars are steered twice for one tick), and the client goes on.

A worker that is merely late must not be woken: it would make that step twice, and be out of step with its client from
then on. So the threads of a silent client on this machine are examined (`threads`): it is freed if its worker waits for
a step while its main thread waits for the end of one, which has no other cause. If the system does not show what a
thread waits for, a client that has called nothing at all since its snapshot is freed once all its threads sleep, or,
like a client elsewhere, when it has been silent for longer. A client that really lost the first wake-up continues after
the rescue bit for bit as if nothing had happened.

Three others are left alone: a client with unknown threads that began its step (it asks for the vehicles' lights; so
this covers a client that a debugger stops between ticks, and a traffic manager in asynchronous mode), a process that is
stopped as a whole (it answers nothing), and anything that is not a traffic manager (it answers with an error). A client
that ticks with a traffic manager in another process is not helped, because the registration is not its own.
"""

from __future__ import annotations

import logging
import socket
import threading
import time
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import msgpack

from carlette.watchdog.threads import is_still, waits_for_itself

STALLED_S = 0.5
"""A client in step with the server calls within microseconds of a snapshot."""
FAR_STALLED_S = 3.0
"""The same for a client whose threads cannot be examined: on another machine, or with a thread that always runs (s)."""
LONGEST_LOOK_S = 8.0
"""A client that stays silent is examined again after twice the time, but at most this much later (s)."""
ANSWER_S = 2.0
MOST_TRIES = 4
"""Most attempts if a rescue is not answered; each waits twice as long as the one before."""
LONGEST_ANSWER_BYTES = 65536

log = logging.getLogger(__name__)


@dataclass
class _Silence:
    """A client's silence since its last snapshot."""

    since: float
    """The snapshot, or the last call that was noticed."""
    due: float
    """When it is examined next, unless it calls before."""
    surely_lost: float
    """From this time on it is no longer asked whether it works."""
    host: str
    ports: tuple[int, ...]
    tries: int = 0
    calls: int = 0
    calls_seen: int = 0
    """At the last look."""
    has_begun: bool = False
    """True if its worker was woken by the snapshot or by a rescue."""


class TrafficManagerWatchdog:
    """Notices a client that went silent after a snapshot that it requested. Times are monotonic seconds."""

    def __init__(self) -> None:
        self.count = 0
        """How often a client was freed."""
        self._silence: _Silence | None = None
        self._helper: threading.Thread | None = None
        self._switching = threading.Event()

    @property
    def is_switching(self) -> bool:
        """True while a woken traffic manager is not yet back in synchronous mode: no snapshot should go out."""
        return self._switching.is_set()

    def wait_for_switch(self) -> None:
        """Return when no traffic manager is between its modes; bounded by the time it has to answer."""
        if self.is_switching and self._helper is not None:
            self._helper.join(ANSWER_S)

    def published(self, now: float, host: str, managers: Iterable[int]) -> None:
        """Note that the snapshot requested by a client at `host` with these traffic manager ports has been sent."""
        ports = tuple(managers)
        self._silence = _Silence(now, now + STALLED_S, now + FAR_STALLED_S, host, ports) if ports else None

    def heard(self, has_begun: bool = True) -> None:
        """Note that this client called again; `has_begun` unless it may have called before it waited for its step."""
        if self._silence is not None:
            self._silence.calls += 1
            self._silence.has_begun |= has_begun

    def left(self) -> None:
        """Note that this client has disconnected."""
        self._silence = None

    def look(self, now: float) -> None:
        """Free the client if it has been silent for too long. To be called regularly."""
        silence = self._silence
        if silence is None:
            return
        if silence.calls != silence.calls_seen:
            silence.calls_seen = silence.calls
            silence.since, silence.due = now, max(silence.due, now + STALLED_S)
        if now < silence.due or (self._helper is not None and self._helper.is_alive()):
            return
        if silence.tries == MOST_TRIES:
            self._silence = None
            return
        silence.due = now + min(now - silence.since, LONGEST_LOOK_S)
        arguments = (silence, now >= silence.surely_lost)
        self._helper = threading.Thread(target=self._free, args=arguments, name="carlette-rescue", daemon=True)
        self._helper.start()

    def _free(self, silence: _Silence, is_surely_lost: bool) -> None:
        calls = silence.calls
        if not self._is_lost(silence, is_surely_lost) or self._silence is not silence or silence.calls != calls:
            # It works, or it called while its threads were examined.
            return
        silence.tries += 1
        silence.due += STALLED_S * 2**silence.tries
        had_begun = silence.has_begun
        for port in silence.ports:
            if self._wakes(silence.host, port):
                self.count += 1
                silence.has_begun = True
                if had_begun:
                    log.warning("its cars were steered twice in this tick: another run may differ from here on")

    @staticmethod
    def _is_lost(silence: _Silence, is_surely_lost: bool) -> bool:
        is_here = _is_here(silence.host)
        looks = [is_here and waits_for_itself(port) for port in silence.ports]
        if is_here and None not in looks:
            return any(looks)
        if silence.has_begun:
            return False
        return is_surely_lost or (is_here and all(is_still(port) for port in silence.ports))

    def _wakes(self, host: str, port: int) -> bool:
        try:
            wake(host, port, self._switching)
        except (OSError, ValueError, msgpack.UnpackException) as error:
            log.info("the traffic manager at %s:%d was not woken: %s", host, port, error)
            return False
        log.warning("woke the traffic manager at %s:%d from a lost wake-up", host, port)
        return True


def _is_here(host: str) -> bool:
    return host == "::1" or host.startswith(("127.", "::ffff:127."))


def wake(host: str, port: int, switching: threading.Event | None = None) -> None:
    """Make a traffic manager leave and re-enter synchronous mode. Raises `OSError` if it does not answer.

    `switching` is set while it is in asynchronous mode.
    """
    busy = switching or threading.Event()
    with socket.create_connection((host, port), timeout=ANSWER_S) as sock:
        # A process that is merely stopped answers nothing, and is left alone.
        sock.sendall(_request(0, "health_check_remote_TM"))
        _answers(sock, 1)
        busy.set()
        try:
            # At once, or the worker would find itself in asynchronous mode after the missed step and make another.
            sock.sendall(_request(1, "set_synchronous_mode", False) + _request(2, "set_synchronous_mode", True))
            if _answers(sock, 2) != [1, 2]:
                sock.sendall(_request(3, "set_synchronous_mode", True))
                _answers(sock, 1)
        finally:
            busy.clear()


def _request(number: int, method: str, *arguments: Any) -> bytes:
    packed: bytes = msgpack.packb([0, number, method, arguments])
    return packed


def _answers(sock: socket.socket, count: int) -> list[int]:
    """Return the numbers of the next answered requests; raise `OSError` for an error, or if there is none in time."""
    unpacker = msgpack.Unpacker(raw=True, max_buffer_size=LONGEST_ANSWER_BYTES)
    numbers: list[int] = []
    end = time.monotonic() + ANSWER_S
    while time.monotonic() < end:
        data = sock.recv(4096)
        if not data:
            raise ConnectionError("it closed the connection")
        unpacker.feed(data)
        for answer in unpacker:
            if not isinstance(answer, list) or len(answer) != 4 or answer[2] is not None:
                raise ConnectionError("it does not answer as a traffic manager does")
            numbers.append(answer[1])
        if len(numbers) >= count:
            return numbers
    raise TimeoutError("it did not answer in time")
