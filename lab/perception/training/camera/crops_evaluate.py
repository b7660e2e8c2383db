"""Evaluates the crop network on held-out crops: temperatures, thresholds, confusion matrices.

The required shares are ours.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lab.perception.training.camera.crops_data import Crops
from stucksolver.scene.objects import PASSABLE_KINDS
from stucksolver_perception.camera.crop_network import (
    GESTURES,
    KINDS,
    LAMP_ANSWERS,
    LAMPS,
    LIGHTS,
    NEVER,
    UNSEEN_GESTURE,
    softmax,
)
from stucksolver_perception.measurements import Floats

KIND_RIGHT, PASSABLE_RIGHT = 0.95, 0.99
"""Share of right answers that is required on held-out crops: of a kind, and of a kind that may be driven over."""
LIGHT_RIGHT = {"red": 0.98, "yellow": 0.98, "green": 0.99, "off": 0.98, "unseen": 0.0}
"""The same for each state of a light."""
LAMP_RIGHT = 0.97
"""The same for lamps."""
SPECIAL_RIGHT = 0.95
"""The same for lit emergency lights."""
DOOR_RIGHT = 0.9
"""The same for open doors."""
BLINKER_DARK_RIGHT = 0.75
"""The same for a blinker that is dark in one image. It may still be blinking: the memory waits for more images."""
GESTURE_RIGHT = 0.95
"""The same for gestures."""
LEAST_CONFIDENCE = 0.5
"""Least confidence of an answer."""


@dataclass(frozen=True, eq=False)
class Logits:
    """The network's outputs for crops."""

    kind: Floats
    """(n, len(KINDS))."""
    lamps: Floats
    """(n, len(LAMPS), 3)."""
    light: Floats
    """(n, len(LIGHTS))."""
    gesture: Floats
    """(n, len(GESTURES))."""

    @staticmethod
    def from_outputs(outputs: Sequence[Floats]) -> Logits:
        """Return the outputs of the network in the order of `HEADS`."""
        kind, lamps, light, gesture = outputs
        shaped = lamps.reshape(-1, len(LAMPS), len(LAMP_ANSWERS))
        return Logits(kind, shaped, light.reshape(-1, len(LIGHTS)), gesture.reshape(-1, len(GESTURES)))

    def subset(self, which: NDArray[np.bool_]) -> Logits:
        """Return the outputs for some of the crops."""
        return Logits(self.kind[which], self.lamps[which], self.light[which], self.gesture[which])


