"""A LiDAR as the rig has it, in a world of a flat road and boxes."""

import numpy as np

from stucksolver_perception.lidar.sweeps import SweepBuffer
from stucksolver_perception.measurements import Floats, LidarSweep, PoseEstimate, Singles
from stucksolver_perception.rig import load_rig

RIG = load_rig().lidar
TICK_S = 0.05


def scan(boxes: Floats, time_s: float, seed: int = 0) -> LidarSweep:
    """The half turn that a tick holds, seen by a vehicle that stands at the origin.

    Args:
        boxes: (n, 7): middle x, y, z, length, width, height, yaw.
        time_s: Odd and even ticks see opposite sides.
        seed: Of what drops off.
    """
    random = np.random.default_rng([seed, round(time_s / TICK_S)])
    count = round(RIG.points_per_s * TICK_S / RIG.channels)
    half = round(time_s / TICK_S) % 2
    azimuth = np.pi * (half + np.arange(count) / count)
    elevation = np.radians(np.linspace(RIG.lower_deg, RIG.upper_deg, RIG.channels))
    turn, tilt = (item.ravel() for item in np.meshgrid(azimuth, elevation))
    rays = np.stack([np.cos(tilt) * np.cos(turn), np.cos(tilt) * np.sin(turn), np.sin(tilt)], axis=1)
    start = np.array([RIG.mount.x_m, RIG.mount.y_m, RIG.mount.z_m])
    with np.errstate(divide="ignore", invalid="ignore"):
        far = np.where(rays[:, 2] < 0, -start[2] / rays[:, 2], np.inf)
        for box in boxes:
            far = np.minimum(far, _hit(box, start, rays))
    seen = (far < RIG.range_m) & (random.uniform(size=len(far)) > RIG.dropoff_general)
    points = np.empty((int(seen.sum()), 4), np.float32)
    points[:, :3] = start + rays[seen] * far[seen, None]
    points[:, 3] = np.exp(-RIG.attenuation_per_m * far[seen])
    return LidarSweep(time_s, points)


def seconds(boxes_at: "list[Floats]", seed: int = 0) -> Singles:
    """(n, 5): the sweeps of consecutive ticks, gathered as for the detector, seen by a vehicle that stands."""
    buffer = SweepBuffer()
    for i, boxes in enumerate(boxes_at):
        pose = PoseEstimate(TICK_S * i, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, np.eye(4))
        buffer.add(scan(boxes, TICK_S * i, seed), pose)
    return buffer.gather(pose)


def _hit(box: Floats, start: Floats, rays: Floats) -> Floats:
    """How far each ray goes until it meets the box; infinite where it does not (slabs; Kay and Kajiya 1986)."""
    cos, sin = np.cos(box[6]), np.sin(box[6])
    turn = np.array([[cos, sin, 0], [-sin, cos, 0], [0, 0, 1]])
    own, way = turn @ (start - box[:3]), rays @ turn.T
    sides = (np.stack([-box[3:6] / 2, box[3:6] / 2])[:, None, :] - own) / way
    near, far = sides.min(axis=0).max(axis=1), sides.max(axis=0).min(axis=1)
    return np.where((near < far) & (near > 0), near, np.inf)
