"""Compares the sensors that a leaderboard agent declares with the rig, and reports mismatches before the run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from stucksolver_bridge.sensor_data import CAMERA, GNSS, IMU, LIDAR, REAR, SPEED, name_of
from stucksolver_carla.perception_interface import SensorError
from stucksolver_perception.rig import CameraRig, Rig, SensorMount

REQUIRED = {
    CAMERA: ("sensor.camera.rgb", "front camera"),
    LIDAR: ("sensor.lidar.ray_cast", "LiDAR"),
    IMU: ("sensor.other.imu", "IMU"),
    GNSS: ("sensor.other.gnss", "GNSS"),
    SPEED: ("sensor.speedometer", "speedometer"),
}
"""The required sensors, one of each, by this package's names: the leaderboard's type ids, and descriptions."""
SAME_DEG = 0.01
"""Tolerance of the field of view (degrees), which is declared in whole degrees."""


def rig_of(declared: Sequence[Mapping[str, Any]], rig: Rig) -> Rig:
    """Return the rig with the mounts of cameras and LiDAR that the agent declares, possibly without a rear camera.

    Mounts may differ from the rig file's, because they are known exactly. The image's size and field of view may not,
    because the networks were trained for them.

    Raises:
        SensorError: A sensor is missing, or does not fit the rig.
    """
    by_name: dict[str, list[Mapping[str, Any]]] = {}
    for item in declared:
        by_name.setdefault(name_of(item) or "", []).append(item)
    for key, (type_id, name) in REQUIRED.items():
        count = len(by_name.get(key, ()))
        if count != 1:
            raise SensorError(
                f"the agent declares {count} sensors of type {type_id}: perception requires one {name}; "
                f"declare it (\"sensors\": true), or set perception to 'privileged'"
            )
    rear_cameras = by_name.get(REAR, [])
    if len(rear_cameras) > 1:
        raise SensorError(f"the agent declares {len(rear_cameras)} rear cameras; declare one at most")
    rear = (
        None
        if rig.rear_camera is None or not rear_cameras
        else _declared_camera(REAR, rear_cameras[0], rig.rear_camera)
    )
    lidar = rig.lidar.model_copy(update={"mount": _mount(by_name[LIDAR][0])})
    camera = _declared_camera(CAMERA, by_name[CAMERA][0], rig.camera)
    return rig.model_copy(update={"camera": camera, "rear_camera": rear, "lidar": lidar})


def _declared_camera(name: str, declared: Mapping[str, Any], rig: CameraRig) -> CameraRig:
    size = (int(declared.get("width", 0)), int(declared.get("height", 0)))
    if size != (rig.width_px, rig.height_px):
        raise SensorError(
            f"the agent's {name} has images of {size[0]} x {size[1]}, the rig has {rig.width_px} x {rig.height_px}: "
            f"give the rig file of this {name}"
        )
    if abs(float(declared.get("fov", 0.0)) - rig.fov_deg) > SAME_DEG:
        raise SensorError(
            f"the agent's {name} has a field of view of {declared.get('fov')} degrees, the rig has "
            f"{rig.fov_deg:g}: give the rig file of this {name}"
        )
    return rig.model_copy(update={"mount": _mount(declared)})


def _mount(declared: Mapping[str, Any]) -> SensorMount:
    """Return the mount of a declared sensor. In CARLA's frame, y, yaw and pitch have the opposite signs."""
    x, y, z, roll, pitch, yaw = (float(declared.get(part, 0.0)) for part in ("x", "y", "z", "roll", "pitch", "yaw"))
    return SensorMount(x_m=x, y_m=-y, z_m=z, yaw_deg=-yaw, pitch_deg=-pitch, roll_deg=roll)
