"""Trains the interpreter on one GPU. It requires numpy, torch and the output of `lab.language.interpreter.encode`.

```
python -m lab.language.interpreter.train --data DIR --start START --steps 1200 --rate 1e-4 --out TEACHER
python -m lab.language.interpreter.train --data DIR --teacher TEACHER --steps 2000 --out OUT
```

`START`: `start-*.npz` and `ids.npy`, see `lab.language.interpreter.model.load_start`. The teacher, a larger network, is
trained first; its outputs for each sentence are learned next to the labels (Hinton et al. 2015). The command writes
`weights-*.npz` (float16 or 4 bits, in parts of at most 15 MB) and prints the accuracy on the held-out sentences.

The numbers are ours.
"""

from __future__ import annotations

import argparse
import copy
import math
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional as F

from lab.language.interpreter.model import BLOCK, LAYERS, Net, load_start, packed, spread, start_from, take_layers

BATCH = 256
"""Number of sentences per batch."""
RATE = 1.5e-4
"""Learning rate of the encoder."""
HEAD_RATE = 1e-3
"""Learning rate of the heads."""
WARM_STEPS = 200
"""Number of steps over which the rate rises."""
AVERAGE = 0.999
"""Decay of the moving average of the weights, which is the result."""
HIDE_SHARE = 0.04
"""Share of the word pieces that is hidden at random."""
SMOOTHING = 0.05
"""Label smoothing."""
WEIGHTS = {"intent": 1.0, "side": 0.5, "flags": 0.5, "claims": 1.0}
"""Weights of the losses by field."""
ALIKE = 16
"""Number of batches that are drawn together and sorted by length."""
PART_BYTES = 15_000_000
"""Maximum size of one file (bytes)."""
SOFT = 2.0
"""Temperature at which the teacher's probabilities of intents are learned."""
TAUGHT_SHARE = 0.6
"""Share of the loss against the teacher's output; the rest is against the labels."""
N_INTENTS = 16
"""Number of intents."""
FLAGS_AT = N_INTENTS + 3
"""Position of the flags: the intents and the sides (none, left, right) precede negated, urgent, and the claims."""


class Data:
    """One file of encoded sentences on a device."""

    def __init__(self, file: Path, device: str) -> None:
        arrays = np.load(file)
        self.logits = int(arrays["logits"])
        self.parts = {
            name: torch.from_numpy(arrays[name].astype(np.int32)).to(device)
            for name in ("ids", "kinds", "length", "intent", "side", "flags", "claims")
        }

    def __len__(self) -> int:
        return len(self.parts["intent"])

    def batches(self, batch: int) -> Iterator[Tensor]:
        """Yield batches without end, each of sentences of like length, because the longest one sets the cost."""
        length = self.parts["length"]
        while True:
            some = torch.randint(len(self), (batch * ALIKE,), device=length.device)
            some = some[length[some].argsort()].view(ALIKE, batch)
            yield from some[torch.randperm(ALIKE, device=length.device)]

    def batch(self, which: Tensor) -> dict[str, Tensor]:
        b = {name: part[which] for name, part in self.parts.items()}
        longest = int(b["length"].max())
        b["ids"], b["kinds"] = b["ids"][:, :longest], b["kinds"][:, :longest]
        b["mask"] = (torch.arange(longest, device=which.device) < b["length"][:, None]).float()
        return b


def loss_of(out: Tensor, b: dict[str, Tensor]) -> Tensor:
    """Return the fields' losses, summed with their weights."""
    intents, sides = out[:, :N_INTENTS], out[:, N_INTENTS:FLAGS_AT]
    flags, claims = out[:, FLAGS_AT : FLAGS_AT + 2], out[:, FLAGS_AT + 2 :]
    loss: Tensor = (
        WEIGHTS["intent"] * F.cross_entropy(intents, b["intent"].long(), label_smoothing=SMOOTHING)
        + WEIGHTS["side"] * F.cross_entropy(sides, b["side"].long())
        + WEIGHTS["flags"] * F.binary_cross_entropy_with_logits(flags, b["flags"].float())
        + WEIGHTS["claims"] * F.binary_cross_entropy_with_logits(claims, b["claims"].float())
    )
    return loss


