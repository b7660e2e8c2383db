"""Selects the parts of an image that may contain words: around stopped objects, at posts of the map, and ahead."""

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
"""Maximum distance of a readable sign (m), measured with `python -m lab.benchmarks.sign_words`."""
SLOW_MPS = 0.5
"""Maximum speed of an object that is read (m/s). The word of a faster one would be elsewhere at the next look. Ours."""
MAX_OBJECTS = 4
"""Maximum number of objects, the nearest first, so that each target is read within about ten looks. Ours."""
MAX_VEHICLES = 3
"""Maximum number of vehicles. Ours."""
MAX_POSTS = 3
"""Maximum number of posts. Ours."""
MIN_HEIGHT_M = 0.5
"""Minimum height of an object with a sign (m). Cones are excepted, because their signs are above them. Ours."""
ABOVE_M = 1.2
"""Height of a sign above a barrier, and of a flagger's paddle above the person (m). Ours."""
SIDE_M = 0.7
"""Distance of a paddle to the side of a flagger (m). Ours."""
POST_FACE_M = 2.25
"""Height of the center of a sign's face on its post (m). Ours."""
POST_HALF_M = 0.9
"""Half the size of the crop around that center (m). Ours."""
MIN_CROP_PX = 24
"""Minimum side of a crop (px). Ours."""
MARGIN = 0.06
"""Margin of every other look at a target, as a share of its sides. Without noise, the camera of a stopped vehicle gives
the same image again, and two looks at the same pixels would prove nothing. Ours."""
SWATHS = 3
"""Number of crops of the image ahead. They overlap by the width of a sign 10 m away."""
SWATH_PX = 640
"""Width of these crops (px). Ours."""
SWATH_ABOVE_PX = 250
"""Height of these crops above the horizon (px). Ours."""
SWATH_BELOW_PX = 90
"""Height of these crops below the horizon (px). Ours."""
VEHICLE_WORDS = frozenset({SignWord.SCHOOL_BUS, SignWord.POLICE, SignWord.AMBULANCE, SignWord.FIRE})
"""Words on vehicles. Any other word in a vehicle's crop is on another object, mostly behind it, and vice versa."""
_VEHICLES = frozenset({LABELS.index("car"), LABELS.index("truck"), LABELS.index("two_wheeler")})
_CONE = LABELS.index("cone")


@dataclass(frozen=True)
class SignTarget:
    """A part of the image for reading."""

    key: str
    """Name that is constant while the ego is stopped."""
    left: int
    top: int
    right: int
    bottom: int
    """Lower edge of the part in the image (px), as `left`, `top` and `right`."""
    track_id: int | None = None
    """Id of the tracked object; None without one."""
    is_vehicle: bool = False
    """True if the tracked object is a vehicle."""
    distance_m: float | None = None
    """Distance from the ego's reference point (m), if known."""
    single: bool = True
    """False for a part of the road ahead, which is not upscaled."""

    def crop(self, rgb: Pixels) -> Pixels:
        """Return this part of an image."""
        return rgb[self.top : self.bottom, self.left : self.right]

    def widened(self, rig: CameraRig) -> SignTarget:
        """Return the same part with a margin, so that a second look has other pixels."""
        across, along = MARGIN * (self.right - self.left), MARGIN * (self.bottom - self.top)
        return replace(
            self,
            left=max(int(self.left - across), 0),
            top=max(int(self.top - along), 0),
            right=min(int(self.right + across), rig.width_px),
            bottom=min(int(self.bottom + along), rig.height_px),
        )

    def carries(self, word: SignWord, column: float, row: float) -> bool:
        """Return True if the tracked object of this target may carry a word at this position in the image."""
        is_inside = self.left <= column < self.right and self.top <= row < self.bottom
        return is_inside and self.track_id is not None and self.is_vehicle == (word in VEHICLE_WORDS)


def targets(
    rig: CameraRig, pose: PoseEstimate, tracks: Sequence[Track], posts: Mapping[int, tuple[float, float]]
) -> tuple[SignTarget, ...]:
    """Return the targets, most promising first.

    Args:
        rig: The camera.
        pose: The pose of the stopped ego.
        tracks: Tracks at the time of the pose.
        posts: Positions (m, local frame) of the map's signs, by number.
    """
    slow = [track for track in tracks if not track.hidden and math.hypot(track.vx_mps, track.vy_mps) <= SLOW_MPS]
    boxes = boxes_of(slow, pose)
    nearest_first = sorted(
        (_distance_m(box), i) for i, box in enumerate(boxes) if box[0] > 0.0 and _distance_m(box) <= REACH_M
    )
    objects = [i for _, i in nearest_first if slow[i].label not in _VEHICLES and _has_height(slow[i])]
    vehicles = [i for _, i in nearest_first if slow[i].label in _VEHICLES]
    candidates = [_track_target(rig, slow[i], boxes[i]) for i in objects[:MAX_OBJECTS]]
    candidates += [*swaths(rig), *_post_targets(rig, pose, posts)]
    candidates += [_track_target(rig, slow[i], boxes[i]) for i in vehicles[:MAX_VEHICLES]]
    return tuple(item for item in candidates if item is not None)


