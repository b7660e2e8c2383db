"""Identifies the posts of signs and lights on the map: a narrow, upright, slow object at such a position is the post.

The LiDAR's network has no label for posts, so they count as pedestrians, as a safe assumption
(`lidar/refinement/unexplained_returns.py`). A driver keeps 0.5 m from pedestrians, and would not pass a post at the
edge of a narrow lane.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from stucksolver_carla.stack.carla_frames import to_local
from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.tracking import Track

if TYPE_CHECKING:
    import carla

LIGHT_TYPE = "1000001"
"""OpenDRIVE's type of traffic lights in the maps of CARLA and carlette."""
MATCH_M = 0.6
"""Maximum distance of a post from its position on the map (m): the localizer's error and a small cluster's. Ours."""
MAX_WIDTH_M = 0.8
"""Maximum width of a post in the track (m). Ours."""
SLOW_MPS = 0.6
"""Maximum speed of a post's track (m/s); the speed of a new track is not exact. Ours."""
POST_M = 0.2
"""Width of a post (m). Ours."""

_PERSON, _BARRIER = LABELS.index("pedestrian"), LABELS.index("barrier")


def sign_positions(carla_map: carla.Map) -> dict[int, tuple[float, float]]:
    """Return the positions (m, local frame) of the signs on a map, by number."""
    signs = (landmark for landmark in carla_map.get_all_landmarks() if landmark.type != LIGHT_TYPE)
    return dict(enumerate(dict.fromkeys(to_local(sign.transform.location) for sign in signs)))


class KnownPosts:
    """The posts of one map, in the local frame (m)."""

    def __init__(self, positions: Sequence[tuple[float, float]]) -> None:
        self._positions = tuple(positions)

    def as_post(self, track: Track) -> Track:
        """Return a track; as a post if the map has one at its position."""
        if track.label != _PERSON or max(track.length_m, track.width_m) > MAX_WIDTH_M:
            return track
        if math.hypot(track.vx_mps, track.vy_mps) > SLOW_MPS:
            return track
        if all(math.hypot(track.x_m - x, track.y_m - y) > MATCH_M for x, y in self._positions):
            return track
        return replace(track, label=_BARRIER, length_m=POST_M, width_m=POST_M, vx_mps=0.0, vy_mps=0.0)
