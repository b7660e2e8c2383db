"""Whether the process that listens on a port of this machine does anything at all.

A thread that waits sleeps; one that works, or would if it got a core, is runnable. So threads that are all asleep for a
while wait for each other or for somebody else. Linux tells this in `/proc`, of processes of the same user.
"""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from pathlib import Path

PROC = Path("/proc")
SAMPLES = 10
SAMPLE_S = 0.005
LISTENING, ASLEEP = "0A", "S"


def is_still(port: int) -> bool | None:
    """True when all threads of the process that listens on `port` sleep for 50 ms; None when that cannot be told."""
    process = _listener(port)
    if process is None:
        return None
    for _ in range(SAMPLES):
        try:
            if any(state != ASLEEP for state in _states(process)):
                return False
        except OSError:
            return None
        time.sleep(SAMPLE_S)
    return True


def _states(process: Path) -> Iterator[str]:
    for thread in (process / "task").iterdir():
        # The name in front, in brackets, may hold anything.
        yield (thread / "stat").read_text(errors="replace").rpartition(")")[2].split()[0]


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
            lines = (PROC / "net" / table).read_text().splitlines()[1:]
        except OSError:
            continue
        for fields in map(str.split, lines):
            if fields[3] == LISTENING and int(fields[1].rpartition(":")[2], 16) == port:
                yield fields[9]


def _holds(process: Path, sockets: set[str]) -> bool:
    try:
        return any(os.readlink(one) in sockets for one in (process / "fd").iterdir())
    except OSError:
        # It has ended, or belongs to another user.
        return False
