"""Batches of examples as tensors; in training with noise of age and position, and with missing objects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from lab.language.student.data import Example
from lab.language.student.net import KINDS
from stucksolver_language.student.feature_encoding import MOST, SLOTS, Floats

NOISE = 0.08
"""Standard deviation of the noise on measured numbers. Ours.

It is about 0.2 s in 2 s, 0.2 m at 2 m, 2 m at 20 m.
"""
DROPPED = 0.1
"""Share of the objects and lanes that are missing. Ours."""
UNSEEN = 0.1
"""Share of the objects with only kind and position: their stopped time is 0 and unknown. Ours."""
MOST_PLANS = 48
"""Maximum number of plans of one example in one step. Ours."""


@dataclass(frozen=True)
class ExampleBatch:
    """Examples as tensors; the first axis is the batch. See `Example` for the labels."""

    rows: dict[str, Tensor]
    mask: Tensor
    plans: Tensor
    named: Tensor
    ends: Tensor
    cause: Tensor
    hold: Tensor
    intents: Tensor
    accepted: Tensor
    value: Tensor
    fitting: Tensor
    real: Tensor
    """True where there is a plan (batch, plans)."""


def batch_of(examples: Sequence[Example], rng: np.random.Generator | None = None) -> ExampleBatch:
    """Return examples as tensors.

    Args:
        examples: The examples.
        rng: Source of noise; None for the numbers as they are, with all plans.
    """
    chosen = [_chosen(example, rng) for example in examples]
    most = max((len(keep) for keep in chosen), default=0) or 1
    width = examples[0].plans.shape[-1]
    plans = np.zeros((len(examples), most, SLOTS, width), np.float32)
    named = np.full((len(examples), most, SLOTS), MOST["objects"], np.int64)
    accepted = np.full((len(examples), most), -1, np.int64)
    value = np.full((len(examples), most), np.nan, np.float32)
    fitting = np.zeros((len(examples), most), np.bool_)
    for number, (example, keep) in enumerate(zip(examples, chosen, strict=True)):
        count = len(keep)
        plans[number, :count], named[number, :count] = example.plans[keep], example.named[keep]
        accepted[number, :count], value[number, :count] = example.accepted[keep], example.value[keep]
        fitting[number, :count] = example.fitting[keep]
    rows = {kind: np.stack([example.scene.rows[kind] for example in examples]) for kind in KINDS}
    mask = np.stack([example.scene.mask for example in examples])
    if rng is not None:
        rows, mask = _noisy(rows, mask, rng)
    as_tensor = torch.from_numpy
    return ExampleBatch(
        rows={kind: as_tensor(table) for kind, table in rows.items()},
        mask=as_tensor(mask),
        plans=as_tensor(plans),
        named=as_tensor(named),
        ends=as_tensor(np.stack([example.ends for example in examples])),
        cause=torch.tensor([example.cause for example in examples]),
        hold=torch.tensor([example.hold for example in examples]),
        intents=as_tensor(np.stack([example.intents for example in examples])),
        accepted=as_tensor(accepted),
        value=as_tensor(value),
        fitting=as_tensor(fitting),
        real=as_tensor(np.arange(most) < np.array([[len(keep)] for keep in chosen])),
    )


def _chosen(example: Example, rng: np.random.Generator | None) -> NDArray[np.int64]:
    """Return the used plans of an example: all that the guard accepts or that fit, and some others."""
    count = len(example.accepted)
    if rng is None or count <= MOST_PLANS:
        return np.arange(count)
    first = (example.accepted == 1) | example.fitting
    order = np.lexsort((rng.random(count), ~first))
    return np.sort(order[:MOST_PLANS])


def _noisy(
    rows: dict[str, Floats], mask: NDArray[np.bool_], rng: np.random.Generator
) -> tuple[dict[str, Floats], NDArray[np.bool_]]:
    """Return rows and mask with noise. Numbers that are exactly 0, 1 or -1 are codes, and stay."""
    found = {}
    for kind, table in rows.items():
        measured = ~np.isin(table, (0.0, 1.0, -1.0))
        noise = rng.normal(0.0, NOISE, table.shape).astype(np.float32) * np.maximum(np.abs(table), 0.3)
        found[kind] = table + np.where(measured, noise, 0.0).astype(np.float32)
    missing = rng.random(mask.shape) < DROPPED
    missing[:, 0] = False
    unseen = rng.random(found["objects"].shape[:2]) < UNSEEN
    found["objects"][..., AGES][unseen] = 0.0
    return found, mask & ~missing


AGES = slice(-13, -7)
"""Columns of an object's row with the times for which it has been visible, stopped and not moved."""
