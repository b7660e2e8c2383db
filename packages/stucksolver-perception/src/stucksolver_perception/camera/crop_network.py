"""Loads and runs the crop network, and returns its answers as probabilities."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from stucksolver.scene import ObjectKind
from stucksolver.scene.objects import Gesture
from stucksolver_perception.measurements import Floats, Pixels, Singles
from stucksolver_perception.network_files import DATA, NetworkFileError, load_session
from stucksolver_perception.recording import PARTS

VERSION = 2
"""Version of the network's inputs and outputs, with the names below."""
NOTHING = "nothing"
"""The answer for a box that is empty, or whose object is hidden."""
KINDS = (*(kind.value for kind in ObjectKind if kind is not ObjectKind.UNKNOWN), NOTHING)
LAMPS = PARTS
LAMP_ANSWERS = ("off", "on", "unseen")
LIGHTS = ("red", "yellow", "green", "off", "unseen")
UNSEEN_GESTURE = "unseen"
GESTURES = (*(item.value for item in Gesture), UNSEEN_GESTURE)
HEADS = {"kind": len(KINDS), "lamps": len(LAMPS) * len(LAMP_ANSWERS), "light": len(LIGHTS), "gesture": len(GESTURES)}
"""The number of logits of each of the network's outputs, in order."""
NEVER = 2.0
"""A threshold that no confidence reaches, for answers that were not accurate enough on held-out data."""


@dataclass(frozen=True, eq=False)
class CropAnswers:
    """Calibrated probabilities for n crops."""

    kind: Floats
    """(n, len(KINDS))."""
    lamps: Floats
    """(n, len(LAMPS), 3), see `LAMP_ANSWERS`."""
    light: Floats
    """(n, len(LIGHTS))."""
    gesture: Floats
    """(n, len(GESTURES)); valid only for flaggers."""


class CropNetwork:
    """The loaded network.

    Raises:
        NetworkFileError: Its files cannot be used.
    """

    def __init__(self, folder: Path = DATA, threads: int = 1) -> None:
        card_file = folder / "crops.json"
        self._session, self.card = load_session(folder / "crops.onnx", card_file, VERSION, threads)
        names = {"kinds": KINDS, "lamps": LAMPS, "lights": LIGHTS, "gestures": GESTURES}
        for key, expected in names.items():
            if self.card.get(key) != list(expected):
                raise NetworkFileError(f"{card_file}: `{key}` differ from those of this code; train the network again")
        try:
            self._temperature = {head: float(self.card["temperatures"][head]) for head in HEADS}
            thresholds: dict[str, Any] = self.card["least"]
            self.least_kind = np.array([float(thresholds["kind"][name]) for name in KINDS])
            self.least_lamp = np.array(
                [[float(thresholds["lamps"][name][answer]) for answer in LAMP_ANSWERS] for name in LAMPS]
            )
            self.least_light = np.array([float(thresholds["light"][name]) for name in LIGHTS])
            self.least_gesture = np.array([float(thresholds["gesture"][name]) for name in GESTURES])
        except (KeyError, TypeError, ValueError) as error:
            raise NetworkFileError(
                f"{card_file}: a temperature or threshold is missing: {error}; train the network again"
            ) from error

    def run(self, crops: Pixels, features: Singles) -> CropAnswers:
        """Return the answers for crops (n, 64, 64, 3) and features (n, 10) of `crops.py`."""
        if not len(crops):
            return CropAnswers(*self._probabilities([np.zeros((0, size), np.float32) for size in HEADS.values()]))
        return CropAnswers(*self._probabilities(self._session.run(None, {"crops": crops, "features": features})))

    def _probabilities(self, logits: list[Singles]) -> list[Floats]:
        kind, lamps, light, gesture = (
            item.astype(np.float64) / self._temperature[head] for head, item in zip(HEADS, logits, strict=True)
        )
        lamps = lamps.reshape(-1, len(LAMPS), len(LAMP_ANSWERS))
        return [softmax(kind), softmax(lamps), softmax(light), softmax(gesture)]


def softmax(logits: Floats) -> Floats:
    """Return the softmax along the last axis."""
    powers = np.exp(logits - logits.max(axis=-1, keepdims=True)) if logits.size else logits
    return np.asarray(powers / np.maximum(powers.sum(axis=-1, keepdims=True), 1e-300))
