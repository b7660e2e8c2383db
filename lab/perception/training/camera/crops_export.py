"""Exports the trained crop network to the files that the runtime loads: `crops.onnx` and its card `crops.json`."""

from __future__ import annotations

import hashlib
import json
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import torch

from lab.perception.training.camera.crops_data import Crops
from lab.perception.training.camera.crops_net import CropNet, ExportedCropNet
from stucksolver_perception.camera.crop_network import GESTURES, HEADS, KINDS, LAMPS, LIGHTS, VERSION
from stucksolver_perception.camera.crops import CROP_PX, FEATURES

OPSET = 17
"""Version of the ONNX operator set."""
TOLERANCE = 2e-2
"""Largest allowed difference between the logits of onnxruntime and torch. Ours."""
TRIED = 64
"""Number of crops on which both are compared. Ours."""


class ExportError(RuntimeError):
    """The outputs of the exported and the trained network differ."""


def export(net: CropNet, out: Path, card: dict[str, Any], tried: Crops) -> dict[str, Any]:
    """Write the network and its card, test the export on some crops, and return the card.

    Raises:
        ExportError: The outputs differ.
    """
    shipped, file = ExportedCropNet(net).eval(), out / "crops.onnx"
    example = (torch.zeros(2, CROP_PX, CROP_PX, 3, dtype=torch.uint8), torch.zeros(2, FEATURES))
    names = list(HEADS)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the exporter that requires no further package warns that it is deprecated
        torch.onnx.export(
            shipped,
            example,
            str(file),
            input_names=["crops", "features"],
            output_names=names,
            dynamic_axes={name: {0: "n"} for name in ("crops", "features", *names)},
            opset_version=OPSET,
            dynamo=False,
        )
    full = {
        "version": VERSION,
        "kinds": list(KINDS),
        "lamps": list(LAMPS),
        "lights": list(LIGHTS),
        "gestures": list(GESTURES),
        **card,
        "sha256": hashlib.sha256(file.read_bytes()).hexdigest(),
    }
    _compare(shipped, file, tried)
    (out / "crops.json").write_text(json.dumps(full, indent=1) + "\n", encoding="utf-8")
    return full


def _compare(shipped: ExportedCropNet, file: Path, tried: Crops) -> None:
    import onnxruntime

    tried = tried.subset(np.arange(min(TRIED, len(tried))))
    crops, features = tried.middles, tried.features
    with torch.no_grad():
        expected = shipped(torch.from_numpy(crops), torch.from_numpy(features))
    session = onnxruntime.InferenceSession(str(file), providers=["CPUExecutionProvider"])
    outputs = session.run(None, {"crops": crops, "features": features})
    worst = max(float(np.abs(a.numpy() - b).max()) for a, b in zip(expected, outputs, strict=True))
    if worst > TOLERANCE:
        raise ExportError(f"onnxruntime and torch differ by {worst:.3g}: {file}. Do not ship it")
