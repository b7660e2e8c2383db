"""The network's convolutions in 8-bit integers: a third of the time on processors with VNNI, half the file."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from pathlib import Path
from typing import Any

FULL = ("/heat/Conv", "/box/Conv")
"""Layers that keep their precision: what they say is the answer itself."""
QUANTISED = ["Conv", "ConvTranspose", "Relu", "Add"]


def quantise(file: Path, to: Path, inputs: Iterator[dict[str, Any]]) -> None:
    """Static quantisation after training (Jacob et al. 2018), by channel, with onnxruntime's tools.

    Args:
        file: The exported network.
        to: Where the other one goes.
        inputs: What the network is fed on typical windows; their extremes set the ranges of the integers.
    """
    from onnxruntime.quantization import CalibrationDataReader, QuantFormat, QuantType, quantize_static
    from onnxruntime.quantization.shape_inference import quant_pre_process

    class Reader(CalibrationDataReader):  # type: ignore[misc]
        def get_next(self) -> dict[str, Any] | None:
            return next(inputs, None)

    logging.getLogger().setLevel(logging.ERROR)
    plain = to.with_suffix(".plain.onnx")
    # Batch normalisations become part of their convolutions before these are quantised.
    quant_pre_process(str(file), str(plain), skip_symbolic_shape=True)
    quantize_static(
        str(plain),
        str(to),
        Reader(),
        quant_format=QuantFormat.QDQ,
        per_channel=True,
        activation_type=QuantType.QUInt8,
        weight_type=QuantType.QInt8,
        op_types_to_quantize=QUANTISED,
        nodes_to_exclude=_named(plain, FULL),
    )
    plain.unlink()


def _named(file: Path, parts: tuple[str, ...]) -> list[str]:
    import onnx

    return [node.name for node in onnx.load(str(file)).graph.node if any(part in node.name for part in parts)]
