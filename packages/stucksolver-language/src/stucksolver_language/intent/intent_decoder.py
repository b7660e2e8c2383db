"""Converts the network's output to an interpretation with calibrated probabilities.

An uncertain interpretation never moves the vehicle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stucksolver.scene.interpretation import MOVES, STAYS, Claim, DirectedSide, GuidanceIntent, Interpretation

Numbers = NDArray[np.float32]

INTENTS = tuple(GuidanceIntent)
SIDES = (None, *DirectedSide)
CLAIMS = tuple(Claim)
INTENT = slice(0, len(INTENTS))
"""Slice of the network's output: logits of the intents."""
SIDE = slice(INTENT.stop, INTENT.stop + len(SIDES))
NEGATED = SIDE.stop
URGENT = NEGATED + 1
"""Index of the logit for an urgent utterance."""
CLAIM = slice(URGENT + 1, URGENT + 1 + len(CLAIMS))
"""Slice of the network's output: logits of the claims."""
LOGITS = CLAIM.stop
"""Number of outputs of the network."""


@dataclass(frozen=True)
class ConfidenceThresholds:
    """Probabilities from which an interpretation counts. They are calibrated and stored in the model's card."""

    temperature: float
    """Divisor of the intents' logits."""
    move: float
    """Lowest probability of an intent that moves the vehicle."""
    against: float
    """Highest total probability of the intents that keep the vehicle stopped, if another intent moves it."""
    stay: float
    """Lowest probability of an intent that keeps the vehicle stopped."""
    reroute: float
    """Lowest probability of a request for another route. Such a request alone starts no maneuver."""


def read_fields(logits: Numbers, doubt: ConfidenceThresholds, reader: str) -> Interpretation:
    """Return the interpretation of the network's output (LOGITS,)."""
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