def halves(group: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return which crops calibrate; the others are scored.

    The split is by recording, or by time if there is only one recording.
    """
    names = np.unique(group)
    if len(names) > 1:
        return np.isin(group, names[::2])
    return np.arange(len(group)) < len(group) // 2


def temperature_of(logits: Floats, labels: NDArray[np.int64]) -> float:
    """Return the most likely temperature for labels (n,) and logits (n, k); 1 without labels (Guo et al. 2017)."""
    counts = labels >= 0
    if not counts.any():
        return 1.0
    logits, labels = logits[counts], labels[counts]
    candidates = np.exp(np.linspace(np.log(0.3), np.log(5.0), 60))
    losses = [
        -np.log(softmax(logits / candidate)[np.arange(len(labels)), labels] + 1e-12).mean() for candidate in candidates
    ]
    return float(candidates[int(np.argmin(losses))])


def least_confidence(confidence: Floats, right: NDArray[np.bool_], share: float) -> float:
    """Return the lowest confidence above which at least a given share of the answers is right.

    Args:
        confidence: (n,), of the answers of one class.
        right: (n,), True for right answers.
        share: Between 0 and 1. It takes at least 100 answers to show a share of 0.99, and 20 to show 0.95.

    Returns:
        At least `LEAST_CONFIDENCE`; `NEVER` if no confidence is enough, or if there are too few answers.
    """
    order = np.argsort(-confidence, kind="stable")
    counts = np.arange(1, len(order) + 1)
    good = np.cumsum(right[order]) / counts >= share
    # Answers of equal confidence are accepted or rejected together.
    ends = np.append(np.diff(confidence[order]) != 0, True) if len(order) else np.zeros(0, bool)
    enough = counts >= round(1.0 / max(1.0 - share, 1e-9))
    found = np.flatnonzero(good & ends & enough)
    return max(LEAST_CONFIDENCE, float(confidence[order][found[-1]])) if len(found) else NEVER


def cross_check(logits: Logits, crops: Crops) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the card from all crops, and the scores of each half with a card from the other half."""
    half = halves(crops.group)
    parts = [(logits.subset(item), crops.subset(item)) for item in (half, ~half)]
    cards = [calibrated(*part) for part in reversed(parts)]
    return calibrated(logits, crops), scores([(*part, card) for part, card in zip(parts, cards, strict=True)])


def calibrated(logits: Logits, crops: Crops) -> dict[str, Any]:
    """Return temperatures and thresholds, in the card's format."""
    flat = logits.lamps.reshape(-1, len(LAMP_ANSWERS)), crops.lamps.reshape(-1)
    temperatures = {
        "kind": temperature_of(logits.kind, crops.kind),
        "lamps": temperature_of(*flat),
        "light": temperature_of(logits.light, crops.light),
        "gesture": temperature_of(logits.gesture, crops.gesture),
    }
    kind = softmax(logits.kind / temperatures["kind"])
    lamps = softmax(logits.lamps / temperatures["lamps"])
    light = softmax(logits.light / temperatures["light"])
    gesture = softmax(logits.gesture / temperatures["gesture"])
    passable = {item.value for item in PASSABLE_KINDS}
    wanted = {name: PASSABLE_RIGHT if name in passable else KIND_RIGHT for name in KINDS}
    lamp_least = {}
    blinkers = [i for i, name in enumerate(LAMPS) if "blinker" in name]
    for i, name in enumerate(LAMPS):
        dark = BLINKER_DARK_RIGHT if i in blinkers else LAMP_RIGHT
        lit = {"door_open": DOOR_RIGHT, "emergency_lights": SPECIAL_RIGHT}.get(name, LAMP_RIGHT)
        shares = dict(zip(LAMP_ANSWERS, (dark, lit, 0.0), strict=True))
        # Calibrate both sides together: training mirrors its crops, and lit blinkers are rare.
        which = blinkers if i in blinkers else [i]
        outputs, labels, state = (
            np.concatenate([item[:, k] for k in which]) for item in (lamps, crops.lamps, crops.lit)
        )
        lamp_least[name] = _least(outputs, labels, shares, state)
    gestures = {name: 0.0 if name == UNSEEN_GESTURE else GESTURE_RIGHT for name in GESTURES}
    least = {
        "kind": _least(kind, crops.kind, wanted),
        "lamps": lamp_least,
        "light": _least(light, crops.light, LIGHT_RIGHT, crops.state),
        "gesture": _least(gesture, crops.gesture, gestures, crops.signal),
    }
    return {"temperatures": temperatures, "least": least}


def _least(
    shares: Floats, labels: NDArray[np.int64], wanted: dict[str, float], state: NDArray[np.int64] | None = None
) -> dict[str, float]:
    """Return thresholds by name; `wanted` has the names in the order of the columns of `shares`.

    With `state`, an answer is also right if it is the state of the light, lamp or flagger although it counts as hidden:
    a part of it, its glow, or its twin on the same pole, was enough.
    """
    counts = labels >= 0
    best, sure, labels = shares[counts].argmax(1), shares[counts].max(1), labels[counts]
    shown = labels if state is None else state[counts]
    return {
        name: round(
            least_confidence(sure[best == i], (labels[best == i] == i) | (shown[best == i] == i), share),
            4,
        )
        for i, (name, share) in enumerate(wanted.items())
    }


def scores(parts: Sequence[tuple[Logits, Crops, dict[str, Any]]]) -> dict[str, Any]:
    """Return accuracy, answer rate, accuracy of the answers, and confusion matrix of each head, over all parts.

    Each part has the outputs for some crops, the crops, and the card to use.
    """
    answers: dict[str, list[_HeadAnswers]] = {}
    for logits, crops, card in parts:
        warm, least = card["temperatures"], card["least"]
        kind, light, gesture, lamps = (
            softmax(getattr(logits, head) / warm[head]) for head in ("kind", "light", "gesture", "lamps")
        )
        item = {
            "kind": _answers(kind, crops.kind, least["kind"]),
            "light": _answers(light, crops.light, least["light"], crops.state),
            "gesture": _answers(gesture, crops.gesture, least["gesture"], crops.signal),
        }
        for i, name in enumerate(LAMPS):
            item[name] = _answers(lamps[:, i], crops.lamps[:, i], least["lamps"][name], crops.lit[:, i])
        for head, found in item.items():
            answers.setdefault(head, []).append(found)
    return {head: _scored(found) for head, found in answers.items()}


@dataclass(frozen=True, eq=False)
class _HeadAnswers:
    """One head's answers for crops with a label."""

    names: list[str]
    labels: NDArray[np.int64]
    shown: NDArray[np.int64]
    best: NDArray[np.int64]
    says: NDArray[np.bool_]


def _answers(
    shares: Floats, labels: NDArray[np.int64], least: dict[str, float], state: NDArray[np.int64] | None = None
) -> _HeadAnswers:
    counts = labels >= 0
    shown = labels[counts] if state is None else state[counts]
    limits = np.array(list(least.values()))
    best, sure = shares[counts].argmax(1), shares[counts].max(1)
    return _HeadAnswers(list(least), labels[counts], shown, best, sure >= limits[best])


def _scored(parts: Sequence[_HeadAnswers]) -> dict[str, Any]:
    names = parts[0].names
    labels, shown, best, says = (
        np.concatenate([getattr(part, name) for part in parts]) for name in ("labels", "shown", "best", "says")
    )
    matrix = np.zeros((len(names), len(names)), int)
    np.add.at(matrix, (labels, best), 1)
    by_name = {}
    for i, name in enumerate(names):
        true, answered = labels == i, says & (best == i)
        by_name[name] = {
            "crops": int(true.sum()),
            "found": _share(best[true] == i),
            "answered": _share(answered[true]),
            "answers": int(answered.sum()),
            "right": _share((true | (shown == i))[answered]),
        }
    return {
        "crops": len(labels),
        "accuracy": _share(best == labels),
        "answered": _share(says),
        "right_when_answered": _share(((best == labels) | (best == shown))[says]),
        "by_name": by_name,
        "confusion": matrix.tolist(),
    }


def _share(flags: NDArray[np.bool_]) -> float | None:
    return round(float(flags.mean()), 4) if len(flags) else None


def report(scores_by_head: dict[str, Any]) -> str:
    """Return the scores as text, with one confusion matrix (rows: truth) for each head."""
    lines = []
    for head, item in scores_by_head.items():
        lines.append(
            f"{head}: {item['crops']} crops, accuracy {item['accuracy']}, answered {item['answered']}, "
            f"right when answered {item['right_when_answered']}"
        )
        for name, row in item["by_name"].items():
            if row["crops"] or row["answers"]:
                lines.append(
                    f"  {name:16} crops {row['crops']:6} found {row['found']} answered {row['answered']} "
                    f"answers {row['answers']} right {row['right']}"
                )
        used = [i for i, row in enumerate(item["confusion"]) if sum(row) or any(r[i] for r in item["confusion"])]
        names = list(item["by_name"])
        lines.append("  truth \\ answer   " + " ".join(f"{names[i][:7]:>7}" for i in used))
        lines += [f"  {names[i]:16} " + " ".join(f"{item['confusion'][i][j]:7}" for j in used) for i in used]
    return "\n".join(lines)
