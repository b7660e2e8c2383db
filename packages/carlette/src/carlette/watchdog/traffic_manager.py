"""Frees clients that hang because their own traffic manager has lost a wake-up.

Pacing makes the loss rare, but on a loaded machine a thread may be late by any amount of time. A client that lost the
wake-up makes no more calls: its main thread waits inside `world.tick()` for a worker that waits to be woken. The
traffic manager still answers on its own port, and leaving synchronous mode there wakes the worker
(`TrafficManagerLocal` of CARLA 0.9.15 and 0.9.16), which then makes the step that was missed. So the watchdog checks
whether a silent client responds, makes it leave synchronous mode, and makes it enter it again.

The other half of a step may be lost as well: the worker ends it and also notifies the main thread without the
mutex. Then the same rescue makes the worker step once more (its cars are steered twice for one tick), and the
client continues.

A worker that is merely late must not be woken: it would make that step twice, and be out of step with its client from
then on. So the threads of a silent client on this machine are examined (`threads`). The client is freed if its worker
waits for a step while its main thread waits for the end of one, which has no other cause. If the system does not show
what a thread waits for, a client that has called nothing at all since its snapshot is freed once all its threads sleep.
Such a client, or one on another machine, is also freed after a longer silence. A client that really lost the first
wake-up continues after the rescue bit for bit as if nothing had happened.

Three others are left alone: a client with unknown threads that began its step (it requests the vehicles' lights; this
covers a client that a debugger stops between ticks, and a traffic manager in asynchronous mode), a process that is
stopped as a whole (it answers nothing), and anything that is not a traffic manager (it answers with an error). A client
that ticks with a traffic manager in another process is not helped, because the registration is not its own.

The numbers are ours.
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
"""Silence after which a client is examined (s). A client in step calls within microseconds of a snapshot."""
FAR_STALLED_S = 3.0
"""The same for a client whose threads cannot be examined: on another machine, or with a thread that always runs (s)."""
LONGEST_LOOK_S = 8.0
"""Longest time between two checks of a silent client (s). The time doubles up to this value."""
ANSWER_S = 2.0
"""Time for a traffic manager to answer (s)."""
MOST_TRIES = 4
"""Maximum number of attempts if a rescue is not answered; each wait is twice as long as the one before."""
LONGEST_ANSWER_BYTES = 65536
"""Longest answer of a traffic manager (bytes)."""

log = logging.getLogger(__name__)


@dataclass
class _Silence:
    """Silence of a client since its last snapshot."""

    since: float
    """Time of the snapshot, or of the last call that was noticed."""
    due: float
    """Time of the next check, unless the client calls before."""
    surely_lost: float
    """Time from which on the client is freed without a check whether it works."""
    host: str
    ports: tuple[int, ...]
    tries: int = 0
    """Number of rescues so far."""
    calls: int = 0
    """Number of calls of the client since the snapshot."""
    calls_seen: int = 0
    """Value of `calls` at the last check."""
    has_begun: bool = False
    """True if the snapshot or a rescue woke the worker of the client."""


class TrafficManagerWatchdog:
    """Notices a client that is silent after a snapshot that it requested. Times are monotonic (s)."""

    def __init__(self) -> None:
        self.count = 0
        """Number of rescues of clients."""
        self._silence: _Silence | None = None
        self._helper: threading.Thread | None = None
        self._switching = threading.Event()

    @property
    def is_switching(self) -> bool:
        """True while a woken traffic manager is not yet back in synchronous mode: no snapshot should be sent."""
        return self._switching.is_set()

    def wait_for_switch(self) -> None:
        """Return when no traffic manager is between its modes; limited by the time for its answer."""
        if self.is_switching and self._helper is not None:
            self._helper.join(ANSWER_S)

    def published(self, now: float, host: str, managers: Iterable[int]) -> None:
        """Note that the snapshot requested by a client at `host` with these traffic manager ports has been sent."""
        ports = tuple(managers)
        self._silence = _Silence(now, now + STALLED_S, now + FAR_STALLED_S, host, ports) if ports else None

    def note_call(self, has_begun: bool = True) -> None:
        """Note a call of this client; `has_begun` is False if it may have called before it waited for its step."""
        if self._silence is not None:
            self._silence.calls += 1
            self._silence.has_begun |= has_begun

    def note_disconnect(self) -> None:
        """Note that this client has disconnected."""
        self._silence = None

    def free_if_silent(self, now: float) -> None:
        """Free the client if it has been silent for too long. Call this regularly."""
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
            # The client works, or it called while its threads were examined.
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
            # The rescue failed; the next check tries again, up to `MOST_TRIES` times.
            log.info("the traffic manager at %s:%d was not woken: %s", host, port, error)
            return False
        log.warning("woke the traffic manager at %s:%d from a lost wake-up", host, port)
        return True


def _is_here(host: str) -> bool:
    return host == "::1" or host.startswith(("127.", "::ffff:127."))


def wake(host: str, port: int, switching: threading.Event | None = None) -> None:
    """Make a traffic manager leave and re-enter synchronous mode.

    `switching` is set while it is in asynchronous mode.

    Raises:
        OSError: The traffic manager does not answer.
    """
    busy = switching or threading.Event()
    with socket.create_connection((host, port), timeout=ANSWER_S) as sock:
        # Check first: a process that is merely stopped answers nothing, and is left alone.
        sock.sendall(_request(0, "health_check_remote_TM"))
        _answers(sock, 1)
        busy.set()
        try:
            # Send both at once. Otherwise the worker would find asynchronous mode after the missed step and
            # make another.
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
    """Return the numbers of the next answered requests; raise `OSError` for an error or a timeout."""
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
