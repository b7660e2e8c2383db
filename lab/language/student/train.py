"""Trains the student: `python -m lab distill train --data DIR --out OUT`. It requires torch; a CPU is enough."""

from __future__ import annotations

import copy
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional

from lab.language.student.batches import ExampleBatch, batch_of
from lab.language.student.data import Example
from lab.language.student.net import StudentNet
from lab.training.schedule import average, rate

PEAK_RATE, WEIGHT_DECAY, WARM_UP = 2e-3, 0.05, 0.05
"""Largest learning rate, weight decay, and share of the steps over which the rate rises. Ours."""
AVERAGED = 0.998
"""Decay of the moving average of the weights, per step. Ours."""
WEIGHTS = {"hazard": 1.0, "cause": 0.3, "hold": 0.3, "intent": 0.3, "accepted": 1.0, "value": 0.3, "prior": 0.3}
"""Weight of each head's loss. Ours: the labels of the drives count more than those of the rules."""
REPORT_S = 15.0
"""Time between two reports (s)."""
Say = Callable[[str], None]


@dataclass(frozen=True)
class StudentTrainOptions:
    """Options of a training run.

    Attributes:
        minutes: Duration, without reading and scoring.
        seed: Seed of the weights, the order and the noise.
        batch: Examples in one step.
        steps: Number of steps after which the training ends even if time is left; with it a run can be
            repeated exactly.
    """

    minutes: float = 5.0
    """Duration (min). Ours."""
    seed: int = 1
    """Seed of the weights, the order and the noise."""
    batch: int = 48
    """Number of examples in one step. Ours."""
    steps: int | None = None


def fit(taught: Sequence[Example], plan_width: int, settings: StudentTrainOptions, say: Say) -> StudentNet:
    """Return the trained network with averaged weights, on the CPU.

    Args:
        taught: The examples.
        plan_width: Width of one behavior of a plan.
        settings: The options.
        say: Called with each line of progress.

    Raises:
        ValueError: There are no examples.
    """
    if not taught:
        raise ValueError("no samples to train on. Collect some first")
    torch.manual_seed(settings.seed)
    rng = np.random.default_rng(settings.seed)
    net = StudentNet(plan_width).train()
    averaged: StudentNet = copy.deepcopy(net).eval()
    optimizer = torch.optim.AdamW(net.parameters(), PEAK_RATE, weight_decay=WEIGHT_DECAY)
    weights = sampling_weights(taught)
    start, reported_s, step = time.monotonic(), 0.0, 0
    smooth = torch.zeros(len(WEIGHTS))
    while True:
        spent = time.monotonic() - start
        done = step / settings.steps if settings.steps else spent / (60.0 * settings.minutes)
        if done >= 1.0:
            break
        for group in optimizer.param_groups:
            group["lr"] = PEAK_RATE * rate(done, WARM_UP)
        drawn = rng.choice(len(taught), settings.batch, p=weights)
        parts = losses_of(net, batch_of([taught[k] for k in drawn], rng))
        optimizer.zero_grad(set_to_none=True)
        (parts * torch.tensor(list(WEIGHTS.values()))).sum().backward()
        torch.nn.utils.clip_grad_norm_(net.parameters(), 1.0)
        optimizer.step()
        step += 1
        average(averaged, net, min(AVERAGED, step / (step + 10.0)))
        smooth = torch.lerp(parts.detach(), smooth, 0.98 if step > 1 else 0.0)
        if spent - reported_s >= REPORT_S:
            reported_s = spent
            say(
                f"{spent:.0f} s, step {step}: " + " ".join(f"{k} {v:.3f}" for k, v in zip(WEIGHTS, smooth, strict=True))
            )
    return averaged


def losses_of(net: StudentNet, batch: ExampleBatch) -> Tensor:
    """Return the loss of each head in the order of `WEIGHTS` (7,)."""
    hazard, cause, hold, intent, accepted, value, prior = net(batch.rows, batch.mask, batch.plans, batch.named)
    return torch.stack(
        [
            _yes_no(hazard, batch.ends),
            _cross_entropy(cause, batch.cause),
            _cross_entropy(hold, batch.hold),
            _cross_entropy(intent.flatten(0, 1), batch.intents.flatten()),
            _yes_no(accepted, batch.accepted),
            _worth(value, batch.value),
            _choice(prior, batch.fitting, batch.real),
        ]
    )


def _yes_no(logits: Tensor, labels: Tensor) -> Tensor:
    known = labels >= 0
    each = functional.binary_cross_entropy_with_logits(logits, labels.clamp(min=0).float(), reduction="none")
    return (each * known).sum() / known.sum().clamp(min=1)


def _cross_entropy(logits: Tensor, labels: Tensor) -> Tensor:
    total = functional.cross_entropy(logits, labels, ignore_index=-1, reduction="sum")
    return total / (labels >= 0).sum().clamp(min=1)


def _worth(value: Tensor, labels: Tensor) -> Tensor:
    known = labels.isfinite()
    each = functional.smooth_l1_loss(value, labels.nan_to_num(), reduction="none")
    return (each * known).sum() / known.sum().clamp(min=1)


def _choice(prior: Tensor, fitting: Tensor, real: Tensor) -> Tensor:
    """Return the surprise at a fitting plan among all plans, for examples with one."""
    shares = prior.masked_fill(~real, -1e4).log_softmax(dim=1)
    each = -shares.masked_fill(~fitting, -1e4).logsumexp(dim=1)
    some = fitting.any(dim=1)
    return torch.where(some, each, torch.zeros_like(each)).sum() / some.sum().clamp(min=1)


def sampling_weights(taught: Sequence[Example]) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Return how often each example is drawn: long standstills less than in proportion, judged plans more often."""
    keys = [(m.suite, m.route_id, m.seed, m.standstill) for m in (example.moment for example in taught)]
    _, place, counts = np.unique([repr(key) for key in keys], return_inverse=True, return_counts=True)
    weights = counts[place].astype(np.float64) ** -0.7
    weights *= np.array([3.0 if len(example.accepted) else 1.0 for example in taught])
    return np.asarray(weights / weights.sum())
