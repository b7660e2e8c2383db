"""The folder of the logs.

A file name from a client cannot lead out of it, because the protocol has no authentication.
"""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from carlette.errors import RequestError

LONGEST_NAME, LONGEST_PATH = 255, 1024
"""Longest name and longest path within the folder (bytes).

Ours; with the folder, a path stays below the system's 4,096.
"""
LONGEST_TOLD = 200
"""Number of characters of a name that an error message repeats. Ours."""


def default_folder() -> Path:
    """Return `carlette/recordings` in the user's folder for state (XDG base directories)."""
    try:
        state = Path(os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state")
    except RuntimeError:  # a user without a home
        state = Path(tempfile.gettempdir()) / f"state-{os.getuid()}"
    return state / "carlette" / "recordings"


def path_in(folder: Path, name: str) -> Path:
    """Return the file that a client names: relative to the folder, or absolute and within it.

    Raises:
        RequestError: The name leads elsewhere, also through `..` or a link.
    """
    encoded = os.fsencode(name)
    if not name or "\0" in name or len(encoded) > LONGEST_PATH or max(map(len, encoded.split(b"/"))) > LONGEST_NAME:
        raise RequestError(f"'{_short(name)}' is not a file name; give one such as run.log")
    root = folder.resolve()
    if ".." in Path(name).parts:
        raise RequestError(_refusal(name, root))
    try:
        path = (root / name).resolve()
    except (OSError, RuntimeError):  # circular links
        raise RequestError(f"'{_short(name)}' is not a file name; give one such as run.log") from None
    if path == root or not path.is_relative_to(root):
        raise RequestError(_refusal(name, root))
    return path


def make_room(path: Path) -> None:
    """Create the folder of a log; raise `RequestError` if that fails."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RequestError(
            f"cannot record to '{path}': {error.strerror}; start the server with another --recordings"
        ) from None


def _short(name: str) -> str:
    return name if len(name) <= LONGEST_TOLD else f"{name[:LONGEST_TOLD]}…"


def _refusal(name: str, root: Path) -> str:
    return f"'{_short(name)}' is not a file within '{root}', where the server keeps logs; give a name such as run.log"
