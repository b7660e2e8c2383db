"""Notices while the vehicle drives that its LiDAR is turned about the vertical axis.

A vehicle that drives straight ahead moves along its own axis. If its LiDAR is turned, walls and poles seem to move
along an axis that is turned as well: by 0.35 m to the side on 10 m for 2 degrees. So two turns of the LiDAR, taken some
meters apart, are matched by their upright surfaces (generalized ICP in the plane; Segal, Haehnel and Thrun 2009), and
the direction of the motion between them is compared with that of dead reckoning by wheels and gyro. In a bend this
works as well, since the rotation between both is estimated, too.

A match may be wrong: the tires slip, the vehicle is hit, a column of cars moves past. So the sensor counts as turned
only if nearly all of several matches in a row agree. Where nothing stands upright there is no match, and nothing is
said.
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

APART_M, APART_S = 6.0, 0.8
"""Two turns are matched after this distance and time at least: less shifts too little, and costs more."""
LONGEST_S = 8.0
"""Not after a longer time: the gyro's errors add up."""
PAUSE_S = 0.25
"""If there is no pose for longer, the motion since the last turn is not known."""
SIDEWAYS_MPS2 = 1.5
"""With more lateral acceleration the tires slip by up to a degree, as a rule of thumb half a degree per m/s2."""
JOLT_MPS2 = 12.0
"""No brake and no engine changes the speed faster: the vehicle was hit."""
JOLT_MPS = 0.2
"""Noise of the wheels' speed, from one sweep to the next."""
TURNS_RAD = math.radians(12.0)
"""If the vehicle turned further, too much depends on where its rear axle is: half a meter makes a degree of 12."""

NEAR_M, FAR_M = 3.5, 50.0
"""Upright surfaces are looked for between these distances: not on the vehicle itself, and where returns are dense."""
LOW_M = 0.6
"""Above what changes with the pitch of the vehicle."""
SEAM_M = 10.0
"""The vehicle moves no further than this during one turn."""
CELL_M = 0.3
"""Side of a cell of the grid in which upright surfaces are looked for."""
SPAN_M = 0.5
"""A cell is upright if its returns span this height: walls, poles, trunks, not slopes and treetops, ..."""
FEWEST_RETURNS = 3
"""... and if there are at least so many."""
MOST_CELLS = 300
"""Of the second turn; more cost time and add little."""
FEWEST_CELLS = 40
MARGIN_M = 0.5
"""Returns this far outside of the box of something that moves may be from it."""

NEIGHBORS, NEIGHBORHOOD_M = 8, 1.0
"""Cells that tell the direction of a surface."""
SURFACE_M = 0.05
"""Standard deviation of a cell's middle across its surface."""
STARTS_RAD = np.radians(np.arange(-8.0, 8.1, 2.0))
"""Angles from which a match may start: even a large one is found."""
WIDE_M, NARROW_M = 1.0, 0.5
"""Cells further apart than this do not belong together: in the first steps, and in the last ones."""
WIDE_STEPS, STEPS = 4, 10
DONE_RAD = 2e-4
GYRO_SD_RAD, WHEELS_SD = 0.03, 0.03
"""Standard deviations of the turn by gyro, and of the distance by wheels as a share of it."""
FITS = 0.3
"""Share of the second turn's cells, weighted by how well they fit, in a match that counts."""
SURE_RAD = math.radians(0.3)
"""Standard deviation of the angle in a match that counts."""

MATCHES, AGREEING = 6, 5
"""See `AngleConsensus`."""


class Match(NamedTuple):
    """What two turns of the LiDAR say."""

    turned_rad: float
    """How far the LiDAR is turned to the left."""
    sd_rad: float
    fits: float
    """See `FITS`."""


class _Place(NamedTuple):
    """Where the vehicle is by dead reckoning."""

    time_s: float = 0.0
    odometer_m: float = 0.0
    x_m: float = 0.0
    y_m: float = 0.0
    yaw_rad: float = 0.0

    def onward(self, speed_mps: float, rate_rps: float, dt: float) -> _Place:
        """Return the place after `dt` seconds; see `localization.model.onward`."""
        middle, aside = self.yaw_rad + rate_rps * dt / 2.0, REAR_AXLE_M * rate_rps
        return _Place(
            self.time_s + dt,
            self.odometer_m + abs(speed_mps) * dt,
            self.x_m + (speed_mps * math.cos(middle) - aside * math.sin(middle)) * dt,
            self.y_m + (speed_mps * math.sin(middle) + aside * math.cos(middle)) * dt,
            self.yaw_rad + rate_rps * dt,
        )

    def relative_to(self, other: _Place) -> tuple[Floats, float]:
        """Return this place (2,) in the vehicle frame at another, and its yaw there."""
        away = np.array([self.x_m - other.x_m, self.y_m - other.y_m])
        return _turning(-other.yaw_rad) @ away, self.yaw_rad - other.yaw_rad


class _Turn(NamedTuple):
    """The upright surfaces of one turn of the LiDAR, and where it was taken."""

    place: _Place
    cells: Floats
    spreads: Floats
    """(n, 2, 2): covariances of the cells' middles."""
    tree: Any


