"""The input of perception, and its output for one moment."""

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
    """Pose at the moment for which the answer is wanted; its time is the percept's."""
    sweeps: tuple[tuple[LidarSweep, PoseEstimate], ...]
    """The sweeps since the last cycle, each with the pose at its time."""
    picture: CameraFrame | None
    """A new image, if there is one."""
    picture_pose: PoseEstimate | None
    heads: Mapping[int, Floats]
    """Lights on the map that may be in view: boxes of their heads (k, 7), local frame."""
    rear: tuple[CameraFrame, PoseEstimate] | None = None
    """A new image of the rear camera, with the pose at its time."""


@dataclass(frozen=True, eq=False)
class PerceptionResult:
    """What is around at `pose.time_s`; tracks are in the local frame."""

    pose: PoseEstimate
    tracks: tuple[Track, ...]
    attributes: Mapping[int, Attributes]
    """The camera's attributes of a track, by its id; tracks that it never saw are missing."""
    lights: Mapping[int, LightState]
    """The lights that were looked for; `UNKNOWN` if nothing certain is seen."""
    seen: FreeSpace
    """In the vehicle frame at `pose`."""
    far: FarDetections | None
    """Detections of the last image."""
    picture_time_s: float | None
    far_tracks: tuple[FarTrack, ...] = ()
    """Vehicles that only the camera tracks, at `pose.time_s`; those that the LiDAR tracks too are in `tracks`."""
    far_view: FarView | None = None
    """What the last images showed; None before the first."""
    unknown_m: Floats | None = None
    """(`visibility.AZIMUTHS`,): distance of the nearest tall return that comes from no track; None if not known."""
    lidar_turned_rad: float | None = None
    """How far the LiDAR is turned to the left (rad), see `lidar/alignment.py`; None if nothing says so."""
    camera_turned_rad: float | None = None
    """The same of the front camera, see `camera/alignment.py`."""
    stages_ms: Mapping[str, float] = field(default_factory=dict)
    """Duration of each step (ms)."""
