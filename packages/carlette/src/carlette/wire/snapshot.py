"""The world snapshot: a header and one packed record of 119 bytes for each actor."""

from __future__ import annotations

import struct
import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

RECORD_BYTES = 119
"""Size of one actor's record, as in CARLA (bytes)."""
_UNION = 65
"""Offset of the fields that depend on the kind of actor (bytes)."""

_FIELDS: dict[str, tuple[Any, int]] = {
    "id": ("<u4", 0),
    "state": ("u1", 4),
    "location": (("<f4", 3), 5),
    "rotation": (("<f4", 3), 17),
    "velocity": (("<f4", 3), 29),
    "angular": (("<f4", 3), 41),
    "acceleration": (("<f4", 3), 53),
    # vehicle
    "pedals": (("<f4", 3), _UNION),  # throttle, steer, brake
    "switches": (("u1", 3), _UNION + 12),  # hand brake, reverse, manual gear shift
    "gear": ("<i4", _UNION + 15),
    "speed_limit": ("<f4", _UNION + 19),
    "light_state": ("u1", _UNION + 23),
    "has_light": ("u1", _UNION + 24),
    "light_id": ("<u4", _UNION + 25),
    # walker
    "walk_direction": (("<f4", 3), _UNION),
    "walk_speed": ("<f4", _UNION + 12),
    "walk_jump": ("u1", _UNION + 16),
    # traffic light, traffic sign
    "sign_id": ("S32", _UNION),
    "light_times": (("<f4", 3), _UNION + 32),  # green, yellow, red
    "elapsed": ("<f4", _UNION + 44),
    "pole": ("<u4", _UNION + 48),
    "frozen": ("u1", _UNION + 52),
    "color": ("u1", _UNION + 53),
}

RECORD = np.dtype(
    {
        "names": list(_FIELDS),
        "formats": [form for form, _ in _FIELDS.values()],
        "offsets": [offset for _, offset in _FIELDS.values()],
        "itemsize": RECORD_BYTES,
    }
)
"""One actor. The fields from byte 65 on overlap: they depend on the kind of actor."""

Records = NDArray[np.void]

MAP_CHANGE = 1
"""Flag: the map has changed."""

_SENSOR_HEADER = struct.Struct("<QQd6f")
_WORLD_HEADER = struct.Struct("<Qdf3iI")


def sensor_header(sensor_type: int, frame: int, elapsed_s: float, pose: tuple[float, ...] = (0.0,) * 6) -> bytes:
    """Return the 48 bytes in front of every message of a stream; `pose` is x y z pitch yaw roll."""
    return _SENSOR_HEADER.pack(sensor_type, frame, elapsed_s, *pose)


def world_header(episode_id: int, delta_s: float, flags: int) -> bytes:
    """Return the 36 bytes between the sensor header and the records."""
    return _WORLD_HEADER.pack(episode_id, time.time(), delta_s, 0, 0, 0, flags)
