"""Trains the head for gestures of a crop network, and no other part.

```
python -m lab.perception.training.camera.gesture_head_train --start crops.onnx --data DIR --check DIR --out OUT
```

Since the rest of the network is unchanged, only its outputs for the flaggers' crops are required. Each crop is
augmented a few times and passes through the network once; the head learns from the outputs within a minute on a CPU.
The head is calibrated on the check recordings, and each half of them is scored with the calibration of the other half.
The command writes `crops.onnx` and `crops.json` to OUT; all outputs but the gestures are unchanged.

The numbers are ours.
"""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from lab.perception.training.camera.crops_data import Crops, crops_in
from lab.perception.training.camera.crops_evaluate import cross_check, report
from lab.perception.training.camera.crops_export import export
from lab.perception.training.camera.crops_net import CropNet, augmented, restored
from lab.perception.training.camera.crops_train import PEAK_RATE, RARE, WARM_UP, WEIGHT_DECAY, logits_of
from lab.training.schedule import rate

AT_ONCE = 128
"""Number of crops that pass through the trunk together."""
BATCH = 512
"""Number of crops of a step."""
SMOOTHED = 0.02
"""Label smoothing: the gesture of a flagger in the dark is never certain."""
LEAST_SPREAD = 1e-3
"""Least standard deviation of an input in its normalization."""


@dataclass(frozen=True)
class HeadSettings:
    """Options of a training of the head."""

    start: Path
    """An exported network, with its card next to it."""
    out: Path
    rounds: int = 16
    """Number of augmentations of each crop."""
    steps: int = 1500
    """Number of steps."""
    seed: int = 1
    """Seed of the training."""
    jobs: int = 1
    """Number of reading processes."""


def train(data: Sequence[Path], check: Sequence[Path], settings: HeadSettings) -> dict[str, Any]:
    """Train, export and score a head, and return the card.

    Raises:
        RestoreError: The network to start from cannot be used.
        RecordingError: A folder has no recordings.
        ValueError: The recordings contain no flaggers.
    """
    torch.manual_seed(settings.seed)
    net = restored(settings.start).eval()
    taught, held = (crops_in(folders, settings.jobs, settings.seed, flaggers=True) for folders in (data, check))
    print(f"{len(taught)} crops of flaggers to train on, {len(held)} to check on", flush=True)
    if not len(taught) or not len(held):
        raise ValueError("no flaggers in the recordings. Record some with close_scenes --gestures")
    outputs = torch.cat([_trunk_outputs(net, taught) for _ in range(settings.rounds)])
    fit(net.gesture, outputs, torch.from_numpy(np.tile(taught.gesture, settings.rounds)), settings.steps)
    card, scores = cross_check(logits_of(net, held), held)
    print(report({"gesture": scores["gesture"]}))
    card_before = json.loads(settings.start.with_suffix(".json").read_text(encoding="utf-8"))
    for part in card:
        card[part] = card_before[part] | {"gesture": card[part]["gesture"]}
    card["trained"] = card_before["trained"] | {"flaggers": len(taught), "check_flaggers": len(held)}
    settings.out.mkdir(parents=True, exist_ok=True)
    return export(net, settings.out, card, held)


def fit(head: nn.Sequential, outputs: Tensor, gestures: Tensor, steps: int) -> None:
    """Train the head.

    Args:
        head: Two linear layers with a ReLU between them.
        outputs: (n, `TRUNK_WIDTH`), of `CropNet.trunk_outputs`.
        gestures: (n,), indices into `GESTURES`.
        steps: Number of steps.
    """
    counts = torch.bincount(gestures).float()
    weights = counts[gestures] ** -RARE
    mean, spread = outputs.float().mean(dim=0), outputs.float().std(dim=0) + LEAST_SPREAD
    optimizer = torch.optim.AdamW(head.parameters(), PEAK_RATE, weight_decay=WEIGHT_DECAY)
    for step in range(steps):
        for group in optimizer.param_groups:
            group["lr"] = PEAK_RATE * rate(step / steps, WARM_UP)
        drawn = torch.multinomial(weights, BATCH, replacement=True)
        logits = head((outputs[drawn].float() - mean) / spread)
        loss = functional.cross_entropy(logits, gestures[drawn], label_smoothing=SMOOTHED)
        optimizer.zero_grad(set_to_none=True)
        loss.backward()  # type: ignore[no-untyped-call]
        optimizer.step()
    # Merge this normalization into the head: from now on its input has none.
    first = head[0]
    assert isinstance(first, nn.Linear)
    with torch.no_grad():
        first.weight /= spread
        first.bias -= first.weight @ mean


def _trunk_outputs(net: CropNet, crops: Crops) -> Tensor:
    """Return the outputs of the trunk for the crops, augmented at random."""
    found = []
    with torch.no_grad():
        for start in range(0, len(crops), AT_ONCE):
            span = slice(start, start + AT_ONCE)
            parts = (torch.from_numpy(row[span]) for row in (crops.crops, crops.features, crops.lamps))
            pictures, features, _ = augmented(*parts)
            found.append(net.trunk_outputs(pictures, features).half())
    return torch.cat(found)


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(description="train the head for gestures of a crop network")
    parser.add_argument("--start", type=Path, required=True, help="the network, such as the shipped crops.onnx")
    parser.add_argument("--data", type=Path, nargs="+", required=True, help="folders of training recordings")
    parser.add_argument("--check", type=Path, nargs="+", required=True, help="folders of held-out recordings")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--rounds", type=int, default=16, help="how often each crop is augmented")
    parser.add_argument("--steps", type=int, default=1500)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="number of reading processes")
    options = parser.parse_args(arguments)
    settings = HeadSettings(options.start, options.out, options.rounds, options.steps, options.seed, options.jobs)
    train(options.data, options.check, settings)


if __name__ == "__main__":
    main()
