"""Trains the crop network.

```
python -m lab.perception.training.camera.crops_train --data DIR --check DIR --out OUT
```

It reads all crops of the recordings, trains for a given time on a GPU or the CPU, calibrates on the check recordings,
scores each half of them with the calibration of the other half, and writes `crops.onnx`, `crops.json` (the card) and
`crops_scores.json` to OUT.

The numbers are ours.
"""

from __future__ import annotations

import argparse
import copy
import json
import os
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.nn import functional

from lab.perception.training.camera.crops_data import Crops, crops_in
from lab.perception.training.camera.crops_evaluate import Logits, cross_check, report
from lab.perception.training.camera.crops_export import export
from lab.perception.training.camera.crops_net import CropNet, augmented, middle, restored
from lab.training.restore import settle
from lab.training.schedule import average, rate
from stucksolver_perception.camera.crop_network import HEADS, LAMP_ANSWERS
from stucksolver_perception.measurements import Floats

MOST_CROPS = 250_000
"""Maximum number of crops by default (about 7 GB); more are subsampled."""
RARE = 0.65
"""Classes are drawn in proportion to count ** (1 - this)."""
LIT = 3.0
"""Factor by which crops with a lit lamp or an open door are drawn more often."""
PEAK_RATE = 2e-3
"""Largest learning rate."""
WEIGHT_DECAY = 0.02
"""Weight decay."""
WARM_UP = 0.05
"""Share of the steps in which the rate rises to its peak."""
AVERAGED = 0.998
"""Decay of the moving average of the weights, per step."""
REPORT_S = 5.0
"""Time between two reports (s)."""


@dataclass(frozen=True)
class CropsTrainOptions:
    """Options of a training run."""

    out: Path
    minutes: float
    """Duration of training, without reading and scoring (min)."""
    seed: int = 1
    """Seed of the training."""
    batch: int = 512
    """Number of crops per step."""
    steps: int | None = None
    """Maximum number of steps, even if time is left."""
    jobs: int = 1
    """Number of reading processes."""
    device: str = "cpu"
    start: Path | None = None
    """An exported network to start from; random weights if None."""
    peak_rate: float = PEAK_RATE
    most: int = MOST_CROPS
    """Maximum number of crops to train on; more are subsampled."""


def train(data: Sequence[Path], check: Sequence[Path], settings: CropsTrainOptions) -> dict[str, object]:
    """Train, export and score a network, and return the card.

    Each folder of `data` is drawn from equally often, however much it contains.

    Raises:
        RecordingError: A folder has no recordings.
        ValueError: The recordings contain no crops.
    """
    torch.manual_seed(settings.seed)
    start = time.monotonic()
    parts = [crops_in([folder], settings.jobs, settings.seed) for folder in data]
    weights = np.concatenate([shares_of(part) for part in parts])
    taught = Crops.joined(parts)
    del parts
    held = crops_in(check, settings.jobs, settings.seed)
    print(f"{len(taught)} crops to train on, {len(held)} to check on, read in {time.monotonic() - start:.0f} s")
    if not len(taught) or not len(held):
        raise ValueError("no crops in the recordings. They need images with instance masks")
    net = fit(taught, weights, settings)
    logits = logits_of(net, held)
    card, scores = cross_check(logits, held)
    print(report(scores))
    settings.out.mkdir(parents=True, exist_ok=True)
    (settings.out / "crops_scores.json").write_text(json.dumps(scores, indent=1) + "\n", encoding="utf-8")
    card["trained"] = {
        "crops": len(taught),
        "check_crops": len(held),
        "minutes": settings.minutes,
        "seed": settings.seed,
    }
    return export(net, settings.out, card, held)