def taught(out: Tensor, wanted: Tensor) -> Tensor:
    """Return the same against a teacher's logits instead of labels."""
    intents, sides = slice(0, N_INTENTS), slice(N_INTENTS, FLAGS_AT)
    flags, claims = slice(FLAGS_AT, FLAGS_AT + 2), slice(FLAGS_AT + 2, None)
    soft = F.cross_entropy(out[:, intents] / SOFT, (wanted[:, intents] / SOFT).softmax(1)) * SOFT**2
    loss: Tensor = (
        WEIGHTS["intent"] * soft
        + WEIGHTS["side"] * F.cross_entropy(out[:, sides], wanted[:, sides].softmax(1))
        + WEIGHTS["flags"] * F.binary_cross_entropy_with_logits(out[:, flags], wanted[:, flags].sigmoid())
        + WEIGHTS["claims"] * F.binary_cross_entropy_with_logits(out[:, claims], wanted[:, claims].sigmoid())
    )
    return loss


def accuracy(net: nn.Module, data: Data) -> float:
    """Return the share of right intents."""
    net.eval()
    right = 0
    device = data.parts["intent"].device
    with torch.no_grad():
        for which in torch.arange(len(data), device=device).split(512):
            b = data.batch(which)
            out = net(b["ids"], b["kinds"], b["mask"])[:, :N_INTENTS]
            right += int((out.argmax(1) == b["intent"]).sum())
    return right / max(len(data), 1)


def fit(net: Net, data: Data, dev: Data, options: argparse.Namespace, teacher: nn.Module | None = None) -> Net:
    """Train a network, and return the moving average of its weights."""
    device = data.parts["ids"].device.type
    hidden, steps, rate, heads = options.hidden, options.steps, options.rate, net.heads
    average = copy.deepcopy(net)
    ours = {id(p) for p in heads}
    rest = [p for p in net.parameters() if id(p) not in ours]
    groups = [{"params": rest, "lr": rate, "top": rate}, {"params": heads, "lr": HEAD_RATE, "top": HEAD_RATE}]
    optimizer = torch.optim.AdamW(groups, weight_decay=0.01, betas=(0.9, 0.98))
    begun = time.monotonic()
    for step, which in zip(range(steps), data.batches(options.batch), strict=False):
        net.train()
        b = data.batch(which)
        hide = (torch.rand(b["ids"].shape, device=device) < options.hide) & (b["ids"] > 999)
        ids = torch.where(hide, torch.full_like(b["ids"], hidden), b["ids"])
        share = min((step + 1) / WARM_STEPS, 0.5 * (1 + math.cos(math.pi * step / steps)))
        for group in optimizer.param_groups:
            group["lr"] = group["top"] * share
        with torch.autocast(device, torch.bfloat16, enabled=device == "cuda"):
            out = net(ids, b["kinds"], b["mask"])
            with torch.no_grad():
                wanted = None if teacher is None else teacher(b["ids"], b["kinds"], b["mask"])
        loss = loss_of(out.float(), b)
        if wanted is not None:
            loss = TAUGHT_SHARE * taught(out.float(), wanted.float()) + (1.0 - TAUGHT_SHARE) * loss
        optimizer.zero_grad(set_to_none=True)
        loss.backward()
        nn.utils.clip_grad_norm_(net.parameters(), 1.0)
        optimizer.step()
        decay = min(AVERAGE, (step + 1) / (step + 10))
        with torch.no_grad():
            for averaged, now in zip(average.parameters(), net.parameters(), strict=True):
                averaged.lerp_(now, 1.0 - decay)
        if (step + 1) % 500 == 0 or step + 1 == steps:
            took = time.monotonic() - begun
            print(
                f"step {step + 1} {took:.0f} s loss {float(loss.detach()):.3f} dev {accuracy(average, dev):.4f}",
                flush=True,
            )
    return average


