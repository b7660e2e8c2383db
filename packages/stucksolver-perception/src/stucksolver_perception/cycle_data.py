"""Defines the input of one cycle of perception, and its result."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from stucksolver.scene.surroundings import LightState
from stucksolver_perception.camera.attributes import Attributes
from stucksolver_perception.camera.far_detector import FarDetections
from stucksolver_perception.far_tracking import FarTrack
from stucksolver_perception.far_view import FarView
from stucksolver_perception.free_space import FreeSpace
from stucksolver_perception.measurements import CameraFrame, Floats, LidarSweep, PoseEstimate
from stucksolver_perception.tracking import Track


@dataclass(frozen=True, eq=False)
class PerceptionInput:
    """The data of one cycle."""

    pose: PoseEstimate
    """Pose at the time of the result."""
    sweeps: tuple[tuple[LidarSweep, PoseEstimate], ...]
    """The sweeps since the last cycle, each with the pose at its time."""
    picture: CameraFrame | None
    """A new image of the front camera; None without one."""
    picture_pose: PoseEstimate | None
    """Pose at the time of the image; None without one."""
    heads: Mapping[int, Floats]
    """Boxes (k, 7) of the heads of each light on the map that may be in view, by the light's id, in the local frame."""
    rear: tuple[CameraFrame, PoseEstimate] | None = None
    """A new image of the rear camera, with the pose at its time; None without one."""


@dataclass(frozen=True, eq=False)
class PerceptionResult:
    """The perceived surroundings at `pose.time_s`."""

    pose: PoseEstimate
    """Pose of the ego."""
    tracks: tuple[Track, ...]
    """Tracks of the LiDAR in the local frame."""
    attributes: Mapping[int, Attributes]
    """The camera's attributes of tracks, by the track's id. A track without any is missing."""
    lights: Mapping[int, LightState]
    """The states of the lights in `PerceptionInput.heads`, by id; `UNKNOWN` without a certain one."""
    seen: FreeSpace
    """Free space in the vehicle frame at `pose`."""
    far: FarDetections | None
    """Detections in the last image of the front camera; None before the first."""
    picture_time_s: float | None
    """Time of the last image (s); None before the first."""
    far_tracks: tuple[FarTrack, ...] = ()
    """Vehicles that only the camera tracks, at `pose.time_s`. Those that the LiDAR tracks too are in `tracks`."""
    far_view: FarView | None = None
    """The last images for sight distances; None before the first."""
    unknown_m: Floats | None = None
    """(`free_space.AZIMUTHS`,): distance of the nearest tall return that belongs to no track (m); None if unknown."""
    lidar_turned_rad: float | None = None
    """Yaw error of the LiDAR, positive to the left (rad); None without a detected one. See
    `lidar/lidar_miscalibration.py`."""
    camera_turned_rad: float | None = None
    """Yaw error of the front camera, likewise. See `camera/camera_miscalibration.py`."""
    stages_ms: Mapping[str, float] = field(default_factory=dict)
    """Duration of each stage (ms), by its name."""
