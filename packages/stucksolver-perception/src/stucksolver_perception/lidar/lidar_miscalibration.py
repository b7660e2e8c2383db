"""Detects during driving that the LiDAR is turned about the vertical axis.

A vehicle that drives straight ahead moves along its own axis. If its LiDAR is turned, walls and poles seem to move
along an axis that is turned too: by 0.35 m to the side over 10 m for 2 degrees. So two turns of the LiDAR, measured
some meters apart, are matched with their upright surfaces (generalized ICP in the plane; Segal, Haehnel and Thrun
2009). The direction of the motion between them is compared with that of dead reckoning with wheels and gyro. This also
works in bends, because the rotation between the two turns is estimated too.

A match may be wrong: the tires slip, the vehicle is hit, or a column of cars moves past. So the sensor counts as turned
only if nearly all of several consecutive matches agree. Without upright surfaces there is no match, and no result.
"""

from __future__ import annotations

import math
from collections import deque
from typing import Any, NamedTuple

import numpy as np

from stucksolver_perception.angle_consensus import AngleConsensus
from stucksolver_perception.free_space import within
from stucksolver_perception.lidar.sweeps import RECENT_S
from stucksolver_perception.localization.ekf_localizer import REAR_AXLE_M
from stucksolver_perception.measurements import Floats, LidarSweep, PoseEstimate, Singles
from stucksolver_perception.rig import LidarRig

MIN_DISTANCE_M, MIN_TIME_S = 6.0, 0.8
"""Minimum distance (m) and time (s) between two matched turns. Less motion gives a less accurate angle, at a higher
cost. Ours."""
MAX_TIME_S = 8.0
"""Maximum time between two matched turns (s), because the gyro's errors add up. Ours."""
PAUSE_S = 0.25
"""Maximum time between two poses (s). After a longer pause, the motion since the last turn is unknown. Ours."""
LATERAL_MPS2 = 1.5
"""Maximum lateral acceleration (m/s²). Above it the tires slip by up to a degree: as a rule of thumb, half a degree per
m/s²."""
JOLT_MPS2 = 12.0
"""Acceleration that neither brake nor engine reaches (m/s²): the vehicle was hit."""
JOLT_MPS = 0.2
"""Allowance for the noise of the wheels' speed from one sweep to the next (m/s)."""
MAX_TURN_RAD = math.radians(12.0)
"""Maximum yaw between two matched turns (rad). Above it, the result depends too much on the position of the rear axle:
at 12 degrees, half a meter causes an error of one degree."""

NEAR_M, FAR_M = 3.5, 50.0
"""Distances between which upright surfaces count (m): not on the ego, and where returns are dense. Ours."""
LOW_M = 0.6
"""Minimum height of a return (m), above those that change with the vehicle's pitch. Ours."""
TURN_MOTION_M = 10.0
"""Maximum motion of the vehicle during one turn of the LiDAR (m)."""
CELL_M = 0.3
"""Side of a cell of the grid for upright surfaces (m). Ours."""
UPRIGHT_M = 0.5
"""Minimum height that the returns of an upright cell span (m): walls, poles and trunks, not slopes and treetops.
Ours."""
MIN_RETURNS = 3
"""Minimum number of returns of an upright cell. Ours."""
MAX_CELLS = 300
"""Maximum number of cells of the second turn; more cells cost time and add little accuracy. Ours."""
MIN_CELLS = 40
"""Minimum number of upright cells of a turn. Ours."""
MARGIN_M = 0.5
"""Margin around the box of a moving object within which returns may come from it (m). Ours."""

NEIGHBORS, NEIGHBOR_M = 8, 1.0
"""Maximum number and distance (m) of the cells from which a surface's direction is computed. Ours."""
SURFACE_M = 0.05
"""Standard deviation of a cell's center across its surface (m). Ours."""
START_ANGLES_RAD = np.radians(np.arange(-8.0, 8.1, 2.0))
"""Angles from which a match may start, so that large errors are detected too. Ours."""
WIDE_M, NARROW_M = 1.0, 0.5
"""Maximum distance of corresponding cells, in the first steps and in the last ones (m). Ours."""
WIDE_STEPS, STEPS = 4, 10
"""Number of first steps, and maximum number of all steps. Ours."""
CONVERGED_RAD = 2e-4
"""Change below which the iteration ends (rad). Ours."""
GYRO_SD_RAD, WHEEL_SD = 0.03, 0.03
"""Standard deviations of the turn from the gyro (rad), and of the distance from the wheels as a share of it. Ours."""
MIN_FIT = 0.3
"""Minimum share of the second turn's cells that match, weighted by their fit. Ours."""
MAX_SD_RAD = math.radians(0.3)
"""Maximum standard deviation of the angle of a match that counts (rad). Ours."""

