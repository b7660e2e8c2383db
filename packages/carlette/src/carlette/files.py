"""Reading files that somebody else names: only regular ones, and never more of them than a bound."""

from __future__ import annotations

import os
import stat
from pathlib import Path


def read_regular(path: Path, most_bytes: int) -> bytes:
    """All bytes of a regular file.

    Raises `OSError`, its `strerror` a phrase to tell, for what is no regular file (a pipe would wait for a writer for
    ever, a device may never end) and for a file of more than `most_bytes`.
    """
    # Without blocking, as opening a pipe waits for its other end.
    number = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_NOCTTY | os.O_CLOEXEC)
    with open(number, "rb") as file:
        if not stat.S_ISREG(os.fstat(number).st_mode):
            raise OSError(None, "it is not a regular file", str(path))
        # Not the size that it claims: files of `/proc` claim none, and a file may grow.
        data = file.read(most_bytes + 1)
    if len(data) > most_bytes:
        raise OSError(None, f"it is larger than {most_bytes:,} bytes", str(path))
    return data
