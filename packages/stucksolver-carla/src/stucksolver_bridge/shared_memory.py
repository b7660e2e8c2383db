"""Pictures and point clouds for another process, in an unnamed file in memory.

Each array has its own place in the file, where new data overwrite the old. The other process asks for the newest data,
and copies them before it asks again. Python 3.7, standard library only.
"""

from __future__ import annotations

import mmap
import os
import tempfile
from typing import Any, Mapping

MEMORY = "/dev/shm"
"""Files in this folder are never written to a disk. If it does not exist, the folder for temporary files is used."""


class SharedFrames:
    """`sizes`: bytes for each array, by its name. The process that reads must inherit `fd`."""

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
        """Store an array and return where it is: `at`, `bytes`, `shape`, `format` (as `memoryview` names them).

        `at` is None if nothing was stored: the array is too large for its place, or it is not an array.
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
        """Close the file. The reader keeps what it has."""
        self._memory.close()
        self._file.close()