MATCHES, AGREEING = 6, 5
"""Number of matches, and number of them that must agree; see `AngleConsensus`."""


class Match(NamedTuple):
    """The result of matching two turns of the LiDAR."""

    turned_rad: float
    """Yaw error of the LiDAR, positive to the left (rad)."""
    sd_rad: float
    """Standard deviation of the yaw error (rad)."""
    fit_share: float
    """Share of the cells that match; see `MIN_FIT`."""


class _OdometryPose(NamedTuple):
    """The vehicle's pose from dead reckoning. It is 0 at the first sweep."""

    time_s: float = 0.0
    odometer_m: float = 0.0
    x_m: float = 0.0
    y_m: float = 0.0
    yaw_rad: float = 0.0

    def moved_by(self, speed_mps: float, rate_rps: float, dt: float) -> _OdometryPose:
        """Return the pose after `dt` seconds; see `localization.vehicle_state_model.predict_state`."""
        mid_yaw, lateral_mps = self.yaw_rad + rate_rps * dt / 2.0, REAR_AXLE_M * rate_rps
        return _OdometryPose(
            self.time_s + dt,
            self.odometer_m + abs(speed_mps) * dt,
            self.x_m + (speed_mps * math.cos(mid_yaw) - lateral_mps * math.sin(mid_yaw)) * dt,
            self.y_m + (speed_mps * math.sin(mid_yaw) + lateral_mps * math.cos(mid_yaw)) * dt,
            self.yaw_rad + rate_rps * dt,
        )

    def relative_to(self, other: _OdometryPose) -> tuple[Floats, float]:
        """Return this position (2,) in the vehicle frame at another pose (m), and its yaw there (rad)."""
        offset = np.array([self.x_m - other.x_m, self.y_m - other.y_m])
        return _rotation(-other.yaw_rad) @ offset, self.yaw_rad - other.yaw_rad


class _Turn(NamedTuple):
    """The upright surfaces of one turn of the LiDAR."""

    odometry: _OdometryPose
    """Pose at the end of the turn."""
    cells: Floats
    """(n, 2): centers of the cells in the vehicle frame (m)."""
    covariances: Floats
    """(n, 2, 2): covariances of these centers (m²)."""
    tree: Any
    """Search tree of the cells."""


