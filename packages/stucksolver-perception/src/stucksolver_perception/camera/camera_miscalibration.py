"""Notices while the vehicle drives that its front camera is turned about the vertical axis.

Where the LiDAR's range jumps from one ray to the next, something ends: a wall, a pole, a vehicle. Most of these ends
are edges in the picture, too (Levinson and Thrun 2013). The angle at which the picture has the strongest edges where
the LiDAR saw the ends is how far the camera is turned against the LiDAR. How far the LiDAR itself is turned against the
vehicle's motion is known from `lidar/alignment.py`, so a LiDAR that is turned does not accuse the camera.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from stucksolver_perception.angle_consensus import AngleConsensus
from stucksolver_perception.lidar.sweeps import RECENT_S
from stucksolver_perception.measurements import CameraFrame, Floats, LidarSweep, PoseEstimate, Singles
from stucksolver_perception.rig import CameraRig, LidarRig, Rig
from stucksolver_perception.vehicle_frame import points_into_vehicle

ANGLES_RAD = np.radians(np.arange(-6.0, 6.01, 0.2))
"""Angles that are compared, to the left positive."""
NEAR_M = 4.0
"""Ends that are nearer are seen at another place from the camera than from the LiDAR."""
JUMP_M, JUMP_SHARE = 1.0, 0.1
"""The range jumps if it changes by more than this, and this share of itself."""
BESIDE_RAD = math.radians(1.6)
"""Rays this close are neighbors: of those between them, some may be lost."""
GAP_RAD = math.radians(2.6)
"""If no ray came back for longer, the sky begins here. Six rays of the shipped LiDAR, of which half are lost."""
LOW_M = 0.3
"""Lower returns are the road."""
FEWEST, MOST = 20, 400
"""Ends in a picture that counts; more cost time and add little."""
BLUR_PX = 3
"""Brightness is compared this far to the left and to the right of an end (px)."""
STRONG = 40.0
"""A stronger edge (0 to 255) counts as much as this one: a lamp must not outvote all others."""
AROUND_RAD = math.radians(0.9)
"""Angles this close to the best one belong to it."""
CLEAR = 0.4
"""How far the edges at the best angle must stand out from those at all others, as a share of how far they stand out
from usual ones. On 54 drives 3 % of the measurements were off by more than 0.7 degrees with it; without it 9 % on 21 of
them, most of these in heavy rain at night.
"""
FAINT = 2.0
"""Weaker edges at the best angle (0 to 255) are the noise of the picture, or fog."""
MOVES_MPS = 1.0
"""A slower vehicle would look at the same scene again and again."""
MEASUREMENTS, AGREEING = 8, 7
"""See `AngleConsensus`: one more than for the LiDAR, since the same scene may mislead two measurements."""


class CameraAlignment:
    """Call `look` with each picture, and `measure` when it is known anew how far the LiDAR is turned."""

    def __init__(self, rig: Rig) -> None:
        self._rig = rig
        self._strength, self._count = np.zeros(len(ANGLES_RAD)), 0
        self._agreement = AngleConsensus(MEASUREMENTS, AGREEING)

    @property
    def turned_rad(self) -> float | None:
        """How far the camera is turned to the left (rad); None if it is not, or if this is not certain."""
        return self._agreement.turned_rad

    def look(self, frame: CameraFrame, pose: PoseEstimate, sweeps: Iterable[tuple[LidarSweep, PoseEstimate]]) -> None:
        """Compare a picture with the LiDAR.

        Args:
            frame: Of the front camera.
            pose: The vehicle's pose at its time.
            sweeps: In the vehicle frame, each with the pose at its time; those that are older than a turn are left out.
        """
        if abs(pose.speed_mps) < MOVES_MPS:
            return
        fresh = [item for item in sweeps if abs(item[1].time_s - pose.time_s) <= RECENT_S]
        ends = [_seen_from(ends_of(sweep.points, self._rig.lidar), then, pose) for sweep, then in fresh]
        if not ends:
            return
        strength, count = edges_by_angle(frame, np.concatenate(ends), self._rig.camera)
        if count >= FEWEST:
            self._strength += count * strength
            self._count += count

    def measure(self, lidar_turned_rad: float) -> float | None:
        """Conclude from the pictures since the last call how far the camera is turned to the left (rad).

        Args:
            lidar_turned_rad: How far the LiDAR was turned to the left meanwhile.

        Returns:
            None if they do not show it.
        """
        if not self._count:
            return None
        strength = self._strength / self._count
        self._strength, self._count = np.zeros(len(ANGLES_RAD)), 0
        best = int(strength.argmax())
        beyond = best in (0, len(ANGLES_RAD) - 1)
        elsewhere = float(strength[np.abs(ANGLES_RAD - ANGLES_RAD[best]) > AROUND_RAD].max())
        clear = strength[best] - elsewhere >= CLEAR * (strength[best] - float(np.median(strength)))
        if beyond or not clear or strength[best] < FAINT:
            return None
        turned_rad = float(ANGLES_RAD[best]) + lidar_turned_rad
        self._agreement.add(turned_rad)
        return turned_rad


def ends_of(points: Singles, lidar: LidarRig) -> Floats:
    """(n, 3): the returns of a sweep ahead of the vehicle with which something ends, to the left or to the right."""
    mount = lidar.mount
    ahead = points[(points[:, 0] > NEAR_M) & (np.abs(points[:, 1]) < 1.2 * points[:, 0]), :3].astype(np.float64)
    x, y, z = (ahead - np.array([mount.x_m, mount.y_m, mount.z_m])).T
    far, azimuth = np.hypot(x, y), np.arctan2(y, x)
    step = math.radians(lidar.upper_deg - lidar.lower_deg) / (lidar.channels - 1)
    channel = np.round((np.arctan2(z, far) - math.radians(lidar.lower_deg)) / step)
    order = np.lexsort((azimuth, channel))
    far, azimuth, channel = far[order], azimuth[order], channel[order]
    same, apart, jump = np.diff(channel) == 0.0, np.diff(azimuth), np.diff(far)
    jumps = same & (apart < BESIDE_RAD) & (np.abs(jump) > JUMP_M + JUMP_SHARE * np.minimum(far[1:], far[:-1]))
    sky = same & (apart > GAP_RAD)
    found = np.zeros(len(far), np.bool_)
    found[1:] |= sky | (jumps & (jump < 0.0))
    found[:-1] |= sky | (jumps & (jump > 0.0))
    ends: Floats = ahead[order[found]]
    return ends[ends[:, 2] > LOW_M]


def edges_by_angle(frame: CameraFrame, ends: Floats, camera: CameraRig) -> tuple[Floats, int]:
    """Return how strong the picture's edges are at ends (n, 3; vehicle frame), for each of `ANGLES_RAD`.

    Only ends that are in the picture at all of these angles are used; their number is returned, too.
    """
    mount = camera.mount.to_vehicle()
    seen = (ends - mount[:3, 3]) @ mount[:3, :3]
    azimuth = np.arctan2(seen[:, 1], seen[:, 0])
    steep = seen[:, 2] / np.maximum(np.hypot(seen[:, 0], seen[:, 1]), 1e-3)
    wide = math.radians(camera.fov_deg) / 2.0
    high = (camera.height_px / 2.0 - 1.0) / camera.focal_px * math.cos(wide)
    shown = np.flatnonzero((np.abs(azimuth) < wide - ANGLES_RAD[-1]) & (np.abs(steep) < high))
    if len(shown) == 0:
        return np.zeros(len(ANGLES_RAD)), 0
    some = shown[:: math.ceil(len(shown) / MOST)]
    off = azimuth[some, None] - ANGLES_RAD
    column = (camera.width_px / 2.0 - camera.focal_px * np.tan(off)).astype(np.int64)
    row = (camera.height_px / 2.0 - camera.focal_px * steep[some, None] / np.cos(off)).astype(np.int64)
    column = np.clip(column, BLUR_PX, camera.width_px - 1 - BLUR_PX)
    left, right = (frame.rgb[row, column + aside, 1].astype(np.float64) for aside in (-BLUR_PX, BLUR_PX))
    return np.minimum(np.abs(right - left), STRONG).mean(axis=0), len(some)


def _seen_from(points: Floats, then: PoseEstimate, now: PoseEstimate) -> Floats:
    """Points (n, 3) of the vehicle frame at one pose, in that at another."""
    cos, sin = math.cos(then.yaw_rad), math.sin(then.yaw_rad)
    x = then.x_m + cos * points[:, 0] - sin * points[:, 1]
    y = then.y_m + sin * points[:, 0] + cos * points[:, 1]
    return np.column_stack([points_into_vehicle(np.stack([x, y], axis=1), now), points[:, 2]])
