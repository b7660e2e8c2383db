"""Servers as subprocesses, for the real client to connect to."""

from __future__ import annotations

import re
import secrets
import socket
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

LEAVES_WITHIN_S = 60.0
"""Whoever takes longer hangs; a busy machine may need seconds for an end that comes at once."""
READY = re.compile(r"carlette: listening on (\S+):(\d+) map=(\S+)")


PORTS = range(20_000, 32_000, 2)
"""Below those that Linux gives to whoever connects (from 32,768 on): a client of another test takes none of these."""


def free_port() -> int:
    """A port on which nobody listens now, nor on the next one, which a server's streams need.

    Another process may take it: where a server can choose, let it.
    """
    while True:
        # Not `random`: hypothesis gives that the same seed in every process.
        port = secrets.choice(PORTS)
        if _is_free(port) and _is_free(port + 1):
            return port


def _is_free(port: int) -> bool:
    with socket.socket() as one:
        try:
            one.bind(("127.0.0.1", port))
        except OSError:
            return False
        return True


@contextmanager
def running_server(
    *arguments: str, program: Sequence[str] = ("-m", "carlette"), folder: Path | None = None
) -> Iterator[int]:
    """A server (in that folder) on a free port, which it yields; ends with the block, and with this process."""
    command = [sys.executable, *program, "--port", "0", "--exit-on-stdin-eof", *arguments]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=folder) as process:
        try:
            assert process.stdout is not None
            ready = READY.fullmatch(process.stdout.readline().strip())
            assert ready, "the server did not come up"
            yield int(ready[2])
        finally:
            process.terminate()
            assert process.wait(LEAVES_WITHIN_S) == 0