class LidarAlignment:
    """Detector of a turned LiDAR. Call `add` with each sweep, in order of time, and `look` regularly."""

    def __init__(self, lidar: LidarRig) -> None:
        # The import takes 0.2 s. It happens here so that it does not delay a cycle.
        from scipy.spatial import cKDTree  # type: ignore[import-untyped]

        self._tree: Any = cKDTree
        self._foot = np.array([lidar.mount.x_m, lidar.mount.y_m])
        self._pose: PoseEstimate | None = None
        self._odometry = _OdometryPose()
        self._sweeps: deque[tuple[_OdometryPose, Singles]] = deque()
        """The returns of the last turn that may come from upright surfaces."""
        self._is_unreliable = False
        """True if the motion since the last match is not known well enough."""
        self._before: _Turn | None = None
        self._consensus = AngleConsensus(MATCHES, AGREEING)

    @property
    def turned_rad(self) -> float | None:
        """Yaw error of the LiDAR, positive to the left (rad); None without a certain one."""
        return self._consensus.turned_rad

    def add(self, sweep: LidarSweep, pose: PoseEstimate) -> None:
        """Add the next sweep.

        Args:
            sweep: Points in the vehicle frame.
            pose: The vehicle's pose at the time of the sweep. Only speed and yaw rate are used, because satellite fixes
                shift the position by decimeters.
        """
        self._move(pose)
        range_m = np.hypot(sweep.points[:, 0], sweep.points[:, 1])
        usable = (range_m > NEAR_M) & (range_m < FAR_M) & (sweep.points[:, 2] > LOW_M)
        self._sweeps.append((self._odometry, sweep.points[usable, :3]))
        while self._odometry.time_s - self._sweeps[0][0].time_s > RECENT_S:
            self._sweeps.popleft()

    def look(self, moving: Floats) -> Match | None:
        """Match the last turn with an earlier one if the vehicle has moved far enough, and return a reliable match.

        Args:
            moving: (k, 5): footprints of objects that may move, in the vehicle frame of the last sweep's pose; see
                `free_space.within`.
        """
        before, is_unreliable = self._before, self._is_unreliable
        if not self._sweeps or (before is not None and not self._is_due(before.odometry)):
            return None
        self._before, self._is_unreliable = self._take_turn(moving), False
        if (
            before is None
            or self._before is None
            or is_unreliable
            or self._odometry.time_s - before.odometry.time_s > MAX_TIME_S
        ):
            return None
        match = self._match_turns(before, self._before)
        if match is None or match.fit_share < MIN_FIT or match.sd_rad > MAX_SD_RAD:
            return None
        self._consensus.add(match.turned_rad)
        return match

    def _move(self, pose: PoseEstimate) -> None:
        last, self._pose = self._pose, pose
        if last is None:
            self._odometry = _OdometryPose(pose.time_s)
            return
        dt = pose.time_s - last.time_s
        speed, rate = (pose.speed_mps + last.speed_mps) / 2.0, pose.yaw_rate_rps
        was_hit = abs(pose.speed_mps - last.speed_mps) > JOLT_MPS2 * dt + JOLT_MPS
        self._is_unreliable |= dt > PAUSE_S or was_hit or abs(speed * rate) > LATERAL_MPS2
        self._odometry = self._odometry.moved_by(speed, rate, dt)

    def _is_due(self, before: _OdometryPose) -> bool:
        is_far_enough = self._odometry.odometer_m - before.odometer_m >= MIN_DISTANCE_M
        return is_far_enough and self._odometry.time_s - before.time_s >= MIN_TIME_S

    def _take_turn(self, moving: Floats) -> _Turn | None:
        """Return the last turn; None if it has too few upright surfaces."""
        parts = []
        for odometry, points in self._sweeps:
            shift, yaw = odometry.relative_to(self._odometry)
            parts.append(np.column_stack([points[:, :2] @ _rotation(yaw).T + shift, points[:, 2]]))
        cells = upright_cells(np.concatenate(parts), moving)
        if len(cells) < MIN_CELLS:
            return None
        tree = self._tree(cells)
        return _Turn(self._odometry, cells, _cell_covariances(cells, tree), tree)

    def _match_turns(self, before: _Turn, now: _Turn) -> Match | None:
        moved, turn_rad = now.odometry.relative_to(before.odometry)
        if abs(turn_rad) > MAX_TURN_RAD:
            return None
        # The motion of the reference point becomes that of the LiDAR, around which the points turn.
        moved = moved + (_rotation(turn_rad) - np.eye(2)) @ self._foot
        if math.hypot(*moved) < MIN_DISTANCE_M / 2.0:
            return None
        return _match(before, now, turn_rad, moved, self._foot)


def upright_cells(points: Floats, moving: Floats) -> Floats:
    """Return (m, 2): centers of the cells with an upright surface that does not move.

    Args:
        points: (n, 3): x, y, z (m) in the vehicle frame.
        moving: See `LidarAlignment.look`.
    """
    x, y, z = points.T
    reach, side = FAR_M + TURN_MOTION_M, math.ceil(2.0 * (FAR_M + TURN_MOTION_M) / CELL_M) + 1
    cell = ((x + reach) / CELL_M).astype(np.int64) * side + ((y + reach) / CELL_M).astype(np.int64)
    count = np.bincount(cell, minlength=side * side)
    low, high = np.full(side * side, np.inf), np.full(side * side, -np.inf)
    np.minimum.at(low, cell, z)
    np.maximum.at(high, cell, z)
    upright = (count >= MIN_RETURNS) & (high - low >= UPRIGHT_M)
    centers = [np.bincount(cell, axis, side * side)[upright] / count[upright] for axis in (x, y)]
    is_static = ~within(moving, centers[0], centers[1], MARGIN_M, MARGIN_M)
    return np.stack(centers, axis=1)[is_static]


def _cell_covariances(cells: Floats, tree: Any) -> Floats:
    """Return (n, 2, 2): the covariance of each cell's center, large along its surface and small across it (m²)."""
    distance, index = tree.query(cells, k=NEIGHBORS, distance_upper_bound=NEIGHBOR_M)
    is_near = np.isfinite(distance)
    neighbors = cells[np.where(is_near, index, 0)]
    count = is_near.sum(axis=1)[:, None]
    mean = (neighbors * is_near[..., None]).sum(axis=1) / count
    offset = (neighbors - mean[:, None]) * is_near[..., None]
    covariance: Floats = offset.transpose(0, 2, 1) @ offset / count[..., None] + SURFACE_M**2 * np.eye(2)
    return covariance