class LidarAlignment:
    """Call `add` with each sweep, in order of time, and `look` now and then."""

    def __init__(self, lidar: LidarRig) -> None:
        # Imported now, not on the road: it takes 0.2 s.
        from scipy.spatial import cKDTree  # type: ignore[import-untyped]

        self._tree: Any = cKDTree
        self._foot = np.array([lidar.mount.x_m, lidar.mount.y_m])
        self._pose: PoseEstimate | None = None
        self._place = _Place()
        self._sweeps: deque[tuple[_Place, Singles]] = deque()
        """The returns of the last turn that may be from upright surfaces."""
        self._spoilt = False
        """True if the motion since the last look cannot be told well enough."""
        self._before: _Turn | None = None
        self._agreement = AngleConsensus(MATCHES, AGREEING)

    @property
    def turned_rad(self) -> float | None:
        """How far the LiDAR is turned to the left (rad); None if it is not, or if this is not certain."""
        return self._agreement.turned_rad

    def add(self, sweep: LidarSweep, pose: PoseEstimate) -> None:
        """Add the next sweep.

        Args:
            sweep: In the vehicle frame.
            pose: At its time. Only speed and yaw rate are used: satellites shift the position by decimeters.
        """
        self._move(pose)
        far = np.hypot(sweep.points[:, 0], sweep.points[:, 1])
        kept = (far > NEAR_M) & (far < FAR_M) & (sweep.points[:, 2] > LOW_M)
        self._sweeps.append((self._place, sweep.points[kept, :3]))
        while self._place.time_s - self._sweeps[0][0].time_s > RECENT_S:
            self._sweeps.popleft()

    def look(self, moving: Floats) -> Match | None:
        """Match the last turn with the one before, if the vehicle has moved far enough.

        Args:
            moving: (k, 5): footprints of what may move, in the vehicle frame of the last sweep's pose, as
                `visibility.within` takes them.

        Returns:
            A new match that counts; None if there is none.
        """
        before, spoilt = self._before, self._spoilt
        if not self._sweeps or (before is not None and not self._is_due(before.place)):
            return None
        self._before, self._spoilt = self._taken(moving), False
        if before is None or self._before is None or spoilt or self._place.time_s - before.place.time_s > LONGEST_S:
            return None
        match = self._matched(before, self._before)
        if match is None or match.fits < FITS or match.sd_rad > SURE_RAD:
            return None
        self._agreement.add(match.turned_rad)
        return match

    def _move(self, pose: PoseEstimate) -> None:
        last, self._pose = self._pose, pose
        if last is None:
            self._place = _Place(pose.time_s)
            return
        dt = pose.time_s - last.time_s
        speed, rate = (pose.speed_mps + last.speed_mps) / 2.0, pose.yaw_rate_rps
        jolted = abs(pose.speed_mps - last.speed_mps) > JOLT_MPS2 * dt + JOLT_MPS
        self._spoilt |= dt > PAUSE_S or jolted or abs(speed * rate) > SIDEWAYS_MPS2
        self._place = self._place.onward(speed, rate, dt)

    def _is_due(self, before: _Place) -> bool:
        far = self._place.odometer_m - before.odometer_m >= APART_M
        return far and self._place.time_s - before.time_s >= APART_S

    def _taken(self, moving: Floats) -> _Turn | None:
        """Return the last turn; None if hardly anything stands upright."""
        parts = []
        for place, points in self._sweeps:
            shift, yaw = place.relative_to(self._place)
            parts.append(np.column_stack([points[:, :2] @ _turning(yaw).T + shift, points[:, 2]]))
        cells = upright_cells(np.concatenate(parts), moving)
        if len(cells) < FEWEST_CELLS:
            return None
        tree = self._tree(cells)
        return _Turn(self._place, cells, _spreads(cells, tree), tree)

    def _matched(self, before: _Turn, now: _Turn) -> Match | None:
        moved, turn_rad = now.place.relative_to(before.place)
        if abs(turn_rad) > TURNS_RAD:
            return None
        # Points turn around the LiDAR, not around the reference point.
        moved = moved + (_turning(turn_rad) - np.eye(2)) @ self._foot
        if math.hypot(*moved) < APART_M / 2.0:
            return None
        return _match(before, now, turn_rad, moved, self._foot)


def upright_cells(points: Floats, moving: Floats) -> Floats:
    """(m, 2): middles of the cells in which something upright stands that does not move.

    Args:
        points: (n, 3): x, y, z (m) in the vehicle frame.
        moving: See `LidarAlignment.look`.
    """
    x, y, z = points.T
    reach, side = FAR_M + SEAM_M, math.ceil(2.0 * (FAR_M + SEAM_M) / CELL_M) + 1
    cell = ((x + reach) / CELL_M).astype(np.int64) * side + ((y + reach) / CELL_M).astype(np.int64)
    count = np.bincount(cell, minlength=side * side)
    low, high = np.full(side * side, np.inf), np.full(side * side, -np.inf)
    np.minimum.at(low, cell, z)
    np.maximum.at(high, cell, z)
    upright = (count >= FEWEST_RETURNS) & (high - low >= SPAN_M)
    middles = [np.bincount(cell, item, side * side)[upright] / count[upright] for item in (x, y)]
    stands = ~within(moving, middles[0], middles[1], MARGIN_M, MARGIN_M)
    return np.stack(middles, axis=1)[stands]


