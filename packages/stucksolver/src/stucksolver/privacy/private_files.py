"""Files that only their owner may read and write, since they contain utterances and camera images."""

from __future__ import annotations

import os
from io import FileIO
from pathlib import Path

OWNERS = 0o600
"""Mode of a private file: the owner may read and write."""
OTHERS = 0o077
"""Mode bits of all other users."""


def make_private(path: Path) -> None:
    """Remove the permissions of all other users from an existing file.

    Raises:
        OSError: The file belongs to another user, or cannot be changed.
    """
    if path.stat().st_mode & OTHERS:
        path.chmod(OWNERS)


def open_new(path: Path) -> FileIO:
    """Create a file and open it for writing, unbuffered.

    Raises:
        OSError: The file exists, or cannot be created.
    """
    return open(path, "xb", buffering=0, opener=_owners)


def append(path: Path, content: bytes) -> None:
    """Append to a file. Create it, or make it private first.

    Raises:
        OSError: The file cannot be written.
    """
    with open(path, "ab", opener=_owners) as file:
        if os.fstat(file.fileno()).st_mode & OTHERS:
            os.fchmod(file.fileno(), OWNERS)
        file.write(content)


def write_once(path: Path, content: bytes) -> None:
    """Write a file that is named after its content. Keep an existing file, but make it private.

    Raises:
        OSError: The file cannot be written.
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
