"""The answers of the network, in the order of its outputs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stucksolver.plan import CauseCode, Intent, WaitReason

VERSION = 1
"""Increased with every change of this file. Weights of another version are refused."""
TIMES_S = (2.0, 5.0, 10.0, 20.0, 40.0)
"""For these times the network says how likely the wait ends by itself until then (s)."""
CAUSES = tuple(CauseCode)
HOLDS: tuple[WaitReason | None, ...] = (None, *WaitReason)
"""Why waiting is right; the first answer is that it is not."""
INTENTS: tuple[Intent | None, ...] = (None, *Intent)
"""What an object is about to do; the first answer is that it does not matter."""
OUTPUTS = ("hazard", "cause", "hold", "intent", "accepted", "value", "prior")
Floats = NDArray[np.float32]


@dataclass(frozen=True)
class StudentOutput:
    """The network's outputs for one scene.

    Attributes:
        hazard: Logits of the wait ending in each interval between two of `TIMES_S`, given that it lasts so long (5,).
        cause: Logits of `CAUSES`.
        hold: Logits of `HOLDS`.
        intent: Logits of `INTENTS` for each row of objects (rows, answers).
        accepted: Logit for each plan that the guard accepts it (plans,).
        value: What each plan is worth if it is accepted, in 10 m of progress (plans,).
        prior: Logits of the plan among all that fits what is wanted here (plans,).
    """

    hazard: Floats
    cause: Floats
    hold: Floats
    intent: Floats
    accepted: Floats
    value: Floats
    prior: Floats


def ends_within(hazard: NDArray[np.floating]) -> NDArray[np.float64]:
    """Return the probabilities that the wait ends within `TIMES_S`, from the logits of the hazards (…, 5)."""
    lasts = np.cumprod(1.0 / (1.0 + np.exp(np.asarray(hazard, np.float64))), axis=-1)
    return np.asarray(1.0 - lasts)