def _match(before: _Turn, now: _Turn, turn_rad: float, moved: Floats, foot: Floats) -> Match | None:
    """Match two turns with Gauss-Newton steps and the weights of Geman and McClure.

    Return the match; None without enough corresponding cells. The estimates are the angle of the motion, the error of
    the turn, and the scale of the distance. The last two have the standard deviations of gyro and wheels.
    """
    sample = slice(None, None, max(1, math.ceil(len(now.cells) / MAX_CELLS)))
    cells, covariances = now.cells[sample] - foot, now.covariances[sample]
    reference = before.cells - foot
    angle, error, scale = _start_angle(before, cells, turn_rad, moved, foot), 0.0, 1.0
    prior = np.diag([0.0, GYRO_SD_RAD**-2, WHEEL_SD**-2])
    for step in range(STEPS):
        turned = cells @ _rotation(turn_rad + error).T
        shift = scale * (_rotation(angle) @ moved)
        reach = WIDE_M if step < WIDE_STEPS else NARROW_M
        distance, index = before.tree.query(turned + shift + foot, distance_upper_bound=reach)
        is_near = np.isfinite(distance)
        if int(is_near.sum()) < MIN_CELLS / 2:
            return None
        rotation = _rotation(turn_rad + error)
        residual = turned[is_near] + shift - reference[index[is_near]]
        weight = _inverse(before.covariances[index[is_near]] + rotation @ covariances[is_near] @ rotation.T)
        fit = 1.0 / (1.0 + np.einsum("ni,nij,nj->n", residual, weight, residual) / 2.0) ** 2
        shape = residual.shape
        columns = (np.broadcast_to(_left(shift), shape), _left(turned[is_near]), np.broadcast_to(shift, shape))
        jacobian = np.stack(columns, axis=2)
        weighted = (fit[:, None, None] * (weight @ jacobian)).reshape(-1, 3)
        normal = jacobian.reshape(-1, 3).T @ weighted + prior
        gradient = weighted.T @ residual.ravel() + prior @ np.array([0.0, error, scale - 1.0])
        try:
            covariance = np.linalg.inv(normal)
        except np.linalg.LinAlgError:
            # The matched cells do not determine the motion, so there is no match.
            return None
        change = -covariance @ gradient
        angle, error, scale = angle + change[0], error + change[1], scale + change[2]
        if step > WIDE_STEPS and abs(change).max() < CONVERGED_RAD:
            break
    # An error of the gyro that grows evenly turns the motion by half of the angle by which it turns the vehicle.
    sd_rad = math.sqrt(covariance[0, 0]) if covariance[0, 0] > 0.0 else math.inf
    return Match(error / 2.0 - angle, sd_rad, float(fit.sum()) / len(cells))


def _start_angle(before: _Turn, cells: Floats, turn_rad: float, moved: Floats, foot: Floats) -> float:
    """Return the angle of `START_ANGLES_RAD` with which most cells are near cells of the other turn."""
    turned = cells @ _rotation(turn_rad).T + foot
    distance = [
        before.tree.query(turned + _rotation(a) @ moved, distance_upper_bound=NARROW_M)[0] for a in START_ANGLES_RAD
    ]
    score = np.maximum(0.0, 1.0 - (np.minimum(distance, NARROW_M) / NARROW_M) ** 2).sum(axis=1)
    return float(START_ANGLES_RAD[int(score.argmax())])


def _rotation(angle_rad: float) -> Floats:
    cos, sin = math.cos(angle_rad), math.sin(angle_rad)
    return np.array([[cos, -sin], [sin, cos]])


def _left(vectors: Floats) -> Floats:
    """Return vectors (…, 2) turned by 90 degrees to the left."""
    return np.stack([-vectors[..., 1], vectors[..., 0]], axis=-1)


def _inverse(matrices: Floats) -> Floats:
    """Return (n, 2, 2): inverses of symmetric matrices. numpy's function takes ten times as long."""
    a, b, d = matrices[:, 0, 0], matrices[:, 0, 1], matrices[:, 1, 1]
    inverse: Floats = np.stack([np.stack([d, -b], 1), np.stack([-b, a], 1)], 1) / (a * d - b * b)[:, None, None]
    return inverse
