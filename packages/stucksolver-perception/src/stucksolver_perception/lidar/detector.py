"""Runs the LiDAR detector: from points of the last half second to boxes with velocities."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from stucksolver_perception.lidar.decode import Calibration, decode
from stucksolver_perception.lidar.grid import BevGrid
from stucksolver_perception.lidar.pillars import occupied, pillars
from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.measurements import Detections, Singles
from stucksolver_perception.network_files import NetworkFileError, load_session

DATA = Path(__file__).with_name("data")
"""Folder of the network that ships with the package."""
WEIGHTS = "lidar.onnx"
"""File name of the weights."""
CARD = "card.json"
"""File name of the card."""
VERSION = 1
"""Version of the network's inputs and outputs."""


class LidarDetector:
    """A CenterPoint network (Yin, Zhou, Krähenbühl 2021) on pillars, run on the processor.

    A run uses one thread. With more threads, onnxruntime's ScatterND with a maximum loses points at random (its issue
    18048).

    Args:
        folder: Folder with `lidar.onnx` and `card.json`.

    Raises:
        NetworkFileError: A file is missing, damaged or has another version, or onnxruntime is not installed.
    """

    def __init__(self, folder: Path = DATA) -> None:
        card_file = folder / CARD
        self._session, card = load_session(folder / WEIGHTS, card_file, VERSION, threads=1)
        try:
            self.grid = BevGrid(**card["grid"])
            self.calibration = Calibration(*(tuple(card[key]) for key in ("slope", "shift", "least_score")))
            labels = tuple(card["labels"])
        except (KeyError, TypeError, ValueError) as error:
            raise NetworkFileError(
                f"{card_file}: a field of the card is missing or invalid ({error}); export the network again"
            ) from error
        if labels != LABELS:
            raise NetworkFileError(f"{card_file}: trained for {', '.join(labels)}; train again for {', '.join(LABELS)}")

    def detect(self, points: Singles, time_s: float) -> Detections:
        """Return the detections in the points' frame, the best first.

        Args:
            points: (n, 5) float32: x, y, z (m), intensity (0 to 1), age (s), from `SweepBuffer.gather`.
            time_s: Time of the points' vehicle frame (s).
        """
        features, cell = pillars(points, self.grid)
        if not len(features):
            return _no_detections(time_s)
        slot, cells = occupied(cell, self.grid)
        inputs = {"features": features, "slot": slot, "occupied": cells}
        logit, label, cell_number, regression = self._session.run(None, inputs)
        return decode(logit, label, cell_number, regression, time_s, self.calibration, self.grid)


def _no_detections(time_s: float) -> Detections:
    none = np.zeros(0)
    return Detections(
        time_s, none.astype(np.int64), none, none.reshape(0, 3), none.reshape(0, 3), none, none.reshape(0, 2)
    )
