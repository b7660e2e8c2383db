"""Converts the network's output to a reading: calibrated probabilities, and doubt that never moves the vehicle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stucksolver.scene.interpretation import MOVES, STAYS, Claim, GuidanceIntent, Interpretation, Side

Numbers = NDArray[np.float32]

INTENTS = tuple(GuidanceIntent)
SIDES = (None, *Side)
CLAIMS = tuple(Claim)
INTENT = slice(0, len(INTENTS))
SIDE = slice(INTENT.stop, INTENT.stop + len(SIDES))
NEGATED = SIDE.stop
URGENT = NEGATED + 1
CLAIM = slice(URGENT + 1, URGENT + 1 + len(CLAIMS))
LOGITS = CLAIM.stop
"""Number of outputs of the network."""


@dataclass(frozen=True)
class ConfidenceThresholds:
    """The thresholds at which a reading counts, as probabilities. They are calibrated and stored in the model's
    card.
    """

    temperature: float
    """The logits of the intent are divided by it."""
    move: float
    """Lowest probability of a reading that moves the vehicle."""
    against: float
    """Highest probability, besides it, of the readings that would have kept the vehicle where it is."""
    stay: float
    """Lowest probability of a reading that keeps the vehicle where it is."""
    reroute: float
    """Lowest probability of a request for another route, which by itself begins no maneuver."""


def read_fields(logits: Numbers, doubt: ConfidenceThresholds, reader: str) -> Interpretation:
    """Return the reading for the network's output (LOGITS,)."""
    intents = softmax(logits[INTENT] / doubt.temperature)
    best = int(intents.argmax())
    likely, confidence = INTENTS[best], float(intents[best])
    side = SIDES[int(logits[SIDE].argmax())]
    held = float(sum(p for intent, p in zip(INTENTS, intents, strict=True) if intent in STAYS))
    least = doubt.reroute if likely is GuidanceIntent.REROUTE else doubt.move
    sure = confidence >= least and held <= doubt.against if likely in MOVES else confidence >= doubt.stay
    return Interpretation(
        intent=likely if sure or likely is GuidanceIntent.UNLAWFUL else GuidanceIntent.UNCLEAR,
        side=side,
        negated=bool(logits[NEGATED] > 0),
        claims=tuple(claim for claim, logit in zip(CLAIMS, logits[CLAIM], strict=True) if logit > 0),
        urgent=bool(logits[URGENT] > 0),
        confidence=round(min(max(confidence, 0.0), 1.0), 4),
        likely=likely,
        reader=reader,
    )


def softmax(logits: Numbers) -> Numbers:
    """Return probabilities from logits, over the last axis."""
    raised = np.exp(logits - logits.max(axis=-1, keepdims=True))
    result: Numbers = raised / raised.sum(axis=-1, keepdims=True)
    return result
