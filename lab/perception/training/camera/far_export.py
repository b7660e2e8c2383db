"""Exports the trained far detector to the files that the runtime loads: `far.onnx` and its card `far.json`."""

from __future__ import annotations

import hashlib
import json
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import torch

from lab.perception.training.camera.far_data import MARGIN_ROWS, Strips
from lab.perception.training.camera.far_net import ExportedFarNet, FarNet
from stucksolver_perception.camera.far_detector import VERSION
from stucksolver_perception.camera.horizon_strip import LABELS, STRIDE, STRIP_ROWS

OPSET = 17
"""Version of the ONNX operator set."""
TOLERANCE = 5e-3
"""Largest allowed difference between the outputs of onnxruntime and torch. Ours."""
LEAST_PEAK = 0.05
"""Height of a peak below which it is ignored. Ours; on a uniform gray image every cell is a peak."""
TRIED = 4
"""Number of images on which both are compared. Ours."""


class ExportError(RuntimeError):
    """The outputs of the exported and the trained network differ."""


def export(net: FarNet, out: Path, card: dict[str, Any], tried: Strips) -> dict[str, Any]:
    """Write the network and its card, test the export on some images, and return the card.

    Raises:
        ExportError: The outputs differ.
    """
    shipped, file = ExportedFarNet(net).eval(), out / "far.onnx"
    width = tried.rgb.shape[2]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the exporter that requires no further package warns that it is deprecated
        torch.onnx.export(
            shipped,
            (torch.zeros(1, STRIP_ROWS, width, 3, dtype=torch.uint8),),
            str(file),
            input_names=["strip"],
            output_names=["peaks", "rest"],
            opset_version=OPSET,
            dynamo=False,
        )
    shape = {"rows": STRIP_ROWS, "width": width, "stride": STRIDE}
    sha256 = hashlib.sha256(file.read_bytes()).hexdigest()
    full = {"version": VERSION, "labels": list(LABELS), "input": shape, **card, "sha256": sha256}
    _compare(shipped, file, tried)
    (out / "far.json").write_text(json.dumps(full, indent=1) + "\n", encoding="utf-8")
    return full


def _compare(shipped: ExportedFarNet, file: Path, tried: Strips) -> None:
    import onnxruntime

    session = onnxruntime.InferenceSession(file.read_bytes(), providers=["CPUExecutionProvider"])
    for rgb in tried.rgb[:TRIED, MARGIN_ROWS:-MARGIN_ROWS]:
        strip = np.ascontiguousarray(rgb[None])
        with torch.no_grad():
            wanted = [item.numpy() for item in shipped(torch.from_numpy(strip))]
        (peaks, rest), (their_peaks, their_rest) = wanted, session.run(None, {"strip": strip})
        off = float(np.quantile(np.abs(rest - their_rest), 0.999))
        for label, y, x in zip(*np.nonzero(peaks[0] >= LEAST_PEAK), strict=True):
            # If two cells are equal except for rounding, either may be the peak.
            near = their_peaks[0, label, max(y - 1, 0) : y + 2, max(x - 1, 0) : x + 2]
            off = max(off, float(np.abs(near - peaks[0, label, y, x]).min()))
        if off > TOLERANCE:
            raise ExportError(f"onnxruntime and torch differ by {off:.4f}: {file}. Do not ship it")