def _spreads(cells: Floats, tree: Any) -> Floats:
    """(n, 2, 2): covariance of each cell's middle: large along its surface, small across it."""
    distance, index = tree.query(cells, k=NEIGHBORS, distance_upper_bound=NEIGHBORHOOD_M)
    near = np.isfinite(distance)
    around = cells[np.where(near, index, 0)]
    count = near.sum(axis=1)[:, None]
    off = (around - ((around * near[..., None]).sum(axis=1) / count)[:, None]) * near[..., None]
    spread: Floats = off.transpose(0, 2, 1) @ off / count[..., None] + SURFACE_M**2 * np.eye(2)
    return spread


def _match(before: _Turn, now: _Turn, turn_rad: float, moved: Floats, foot: Floats) -> Match | None:
    """Match two turns by Gauss-Newton steps with weights after Geman and McClure.

    Estimated are the angle by which the motion seems turned, the error of the turn, and the scale of the distance; the
    latter two only as far as gyro and wheels may be wrong.
    """
    some = slice(None, None, max(1, math.ceil(len(now.cells) / MOST_CELLS)))
    cells, spreads = now.cells[some] - foot, now.spreads[some]
    reference = before.cells - foot
    angle, error, scale = _start(before, cells, turn_rad, moved, foot), 0.0, 1.0
    prior = np.diag([0.0, GYRO_SD_RAD**-2, WHEELS_SD**-2])
    for step in range(STEPS):
        turned = cells @ _turning(turn_rad + error).T
        shift = scale * (_turning(angle) @ moved)
        reach = WIDE_M if step < WIDE_STEPS else NARROW_M
        distance, index = before.tree.query(turned + shift + foot, distance_upper_bound=reach)
        near = np.isfinite(distance)
        if int(near.sum()) < FEWEST_CELLS / 2:
            return None
        turning = _turning(turn_rad + error)
        off = turned[near] + shift - reference[index[near]]
        weight = _inverse(before.spreads[index[near]] + turning @ spreads[near] @ turning.T)
        fit = 1.0 / (1.0 + np.einsum("ni,nij,nj->n", off, weight, off) / 2.0) ** 2
        ways = (np.broadcast_to(_left(shift), off.shape), _left(turned[near]), np.broadcast_to(shift, off.shape))
        by = np.stack(ways, axis=2)
        fitted = (fit[:, None, None] * (weight @ by)).reshape(-1, 3)
        normal = by.reshape(-1, 3).T @ fitted + prior
        gradient = fitted.T @ off.ravel() + prior @ np.array([0.0, error, scale - 1.0])
        try:
            covariance = np.linalg.inv(normal)
        except np.linalg.LinAlgError:
            return None
        change = -covariance @ gradient
        angle, error, scale = angle + change[0], error + change[1], scale + change[2]
        if step > WIDE_STEPS and abs(change).max() < DONE_RAD:
            break
    # An error of the gyro that grows evenly turned the motion by half of what it turned the vehicle.
    sd_rad = math.sqrt(covariance[0, 0]) if covariance[0, 0] > 0.0 else math.inf
    return Match(error / 2.0 - angle, sd_rad, float(fit.sum()) / len(cells))


def _start(before: _Turn, cells: Floats, turn_rad: float, moved: Floats, foot: Floats) -> float:
    """Return the angle of `STARTS_RAD` with which most cells come to lie near others."""
    turned = cells @ _turning(turn_rad).T + foot
    distance = [before.tree.query(turned + _turning(a) @ moved, distance_upper_bound=NARROW_M)[0] for a in STARTS_RAD]
    score = np.maximum(0.0, 1.0 - (np.minimum(distance, NARROW_M) / NARROW_M) ** 2).sum(axis=1)
    return float(STARTS_RAD[int(score.argmax())])


def _turning(angle_rad: float) -> Floats:
    cos, sin = math.cos(angle_rad), math.sin(angle_rad)
    return np.array([[cos, -sin], [sin, cos]])


def _left(vectors: Floats) -> Floats:
    """Vectors (…, 2), turned by 90 degrees to the left."""
    return np.stack([-vectors[..., 1], vectors[..., 0]], axis=-1)


def _inverse(matrices: Floats) -> Floats:
    """(n, 2, 2): inverses of symmetric matrices; numpy's own takes ten times as long."""
    a, b, d = matrices[:, 0, 0], matrices[:, 0, 1], matrices[:, 1, 1]
    inverse: Floats = np.stack([np.stack([d, -b], 1), np.stack([-b, a], 1)], 1) / (a * d - b * b)[:, None, None]
    return inverse
