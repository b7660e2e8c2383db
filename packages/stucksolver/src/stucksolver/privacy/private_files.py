"""Files that only their owner may read and write, since they hold what people said and what a camera saw."""

from __future__ import annotations

import os
from io import FileIO
from pathlib import Path

OWNERS = 0o600
OTHERS = 0o077


def make_private(path: Path) -> None:
    """Take an existing file away from everybody but its owner.

    Raises:
        OSError: It belongs to somebody else, or cannot be changed.
    """
    if path.stat().st_mode & OTHERS:
        path.chmod(OWNERS)


def open_new(path: Path) -> FileIO:
    """Create a file and open it for writing, unbuffered.

    Raises:
        OSError: It exists, or cannot be created.
    """
    return open(path, "xb", buffering=0, opener=_owners)


def append(path: Path, content: bytes) -> None:
    """Append to a file; create it, or take it away from others first.

    Raises:
        OSError: It cannot be written.
    """
    with open(path, "ab", opener=_owners) as file:
        if os.fstat(file.fileno()).st_mode & OTHERS:
            os.fchmod(file.fileno(), OWNERS)
        file.write(content)


def write_once(path: Path, content: bytes) -> None:
    """Write a file whose name says what it holds; keep one that exists, but take it away from others.

    Raises:
        OSError: It cannot be written.
    """
    if path.exists():
        make_private(path)
        return
    part = path.with_suffix(f".{os.getpid()}.part")
    part.unlink(missing_ok=True)
    with open(part, "xb", opener=_owners) as file:
        file.write(content)
    part.replace(path)


def _owners(path: str, flags: int) -> int:
    return os.open(path, flags, OWNERS)