def save(net: Net, folder: Path) -> None:
    """Write all parameters in small parts: those of a coarse network in 4 bits, all others in float16."""
    folder.mkdir(parents=True, exist_ok=True)
    part: dict[str, np.ndarray] = {}
    number = size = 0
    for name, array in _arrays(net).items():
        pieces = np.array_split(array, math.ceil(array.nbytes / PART_BYTES)) if array.nbytes > PART_BYTES else [array]
        for i, piece in enumerate(pieces):
            if size and size + piece.nbytes > PART_BYTES:
                np.savez(folder / f"weights-{number}.npz", **part)  # type: ignore[arg-type]
                part, number, size = {}, number + 1, 0
            part[f"{name}#{i}"] = piece
            size += piece.nbytes
    np.savez(folder / f"weights-{number}.npz", **part)  # type: ignore[arg-type]


def _arrays(net: Net) -> dict[str, np.ndarray]:
    arrays: dict[str, np.ndarray] = {}
    for name, value in net.state_dict().items():
        if name in net.in_4_bits:
            arrays[f"{name}|q"], arrays[f"{name}|s"] = packed(value.cpu())
        else:
            arrays[name] = value.cpu().numpy().astype(np.float16)
    return arrays


def load_arrays(folder: Path) -> dict[str, np.ndarray]:
    """Return the stored arrays of `save`."""
    found: dict[str, list[np.ndarray]] = {}
    for file in sorted(folder.glob("weights-*.npz")):
        with np.load(file) as arrays:
            for name in arrays.files:
                found.setdefault(name.rpartition("#")[0], []).append(arrays[name])
    return {name: np.concatenate(parts) for name, parts in found.items()}


def load_parts(folder: Path) -> dict[str, Tensor]:
    """Return the parameters from `save` as float32 tensors by name."""
    arrays = load_arrays(folder)
    found: dict[str, Tensor] = {}
    for name, array in arrays.items():
        whole, _, kind = name.partition("|")
        if kind == "q":
            numbers = spread(array).reshape(len(array), -1, BLOCK) * arrays[f"{whole}|s"].astype(np.float32)[..., None]
            found[whole] = torch.from_numpy(numbers.reshape(len(array), -1))
        elif not kind:
            found[name] = torch.from_numpy(array.astype(np.float32))
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description="Train the teacher, or the reader of words.")
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--start", type=Path, help="folder of the checkpoint: trains the teacher")
    parser.add_argument("--teacher", type=Path, help="what a training of the teacher wrote: trains the reader")
    parser.add_argument("--layers", default="0,1,3,5,6,8,10,11", help="those of the teacher's layers that it keeps")
    parser.add_argument("--steps", type=int, default=1500)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--batch", type=int, default=BATCH)
    parser.add_argument("--rate", type=float, default=RATE)
    parser.add_argument("--hide", type=float, default=HIDE_SHARE, help="share of the word pieces hidden at random")
    parser.add_argument("--dropout", type=float, default=0.1)
    parser.add_argument("--hidden", type=int, default=103, help="the id of [MASK]")
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args()
    if (options.start is None) == (options.teacher is None):
        parser.error("give --start or --teacher")
    torch.manual_seed(options.seed)
    device = "cuda" if torch.cuda.is_available() else "cpu"
    data, dev = Data(options.data / "train.npz", device), Data(options.data / "dev.npz", device)
    save((teacher if options.start else reader)(options, data, dev, device), options.out)


def teacher(options: argparse.Namespace, data: Data, dev: Data, device: str) -> Net:
    """Return all layers of the checkpoint, trained on labels alone."""
    weights, renamed = load_start(options.start)
    net = Net(len(renamed), data.logits, LAYERS, coarse=False, dropout=options.dropout)
    start_from(net, weights, renamed)
    return fit(net.to(device), data, dev, options)


def reader(options: argparse.Namespace, data: Data, dev: Data, device: str) -> Net:
    """Return some of the teacher's layers, in 4 bits, trained on the teacher's outputs and the labels."""
    weights = load_parts(options.teacher)
    whole = Net(len(weights["words.weight"]), data.logits, LAYERS, coarse=False)
    whole.load_state_dict(weights)
    which = [int(k) for k in options.layers.split(",")]
    net = Net(len(weights["words.weight"]), data.logits, len(which), coarse=True, dropout=options.dropout)
    take_layers(net, whole, which)
    return fit(net.to(device), data, dev, options, whole.to(device).eval().requires_grad_(False))


if __name__ == "__main__":
    main()
