"""Shares pictures and point clouds with another process in an unnamed file in memory.

Each array has its own region in the file, where new data overwrite the old. The other process requests the newest data,
and copies them before its next request. Python 3.7, standard library only.
"""

from __future__ import annotations

import mmap
import os
import tempfile
from typing import Any, Mapping

MEMORY = "/dev/shm"
"""Folder whose files are never written to a disk. If it does not exist, the folder for temporary files is used."""


class SharedFrames:
    """Shared memory for several arrays. The process that reads them must inherit `fd`.

    `sizes`: bytes for each array, by its name.
    """

    def __init__(self, sizes: Mapping[str, int]) -> None:
        self._regions: dict[str, tuple[int, int]] = {}
        total = 0
        for name, size in sizes.items():
            self._regions[name] = (total, size)
            total += size
        self.size = total
        folder = MEMORY if os.path.isdir(MEMORY) else None
        self._file = tempfile.TemporaryFile(dir=folder)  # noqa: SIM115 (closed by `close`)
        self.fd = self._file.fileno()
        os.ftruncate(self.fd, total)
        self._memory = mmap.mmap(self.fd, total)

    def put(self, name: str, array: Any) -> dict[str, Any]:
        """Store an array and return its position and layout: `at`, `bytes`, `shape`, `format` (as in `memoryview`).

        `at` is None if nothing was stored: the array is too large for its region, or the value is not an array.
        """
        try:
            view = memoryview(array)
        except TypeError:
            # The reader reports the sensor's fault, with this type.
            return {"at": None, "bytes": 0, "shape": [], "format": type(array).__name__}
        start, size = self._regions[name]
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
        """Close the file. The reader's mapping stays valid."""
        self._memory.close()
        self._file.close()
