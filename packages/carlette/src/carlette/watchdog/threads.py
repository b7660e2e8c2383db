"""Examines the threads of the process that listens on a local port: whether they work, and what they wait for.

A waiting thread sleeps. A thread that works, or would work if it had a core, is runnable. So if all threads sleep for a
while, they wait for each other or for something outside. Linux shows this in `/proc` for processes of the same user. To
users that may also trace the process, it shows the address on which each thread waits.
"""

from __future__ import annotations

import os
import platform
import time
from collections.abc import Iterator
from pathlib import Path

PROC = Path("/proc")
SAMPLES = 10
"""Number of samples; with `SAMPLE_S`, they cover 50 ms. Ours."""
SAMPLE_S = 0.005
"""Time between two samples (s). Ours."""
LISTENING, ASLEEP = "0A", "S"
FUTEX_CALL = {"x86_64": "202"}
NEIGHBORS_BYTES = range(44, 53)
"""Distances between the words on which two threads wait in adjacent condition variables of glibc (48 bytes each).

Each variable has two such words, 4 bytes apart, and uses them in turn.
"""


def is_still(port: int) -> bool | None:
    """True if all threads of the process that listens on `port` sleep for 50 ms; None if that cannot be determined."""
    process = _listener(port)
    if process is None:
        return None
    for _ in range(SAMPLES):
        try:
            if any(state != ASLEEP for state in _states(process)):
                return False
        except OSError:
            # The process has ended, or belongs to another user.
            return None
        time.sleep(SAMPLE_S)
    return True


def waits_for_itself(port: int) -> bool | None:
    """True if two threads of the process that listens on `port` wait on adjacent condition variables for 50 ms.

    A traffic manager has two of them: on one its worker waits for the next step, on the other its client waits for the
    end of this step (`TrafficManagerLocal` of CARLA 0.9.15 and 0.9.16; the addresses were checked in both clients). If
    both wait, one of them has lost its wake-up. None if that cannot be determined.
    """
    process = _listener(port)
    call = FUTEX_CALL.get(platform.machine())
    if process is None or call is None:
        return None
    waits: set[tuple[str, int]] | None = None
    for _ in range(SAMPLES):
        try:
            found = set(_waits(process, call))
        except OSError:
            # The process has ended, or belongs to another user.
            return None
        waits = found if waits is None else waits & found
        if len(waits) < 2:
            return False
        time.sleep(SAMPLE_S)
    words = {word for _, word in waits or ()}
    return any(word + apart in words for word in words for apart in NEIGHBORS_BYTES)


def _waits(process: Path, call: str) -> Iterator[tuple[str, int]]:
    """Yield the threads that wait on a word of memory, and its address."""
    for thread in (process / "task").iterdir():
        fields = (thread / "syscall").read_text(encoding="utf-8").split()
        if fields[0] == call:
            yield thread.name, int(fields[1], 16)


def _states(process: Path) -> Iterator[str]:
    for thread in (process / "task").iterdir():
        # The name in front, in brackets, may contain anything.
        yield (thread / "stat").read_text(errors="replace", encoding="utf-8").rpartition(")")[2].split()[0]


def _listener(port: int) -> Path | None:
    sockets = {f"socket:[{inode}]" for inode in _inodes(port)}
    if sockets:
        for process in PROC.glob("[0-9]*"):
            if _holds(process, sockets):
                return process
    return None


def _inodes(port: int) -> Iterator[str]:
    for table in ("tcp", "tcp6"):
        try:
            lines = (PROC / "net" / table).read_text(encoding="utf-8").splitlines()[1:]
        except OSError:
            # The system has no such table, for example without IPv6.
            continue
        for fields in map(str.split, lines):
            if fields[3] == LISTENING and int(fields[1].rpartition(":")[2], 16) == port:
                yield fields[9]


def _holds(process: Path, sockets: set[str]) -> bool:
    try:
        return any(os.readlink(path) in sockets for path in (process / "fd").iterdir())
    except OSError:
        # The process has ended, or belongs to another user.
        return False