def carrier_of(
    word: SignWord, column: float, row: float, targets_now: Sequence[SignTarget], read_target: SignTarget
) -> SignTarget | None:
    """Return the target of the tracked object that carries a word; None without one.

    Args:
        word: The word.
        column: Column of the word in the image (px).
        row: Row of the word in the image (px).
        targets_now: All targets of this tick.
        read_target: The target in which the word was read.
    """
    if read_target.distance_m is not None and read_target.track_id is None:
        return None  # a post of the map
    carriers = [item for item in (read_target, *targets_now) if item.carries(word, column, row)]
    return min(carriers, key=lambda item: item.distance_m or 0.0, default=None)


def swaths(rig: CameraRig) -> list[SignTarget | None]:
    """Return the parts of the road ahead."""
    horizon = horizon_row(rig)
    top, bottom = horizon - SWATH_ABOVE_PX, horizon + SWATH_BELOW_PX
    width = min(SWATH_PX, rig.width_px)
    starts = np.linspace(0.0, rig.width_px - width, SWATHS)
    parts = (
        _cut(rig, f"ahead-{k}", left, top, left + width, bottom, single=False) for k, left in enumerate(starts.tolist())
    )
    return list(parts)


def bearing_rad(rig: CameraRig, column: float) -> float:
    """Return the direction of a column of the image relative to the vehicle's heading, positive to the left (rad)."""
    return math.atan2(rig.width_px / 2.0 - column, rig.focal_px) + math.radians(rig.mount.yaw_deg)


def _has_height(track: Track) -> bool:
    return track.height_m >= MIN_HEIGHT_M or track.label == _CONE


def _track_target(rig: CameraRig, track: Track, box: Floats) -> SignTarget | None:
    is_vehicle = track.label in _VEHICLES
    if not is_vehicle:
        # Signs are above the object, and paddles are next to it.
        box = box.copy()
        box[2] += ABOVE_M / 2.0
        box[3:5] += 2.0 * SIDE_M
        box[5] += ABOVE_M
    return _box_target(rig, f"track-{track.id}", box, track.id, is_vehicle)


def _post_targets(
    rig: CameraRig, pose: PoseEstimate, posts: Mapping[int, tuple[float, float]]
) -> list[SignTarget | None]:
    rows = np.array([(x, y, pose.z_m + POST_FACE_M, 0.0) for x, y in posts.values()], np.float64).reshape(-1, 4)
    positions = into_vehicle(rows, pose)
    nearest_first = sorted(
        (float(np.hypot(*position[:2])), k) for k, position in enumerate(positions) if position[0] > 0.0
    )
    keys = list(posts)
    side = 2.0 * POST_HALF_M
    return [
        _box_target(rig, f"post-{keys[k]}", np.array([*positions[k, :3], 0.2, side, side, 0.0]))
        for distance_m, k in nearest_first[:MAX_POSTS]
        if distance_m <= REACH_M
    ]


def _box_target(
    rig: CameraRig, key: str, box: Floats, track_id: int | None = None, is_vehicle: bool = False
) -> SignTarget | None:
    column, row, ahead = rig.project(corners_of(box[None])[0])
    if ahead.min() <= NEAREST_M:
        return None
    left, top, right, bottom = (float(item) for item in (column.min(), row.min(), column.max(), row.max()))
    return _cut(
        rig, key, left, top, right, bottom, track_id=track_id, is_vehicle=is_vehicle, distance_m=_distance_m(box)
    )


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
    """Return the part of a rectangle in the image; None if it is too small."""
    sides = (max(int(left), 0), max(int(top), 0), min(int(right), rig.width_px), min(int(bottom), rig.height_px))
    if sides[2] - sides[0] < MIN_CROP_PX or sides[3] - sides[1] < MIN_CROP_PX:
        return None
    return SignTarget(key, *sides, track_id, is_vehicle, distance_m, single)


def _distance_m(box: Floats) -> float:
    return float(np.hypot(box[0], box[1]))
