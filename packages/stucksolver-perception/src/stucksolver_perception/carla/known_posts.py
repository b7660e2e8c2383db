"""Posts of signs and lights that the map knows: what is narrow, upright and stands at such a place is the post.

The LiDAR's network does not name posts, so that they count as people, to be careful (`lidar/residual.py`). A driver
keeps 0.5 m from people, and would not pass a post at the edge of a narrow lane.
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
"""OpenDRIVE's type of traffic lights, in CARLA's maps and ours."""
PLACE_M = 0.6
"""A post is seen within this distance of its place on the map: the error of the localizer and of a small cluster."""
NARROW_M = 0.8
"""What is wider is not a post alone (m)."""
SLOW_MPS = 0.6
"""Whoever moves faster is not a post; the speed of a new track is not exact (m/s)."""
POST_M = 0.2
"""Width of a post (m)."""

_PERSON, _BARRIER = LABELS.index("pedestrian"), LABELS.index("barrier")


def sign_places(carla_map: carla.Map) -> dict[int, tuple[float, float]]:
    """Return the places (m, local frame) of the signs on a map, numbered."""
    signs = (landmark for landmark in carla_map.get_all_landmarks() if landmark.type != LIGHT_TYPE)
    return dict(enumerate(dict.fromkeys(to_local(sign.transform.location) for sign in signs)))


class KnownPosts:
    """The posts of one map, local frame, meters."""

    def __init__(self, places: Sequence[tuple[float, float]]) -> None:
        self._places = tuple(places)

    def told(self, track: Track) -> Track:
        """Return a track, as a post if it stands where the map has one."""
        if track.label != _PERSON or max(track.length_m, track.width_m) > NARROW_M:
            return track
        if math.hypot(track.vx_mps, track.vy_mps) > SLOW_MPS:
            return track
        if all(math.hypot(track.x_m - x, track.y_m - y) > PLACE_M for x, y in self._places):
            return track
        return replace(track, label=_BARRIER, length_m=POST_M, width_m=POST_M, vx_mps=0.0, vy_mps=0.0)
