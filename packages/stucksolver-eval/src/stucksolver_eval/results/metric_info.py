"""The motion of the ego, tick by tick, in Bench2Drive's `metric_info.json`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stucksolver.atomic_files import write_text

if TYPE_CHECKING:
    import carla

DIGITS = 5
"""Number of decimals. As in Bench2Drive."""
Array = NDArray[np.float64]


class MetricInfo:
    """Collects one entry per tick from a `carla.Vehicle`; world frame, angular velocity in degrees per second."""

    def __init__(self) -> None:
        self._rows: list[tuple[float, ...]] = []

    def add(self, ego: carla.Vehicle, transform: carla.Transform) -> None:
        """Add one tick of the vehicle."""
        a, w = ego.get_acceleration(), ego.get_angular_velocity()
        f, r = transform.get_forward_vector(), transform.get_right_vector()
        p, o = transform.location, transform.rotation
        self._rows.append(
            (a.x, a.y, a.z, w.x, w.y, w.z, f.x, f.y, f.z, r.x, r.y, r.z, p.x, p.y, p.z, o.roll, o.pitch, o.yaw)
        )

    def text(self) -> str:
        """Return the file's text in Bench2Drive's format."""
        rows = np.array(self._rows, dtype=np.float64).reshape(-1, 18).round(DIGITS).tolist()
        return json.dumps({str(k): _entry(row) for k, row in enumerate(rows)}, separators=(",", ":"))

    def write(self, folder: Path) -> None:
        """Write the file.

        Raises:
            OutputError: It cannot be written.
        """
        write_text(folder / "metric_info.json", self.text())


NAMES = ("acceleration", "angular_velocity", "forward_vector", "right_vector", "location", "rotation")


def _entry(row: list[float]) -> dict[str, list[float]]:
    return {name: row[3 * k : 3 * k + 3] for k, name in enumerate(NAMES)}


def read_metric_info(path: Path) -> dict[str, Array]:
    """Return each of `NAMES` as an array of shape (ticks, 3).

    Raises:
        OSError: The file cannot be read.
        ValueError: It is not JSON.
        KeyError: A value is missing.
    """
    entries = list(json.loads(path.read_text(encoding="utf-8")).values())
    return {name: np.array([entry[name] for entry in entries], dtype=np.float64).reshape(-1, 3) for name in NAMES}
