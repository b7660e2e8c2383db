"""Trains the LiDAR detector.

```
python -m lab.perception.training.lidar.train --data DIR --check DIR --out OUT --minutes 8
```

The numbers are ours.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from lab.perception.training.lidar.batches import WindowStore
from lab.perception.training.lidar.data import EVERY, SweepWindows, load
from lab.perception.training.lidar.evaluate import calibrated, judged, mean_average_precision, predicted, report
from lab.perception.training.lidar.loss import losses, targets
from lab.perception.training.lidar.net import WIDTHS, PillarNet, restore
from lab.perception.training.lidar.pillars import pillars
from lab.training.restore import settle
from lab.training.schedule import average
from stucksolver_perception.lidar_labels import LABELS

WARM_UP = 0.1
"""Share of the time in which the learning rate rises (one cycle; Smith and Topin 2018)."""
LEAST_RATE = 0.01
"""Learning rate at both ends, as a share of the highest."""
WEIGHT_DECAY = 0.01
"""Weight decay."""
MOST_GRADIENT = 10.0
"""Largest norm of the gradient."""
EMA_DECAY = 0.999
"""Decay of the moving average of the weights, per step."""
SAY_EVERY_S = 5.0
"""Time between two reports (s)."""
RARE_MOST = 4.0
"""Largest ratio of the drawing frequencies of windows with rare labels and of those without."""
CHECKED_IN_DRIVE = 40
"""Number of windows of each recording that are used in the check."""
SETTLED_ON = 32
"""Number of windows on which a restored network gets the statistics of its batch normalizations."""
WEIGHTS = "lidar.pt"
CARD = "training.json"
FIGURES = ("windows", "steps", "minutes", "seed", "mean_ap")
"""Fields of a training that the export copies to the shipped card."""


@dataclass(frozen=True)
class Options:
    """Options of a training run."""

    data: tuple[Path, ...]
    check: tuple[Path, ...]
    out: Path
    minutes: float = 8.0
    """Duration of training alone, without reading and checking (min)."""
    steps: int | None = None
    """Maximum number of steps."""
    seed: int = 0
    """Seed of the training."""
    batch: int = 16
    """Number of windows per step."""
    rate: float = 2e-3
    """Highest learning rate."""
    every: int = EVERY
    widths: tuple[int, int, int] = WIDTHS
    start: Path | None = None
    """A `lidar.pt` or exported `lidar.onnx` of the same widths to continue from.

    None starts with random weights.
    """
    jobs: int = os.cpu_count() or 1
    """Number of reading processes."""
    device: str = ""
    """Name of the device; if empty, a GPU if there is one."""


def train(options: Options) -> list[dict[str, float | str]]:
    """Train and check a network, and write `lidar.pt` and `training.json` to the folder `options.out`.

    Returns:
        One row for each label, see `lab.perception.training.lidar.evaluate.report`.

    Raises:
        RecordingError: A folder has no recordings.
        RestoreError: There is nothing to continue from in `options.start`.
        ValueError: The recordings hold no window.
    """
    began = time.monotonic()
    # Read before the GPU is initialized, because the reading processes are forked.
    windows = load(options.data, options.jobs, every=options.every)
    held_out = load(options.check, options.jobs, most=CHECKED_IN_DRIVE)
    _say(f"read {len(windows)} windows and {len(held_out)} for checking in {time.monotonic() - began:.0f} s")
    device = torch.device(options.device or ("cuda" if torch.cuda.is_available() else "cpu"))
    torch.manual_seed(options.seed)
    torch.backends.cudnn.benchmark = True
    torch.set_float32_matmul_precision("high")
    net = PillarNet(options.widths).to(device, memory_format=torch.channels_last)
    store = WindowStore(windows, device)
    if options.start is not None:
        _continue(net, options.start, store)
    _say(f"{sum(parameter.numel() for parameter in net.parameters()) / 1e6:.2f} million weights on {device}")
    averaged, steps = _fit(net, store, torch.from_numpy(drawn_how_often(windows)).to(device), options)
    # Write before the check, which takes long and might be interrupted.
    options.out.mkdir(parents=True, exist_ok=True)
    weights = {name: value.cpu() for name, value in averaged.state_dict().items()}
    torch.save({"weights": weights, "widths": options.widths}, options.out / WEIGHTS)
    card: dict[str, Any] = {
        "windows": len(windows),
        "steps": steps,
        "seed": options.seed,
        "minutes": options.minutes,
        "mean_ap": None,
    }
    _write(card, options.out)
    del store
    scored = judged(found := predicted(averaged, held := WindowStore(held_out, device)), held)
    rows = report(scored)
    for row in rows:
        _say("  ".join(f"{key} {value}" for key, value in row.items()))
    mean = mean_average_precision(scored)
    _say(f"mean AP at 2 m {mean:.4f} in {len(found)} windows after {steps} steps, {time.monotonic() - began:.0f} s")
    card |= {"labels": LABELS, "calibration": asdict(calibrated(scored)), "mean_ap": mean, "check": rows}
    _write(card | {"checked": len(found)}, options.out)
    return rows


def _continue(net: PillarNet, start: Path, store: WindowStore) -> None:
    """Give the network the weights of an earlier training."""
    if start.suffix != ".onnx":
        weights = torch.load(start, map_location=store.device, weights_only=True)["weights"]
        net.load_state_dict(weights)
        return
    net.load_state_dict(restore(start).state_dict())
    some = torch.linspace(0, len(store) - 1, min(SETTLED_ON, len(store)), device=store.device).long()
    batch = store.batch(some, vary=False)
    settle(net, lambda: net(*pillars(batch.points, batch.window), len(some)))


def drawn_how_often(windows: SweepWindows) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Return (windows,): sampling weights, higher for windows with rare labels."""
    shown = np.array([[(labels == label).any() for label in range(len(LABELS))] for labels in windows.labels])
    rarity = np.sqrt(1.0 / np.maximum(shown.mean(axis=0), 1e-3))
    return np.asarray(np.clip((shown * rarity).max(axis=1), 1.0, RARE_MOST))


