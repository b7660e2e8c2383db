"""Trains the reader on one GPU. Needs numpy and torch only, and what `training.words.encode` wrote.

    python -m training.words.train --data DIR --start FILE.npz --seed 1 --steps 6000 --out OUT

`--start`: the start model's weights as float16 arrays by their published names. Writes `weights-*.npz` (float16, in
parts of at most 15 MB) and prints accuracy on the sentences kept apart. With `--teacher DIR` larger networks
(`training.words.teacher`) are trained first, and what they make of each sentence is learnt beside its labels (Hinton et
al. 2015).
"""

from __future__ import annotations

import argparse
import copy
import math
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional as F

from training.words.model import WIDTH, Reader, start_from
from training.words.teacher import Teacher, load_start
from training.words.teacher import start_from as start_teacher

BATCH = 256
RATE = 1.5e-4
HEAD_RATE = 1e-3
WARM_STEPS = 200
AVERAGE = 0.999
"""Decay of the moving average of the weights, which is what is kept."""
HIDE_SHARE = 0.04
"""Of the word pieces, hidden at random."""
SMOOTHING = 0.05
WEIGHTS = {"intent": 1.0, "side": 0.5, "flags": 0.5, "claims": 1.0}
ALIKE = 16
"""Batches are drawn so many at a time and sorted by length."""
PART_BYTES = 15_000_000
SOFT = 2.0
"""Temperature at which the teachers' probabilities of intents are learnt."""
TAUGHT_SHARE = 0.6
"""Of the loss, by what teachers make of a sentence; the rest is by its labels."""
N_INTENTS = 16
FLAGS_AT = N_INTENTS + 3
"""Behind the intents and the sides (none, left, right) stand negated, urgent, and the claims."""


class Net(nn.Module):
    """Word vectors and reader together, as they are trained."""

    def __init__(self, words: int, logits: int, dropout: float = 0.1) -> None:
        super().__init__()
        self.words, self.reader = nn.Embedding(words, WIDTH), Reader(logits, dropout)

    def forward(self, ids: Tensor, kinds: Tensor, mask: Tensor) -> Tensor:
        logits: Tensor = self.reader(self.words(ids), kinds, mask)
        return logits


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

    def drawn(self, batch: int) -> Iterator[Tensor]:
        """Batches without end, each of sentences of like length, since the longest one sets what a batch costs."""
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
    """The fields' losses, summed with their weights."""
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
    """The same against a teacher's logits instead of labels."""
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
    """Share of right intents."""
    net.eval()
    right = 0
    device = data.parts["intent"].device
    with torch.no_grad():
        for which in torch.arange(len(data), device=device).split(512):
            b = data.batch(which)
            out = net(b["ids"], b["kinds"], b["mask"])[:, :N_INTENTS]
            right += int((out.argmax(1) == b["intent"]).sum())
    return right / max(len(data), 1)


def fit(
    net: nn.Module,
    heads: list[nn.Parameter],
    data: Data,
    dev: Data,
    options: argparse.Namespace,
    steps: int,
    rate: float,
    teachers: Sequence[nn.Module] = (),
) -> nn.Module:
    """Trains a network, and returns the moving average of its weights."""
    device = data.parts["ids"].device.type
    hidden = options.hidden
    average = copy.deepcopy(net)
    ours = {id(p) for p in heads}
    rest = [p for p in net.parameters() if id(p) not in ours]
    groups = [{"params": rest, "lr": rate, "top": rate}, {"params": heads, "lr": HEAD_RATE, "top": HEAD_RATE}]
    optimizer = torch.optim.AdamW(groups, weight_decay=0.01, betas=(0.9, 0.98))
    begun = time.monotonic()
    for step, which in zip(range(steps), data.drawn(options.batch), strict=False):
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
                said = [one(b["ids"], b["kinds"], b["mask"]) for one in teachers]
        loss = loss_of(out.float(), b)
        if said:
            wanted = torch.stack(said).float().mean(0)
            loss = TAUGHT_SHARE * taught(out.float(), wanted) + (1.0 - TAUGHT_SHARE) * loss
        optimizer.zero_grad(set_to_none=True)
        loss.backward()
        nn.utils.clip_grad_norm_(net.parameters(), 1.0)
        optimizer.step()
        decay = min(AVERAGE, (step + 1) / (step + 10))
        with torch.no_grad():
            for kept, now in zip(average.parameters(), net.parameters(), strict=True):
                kept.lerp_(now, 1.0 - decay)
        if (step + 1) % 500 == 0 or step + 1 == steps:
            took = time.monotonic() - begun
            print(
                f"step {step + 1} {took:.0f} s loss {float(loss.detach()):.3f} dev {accuracy(average, dev):.4f}",
                flush=True,
            )
    return average


