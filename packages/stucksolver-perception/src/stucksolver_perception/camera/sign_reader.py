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
MIN_SIDE_PX = 320
"""Shorter side to which small crops are upscaled (px). The package's default, 736, takes five times as long and reads
no more words."""
MAX_SCALE = 4.0
"""Maximum factor of the upscaling. Ours."""
MAX_SIDE_PX = 736
"""Maximum longer side (px); larger crops are downscaled. Ours."""


class TextRecognizer(Protocol):
    """Reads the words of the list in crops."""

    def read(self, crop: Pixels, enlarge: bool) -> tuple[DetectedWord, ...]:
        """Return the words with their positions in the crop (px).

        Args:
            crop: (rows, columns, 3) RGB.
            enlarge: True to upscale a small crop of one sign.
        """


def unavailable_reason() -> str | None:
    """Return the reason why words on signs are not read, with the remedy; None if the package is installed."""
    return f"{PACKAGE} not installed; add the extra [signs] (README, Install)" if find_spec(PACKAGE) is None else None


class SignReaderError(RuntimeError):
    """The recognizer cannot be used. The message gives the reason."""


class SignReader:
    """The recognizer. It loads the networks (about 0.5 s, 100 MB) at the first call, because most runs use none."""

    def __init__(self, threads: int = 1) -> None:
        self._threads = threads
        self._engine: Any | None = None

    def read(self, crop: Pixels, enlarge: bool) -> tuple[DetectedWord, ...]:
        """Return the words in a crop; see `TextRecognizer`.

        Raises:
            SignReaderError: The package or a library that it requires cannot be loaded.
        """
        from PIL import Image

        if self._engine is None:
            self._engine = _load(self._threads)
        height, width = crop.shape[:2]
        scale = scale_of(width, height, enlarge)
        image = Image.fromarray(np.ascontiguousarray(crop))
        if scale != 1.0:
            image = image.resize((round(width * scale), round(height * scale)), Image.Resampling.BICUBIC)
        lines, _ = self._engine(np.asarray(image)[:, :, ::-1].copy(), use_cls=False)
        return words_of([_line(box, text, float(confidence), scale) for box, text, confidence in lines or ()])


def _load(threads: int) -> Any:
    try:
        package = importlib.import_module(PACKAGE)
    except ImportError as error:
        # The package may be installed while a system library of OpenCV is missing.
        raise SignReaderError(f"{PACKAGE} cannot be loaded ({error}); install the missing library") from error
    return package.RapidOCR(
        intra_op_num_threads=threads,
        inter_op_num_threads=1,
        det_limit_side_len=MAX_SIDE_PX,
        det_limit_type="max",
    )


def scale_of(width: int, height: int, enlarge: bool) -> float:
    """Return the scale of a crop of this size (px) for reading."""
    scale = min(max(MIN_SIDE_PX / min(width, height), 1.0), MAX_SCALE) if enlarge else 1.0
    return min(scale, MAX_SIDE_PX / max(width, height))


def _line(box: Any, text: str, confidence: float, scale: float) -> TextLine:
    corners = np.asarray(box, np.float64) / scale
    (left, top), (right, bottom) = corners.min(axis=0), corners.max(axis=0)
    return TextLine(text, confidence, float(left), float(top), float(right), float(bottom))
