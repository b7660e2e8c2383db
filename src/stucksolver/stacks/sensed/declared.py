"""Compares the sensors that a leaderboard agent declares with the rig: mismatches are reported before the drive."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from stucksolver.perception.rig import Mount, Rig
from stucksolver.stacks.sensed.mounting import SensorError

CAMERA, LIDAR = "sensor.camera.rgb", "sensor.lidar.ray_cast"
NEEDED = {
    CAMERA: "front camera",
    LIDAR: "LiDAR",
    "sensor.other.imu": "IMU",
    "sensor.other.gnss": "GNSS",
    "sensor.speedometer": "speedometer",
}
"""By the leaderboard's names for their types; one of each."""
SAME_DEG = 0.01
"""Fields of view are given in whole degrees."""


def rig_of(declared: Sequence[Mapping[str, Any]], rig: Rig) -> Rig:
    """Return the rig with camera and LiDAR mounted as the agent declares.

    Mounts may differ from the rig file's, since they are known exactly. What the networks were trained for, the image's
    size and field of view, may not. A leaderboard agent has no rear camera.

    Raises:
        SensorError: A sensor is missing or does not fit.
    """
    for type_id, name in NEEDED.items():
        count = sum(one.get("type") == type_id for one in declared)
        if count != 1:
            raise SensorError(
                f"the agent declares {count} sensors of type {type_id}: perception needs one {name}; "
                f"declare it (\"sensors\": true), or set perception to 'privileged'"
            )
    by_type = {str(one["type"]): one for one in declared}
    camera, lidar = by_type[CAMERA], by_type[LIDAR]
    _check_camera(camera, rig)
    return rig.model_copy(
        update={
            "rear_camera": None,
            "camera": rig.camera.model_copy(update={"mount": _mount(camera)}),
            "lidar": rig.lidar.model_copy(update={"mount": _mount(lidar)}),
        }
    )


def _check_camera(camera: Mapping[str, Any], rig: Rig) -> None:
    size = (int(camera.get("width", 0)), int(camera.get("height", 0)))
    wanted = (rig.camera.width_px, rig.camera.height_px)
    if size != wanted:
        raise SensorError(
            f"the agent's camera has pictures of {size[0]} x {size[1]}, the rig says {wanted[0]} x {wanted[1]}: "
            "give the rig file of this camera"
        )
    if abs(float(camera.get("fov", 0.0)) - rig.camera.fov_deg) > SAME_DEG:
        raise SensorError(
            f"the agent's camera has a field of view of {camera.get('fov')} degrees, the rig says "
            f"{rig.camera.fov_deg:g}: give the rig file of this camera"
        )


def _mount(declared: Mapping[str, Any]) -> Mount:
    """From CARLA's frame: y, yaw and pitch have other signs there, see `mounting.placed`."""
    x, y, z, roll, pitch, yaw = (float(declared.get(part, 0.0)) for part in ("x", "y", "z", "roll", "pitch", "yaw"))
    return Mount(x_m=x, y_m=-y, z_m=z, yaw_deg=-yaw, pitch_deg=-pitch, roll_deg=roll)
