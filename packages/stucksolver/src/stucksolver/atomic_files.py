"""Writes result files, completely or not at all."""

from __future__ import annotations

import contextlib
import os
import tempfile
from pathlib import Path


class OutputError(RuntimeError):
    """Failed write of a result. The message names the file and the remedy."""


def write_text(path: Path, text: str) -> None:
    """Write a file atomically: a crash or a full disk leaves the old file, or none.

    Raises:
        OutputError: The file cannot be written.
    """
    write_bytes(path, text.encode("utf-8"))


def write_bytes(path: Path, data: bytes) -> None:
    """Write bytes atomically.

    Raises:
        OutputError: The file cannot be written.
    """
    temporary = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        temporary.write_bytes(data)
        os.replace(temporary, path)
    except OSError as error:
        with contextlib.suppress(OSError):  # The first error is reported; the remainder is only a temporary file.
            temporary.unlink(missing_ok=True)
        raise cannot_write(path, error) from error


def require_writable(folder: Path) -> None:
    """Create a folder and check that files can be written there, before a run of hours starts.

    Raises:
        OutputError: The folder is not writable.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise cannot_write(folder, error) from error


def cannot_write(path: Path, error: OSError) -> OutputError:
    """Return the error for a failed write."""
    return OutputError(f"cannot write {path}: {error.strerror}; choose another --out or make room")