def fit(taught: Crops, shares: Floats, settings: CropsTrainOptions) -> CropNet:
    """Return the trained network with averaged weights, on the CPU. Crops are drawn in proportion to `shares` (n,)."""
    device = torch.device(settings.device)
    net = (CropNet() if settings.start is None else restored(settings.start)).to(device).train()
    taught, shares = _thinned(taught, shares, settings)
    stored, features, kind, lamps, light, gesture, weights = (
        torch.from_numpy(row).to(device)
        for row in (taught.crops, taught.features, taught.kind, taught.lamps, taught.light, taught.gesture, shares)
    )
    if settings.start is not None:
        some = torch.multinomial(weights, settings.batch, replacement=True)
        settle(net, lambda: net(middle(stored[some]), features[some]))
    optimizer = torch.optim.AdamW(net.parameters(), settings.peak_rate, weight_decay=WEIGHT_DECAY)
    averaged: CropNet = copy.deepcopy(net).eval()
    start, reported_s, step, losses = time.monotonic(), 0.0, 0, torch.zeros(len(HEADS), device=device)
    while True:
        spent = time.monotonic() - start
        done = max(spent / (60.0 * settings.minutes), step / settings.steps if settings.steps else 0.0)
        if done >= 1.0:
            break
        for group in optimizer.param_groups:
            group["lr"] = settings.peak_rate * rate(done, WARM_UP)
        drawn = torch.multinomial(weights, settings.batch, replacement=True)
        pictures, known, lit = augmented(stored[drawn], features[drawn], lamps[drawn])
        with torch.autocast(device.type, torch.bfloat16, enabled=device.type == "cuda"):
            outputs = net(pictures, known)
        parts = losses_of(outputs, kind[drawn], lit, light[drawn], gesture[drawn])
        optimizer.zero_grad(set_to_none=True)
        parts.sum().backward()
        optimizer.step()
        step += 1
        average(averaged, net, min(AVERAGED, step / (step + 10.0)))
        losses = torch.lerp(parts.detach(), losses, 0.95 if step > 1 else 0.0)
        if spent - reported_s >= REPORT_S:
            reported_s = spent
            each = " ".join(f"{head} {float(item):.3f}" for head, item in zip(HEADS, losses, strict=True))
            print(f"{spent:5.0f} s, step {step}: {each}", flush=True)
    averaged.cpu().eval()
    return averaged


def losses_of(outputs: Sequence[Tensor], kind: Tensor, lamps: Tensor, light: Tensor, gesture: Tensor) -> Tensor:
    """Return (4,): the cross entropy of each head, over labels that are not -1."""
    lamp_logits = outputs[1].reshape(-1, len(LAMP_ANSWERS))
    pairs = ((outputs[0], kind), (lamp_logits, lamps.reshape(-1)), (outputs[2], light), (outputs[3], gesture))
    sums = [functional.cross_entropy(pair.float(), label, ignore_index=-1, reduction="sum") for pair, label in pairs]
    counts = [(label >= 0).sum().clamp(min=1) for _, label in pairs]
    return torch.stack([total / count for total, count in zip(sums, counts, strict=True)])


def shares_of(crops: Crops) -> Floats:
    """Return how often each crop is drawn.

    Crops with a rare kind or light state, or a lit lamp, are drawn more often. The sum is 1.
    """
    if not len(crops):
        return np.zeros(0)
    names = np.where(crops.kind >= 0, crops.kind, np.where(crops.light >= 0, 100 + crops.light, 200))
    _, place, counts = np.unique(names, return_inverse=True, return_counts=True)
    weights = counts[place].astype(np.float64) ** -RARE
    weights *= np.where((crops.lamps == 1).any(axis=1), LIT, 1.0)
    return np.asarray(weights / weights.sum())


def logits_of(net: CropNet, crops: Crops) -> Logits:
    """Return the network's outputs for crops, cut in the same way as at runtime."""
    parts: list[list[NDArray[np.float64]]] = []
    with torch.no_grad():
        for start in range(0, len(crops), 512):
            span = slice(start, start + 512)
            outputs = net(middle(torch.from_numpy(crops.crops[span])), torch.from_numpy(crops.features[span]))
            parts.append([output.double().numpy() for output in outputs])
    return Logits.from_outputs([np.concatenate(part) for part in zip(*parts, strict=True)])


def _thinned(crops: Crops, shares: Floats, settings: CropsTrainOptions) -> tuple[Crops, Floats]:
    if len(crops) <= settings.most:
        return crops, shares
    chosen = torch.multinomial(torch.from_numpy(shares), settings.most, replacement=False).sort().values.numpy()
    return crops.subset(chosen), shares[chosen]


def main() -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(description="train the crop network on recordings")
    folders = "folders of training recordings; each is drawn from equally often"
    parser.add_argument("--data", type=Path, nargs="+", required=True, help=folders)
    parser.add_argument("--check", type=Path, nargs="+", required=True, help="folders of held-out recordings")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--minutes", type=float, default=4.0, help="duration of training")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--batch", type=int, default=512)
    parser.add_argument("--steps", type=int, help="stop after this many steps at the latest")
    parser.add_argument("--most", type=int, default=MOST_CROPS, help="maximum number of crops to train on")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="number of reading processes")
    parser.add_argument("--start", type=Path, help="a network to start from, such as the shipped crops.onnx")
    parser.add_argument("--rate", type=float, default=PEAK_RATE, help="largest learning rate")
    options = parser.parse_args()
    device = "cuda" if torch.cuda.is_available() else "cpu"
    settings = CropsTrainOptions(
        options.out,
        options.minutes,
        options.seed,
        options.batch,
        options.steps,
        options.jobs,
        device,
        start=options.start,
        peak_rate=options.rate,
        most=options.most,
    )
    train(options.data, options.check, settings)


if __name__ == "__main__":
    main()
