"""Reads the state of traffic lights from crops of their heads. The positions of the heads come from the map."""

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

MIN_FACING_COS = 0.35
"""Minimum cosine between the direction of a head and the direction to the lens (70 degrees). Ours."""
MIN_LOOKS = 2
"""Number of consecutive equal looks after which a state counts. Ours."""
FORGET_S = 1.0
"""Time without a look after which a light is unknown (s). Ours."""
TOLERANCE_S = 0.05
"""Tolerance of that time, one tick (s), so that images at an interval of one second still confirm each other."""
STATES = (LightState.RED, LightState.YELLOW, LightState.GREEN, LightState.OFF, LightState.UNKNOWN)
"""The states in the order of `LIGHTS`; a hidden head gives no state."""

LightLook = tuple[LightState, float]
"""State of a light in one image, and its confidence (0 to 1; 0 if unknown)."""


class LightReader:
    """Reads the lights in single images. `LightFilter` combines the results over time."""

    def __init__(self, folder: Path = DATA, threads: int = 1, network: CropNetwork | None = None) -> None:
        """Load the weights, or use a network that is already loaded.

        Raises:
            NetworkFileError: The weights cannot be used.
        """
        self._network = CropNetwork(folder, threads) if network is None else network

    def read(self, frame: CameraFrame, rig: CameraRig, heads: Sequence[Floats]) -> tuple[LightLook, ...]:
        """Return the state of each light.

        Args:
            frame: The image.
            rig: The camera of the image.
            heads: For each light (k, 7): center x, y, z, half sizes x, y, z (m) and yaw (rad) of each of its heads in
                the vehicle frame. The lamps of a head point along its negative y axis, as in CARLA.

        Returns:
            One answer for each light, in order; unknown if none of its heads can be read with certainty.
        """
        is_certain = [len(head) for head in heads]
        joined = np.concatenate([np.zeros((0, 7)), *(head.reshape(-1, 7) for head in heads)])
        windows = windows_of(rig, boxes_of_heads(joined))
        keep = np.flatnonzero(windows.usable & (facing(rig, joined) > MIN_FACING_COS) & ~behind_dirt(windows, frame))
        crops = cut_crops(frame.rgb, windows.center[keep], windows.side[keep])
        shares = np.zeros((len(joined), len(LIGHTS)))
        shares[:, -1] = 1.0
        shares[keep] = self._network.run(crops, np.zeros((len(keep), 10), np.float32)).light
        ends = np.cumsum([0, *is_certain])
        parts = [shares[start:end] for start, end in itertools.pairwise(ends.tolist())]
        return tuple(combined(part, self._network.least_light) for part in parts)


@dataclass
class LightFilter:
    """The states of lights over time. A single look never counts, and a state is valid only for a short time."""

    _looks: dict[int, list[tuple[float, LightLook]]] = field(default_factory=dict)
    """The last usable looks at each light, oldest first."""

    def add(self, light_id: int, state: LightState, confidence: float, time_s: float) -> None:
        """Add a look at a light. Looks must come in order of time; a look without a state is ignored."""
        if state is not LightState.UNKNOWN:
            looks = self._looks.setdefault(light_id, [])
            if looks and time_s - looks[-1][0] > FORGET_S + TOLERANCE_S:
                looks.clear()
            looks.append((time_s, (state, confidence)))
            del looks[:-MIN_LOOKS]

    def state(self, light_id: int, time_s: float) -> LightState:
        """Return the state of a light at a time. Callers must never treat unknown as green."""
        return self.look(light_id, time_s)[0]

    def look(self, light_id: int, time_s: float) -> LightLook:
        """Return the state of a light at a time, and the confidence of the less certain look."""
        looks = self._looks.get(light_id, [])
        if len(looks) < MIN_LOOKS or len({item[0] for _, item in looks}) != 1 or time_s - looks[-1][0] > FORGET_S:
            return LightState.UNKNOWN, 0.0
        return looks[-1][1][0], min(confidence for _, (_, confidence) in looks)

    def forget(self, before_s: float) -> None:
        """Drop lights without a look since `before_s` (s)."""
        self._looks = {name: looks for name, looks in self._looks.items() if looks and looks[-1][0] >= before_s}


def combined(shares: Floats, least: Floats) -> LightLook:
    """Return the common answer of a light's heads.

    Args:
        shares: (k, 5) probabilities of each head; see `LIGHTS`.
        least: (5,) threshold of each answer's confidence.

    Returns:
        The state of the most certain head; unknown if no head reaches its threshold, or if two of them disagree.
    """
    shown_index = shares.argmax(axis=1)
    confidence = shares.max(axis=1)
    is_certain = (shown_index != LIGHTS.index("unseen")) & (confidence >= least[shown_index])
    if not is_certain.any() or len(set(shown_index[is_certain].tolist())) > 1:
        return LightState.UNKNOWN, 0.0
    return STATES[int(shown_index[is_certain][0])], float(confidence[is_certain].max())


def boxes_of_heads(heads: Floats) -> Floats:
    """Return heads (k, 7: center, half sizes, yaw) as boxes (k, 7: center, length, width, height, yaw)."""
    boxes = np.array(heads, dtype=np.float64).reshape(-1, 7)
    boxes[:, 3:6] *= 2.0
    return boxes


def facing(rig: CameraRig, heads: Floats) -> Floats:
    """Return the cosine between each head's direction (k, 7; vehicle frame) and its direction to the lens."""
    lens = rig.mount.to_vehicle()[:3, 3]
    to_lens = lens[:2] - heads[:, :2]
    facing_direction = np.stack([np.sin(heads[:, 6]), -np.cos(heads[:, 6])], axis=1)
    return np.asarray(
        np.sum(to_lens * facing_direction, axis=1) / np.maximum(np.hypot(to_lens[:, 0], to_lens[:, 1]), 1e-6)
    )
