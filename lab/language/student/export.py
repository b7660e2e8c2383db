"""Writes the trained student as the two files that the runtime loads: `student.onnx` and its card `student.json`."""

from __future__ import annotations

import hashlib
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from lab.language.student.batches import batch_of
from lab.language.student.data import Example
from lab.language.student.net import KINDS, StudentNet
from stucksolver_language.student.heads import OUTPUTS
from stucksolver_language.student.network import CARD, WEIGHTS, Card, card_text, versions
from stucksolver_language.student.vocabulary import Vocabulary

OPSET = 17
"""Version of the ONNX operator set."""
TOLERANCE = 1e-3
"""Largest allowed difference between the logits of onnxruntime and torch. Ours."""
TRIED = 16
"""Number of examples on which both are compared. Ours."""
INPUTS = (*KINDS, "mask", "plans", "named")


class ExportError(RuntimeError):
    """The exported and the trained network differ, so the exported one must not be used."""


class _Flat(nn.Module):
    """The network with one argument for each input, as in ONNX."""

    def __init__(self, net: StudentNet) -> None:
        super().__init__()
        self.net = net

    def forward(self, *inputs: Tensor) -> tuple[Tensor, ...]:
        """Return the outputs in the order of `OUTPUTS`."""
        rows = dict(zip(KINDS, inputs, strict=False))
        mask, plans, named = inputs[len(KINDS) :]
        found: tuple[Tensor, ...] = self.net(rows, mask, plans, named)
        return found


def export(
    net: StudentNet,
    out: Path,
    words: Vocabulary,
    trained: dict[str, Any],
    tried: Sequence[Example],
) -> Card:
    """Write the network and its card to a folder, and compare both runtimes on some examples.

    The card is not calibrated yet, and has no scores.

    Raises:
        ExportError: They differ.
    """
    flat = _Flat(net).eval()
    out.mkdir(parents=True, exist_ok=True)
    file = out / WEIGHTS
    inputs = _inputs(tried[0])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the exporter that requires no further package warns that it is deprecated
        torch.onnx.export(
            flat,
            tuple(torch.from_numpy(row) for row in inputs.values()),
            str(file),
            input_names=list(INPUTS),
            output_names=list(OUTPUTS),
            dynamic_axes={name: {1: "n"} for name in ("plans", "named", "accepted", "value", "prior")},
            opset_version=OPSET,
            dynamo=False,
        )
    _compare(flat, file, tried[:TRIED])
    card = Card(
        name="student",
        versions=versions(),
        vocabulary=words,
        temperature=1.0,
        sha256=hashlib.sha256(file.read_bytes()).hexdigest(),
        trained=trained,
    )
    (out / CARD).write_text(card_text(card), encoding="utf-8")
    return card


def _inputs(example: Example) -> dict[str, np.ndarray[Any, Any]]:
    batch = batch_of([example])
    tensors = {**batch.rows, "mask": batch.mask, "plans": batch.plans, "named": batch.named}
    return {name: tensors[name].numpy() for name in INPUTS}


def _compare(flat: _Flat, file: Path, tried: Sequence[Example]) -> None:
    import onnxruntime

    session = onnxruntime.InferenceSession(file.read_bytes(), providers=["CPUExecutionProvider"])
    for example in tried:
        inputs = _inputs(example)
        with torch.no_grad():
            wanted = flat(*(torch.from_numpy(table) for table in inputs.values()))
        found = session.run(list(OUTPUTS), inputs)
        off = max(float(np.abs(a.numpy() - b).max()) for a, b in zip(wanted, found, strict=True))
        if off > TOLERANCE:
            raise ExportError(f"onnxruntime and torch differ by {off:.4f}: {file}. Do not use this file")
