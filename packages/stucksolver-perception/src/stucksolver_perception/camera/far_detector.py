"""Detects far vehicles in the image. Beyond the LiDAR's range a car is about ten pixels wide."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stucksolver_perception.camera.horizon_strip import STRIDE, STRIP_ROWS, cut_rows, look_of, strip_top
from stucksolver_perception.measurements import CameraFrame, Floats
from stucksolver_perception.network_files import DATA, load_session
from stucksolver_perception.rig import CameraRig

VERSION = 1
"""Version of the network's inputs and outputs, and of its card."""
MAX_DETECTIONS = 60
"""Maximum number of detections per image. Ours."""
SAME_IOU = 0.5
"""Overlap (intersection over union) from which the less certain of two boxes is a second peak of the same object.
Ours."""
LOG_LIMIT = 5.0
"""Upper bound of a size's logarithm in cells, which prevents an overflow. Ours."""

_COLUMNS = ("column", "row", "width", "height", "score", "label", "towards")


@dataclass(frozen=True, eq=False)
class FarDetections:
    """The n detections of one image, in descending order of confidence."""

    time_s: float
    column: Floats
    """(n,): column of the middle of the box's lower edge (px of the image)."""
    row: Floats
    """(n,): row of the lower edge, where the wheels or feet touch the road (px)."""
    width: Floats
    """(n,): width of the box with its hidden part (px)."""
    height: Floats
    """(n,): height of the box (px)."""
    score: Floats
    """(n,): confidence, 0 to 1."""
    label: NDArray[np.int64]
    """(n,): index into `horizon_strip.LABELS`."""
    towards: Floats
    """(n,): probability that the object's front is visible, so that it is oncoming; not reliable for pedestrians."""
    look: Floats
    """(2,): brightness and contrast of the image at the horizon; see `horizon_strip.look_of`."""

    def __len__(self) -> int:
        return len(self.label)

    def part(self, which: NDArray[Any]) -> FarDetections:
        """Return the selected detections; `which` is a mask or an array of indices."""
        return replace(self, **{name: getattr(self, name)[which] for name in _COLUMNS})


class FarDetector:
    """The loaded network with its decoder.

    Args:
        folder: Folder of `far.onnx` and its card `far.json`.
        threads: Threads per image.

    Raises:
        NetworkFileError: A file is missing, damaged or of another version, or onnxruntime is not installed.
    """

    def __init__(self, folder: Path = DATA, threads: int = 1) -> None:
        self._session, self.card = load_session(folder / "far.onnx", folder / "far.json", VERSION, threads)
        self._threshold = float(self.card["threshold"])

    def detect(self, frame: CameraFrame, rig: CameraRig, pitch_rad: float = 0.0) -> FarDetections:
        """Return the far vehicles in an image.

        Args:
            frame: The image of the rig's camera.
            rig: The camera. Images of another width or field of view than in training raise no error, but cars in them
                have other sizes than in the training data.
            pitch_rad: Downward pitch of the vehicle relative to the road ahead (rad). Small angles may be omitted,
                because the strip has a margin.
        """
        top = strip_top(rig, pitch_rad)
        strip = cut_rows(frame.rgb, top, STRIP_ROWS)
        peaks, rest = self._session.run(None, {"strip": strip[None]})
        return decode(peaks[0], rest[0], frame.time_s, top, self._threshold, look_of(strip))


def decode(
    peaks: NDArray[np.float32],
    rest: NDArray[np.float32],
    time_s: float,
    top: int,
    threshold: float,
    look: Floats,
) -> FarDetections:
    """Return the detections from the network's outputs.

    Args:
        peaks: (labels, h, w): the heat at its local peaks, 0 elsewhere.
        rest: (6, h, w): log of width and height, shift of the center across and down, of the lower edge (cells), and
            the logit of an oncoming object.
        time_s: Time of the image (s).
        top: The strip's first row in the image.
        threshold: Minimum peak.
        look: See `FarDetections`.
    """
    label, y, x = np.nonzero(peaks >= threshold)
    score = peaks[label, y, x].astype(np.float64)
    best = np.argsort(-score, kind="stable")[:MAX_DETECTIONS]
    label, y, x, score = label[best], y[best], x[best], score[best]
    regression = rest[:, y, x].astype(np.float64)
    size = np.exp(np.minimum(regression[:2], LOG_LIMIT)) * STRIDE
    detections = FarDetections(
        time_s=time_s,
        column=(x + 0.5 + regression[2]) * STRIDE,
        row=(y + 0.5 + regression[4]) * STRIDE + top,
        width=size[0],
        height=size[1],
        score=score,
        label=label.astype(np.int64),
        towards=1.0 / (1.0 + np.exp(-regression[5])),
        look=look,
    )
    return detections.part(_is_unique(detections))


def _is_unique(detections: FarDetections) -> NDArray[np.bool_]:
    """Return (n,): True for detections that are not duplicates of a more certain one of any label."""
    left, right = detections.column - detections.width / 2.0, detections.column + detections.width / 2.0
    top, bottom = detections.row - detections.height, detections.row
    overlap_width = np.minimum(right[:, None], right) - np.maximum(left[:, None], left)
    overlap_height = np.minimum(bottom[:, None], bottom) - np.maximum(top[:, None], top)
    shared = np.maximum(overlap_width, 0.0) * np.maximum(overlap_height, 0.0)
    area = detections.width * detections.height
    is_duplicate = shared > SAME_IOU * (area[:, None] + area - shared)
    is_kept = np.ones(len(detections), bool)
    for k in range(1, len(detections)):
        is_kept[k] = not (is_duplicate[k, :k] & is_kept[:k]).any()
    return is_kept