def _fit(net: PillarNet, store: WindowStore, how_often: Tensor, options: Options) -> tuple[PillarNet, int]:
    """Return the network with weights averaged over the steps, and the number of steps."""
    device = store.device
    decayed = [parameter for parameter in net.parameters() if parameter.ndim > 1]
    rest = [parameter for parameter in net.parameters() if parameter.ndim <= 1]
    groups = [{"params": decayed, "weight_decay": WEIGHT_DECAY}, {"params": rest, "weight_decay": 0.0}]
    optimizer = torch.optim.AdamW(groups, lr=options.rate)
    averaged = PillarNet(options.widths).to(device)
    averaged.load_state_dict(net.state_dict())
    net.train()
    began = reported_s = time.monotonic()
    running = torch.zeros(2, device=device)
    step, since = 0, 0
    while True:
        share = _share(began, step, options)
        if share >= 1.0:
            break
        for group in optimizer.param_groups:
            group["lr"] = options.rate * one_cycle(share)
        batch = store.batch(torch.multinomial(how_often, min(options.batch, len(store))), vary=True)
        features, cell = pillars(batch.points, batch.window)
        with torch.autocast(device.type, torch.bfloat16, enabled=device.type == "cuda"):
            heat, box = net(features, cell, len(batch.boxes))
        maps, boxes = losses(heat, box, targets(batch.boxes, batch.labels))
        optimizer.zero_grad(set_to_none=True)
        (maps + boxes).backward()
        # Skip a non-finite step, which would destroy the weights.
        if torch.isfinite(nn.utils.clip_grad_norm_(net.parameters(), MOST_GRADIENT)):
            optimizer.step()
        step, since = step + 1, since + 1
        average(averaged, net, min(EMA_DECAY, step / (step + 9.0)))
        running += torch.stack([maps.detach(), boxes.detach()])
        if time.monotonic() - reported_s > SAY_EVERY_S:
            maps_mean, boxes_mean = (running / since).tolist()
            took = (time.monotonic() - reported_s) / since
            _say(f"step {step}  {100 * share:.0f} %  maps {maps_mean:.4f}  boxes {boxes_mean:.4f}  {took * 1e3:.0f} ms")
            reported_s, since = time.monotonic(), 0
            running.zero_()
    return averaged, step


def _share(began: float, step: int, options: Options) -> float:
    """Return the finished share of the training, 0 to 1."""
    by_time = (time.monotonic() - began) / (60.0 * options.minutes)
    return max(by_time, step / options.steps) if options.steps else by_time


def one_cycle(share: float) -> float:
    """Return the learning rate as a share of the highest: it rises linearly, then falls as a cosine."""
    if share < WARM_UP:
        return LEAST_RATE + (1.0 - LEAST_RATE) * share / WARM_UP
    down = (share - WARM_UP) / (1.0 - WARM_UP)
    return LEAST_RATE + (1.0 - LEAST_RATE) * (1.0 + math.cos(math.pi * down)) / 2.0


def _write(card: dict[str, Any], folder: Path) -> None:
    (folder / CARD).write_text(json.dumps(card, indent=1) + "\n", encoding="utf-8")


def _say(line: str) -> None:
    print(line, flush=True)


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path, nargs="+", required=True, help="training recordings")
    parser.add_argument("--check", type=Path, nargs="+", required=True, help="held-out recordings")
    parser.add_argument("--out", type=Path, required=True, help="folder for lidar.pt and training.json")
    parser.add_argument("--minutes", type=float, default=Options.minutes, help="duration of training alone")
    parser.add_argument("--steps", type=int, help="stop after this many steps at the latest")
    parser.add_argument("--seed", type=int, default=Options.seed)
    parser.add_argument("--batch", type=int, default=Options.batch)
    parser.add_argument("--rate", type=float, default=Options.rate, help="highest learning rate")
    parser.add_argument("--every", type=int, default=Options.every, help="ticks between the ends of two windows")
    parser.add_argument("--widths", type=int, nargs=3, default=Options.widths, help="channels of the three scales")
    parser.add_argument("--start", type=Path, help="lidar.pt or lidar.onnx to continue from")
    parser.add_argument("--jobs", type=int, default=Options.jobs, help="number of reading processes")
    parser.add_argument("--device", default=Options.device)
    options = vars(parser.parse_args(arguments))
    for name in ("data", "check", "widths"):
        options[name] = tuple(options[name])
    train(Options(**options))


if __name__ == "__main__":
    main()
