"""Reads files with names from outside: only regular ones, up to a size limit."""

from __future__ import annotations

import os
import stat
from pathlib import Path


def read_regular(path: Path, most_bytes: int) -> bytes:
    """Return all bytes of a regular file.

    Raises:
        OSError: It is not a regular file (a pipe would block, and a device may never end), or it is larger than
            `most_bytes`. Its `strerror` is a phrase for a message.
    """
    # Do not block: opening a pipe would wait for its other end.
    number = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_NOCTTY | os.O_CLOEXEC)
    with open(number, "rb") as file:
        if not stat.S_ISREG(os.fstat(number).st_mode):
            raise OSError(None, "it is not a regular file", str(path))
        # Do not rely on the reported size: files in `/proc` report none, and a file may grow.
        data = file.read(most_bytes + 1)
    if len(data) > most_bytes:
        raise OSError(None, f"it is larger than {most_bytes:,} bytes", str(path))
    return data
