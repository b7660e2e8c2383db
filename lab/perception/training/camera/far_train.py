"""Trains the detector of far vehicles on recordings, checks it on others, and writes the files that the runtime loads.

```
python -m lab.perception.training.camera.far_train --data DIR [DIR ...] --check DIR --out OUT --minutes 4 --seed 1
```

`--data` takes ordinary drives and those of `lab.perception.recording.far_scenes`; `--check` should contain other towns.
The training uses a GPU if there is one; `--steps 20 --batch 2` is a quick trial on a CPU. `--start far.onnx` continues
from a shipped network, with a lower learning rate.

The numbers are ours.
"""

from __future__ import annotations

import argparse
import copy
import json
import math
import os
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from lab.perception.training.camera.far_data import MARGIN_ROWS, Strips, load
from lab.perception.training.camera.far_evaluate import Run, check, written
from lab.perception.training.camera.far_export import export
from lab.perception.training.camera.far_net import WIDTHS, ExportedFarNet, FarNet, loss_of, restored, scaled
from lab.training.restore import settle
from lab.training.schedule import average
from stucksolver_perception.camera.horizon_strip import STRIP_ROWS
from stucksolver_perception.measurements import Pixels

CROP_WIDTH = 800
"""Width of a crop in training (px): half the strip's width, so that a batch holds more images."""
TOP_RATE = 3e-3
"""Highest learning rate of the one cycle (Smith, Topin 2019)."""
FURTHER = 0.3
"""Highest learning rate of a further training, relative to that."""
SETTLED = 64
"""Number of half strips on which a restored network gets the statistics of its batch normalizations."""
WARM_UP = 0.1
"""Share of the time in which the rate rises."""
DECAY = 1e-4
"""Weight decay."""
AVERAGED = 0.998
"""Decay of the moving average of the weights: about the last 1 / (1 - this) steps are averaged and shipped."""
COLOR, LIGHT = 0.1, 0.2
"""Standard deviations of the log gain of each color channel and of the overall brightness."""
HAZE = 0.06
"""Standard deviation of the offset of all pixels, as a share of the mean brightness."""
NOISE = 1.5
"""Highest standard deviation of the pixel noise (gray levels). An unlit car at night has a contrast of five."""
SAY_EVERY_S = 5.0
"""Time between two reports (s)."""
FAR_M = 60.0
"""Distance beyond which a visible actor makes an image drawn twice as often (m)."""


def train(
    strips: Strips,
    device: torch.device,
    *,
    minutes: float,
    steps: int | None,
    batch: int,
    seed: int,
    widths: tuple[int, int, int] = WIDTHS,
    begun: FarNet | None = None,
) -> FarNet:
    """Train for a number of minutes, or of steps, and return the network.

    `begun`: a network to train further.
    """
    torch.manual_seed(seed)
    net = (begun or FarNet(*widths)).to(device, memory_format=torch.channels_last)
    top_rate = TOP_RATE if begun is None else FURTHER * TOP_RATE
    if begun is not None:
        some = _Batches(strips, device, SETTLED, seed)
        settle(net, lambda: net(some.draw()[0]))
    averaged: FarNet = copy.deepcopy(net)
    optimizer = torch.optim.AdamW(net.parameters(), lr=top_rate, weight_decay=DECAY)
    batches = _Batches(strips, device, batch, seed)
    start, reported_s, step = time.monotonic(), 0.0, 0
    on_gpu = device.type == "cuda"
    while True:
        passed = time.monotonic() - start
        share = step / steps if steps is not None else passed / (60.0 * minutes)
        if share >= 1.0:
            break
        for group in optimizer.param_groups:
            group["lr"] = top_rate * _rate(share)
        pixels, boxes, shift = batches.draw()
        with torch.autocast(device.type, torch.bfloat16, enabled=on_gpu):
            raw = net(pixels)
        loss = loss_of(raw.float(), boxes, shift)
        optimizer.zero_grad(set_to_none=True)
        loss.backward()
        torch.nn.utils.clip_grad_norm_(net.parameters(), 10.0)
        optimizer.step()
        step += 1
        average(averaged, net, min(AVERAGED, step / (step + 10.0)))
        if passed - reported_s >= SAY_EVERY_S:
            reported_s = passed
            print(f"{passed:6.0f} s  step {step}  loss {loss.item():.3f}", flush=True)
    print(f"trained {step} steps of {batch} half strips in {time.monotonic() - start:.0f} s", flush=True)
    averaged.eval()
    return averaged


