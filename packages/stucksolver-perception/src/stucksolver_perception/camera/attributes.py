"""Reads kind, lamps, doors and gesture of detected objects in one image."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stucksolver.scene import ObjectKind
from stucksolver.scene.objects import Gesture
from stucksolver_perception.camera.attribute_filter import AttributeFilter, Attributes
from stucksolver_perception.camera.crop_network import (
    GESTURES,
    KINDS,
    LAMP_ANSWERS,
    NOTHING,
    UNSEEN_GESTURE,
    CropAnswers,
    CropNetwork,
)
from stucksolver_perception.camera.crops import behind_dirt, cut_crops, features_of, windows_of
from stucksolver_perception.measurements import CameraFrame, Floats
from stucksolver_perception.network_files import DATA
from stucksolver_perception.rig import CameraRig

__all__ = ["AttributeFilter", "AttributeReader", "Attributes", "attributes_of"]

OFF, ON = LAMP_ANSWERS.index("off"), LAMP_ANSWERS.index("on")


class AttributeReader:
    """Reads objects in single images. `AttributeFilter` combines the results over time."""

    def __init__(self, folder: Path = DATA, threads: int = 1, network: CropNetwork | None = None) -> None:
        """Load the weights, or use a network that is already loaded.

        Raises:
            NetworkFileError: The weights cannot be used.
        """
        self.network = CropNetwork(folder, threads) if network is None else network

    def read(self, frame: CameraFrame, rig: CameraRig, boxes: Floats) -> tuple[Attributes, ...]:
        """Return the attributes of each box.

        Args:
            frame: The image.
            rig: The camera of the image.
            boxes: (n, 7) center x, y, z, length, width, height (m), yaw (rad) in the vehicle frame at the image's time.

        Returns:
            One answer for each box, in order. It is empty for boxes that are out of view, too small, or behind dirt on
            the lens.
        """
        windows = windows_of(rig, boxes)
        keep = np.flatnonzero(windows.usable & ~behind_dirt(windows, frame))
        answers: list[Attributes] = [Attributes()] * len(boxes)
        if len(keep):
            crops = cut_crops(frame.rgb, windows.center[keep], windows.side[keep])
            crop_answers = self.network.run(crops, features_of(rig, boxes, windows)[keep])
            for i, item in zip(keep.tolist(), attributes_of(crop_answers, self.network), strict=True):
                answers[i] = item
        return tuple(answers)


def attributes_of(answers: CropAnswers, network: CropNetwork) -> list[Attributes]:
    """Return the answers that reach the network's thresholds, for crops of objects; none for lamps of hidden ones."""
    best = answers.kind.argmax(axis=1)
    confidence = answers.kind.max(axis=1)
    is_certain = confidence >= network.least_kind[best]
    hidden = best == KINDS.index(NOTHING)
    lamps = np.where(hidden[:, None], np.nan, _lamps(answers.lamps, network.least_lamp))
    attributes = []
    for i in range(len(best)):
        kind = ObjectKind(KINDS[best[i]]) if is_certain[i] and not hidden[i] else None
        brake, left, right, special, door = (None if np.isnan(lamp) else bool(lamp) for lamp in lamps[i].tolist())
        is_hidden = bool(hidden[i]) if is_certain[i] else None
        gesture = _gesture(answers.gesture[i], network.least_gesture) if kind is ObjectKind.FLAGGER else None
        shares = answers.kind[i]
        attributes.append(
            Attributes(kind, float(confidence[i]), shares, is_hidden, brake, left, right, special, door, gesture)
        )
    return attributes


def _gesture(shares: Floats, thresholds: Floats) -> Gesture | None:
    best = int(shares.argmax())
    confidence = shares[best] >= thresholds[best] and GESTURES[best] != UNSEEN_GESTURE
    return Gesture(GESTURES[best]) if confidence else None


def _lamps(shares: Floats, thresholds: Floats) -> NDArray[np.float64]:
    """Return (n, lamps): 1 on, 0 off, NaN if neither reaches its threshold."""
    is_on = shares[..., ON] >= thresholds[:, ON]
    off = shares[..., OFF] >= thresholds[:, OFF]
    return np.asarray(np.where(is_on, 1.0, np.where(off, 0.0, np.nan)))
