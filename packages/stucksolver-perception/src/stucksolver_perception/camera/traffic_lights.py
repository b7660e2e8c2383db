"""The state of traffic lights from crops of their heads. The map gives the positions of the heads."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from stucksolver.scene.surroundings import LightState
from stucksolver_perception.camera.crop_network import LIGHTS, CropNetwork
from stucksolver_perception.camera.crops import behind_dirt, cut_crops, windows_of
from stucksolver_perception.measurements import CameraFrame, Floats
from stucksolver_perception.network_files import DATA
from stucksolver_perception.rig import CameraRig

LEAST_FACING = 0.35
"""Cosine between the direction of a head and the direction to the lens (70 degrees); flatter ones are not read."""
LOOKS = 2
"""A state counts after this many consecutive looks that agree."""
FORGET_S = 1.0
"""A light that was not read for this long is unknown."""
SLACK_S = 0.05
"""One tick: images that come once a second still confirm each other."""
STATES = (LightState.RED, LightState.YELLOW, LightState.GREEN, LightState.OFF, LightState.UNKNOWN)
"""In the order of `LIGHTS`; a hidden head gives no state."""

LightLook = tuple[LightState, float]
"""What one image shows of a light, and its confidence (0 to 1; 0 if unknown)."""


class LightReader:
    """Reads the lights in an image, one look at a time; see `LightFilter`."""

    def __init__(self, folder: Path = DATA, threads: int = 1, network: CropNetwork | None = None) -> None:
        """Load the weights, or use a network that is already loaded.

        Raises:
            WeightsError: The weights cannot be used.
        """
        self._network = CropNetwork(folder, threads) if network is None else network

    def read(self, frame: CameraFrame, rig: CameraRig, heads: Sequence[Floats]) -> tuple[LightLook, ...]:
        """Return what each light shows.

        Args:
            frame: The image.
            rig: The camera that took it.
            heads: For each light (k, 7): center x, y, z, half sizes x, y, z (m) and yaw (rad) of each of its heads in
                the vehicle frame. A head shows its lamps toward its negative y axis, as in CARLA.

        Returns:
            One answer for each light, in order; unknown if none of its heads can be read with certainty.
        """
        counts = [len(head) for head in heads]
        joined = np.concatenate([np.zeros((0, 7)), *(head.reshape(-1, 7) for head in heads)])
        windows = windows_of(rig, boxes_of_heads(joined))
        keep = np.flatnonzero(windows.usable & (facing(rig, joined) > LEAST_FACING) & ~behind_dirt(windows, frame))
        crops = cut_crops(frame.rgb, windows.center[keep], windows.side[keep])
        shares = np.zeros((len(joined), len(LIGHTS)))
        shares[:, -1] = 1.0
        shares[keep] = self._network.run(crops, np.zeros((len(keep), 10), np.float32)).light
        ends = np.cumsum([0, *counts])
        parts = [shares[start:end] for start, end in itertools.pairwise(ends.tolist())]
        return tuple(combined(part, self._network.least_light) for part in parts)


@dataclass
class LightFilter:
    """The states of lights over time: nothing counts after a single look, and nothing is kept for long."""

    _looks: dict[int, list[tuple[float, LightLook]]] = field(default_factory=dict)
    """For each light its last usable looks, oldest first."""

    def add(self, light_id: int, state: LightState, confidence: float, time_s: float) -> None:
        """Add a look at a light. Looks must come in order of time; a look without a state is ignored."""
        if state is not LightState.UNKNOWN:
            kept = self._looks.setdefault(light_id, [])
            if kept and time_s - kept[-1][0] > FORGET_S + SLACK_S:
                kept.clear()
            kept.append((time_s, (state, confidence)))
            del kept[:-LOOKS]

    def state(self, light_id: int, time_s: float) -> LightState:
        """Return what a light shows at a time by the looks so far; unknown must never be taken for green."""
        return self.look(light_id, time_s)[0]

    def look(self, light_id: int, time_s: float) -> LightLook:
        """Return the same with the confidence of the less certain look."""
        kept = self._looks.get(light_id, [])
        if len(kept) < LOOKS or len({item[0] for _, item in kept}) != 1 or time_s - kept[-1][0] > FORGET_S:
            return LightState.UNKNOWN, 0.0
        return kept[-1][1][0], min(sure for _, (_, sure) in kept)

    def forget(self, before_s: float) -> None:
        """Drop lights without a look since that time (s)."""
        self._looks = {name: looks for name, looks in self._looks.items() if looks and looks[-1][0] >= before_s}


def combined(shares: Floats, least: Floats) -> LightLook:
    """Combine the heads of a light to one answer.

    Args:
        shares: (k, 5) probabilities by head, see `LIGHTS`.
        least: (5,) the confidence from which each answer counts.

    Returns:
        The state of the most certain head; unknown if none is sure enough or two of them disagree.
    """
    shown = shares.argmax(axis=1)
    sure = shares.max(axis=1)
    counts = (shown != LIGHTS.index("unseen")) & (sure >= least[shown])
    if not counts.any() or len(set(shown[counts].tolist())) > 1:
        return LightState.UNKNOWN, 0.0
    return STATES[int(shown[counts][0])], float(sure[counts].max())


def boxes_of_heads(heads: Floats) -> Floats:
    """Convert heads (k, 7: center, half sizes, yaw) to boxes (k, 7: center, length, width, height, yaw)."""
    boxes = np.array(heads, dtype=np.float64).reshape(-1, 7)
    boxes[:, 3:6] *= 2.0
    return boxes


def facing(rig: CameraRig, heads: Floats) -> Floats:
    """Return the cosine between the direction of each head (k, 7; vehicle frame) and the direction from it to the
    lens.
    """
    lens = rig.mount.to_vehicle()[:3, 3]
    way = lens[:2] - heads[:, :2]
    shows = np.stack([np.sin(heads[:, 6]), -np.cos(heads[:, 6])], axis=1)
    return np.asarray(np.sum(way * shows, axis=1) / np.maximum(np.hypot(way[:, 0], way[:, 1]), 1e-6))