class _Batches:
    """Draws half strips with their boxes, and augments them by the variation of cameras and light."""

    def __init__(self, strips: Strips, device: torch.device, batch: int, seed: int) -> None:
        self._random, self._batch, self._device = np.random.default_rng(seed), batch, device
        self._rgb = torch.from_numpy(strips.rgb).to(device)
        self._boxes = torch.from_numpy(strips.boxes).to(device)
        self._top = torch.from_numpy(strips.top).to(device)
        far = np.nan_to_num(strips.boxes[..., 6], nan=0.0, posinf=0.0) > FAR_M
        chances = 1.0 + ((strips.boxes[..., 0] >= 0) & far).any(axis=1)
        self._chances = chances / chances.sum()

    def draw(self) -> tuple[Tensor, Tensor, Tensor]:
        """Return pixels (n, 3, rows, width), boxes (n, m, 10), and column and row of each crop's start (n, 2).

        Pixels are scaled.
        """
        random, n, device = self._random, self._batch, self._device
        which = torch.from_numpy(random.choice(len(self._rgb), n, p=self._chances)).to(device)
        down = random.integers(0, 2 * MARGIN_ROWS + 1, n)
        width = self._rgb.shape[2]
        across = random.integers(0, max(width - CROP_WIDTH, 0) + 1, n)
        rows = torch.from_numpy(down[:, None] + np.arange(STRIP_ROWS)).to(device)
        columns = torch.from_numpy(across[:, None] + np.arange(min(CROP_WIDTH, width))).to(device)
        pixels = self._rgb[which[:, None, None], rows[:, :, None], columns[:, None, :]].permute(0, 3, 1, 2).float()
        boxes = self._boxes[which].clone()
        left = torch.from_numpy(across).to(device).float()
        top = self._top[which].float() + torch.from_numpy(down).to(device).float()
        turned = torch.from_numpy(random.random(n) < 0.5).to(device)
        pixels = torch.where(turned[:, None, None, None], pixels.flip(3), pixels)
        other = 2.0 * left[:, None] + pixels.shape[3]
        boxes[..., 1], boxes[..., 3] = (
            torch.where(turned[:, None], other - boxes[..., 3], boxes[..., 1]),
            torch.where(turned[:, None], other - boxes[..., 1], boxes[..., 3]),
        )
        return scaled(self._changed(pixels)), boxes, torch.stack([left, top], 1)

    def _changed(self, pixels: Tensor) -> Tensor:
        """Change brightness and colors, and add noise. Gain and offset follow the light: night stays readable."""
        n, device = len(pixels), self._device
        gain = torch.exp(
            COLOR * torch.randn(n, 3, 1, 1, device=device) + LIGHT * torch.randn(n, 1, 1, 1, device=device)
        )
        offset = HAZE * torch.randn(n, 1, 1, 1, device=device) * pixels.mean(dim=(1, 2, 3), keepdim=True)
        noise = NOISE * torch.rand(n, 1, 1, 1, device=device)
        return (pixels * gain + offset + noise * torch.randn_like(pixels)).clamp(0.0, 255.0)


def outputs_of(net: FarNet, device: torch.device) -> Run:
    """Return the network in the form for `far_evaluate.check`."""
    shipped = ExportedFarNet(net.to(device)).eval()

    def run(strip: Pixels) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        with torch.no_grad():
            peaks, rest = (item[0].float().cpu().numpy() for item in shipped(torch.from_numpy(strip[None]).to(device)))
        return peaks, rest

    return run


def _rate(share: float) -> float:
    """Return the learning rate at a share of the time, relative to its highest value."""
    if share < WARM_UP:
        return 0.05 + 0.95 * share / WARM_UP
    return max(0.5 * (1.0 + math.cos(math.pi * (share - WARM_UP) / (1.0 - WARM_UP))), 0.002)


def main(arguments: Sequence[str] | None = None) -> int:
    """Train, check and export a network."""
    parser = argparse.ArgumentParser(description="Train the detector of far vehicles.")
    parser.add_argument("--data", type=Path, nargs="+", required=True, help="folders of recordings to train on")
    parser.add_argument("--check", type=Path, nargs="+", required=True, help="folders of recordings to check on")
    parser.add_argument("--out", type=Path, required=True, help="output folder for far.onnx, far.json and far-check.md")
    parser.add_argument("--minutes", type=float, default=4.0, help="duration of training, without reading and checking")
    parser.add_argument("--steps", type=int, help="number of steps, instead of minutes")
    parser.add_argument("--batch", type=int, default=64)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--widths", type=int, nargs=3, default=WIDTHS, help="channels of the three scales")
    parser.add_argument("--start", type=Path, help="far.onnx to continue from, instead of from nothing")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    args = parser.parse_args(arguments)
    device = torch.device("cuda" if torch.cuda.is_available() else "cpu")
    began = time.monotonic()
    strips, held_out = load(args.data, args.jobs), load(args.check, args.jobs)
    print(f"{len(strips)} and {len(held_out)} images, read in {time.monotonic() - began:.0f} s; {device}", flush=True)
    options = {"minutes": args.minutes, "steps": args.steps, "batch": args.batch, "seed": args.seed}
    begun = None if args.start is None else restored(args.start)
    net = train(strips, device, **options, widths=tuple(args.widths), begun=begun)
    card = check(outputs_of(net, device), held_out)
    widths = list(args.widths if begun is None else begun.widths)
    card |= {"seed": args.seed, "minutes": args.minutes, "widths": widths, "pictures": len(strips)}
    card |= {"checked_on": sorted({town for town, _ in held_out.about})}
    args.out.mkdir(parents=True, exist_ok=True)
    card = export(net.cpu(), args.out, card, held_out)
    text = written(card)
    (args.out / "far-check.md").write_text(text, encoding="utf-8")
    print(text)
    print(json.dumps({name: card[name] for name in ("threshold", "sha256")}))
    return 0


if __name__ == "__main__":
    sys.exit(main())
