"""Chooses where in an image words may stand: around standing objects, at posts that the map knows, and ahead."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stucksolver.scene.signs import SignWord
from stucksolver_perception.camera.crops import NEAREST_M, corners_of
from stucksolver_perception.camera.horizon_strip import horizon_row
from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.measurements import Floats, Pixels, PoseEstimate
from stucksolver_perception.rig import CameraRig
from stucksolver_perception.tracking import Track, boxes_of
from stucksolver_perception.vehicle_frame import into_vehicle

REACH_M = 40.0
"""Words on signs are read up to this far (`python -m lab.benchmarks.sign_words`)."""
SLOW_MPS = 0.5
"""What moves faster is not read: its word would belong to another place at the next look."""
MOST_OBJECTS = 4
"""So many objects are read, the nearest first, so that everything gets its turn within some ten looks."""
MOST_VEHICLES = 3
MOST_POSTS = 3
LEAST_HEIGHT_M = 0.5
"""What is lower carries no sign, except cones, which have one above them."""
ABOVE_M = 1.2
"""A sign stands so far above a barrier, and a flagger's paddle is held so far above (m)."""
ASIDE_M = 0.7
"""A paddle is held so far aside (m)."""
POST_FACE_M = 2.25
"""Height of the middle of a sign's face on its post (m)."""
POST_HALF_M = 0.9
"""Half the size of the crop around it (m)."""
LEAST_CROP_PX = 24
MARGIN = 0.06
"""Share of its sides by which every other look at a target is wider. A camera without noise gives a standing vehicle
the same image again, and two looks at the same pixels would prove nothing.
"""
SWATHS = 3
"""The image ahead is read in this many crops. They overlap by the width of a sign 10 m away."""
SWATH_PX = 640
"""Width of these crops (px)."""
SWATH_UP = 250
"""They begin so far above the horizon (px), ..."""
SWATH_DOWN = 90
"""... and end so far below it (px)."""
CARRIED = frozenset({SignWord.SCHOOL_BUS, SignWord.POLICE, SignWord.AMBULANCE, SignWord.FIRE})
"""Words on vehicles. Any other word in a vehicle's crop stands on something else, mostly behind it, and the reverse."""
_VEHICLES = frozenset({LABELS.index("car"), LABELS.index("truck"), LABELS.index("two_wheeler")})
_CONE = LABELS.index("cone")


@dataclass(frozen=True)
class SignTarget:
    """A part of the image to be read."""

    key: str
    """Constant as long as the vehicle stands."""
    left: int
    top: int
    right: int
    bottom: int
    """In the image (px)."""
    track_id: int | None = None
    is_vehicle: bool = False
    distance_m: float | None = None
    """From the vehicle's reference point, if it is known."""
    single: bool = True
    """False for a part of the road ahead, which is read at its own scale."""

    def crop(self, rgb: Pixels) -> Pixels:
        """Return this part of an image."""
        return rgb[self.top : self.bottom, self.left : self.right]

    def widened(self, rig: CameraRig) -> SignTarget:
        """Return the same part with a margin, so that a second look at it is another one."""
        across, along = MARGIN * (self.right - self.left), MARGIN * (self.bottom - self.top)
        return replace(
            self,
            left=max(int(self.left - across), 0),
            top=max(int(self.top - along), 0),
            right=min(int(self.right + across), rig.width_px),
            bottom=min(int(self.bottom + along), rig.height_px),
        )

    def carries(self, word: SignWord, column: float, row: float) -> bool:
        """True if the object that is tracked here may carry a word at this place of the image."""
        inside = self.left <= column < self.right and self.top <= row < self.bottom
        return inside and self.track_id is not None and self.is_vehicle == (word in CARRIED)


def targets(
    rig: CameraRig, pose: PoseEstimate, tracks: Sequence[Track], posts: Mapping[int, tuple[float, float]]
) -> tuple[SignTarget, ...]:
    """Return what is worth reading, most promising first.

    Args:
        rig: The camera.
        pose: Of the standing vehicle.
        tracks: At the time of the pose.
        posts: Places (m, local frame) of the signs that the map knows, by number.
    """
    slow = [track for track in tracks if not track.hidden and math.hypot(track.vx_mps, track.vy_mps) <= SLOW_MPS]
    boxes = boxes_of(slow, pose)
    near = sorted((_away(box), i) for i, box in enumerate(boxes) if box[0] > 0.0 and _away(box) <= REACH_M)
    others = [i for _, i in near if slow[i].label not in _VEHICLES and _has_height(slow[i])]
    vehicles = [i for _, i in near if slow[i].label in _VEHICLES]
    found = [_of_track(rig, slow[i], boxes[i]) for i in others[:MOST_OBJECTS]]
    found += [*swaths(rig), *_of_posts(rig, pose, posts)]
    found += [_of_track(rig, slow[i], boxes[i]) for i in vehicles[:MOST_VEHICLES]]
    return tuple(item for item in found if item is not None)


