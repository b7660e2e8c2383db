"""Reads words in crops with PP-OCR's networks (`rapidocr-onnxruntime`, the extra `signs`)."""

from __future__ import annotations

import importlib
from importlib.util import find_spec
from typing import Any, Protocol

import numpy as np

from stucksolver_perception.camera.sign_words import DetectedWord, TextLine, words_of
from stucksolver_perception.measurements import Pixels

PACKAGE = "rapidocr_onnxruntime"
UNREAD = "words on signs are not read"
LEAST_SIDE_PX = 320
"""Crops are upscaled to this smaller side. The package's own choice, 736, takes five times as long and reads no more
(px).
"""
LARGEST_SCALE = 4.0
"""They are upscaled by at most this factor."""
MOST_SIDE_PX = 736
"""Largest longer side of what is read; larger crops are downscaled (px)."""


class TextRecognizer(Protocol):
    """Reads words of the list in crops."""

    def read(self, crop: Pixels, enlarge: bool) -> tuple[DetectedWord, ...]:
        """Return the words with their places in the crop (px).

        Args:
            crop: (rows, columns, 3) RGB.
            enlarge: True for a small crop of one sign: it is upscaled.
        """


def unavailable_reason() -> str | None:
    """Return why words on signs are not read here, with the remedy; None if they are."""
    return f"{PACKAGE} not installed; add the extra [signs] (README, Install)" if find_spec(PACKAGE) is None else None


class SignReaderError(RuntimeError):
    """The recognizer cannot be used. The message says why."""


class SignReader:
    """Loads the networks at the first look, since most drives never stand for long: some 0.5 s and 100 MB."""

    def __init__(self, threads: int = 1) -> None:
        self._threads = threads
        self._engine: Any | None = None

    def read(self, crop: Pixels, enlarge: bool) -> tuple[DetectedWord, ...]:
        """See `TextRecognizer`.

        Raises:
            SignReaderError: The package or a library that it needs cannot be loaded.
        """
        from PIL import Image

        if self._engine is None:
            self._engine = _load(self._threads)
        height, width = crop.shape[:2]
        scale = scale_of(width, height, enlarge)
        image = Image.fromarray(np.ascontiguousarray(crop))
        if scale != 1.0:
            image = image.resize((round(width * scale), round(height * scale)), Image.Resampling.BICUBIC)
        found, _ = self._engine(np.asarray(image)[:, :, ::-1].copy(), use_cls=False)
        return words_of([_line(box, text, float(sure), scale) for box, text, sure in found or ()])


def _load(threads: int) -> Any:
    try:
        package = importlib.import_module(PACKAGE)
    except ImportError as error:
        # OpenCV needs libraries of the system.
        raise SignReaderError(f"{PACKAGE} cannot be loaded ({error}); install what is missing") from error
    return package.RapidOCR(
        intra_op_num_threads=threads,
        inter_op_num_threads=1,
        det_limit_side_len=MOST_SIDE_PX,
        det_limit_type="max",
    )


def scale_of(width: int, height: int, enlarge: bool) -> float:
    """Return by how much a crop of this size (px) is scaled before it is read."""
    wanted = min(max(LEAST_SIDE_PX / min(width, height), 1.0), LARGEST_SCALE) if enlarge else 1.0
    return min(wanted, MOST_SIDE_PX / max(width, height))


def _line(box: Any, text: str, sure: float, scale: float) -> TextLine:
    corners = np.asarray(box, np.float64) / scale
    (left, top), (right, bottom) = corners.min(axis=0), corners.max(axis=0)
    return TextLine(text, sure, float(left), float(top), float(right), float(bottom))
