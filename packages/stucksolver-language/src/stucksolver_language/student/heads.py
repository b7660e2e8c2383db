"""The answers of the network, in the order of its outputs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stucksolver.plan import CauseCode, Intent, WaitReason

VERSION = 1
"""Version of the outputs. It increases with every change of this file. Weights of another version are rejected."""
TIMES_S = (2.0, 5.0, 10.0, 20.0, 40.0)
"""Times for which the network gives the probability that the wait has ended without a plan (s). Ours."""
CAUSES = tuple(CauseCode)
HOLDS: tuple[WaitReason | None, ...] = (None, *WaitReason)
"""Reasons why waiting is right. The first answer means that waiting is not right."""
INTENTS: tuple[Intent | None, ...] = (None, *Intent)
"""Intents of an object. The first answer means that the object does not matter."""
OUTPUTS = ("hazard", "cause", "hold", "intent", "accepted", "value", "prior")
Floats = NDArray[np.float32]


@dataclass(frozen=True)
class StudentOutput:
    """The network's outputs for one scene.

    Attributes:
        hazard: Logits that the wait ends in each interval between two of `TIMES_S`, given that it lasts until the
            interval (5,).
        cause: Logits of `CAUSES`.
        hold: Logits of `HOLDS`.
        intent: Logits of `INTENTS` for each row of objects (rows, answers).
        accepted: Logit that the guard accepts the plan (plans,).
        value: Value of each plan if it is accepted, in 10 m of progress (plans,).
        prior: Logits over all plans: which one fits the request (plans,).
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