def carrier_of(
    word: SignWord, column: float, row: float, among: Sequence[SignTarget], here: SignTarget
) -> SignTarget | None:
    """Return the tracked object that carries a word; None if it is on none.

    Args:
        word: The word.
        column: Where it is in the image (px).
        row: The same.
        among: All targets of this moment.
        here: The target in which it was read.
    """
    if here.distance_m is not None and here.track_id is None:
        return None  # a post of the map
    able = [item for item in (here, *among) if item.carries(word, column, row)]
    return min(able, key=lambda item: item.distance_m or 0.0, default=None)


def swaths(rig: CameraRig) -> list[SignTarget | None]:
    """Return the parts of the road ahead."""
    horizon = horizon_row(rig)
    top, bottom = horizon - SWATH_UP, horizon + SWATH_DOWN
    width = min(SWATH_PX, rig.width_px)
    starts = np.linspace(0.0, rig.width_px - width, SWATHS)
    parts = (
        _cut(rig, f"ahead-{k}", left, top, left + width, bottom, single=False) for k, left in enumerate(starts.tolist())
    )
    return list(parts)


def bearing_rad(rig: CameraRig, column: float) -> float:
    """Return the direction from the vehicle's heading to a column of the image, to the left positive (rad)."""
    return math.atan2(rig.width_px / 2.0 - column, rig.focal_px) + math.radians(rig.mount.yaw_deg)


def _has_height(track: Track) -> bool:
    return track.height_m >= LEAST_HEIGHT_M or track.label == _CONE


def _of_track(rig: CameraRig, track: Track, box: Floats) -> SignTarget | None:
    is_vehicle = track.label in _VEHICLES
    if not is_vehicle:
        # Signs stand above, paddles are held aside.
        box = box.copy()
        box[2] += ABOVE_M / 2.0
        box[3:5] += 2.0 * ASIDE_M
        box[5] += ABOVE_M
    return _of_box(rig, f"track-{track.id}", box, track.id, is_vehicle)


def _of_posts(rig: CameraRig, pose: PoseEstimate, posts: Mapping[int, tuple[float, float]]) -> list[SignTarget | None]:
    rows = np.array([(x, y, pose.z_m + POST_FACE_M, 0.0) for x, y in posts.values()], np.float64).reshape(-1, 4)
    places = into_vehicle(rows, pose)
    near = sorted((float(np.hypot(*place[:2])), k) for k, place in enumerate(places) if place[0] > 0.0)
    keys = list(posts)
    side = 2.0 * POST_HALF_M
    return [
        _of_box(rig, f"post-{keys[k]}", np.array([*places[k, :3], 0.2, side, side, 0.0]))
        for away, k in near[:MOST_POSTS]
        if away <= REACH_M
    ]


def _of_box(
    rig: CameraRig, key: str, box: Floats, track_id: int | None = None, is_vehicle: bool = False
) -> SignTarget | None:
    column, row, ahead = rig.project(corners_of(box[None])[0])
    if ahead.min() <= NEAREST_M:
        return None
    left, top, right, bottom = (float(item) for item in (column.min(), row.min(), column.max(), row.max()))
    return _cut(rig, key, left, top, right, bottom, track_id=track_id, is_vehicle=is_vehicle, distance_m=_away(box))


def _cut(
    rig: CameraRig,
    key: str,
    left: float,
    top: float,
    right: float,
    bottom: float,
    *,
    track_id: int | None = None,
    is_vehicle: bool = False,
    distance_m: float | None = None,
    single: bool = True,
) -> SignTarget | None:
    """Return the part of this rectangle that is in the image; None if it is too small."""
    sides = (max(int(left), 0), max(int(top), 0), min(int(right), rig.width_px), min(int(bottom), rig.height_px))
    if sides[2] - sides[0] < LEAST_CROP_PX or sides[3] - sides[1] < LEAST_CROP_PX:
        return None
    return SignTarget(key, *sides, track_id, is_vehicle, distance_m, single)


def _away(box: Floats) -> float:
    return float(np.hypot(box[0], box[1]))
