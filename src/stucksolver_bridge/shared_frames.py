"""Pictures and point clouds for another process, in a file in memory that has no name.

Each array has a place of its own in the file. What is put there replaces what was there before: the other process asks
for the newest data, and copies them before it asks again. Python 3.7, standard library only.
"""

from __future__ import annotations

import mmap
import os
import tempfile
from typing import Any, Mapping

MEMORY = "/dev/shm"
"""Files in here never touch a disk; without it they lie among the temporary ones."""


class SharedFrames:
    """`sizes`: bytes for each array, by its name. `fd` is to be inherited by the process that reads."""

    def __init__(self, sizes: Mapping[str, int]) -> None:
        self._places: dict[str, tuple[int, int]] = {}
        total = 0
        for name, size in sizes.items():
            self._places[name] = (total, size)
            total += size
        self.size = total
        folder = MEMORY if os.path.isdir(MEMORY) else None
        self._file = tempfile.TemporaryFile(dir=folder)  # noqa: SIM115 (closed by `close`)
        self.fd = self._file.fileno()
        os.ftruncate(self.fd, total)
        self._memory = mmap.mmap(self.fd, total)

    def put(self, name: str, array: Any) -> dict[str, Any]:
        """Store an array and say where it lies: `at`, `bytes`, `shape`, `format` (as `memoryview` names them).

        `at` is None where nothing was stored: the array is too large for its place, or it is no array.
        """
        try:
            view = memoryview(array)
        except TypeError:
            return {"at": None, "bytes": 0, "shape": [], "format": type(array).__name__}
        start, size = self._places[name]
        fits = view.nbytes <= size
        if fits and view.nbytes:
            self._memory[start : start + view.nbytes] = view.cast("B") if view.c_contiguous else view.tobytes()
        return {
            "at": start if fits else None,
            "bytes": view.nbytes,
            "shape": list(view.shape or ()),
            "format": view.format,
        }

    def close(self) -> None:
        """Nothing more is put in; the reader keeps what it has."""
        self._memory.close()
        self._file.close()