def save(net: nn.Module, folder: Path) -> None:
    """All parameters as float16, in parts that stay small."""
    folder.mkdir(parents=True, exist_ok=True)
    part: dict[str, np.ndarray] = {}
    number = size = 0
    for name, value in net.state_dict().items():
        array = value.detach().cpu().numpy().astype(np.float16)
        pieces = np.array_split(array, math.ceil(array.nbytes / PART_BYTES)) if array.nbytes > PART_BYTES else [array]
        for i, piece in enumerate(pieces):
            if size and size + piece.nbytes > PART_BYTES:
                np.savez(folder / f"weights-{number}.npz", **part)  # type: ignore[arg-type]
                part, number, size = {}, number + 1, 0
            part[f"{name}#{i}"] = piece
            size += piece.nbytes
    np.savez(folder / f"weights-{number}.npz", **part)  # type: ignore[arg-type]


def load_parts(folder: Path) -> dict[str, Tensor]:
    """What `save` wrote, as float32 tensors by name."""
    found: dict[str, list[np.ndarray]] = {}
    for file in sorted(folder.glob("weights-*.npz")):
        with np.load(file) as arrays:
            for name in arrays.files:
                found.setdefault(name.rpartition("#")[0], []).append(arrays[name])
    return {name: torch.from_numpy(np.concatenate(parts).astype(np.float32)) for name, parts in found.items()}


def main() -> None:
    parser = argparse.ArgumentParser(description="Train the reader of words.")
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--start", type=Path, required=True)
    parser.add_argument("--steps", type=int, default=6000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--batch", type=int, default=BATCH)
    parser.add_argument("--rate", type=float, default=RATE)
    parser.add_argument("--hide", type=float, default=HIDE_SHARE, help="share of the word pieces hidden at random")
    parser.add_argument("--dropout", type=float, default=0.1)
    parser.add_argument("--hidden", type=int, default=103, help="the id of [MASK]")
    parser.add_argument("--teacher", type=Path, help="folder of the teachers' start weights")
    parser.add_argument("--teachers", type=int, default=1, help="so many are trained, and their logits averaged")
    parser.add_argument("--teacher-steps", type=int, default=1500)
    parser.add_argument("--teacher-rate", type=float, default=1e-4)
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args()
    torch.manual_seed(options.seed)
    device = "cuda" if torch.cuda.is_available() else "cpu"
    data, dev = Data(options.data / "train.npz", device), Data(options.data / "dev.npz", device)
    start = {name: torch.from_numpy(a.astype(np.float32)) for name, a in np.load(options.start).items()}
    net = Net(len(start["embeddings.word_embeddings.weight"]), data.logits, options.dropout)
    start_from(net.reader, net.words, start)
    heads = [*net.reader.hidden.parameters(), *net.reader.fields.parameters()]
    teachers = trained_teachers(options, data, dev, device) if options.teacher else []
    save(fit(net.to(device), heads, data, dev, options, options.steps, options.rate, teachers), options.out)


def trained_teachers(options: argparse.Namespace, data: Data, dev: Data, device: str) -> list[nn.Module]:
    """Larger networks, trained on the same sentences with seeds of their own."""
    weights, renamed = load_start(options.teacher)
    found: list[nn.Module] = []
    for number in range(options.teachers):
        torch.manual_seed(options.seed + 100 + number)
        one = Teacher(data.logits, renamed, options.dropout)
        start_teacher(one, weights)
        heads = [*one.hidden.parameters(), *one.fields.parameters()]
        kept = fit(one.to(device), heads, data, dev, options, options.teacher_steps, options.teacher_rate)
        found.append(kept.eval().requires_grad_(False))
    return found


if __name__ == "__main__":
    main()
