"""Makes the shipped network of a trained one: `python -m stucksolver_train.lidar.export --run OUT --check DIR`."""

from __future__ import annotations

import argparse
import hashlib
import json
import warnings
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import torch

from stucksolver.perception.labels import LABELS
from stucksolver.perception.lidar.detector import CARD, DATA, VERSION, WEIGHTS
from stucksolver.perception.lidar.pillars import FEATURES, occupied, pillars
from stucksolver_train.lidar.batches import Store
from stucksolver_train.lidar.data import load
from stucksolver_train.lidar.net import PillarNet, Shipped
from stucksolver_train.lidar.train import WEIGHTS as TRAINED

OPSET = 18
INPUTS = ("features", "slot", "occupied")
CLOSE = 1e-3
"""Largest difference between the exported network and the trained one, in logits and regressed values."""
CHECKED = 20


class ExportError(RuntimeError):
    """The exported network says something else than the trained one."""


def export(run: Path, check: Sequence[Path], to: Path = DATA) -> float:
    """Writes `lidar.onnx` and `card.json`.

    Args:
        run: What `stucksolver_train.lidar.train` wrote.
        check: Recordings with which the two networks are compared.
        to: Where the files go.

    Returns:
        The largest difference found.

    Raises:
        ExportError: The two networks disagree.
    """
    kept = torch.load(run / TRAINED, map_location="cpu", weights_only=True)
    net = PillarNet(tuple(kept["widths"]))
    net.load_state_dict(kept["weights"])
    shipped = Shipped(net.eval()).eval()
    to.mkdir(parents=True, exist_ok=True)
    file = to / WEIGHTS
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        torch.onnx.export(
            shipped,
            (torch.zeros(100, FEATURES), torch.arange(100), torch.arange(25)),
            str(file),
            opset_version=OPSET,
            dynamo=False,
            input_names=list(INPUTS),
            output_names=["logit", "label", "place", "regressed"],
            dynamic_axes={"features": {0: "points"}, "slot": {0: "points"}, "occupied": {0: "cells"}},
        )
    worst = _difference(shipped, file, check)
    told: dict[str, Any] = json.loads((run / "training.json").read_text(encoding="utf-8"))
    calibration = told.pop("calibration")
    card = {"version": VERSION, "sha256": hashlib.sha256(file.read_bytes()).hexdigest(), "labels": LABELS}
    card |= {"grid": asdict(net.grid), **calibration, "widths": kept["widths"], "training": told}
    (to / CARD).write_text(json.dumps(card, indent=1) + "\n", encoding="utf-8")
    return worst


def _difference(shipped: Shipped, file: Path, check: Sequence[Path]) -> float:
    import onnxruntime

    session = onnxruntime.InferenceSession(str(file), providers=["CPUExecutionProvider"])
    windows = load(check, 1, most=CHECKED)
    store = Store(windows, torch.device("cpu"))
    worst = 0.0
    for i in np.linspace(0, len(store) - 1, min(CHECKED, len(store))).astype(int).tolist():
        features, cell = pillars(store.batch(torch.tensor([i]), vary=False).points.numpy())
        fed = dict(zip(INPUTS, (features, *occupied(cell)), strict=True))
        with torch.no_grad():
            expected = [one.numpy() for one in shipped(*map(torch.from_numpy, fed.values()))]
        got = session.run(None, fed)
        worst = max(worst, float(np.abs(expected[0] - got[0]).max()), _box_difference(expected, got))
    if not worst < CLOSE:
        raise ExportError(f"{file}: the exported network is off by {worst:.2g}, allowed is {CLOSE}")
    return worst


def _box_difference(expected: Sequence[Any], got: Sequence[Any]) -> float:
    """Of the stronger half, found by label and cell, since equal logits may come in any order."""
    places = {place: i for i, place in enumerate(zip(got[1].tolist(), got[2].tolist(), strict=True))}
    half = list(zip(expected[1].tolist(), expected[2].tolist(), strict=True))[: len(expected[0]) // 2]
    pairs = [(i, places[place]) for i, place in enumerate(half) if place in places]
    if len(pairs) < 0.9 * len(half):
        return float("inf")
    ours, theirs = (list(one) for one in zip(*pairs, strict=True))
    return float(np.abs(expected[3][ours] - got[3][theirs]).max())


def main(arguments: Sequence[str] | None = None) -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--run", type=Path, required=True, help="folder that the training wrote")
    parser.add_argument("--check", type=Path, nargs="+", required=True, help="recordings to compare with")
    parser.add_argument("--out", type=Path, default=DATA, help="folder for lidar.onnx and card.json")
    given = parser.parse_args(arguments)
    worst = export(given.run, given.check, given.out)
    size_mb = (given.out / WEIGHTS).stat().st_size / 1e6
    print(f"{given.out / WEIGHTS}: {size_mb:.1f} MB, off by at most {worst:.2g}")


if __name__ == "__main__":
    main()
