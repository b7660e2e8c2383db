"""Exports a trained network for shipping.

```
python -m lab.perception.training.lidar.export --run OUT --check DIR
```

The numbers are ours.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import torch

from lab.perception.training.lidar.batches import WindowStore
from lab.perception.training.lidar.data import load
from lab.perception.training.lidar.evaluate import (
    RAW,
    ScoredDetections,
    calibrated,
    judged,
    mean_average_precision,
    report,
)
from lab.perception.training.lidar.net import ExportedPillarNet, PillarNet
from lab.perception.training.lidar.quantize import quantise
from lab.perception.training.lidar.train import CARD as TRAINING
from lab.perception.training.lidar.train import FIGURES
from lab.perception.training.lidar.train import WEIGHTS as TRAINED
from stucksolver_perception.lidar.decode import decode
from stucksolver_perception.lidar.detector import CARD, DATA, VERSION, WEIGHTS
from stucksolver_perception.lidar.pillars import FEATURES, occupied, pillars
from stucksolver_perception.lidar_labels import LABELS

OPSET = 18
"""Version of the ONNX operator set."""
AVERAGED = "averaged"
"""Field in the card of the mean of two networks: the weight of the second (`lab.perception.training.lidar.average`)."""
INPUTS = ("features", "slot", "occupied")
OUTPUTS = ("logit", "label", "place", "regressed")
CLOSE = 1e-2
"""Largest allowed difference between the exported and the trained network, in logits and regressed values."""
COMPARED = 20
"""Number of windows on which the two are compared."""
CHECKED_IN_DRIVE = 20
"""Windows of each recording for the calibration."""
RANGES_IN_DRIVE = 4
"""Number of windows of each recording that set the integer ranges."""
MOST_RANGES = 48
"""Maximum number of windows that set the integer ranges."""
MOST_LOST = 0.02
"""Largest allowed loss of mean AP by quantization."""


class ExportError(RuntimeError):
    """The exported network is not as good as the trained one."""


def export(run: Path, check: Sequence[Path], to: Path = DATA, ranges: Sequence[Path] = ()) -> dict[str, Any]:
    """Write `lidar.onnx` and `card.json`.

    Args:
        run: Output folder of `lab.perception.training.lidar.train`.
        check: Held-out recordings, used to compare the networks and to calibrate the scores.
        to: Output folder.
        ranges: Recordings that set the integer ranges. If empty, the network is not quantized.

    Returns:
        The content of the card.

    Raises:
        ExportError: The exported network is not as good as the trained one.
    """
    checkpoint = torch.load(run / TRAINED, map_location="cpu", weights_only=True)
    net = PillarNet(tuple(checkpoint["widths"]))
    net.load_state_dict(checkpoint["weights"])
    shipped = ExportedPillarNet(net.eval()).eval()
    to.mkdir(parents=True, exist_ok=True)
    file, full = to / WEIGHTS, to / "full.onnx"
    _write(shipped, full)
    store = WindowStore(load(check, 1, most=CHECKED_IN_DRIVE), torch.device("cpu"))
    card_entry: dict[str, Any] = {"off_by": _difference(shipped, full, store)}
    found = _judged(full, store)
    card_entry["mean_ap_full"] = mean_average_precision(found)
    if ranges:
        quantise(full, file, _some(WindowStore(load(ranges, 1, most=RANGES_IN_DRIVE), torch.device("cpu"))))
        full.unlink()
        found = _judged(file, store)
        lost = card_entry["mean_ap_full"] - mean_average_precision(found)
        if lost > MOST_LOST:
            raise ExportError(f"quantised to integers, the mean AP falls by {lost:.3f}: {file}. Export without --int8")
    else:
        full.replace(file)
    card_entry |= {"mean_ap": mean_average_precision(found), "check": report(found), "windows": len(store)}
    card: dict[str, Any] = {"version": VERSION}
    card |= {"sha256": hashlib.sha256(file.read_bytes()).hexdigest(), "labels": LABELS}
    card |= {"grid": asdict(net.grid), **asdict(calibrated(found)), "int8": bool(ranges), "shipped": card_entry}
    trained = json.loads((run / TRAINING).read_text(encoding="utf-8"))
    card["trained"] = {"widths": checkpoint["widths"]} | {key: trained[key] for key in FIGURES}
    if AVERAGED in trained:
        card["trained"][AVERAGED] = trained[AVERAGED]
    (to / CARD).write_text(json.dumps(card, indent=1) + "\n", encoding="utf-8")
    return card


def _write(shipped: ExportedPillarNet, file: Path) -> None:
    with warnings.catch_warnings():
        # Torch recommends its newer exporter, which does not support ScatterND with a maximum.
        warnings.simplefilter("ignore")
        torch.onnx.export(
            shipped,
            (torch.zeros(100, FEATURES), torch.arange(100), torch.arange(25)),
            str(file),
            opset_version=OPSET,
            dynamo=False,
            input_names=list(INPUTS),
            output_names=list(OUTPUTS),
            dynamic_axes={"features": {0: "points"}, "slot": {0: "points"}, "occupied": {0: "cells"}},
        )


def _fed(store: WindowStore, window: int) -> dict[str, Any]:
    features, cell = pillars(store.batch(torch.tensor([window]), vary=False).points.numpy())
    return dict(zip(INPUTS, (features, *occupied(cell)), strict=True))


def _some(store: WindowStore) -> Iterator[dict[str, Any]]:
    chosen = np.linspace(0, len(store) - 1, min(MOST_RANGES, len(store))).astype(int).tolist()
    return (_fed(store, window) for window in chosen)


def _session(file: Path) -> Any:
    import onnxruntime

    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = 1  # with more threads, points are lost at random, see `LidarDetector`
    return onnxruntime.InferenceSession(str(file), options, providers=["CPUExecutionProvider"])


def _judged(file: Path, store: WindowStore) -> list[ScoredDetections]:
    session = _session(file)
    outputs = [session.run(None, _fed(store, i)) for i in range(len(store))]
    return judged([decode(logit, label, place, values, 0.0, RAW) for logit, label, place, values in outputs], store)


def _difference(shipped: ExportedPillarNet, file: Path, store: WindowStore) -> float:
    session = _session(file)
    worst = 0.0
    for i in np.linspace(0, len(store) - 1, min(COMPARED, len(store))).astype(int).tolist():
        fed = _fed(store, i)
        with torch.no_grad():
            expected = [item.numpy() for item in shipped(*map(torch.from_numpy, fed.values()))]
        got = session.run(None, fed)
        worst = max(worst, float(np.abs(expected[0] - got[0]).max()), _box_difference(expected, got))
    if not worst < CLOSE:
        raise ExportError(f"the exported network is off by {worst:.2g}, allowed is {CLOSE}: {file}. Do not ship it")
    return worst


def _box_difference(expected: Sequence[Any], got: Sequence[Any]) -> float:
    """Return the largest box difference over the stronger half, matched by label and cell.

    Equal logits may come in any order.
    """
    places = {place: i for i, place in enumerate(zip(got[1].tolist(), got[2].tolist(), strict=True))}
    half = list(zip(expected[1].tolist(), expected[2].tolist(), strict=True))[: len(expected[0]) // 2]
    pairs = [(i, places[place]) for i, place in enumerate(half) if place in places]
    if len(pairs) < 0.9 * len(half):
        return float("inf")
    ours, theirs = (list(pair) for pair in zip(*pairs, strict=True))
    return float(np.abs(expected[3][ours] - got[3][theirs]).max())


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--run", type=Path, required=True, help="output folder of the training")
    parser.add_argument("--check", type=Path, nargs="+", required=True, help="held-out recordings")
    parser.add_argument("--out", type=Path, default=DATA, help="folder for lidar.onnx and card.json")
    parser.add_argument("--int8", type=Path, nargs="+", default=[], help="recordings that set the integer ranges")
    options = parser.parse_args(arguments)
    shipped = export(options.run, options.check, options.out, options.int8)["shipped"]
    size_mb = (options.out / WEIGHTS).stat().st_size / 1e6
    print(f"{options.out / WEIGHTS}: {size_mb:.1f} MB, off by at most {shipped['off_by']:.2g} before quantisation")
    print(f"mean AP at 2 m {shipped['mean_ap']:.4f} of {shipped['mean_ap_full']:.4f} in {shipped['windows']} windows")


if __name__ == "__main__":
    main()
