"""Detects vehicles far ahead in the image: beyond the LiDAR's reach a car is some ten pixels wide."""

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
MOST = 60
"""Number of detections kept per image."""
SAME_IOU = 0.5
"""Of two boxes with this overlap (intersection over union) the less sure one is a second peak of the same object."""
LOG_LIMIT = 5.0
"""Limit of a size's logarithm in cells, so that a wild output does not overflow."""

_COLUMNS = ("column", "row", "width", "height", "score", "label", "towards")


@dataclass(frozen=True, eq=False)
class FarDetections:
    """The detections of one image; equal lengths n, the surest first."""

    time_s: float
    column: Floats
    """(n,): column of the middle of the box's lower edge (px of the image)."""
    row: Floats
    """(n,): row of the lower edge, where the wheels or feet touch the road (px)."""
    width: Floats
    """(n,): width of the box, its hidden part included (px)."""
    height: Floats
    score: Floats
    """(n,): 0 to 1."""
    label: NDArray[np.int64]
    """(n,): index into `far_strip.LABELS`."""
    towards: Floats
    """(n,): probability that its front is visible, so that it comes toward us; means little for people."""
    look: Floats
    """(2,): brightness and contrast of the image at the horizon, see `far_strip.look_of`."""

    def __len__(self) -> int:
        return len(self.label)

    def part(self, which: NDArray[Any]) -> FarDetections:
        """Return some of them, by a mask or by indices."""
        return replace(self, **{name: getattr(self, name)[which] for name in _COLUMNS})


class FarDetector:
    """The network and its decoder, loaded once.

    Args:
        folder: Folder of `far.onnx` and its card `far.json`.
        threads: Threads per image.

    Raises:
        WeightsError: They are missing, damaged or of another version, or onnxruntime is not installed.
    """

    def __init__(self, folder: Path = DATA, threads: int = 1) -> None:
        self._session, self.card = load_session(folder / "far.onnx", folder / "far.json", VERSION, threads)
        self._threshold = float(self.card["threshold"])

    def detect(self, frame: CameraFrame, rig: CameraRig, pitch_rad: float = 0.0) -> FarDetections:
        """Detect far vehicles in an image.

        Args:
            frame: The image, taken by the camera that the rig describes.
            rig: The camera. Images of another width or angle of view than in training are not detected as such, but
                cars then have another size than those that the network knows.
            pitch_rad: How far the nose is down relative to the road ahead (rad); small angles may be left out, since
                the strip has a margin.
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
    """Decode detections from the network's outputs.

    Args:
        peaks: (labels, h, w): the heat at its local peaks, 0 elsewhere.
        rest: (6, h, w): log of width and height, shift of the center across and down, of the lower edge (cells), and
            the logit of coming toward us.
        time_s: Time of the image (s).
        top: The strip's first row in the image.
        threshold: Lower peaks are left out.
        look: See `FarDetections`.
    """
    label, y, x = np.nonzero(peaks >= threshold)
    score = peaks[label, y, x].astype(np.float64)
    best = np.argsort(-score, kind="stable")[:MOST]
    label, y, x, score = label[best], y[best], x[best], score[best]
    told = rest[:, y, x].astype(np.float64)
    size = np.exp(np.minimum(told[:2], LOG_LIMIT)) * STRIDE
    found = FarDetections(
        time_s=time_s,
        column=(x + 0.5 + told[2]) * STRIDE,
        row=(y + 0.5 + told[4]) * STRIDE + top,
        width=size[0],
        height=size[1],
        score=score,
        label=label.astype(np.int64),
        towards=1.0 / (1.0 + np.exp(-told[5])),
        look=look,
    )
    return found.part(_single(found))


def _single(found: FarDetections) -> NDArray[np.bool_]:
    """(n,): True for detections that are not duplicates of a surer one, whatever their labels."""
    left, right = found.column - found.width / 2.0, found.column + found.width / 2.0
    top, bottom = found.row - found.height, found.row
    wide = np.minimum(right[:, None], right) - np.maximum(left[:, None], left)
    high = np.minimum(bottom[:, None], bottom) - np.maximum(top[:, None], top)
    shared = np.maximum(wide, 0.0) * np.maximum(high, 0.0)
    area = found.width * found.height
    same = shared > SAME_IOU * (area[:, None] + area - shared)
    kept = np.ones(len(found), bool)
    for k in range(1, len(found)):
        kept[k] = not (same[k, :k] & kept[:k]).any()
    return kept
