"""Compares the sensors that a leaderboard agent declares with the rig: mismatches are reported before the drive."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from stucksolver_bridge.sensor_data import CAMERA, GNSS, IMU, LIDAR, REAR, SPEED, name_of
from stucksolver_carla.perception_interface import SensorError
from stucksolver_perception.rig import CameraRig, Rig, SensorMount

NEEDED = {
    CAMERA: ("sensor.camera.rgb", "front camera"),
    LIDAR: ("sensor.lidar.ray_cast", "LiDAR"),
    IMU: ("sensor.other.imu", "IMU"),
    GNSS: ("sensor.other.gnss", "GNSS"),
    SPEED: ("sensor.speedometer", "speedometer"),
}
"""By our names: those of the leaderboard for their types, and what they are; one of each."""
SAME_DEG = 0.01
"""Fields of view are given in whole degrees."""


def rig_of(declared: Sequence[Mapping[str, Any]], rig: Rig) -> Rig:
    """Return the rig with cameras and LiDAR mounted as the agent declares; it may lack the rear camera.

    Mounts may differ from the rig file's, since they are known exactly. What the networks were trained for, the image's
    size and field of view, may not.

    Raises:
        SensorError: A sensor is missing or does not fit.
    """
    named: dict[str, list[Mapping[str, Any]]] = {}
    for item in declared:
        named.setdefault(name_of(item) or "", []).append(item)
    for key, (type_id, name) in NEEDED.items():
        count = len(named.get(key, ()))
        if count != 1:
            raise SensorError(
                f"the agent declares {count} sensors of type {type_id}: perception needs one {name}; "
                f"declare it (\"sensors\": true), or set perception to 'privileged'"
            )
    rears = named.get(REAR, [])
    if len(rears) > 1:
        raise SensorError(f"the agent declares {len(rears)} cameras to the rear: perception uses one; declare one")
    rear = None if rig.rear_camera is None or not rears else _declared_camera(REAR, rears[0], rig.rear_camera)
    lidar = rig.lidar.model_copy(update={"mount": _mount(named[LIDAR][0])})
    camera = _declared_camera(CAMERA, named[CAMERA][0], rig.camera)
    return rig.model_copy(update={"camera": camera, "rear_camera": rear, "lidar": lidar})


def _declared_camera(name: str, declared: Mapping[str, Any], rig: CameraRig) -> CameraRig:
    size = (int(declared.get("width", 0)), int(declared.get("height", 0)))
    if size != (rig.width_px, rig.height_px):
        raise SensorError(
            f"the agent's {name} has pictures of {size[0]} x {size[1]}, the rig says {rig.width_px} x {rig.height_px}: "
            f"give the rig file of this {name}"
        )
    if abs(float(declared.get("fov", 0.0)) - rig.fov_deg) > SAME_DEG:
        raise SensorError(
            f"the agent's {name} has a field of view of {declared.get('fov')} degrees, the rig says "
            f"{rig.fov_deg:g}: give the rig file of this {name}"
        )
    return rig.model_copy(update={"mount": _mount(declared)})


def _mount(declared: Mapping[str, Any]) -> SensorMount:
    """From CARLA's frame: y, yaw and pitch have other signs there, see `mounting.placed`."""
    x, y, z, roll, pitch, yaw = (float(declared.get(part, 0.0)) for part in ("x", "y", "z", "roll", "pitch", "yaw"))
    return SensorMount(x_m=x, y_m=-y, z_m=z, yaw_deg=-yaw, pitch_deg=-pitch, roll_deg=roll)
