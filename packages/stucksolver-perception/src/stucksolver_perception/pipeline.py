"""One perception cycle after another: sweeps and images in, a `PerceptionResult` out. Not thread-safe."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from stucksolver.scene.surroundings import LightState
from stucksolver_perception.camera.attribute_filter import AttributeFilter
from stucksolver_perception.camera.attributes import AttributeReader, Attributes
from stucksolver_perception.camera.camera_miscalibration import CameraAlignment
from stucksolver_perception.camera.camera_sight_distance import CameraSight, SightModel
from stucksolver_perception.camera.far_detector import FarDetections, FarDetector
from stucksolver_perception.camera.far_range import RangeModel, far_places
from stucksolver_perception.camera.horizon_strip import is_dirty
from stucksolver_perception.camera.traffic_lights import LightFilter, LightReader
from stucksolver_perception.cycle_data import PerceptionInput, PerceptionResult
from stucksolver_perception.far_tracking import FarTracker, is_refuted
from stucksolver_perception.far_view import FarImage, FarView, blockers_of
from stucksolver_perception.free_space import FreeSpace, footprints
from stucksolver_perception.lidar.detector import LidarDetector
from stucksolver_perception.lidar.lidar_miscalibration import LidarAlignment
from stucksolver_perception.lidar.refinement.barrier_extent import with_measured_extents
from stucksolver_perception.lidar.refinement.barrier_rows import with_low_trucks_as_barriers
from stucksolver_perception.lidar.refinement.close_pedestrians import add_close_pedestrians
from stucksolver_perception.lidar.refinement.debris_height import with_measured_heights
from stucksolver_perception.lidar.refinement.false_pedestrians import drop_false_pedestrians
from stucksolver_perception.lidar.refinement.unexplained_returns import standing_returns, with_unexplained
from stucksolver_perception.lidar.refinement.vehicle_ends import with_measured_ends
from stucksolver_perception.lidar.sweeps import RECENT_S, SweepBuffer
from stucksolver_perception.measurements import CameraFrame, Floats, PoseEstimate
from stucksolver_perception.network_files import NetworkFileError
from stucksolver_perception.rig import SHIPPED, CameraRig, Rig, RigError, load_rig
from stucksolver_perception.tracking import ObjectTracker, Track, boxes_of
from stucksolver_perception.tracking.motion_groups import WHEELED
from stucksolver_perception.vehicle_frame import into_vehicle

LIGHT_REACH_M = 100.0
"""At this distance a light's head of 0.3 m is 3 pixels wide."""


NEEDED = ("onnxruntime", "PIL", "scipy", "filterpy")


def missing_libraries() -> str | None:
    """Return which libraries are missing, with the remedy; None if none is."""
    missing = [name for name in NEEDED if find_spec(name) is None]
    return f"{', '.join(missing)} not installed; add the extra [perception] (README, Install)" if missing else None


def unavailable_reason(rig_file: Path = SHIPPED) -> str | None:
    """Return what keeps perception from running here, with the remedy, or None. Loads all networks once."""
    why = missing_libraries()
    if why:
        return why
    try:
        PerceptionPipeline(load_rig(rig_file))
    except (RigError, NetworkFileError) as error:
        return str(error)
    return None


class PerceptionPipeline:
    """Loads all networks when it is made.

    Raises:
        WeightsError: One of them cannot be used.
    """

    def __init__(self, rig: Rig, threads: int = 1) -> None:
        self._rig = rig
        self._buffer = SweepBuffer()
        self._detector = LidarDetector()
        self._tracker = ObjectTracker(rig)
        self._lidar_alignment, self._camera_alignment = LidarAlignment(rig.lidar), CameraAlignment(rig)
        self._attributes, self._memory = AttributeReader(threads=threads), AttributeFilter()
        self._lights, self._shown = LightReader(threads=threads), LightFilter()
        self._far = FarDetector(threads=threads)
        self._ranges = RangeModel.from_card(self._far.card)
        self._far_tracker = FarTracker(rig.camera, self._ranges)
        recall = SightModel.from_card(self._far.card)
        self._view = FarView((), CameraSight(rig.camera, recall), recall)
        self._picture_s: float | None = None
        self._stages_ms: dict[str, float] = {}

    def perceive(self, look: PerceptionInput) -> PerceptionResult:
        """Return what is around at the time of `look.pose`."""
        self._stages_ms = {}
        with self._timed("sweeps"):
            for sweep, pose in look.sweeps:
                self._buffer.add(sweep, pose)
            points = self._buffer.gather(look.pose)
        with self._timed("lidar"):
            detections = self._detector.detect(points, look.pose.time_s)
        turn = points[points[:, 4] <= RECENT_S]
        with self._timed("visibility"):
            seen = FreeSpace.from_points(turn, self._rig.lidar)
        with self._timed("extents"):
            detections = with_measured_extents(detections, points, self._rig.lidar)
            # A row is not measured as one barrier: its direction, and where it ends, would change from look to look.
            detections = with_low_trucks_as_barriers(detections, turn, self._rig.lidar)
            detections = with_measured_ends(detections, turn, self._rig.lidar)
        with self._timed("residual"):
            standing = standing_returns(turn, self._rig.lidar)
            vehicles = self._vehicles(look.pose)
            detections = drop_false_pedestrians(detections, standing, vehicles)
            detections = add_close_pedestrians(detections, turn, vehicles)
            detections = with_unexplained(detections, standing, vehicles)
            detections = with_measured_heights(detections, points)
        with self._timed("tracking"):
            tracks = self._tracker.update(detections, look.pose, seen, standing)
        with self._timed("alignment"):
            self._align(look, tracks)
        with self._timed("unknown"):
            unknown_m = seen.blocked_otherwise(footprints(boxes_of(tracks, look.pose)))
        lights = self._pictured(look, tracks)
        with self._timed("far_tracks"):
            told = self._far_tracker.tracks(look.pose.time_s, tracks)
            far_tracks = tuple(track for track in told if not is_refuted(track, seen, look.pose))
        newest = self._view.looks[0].found if self._view.looks else None
        return PerceptionResult(
            pose=look.pose,
            tracks=tracks,
            attributes=self._remembered(tracks, look.pose.time_s),
            lights=lights,
            seen=seen,
            far=newest,
            picture_time_s=self._picture_s,
            far_tracks=far_tracks,
            far_view=self._view if newest is not None else None,
            unknown_m=unknown_m,
            lidar_turned_rad=self._lidar_alignment.turned_rad,
            camera_turned_rad=self._camera_alignment.turned_rad,
            stages_ms=dict(self._stages_ms),
        )

    def _vehicles(self, pose: PoseEstimate) -> Floats:
        """(n, 8): boxes of the vehicles that are tracked, in the vehicle frame, and their speeds."""
        vehicles = [track for track in self._tracker.predict(pose.time_s) if WHEELED[track.label]]
        speed = [math.hypot(track.vx_mps, track.vy_mps) for track in vehicles]
        return np.column_stack([boxes_of(vehicles, pose), speed])

    def _align(self, look: PerceptionInput, tracks: tuple[Track, ...]) -> None:
        """Check by what does not move whether LiDAR and camera are still mounted as the rig says."""
        for sweep, pose in look.sweeps:
            self._lidar_alignment.add(sweep, pose)
        if look.picture is not None and look.picture_pose is not None:
            self._camera_alignment.look(look.picture, look.picture_pose, look.sweeps)
        moving = [track for track in tracks if track.standing_since_s is None]
        match = self._lidar_alignment.look(footprints(boxes_of(moving, look.pose)))
        if match is not None:
            self._camera_alignment.measure(match.turned_rad)

    def _pictured(self, look: PerceptionInput, tracks: tuple[Track, ...]) -> Mapping[int, LightState]:
        """Look at the new images, if there are any, and return the known states of the lights."""
        if look.picture is not None and look.picture_pose is not None:
            self._picture_s = look.picture.time_s
            with self._timed("attributes"):
                self._read_attributes(look.picture, self._rig.camera, look.picture_pose, tracks)
            with self._timed("lights"):
                self._read_lights(look.picture, look.picture_pose, look.heads)
            if not is_dirty(look.picture, self._rig.camera):
                self._look_far(look.picture, look.picture_pose, tracks)
        if look.rear is not None and self._rig.rear_camera is not None:
            with self._timed("rear"):
                self._read_attributes(look.rear[0], self._rig.rear_camera, look.rear[1], tracks)
        return {light: self._shown.state(light, look.pose.time_s) for light in look.heads}

    def _look_far(self, picture: CameraFrame, pose: PoseEstimate, tracks: tuple[Track, ...]) -> None:
        with self._timed("far"):
            found = self._far.detect(picture, self._rig.camera)
        with self._timed("far_view"):
            self._follow(found, pose, tracks)

    def _follow(self, found: FarDetections, pose: PoseEstimate, tracks: tuple[Track, ...]) -> None:
        """Add what was detected far ahead."""
        self._far_tracker.update(found, pose, tracks)
        places = far_places(found, self._rig.camera, self._ranges)
        blockers = blockers_of(tracks, found, places, self._rig.camera, pose)
        self._view = self._view.with_look(FarImage(found, pose, blockers))

    def _read_attributes(
        self, picture: CameraFrame, camera: CameraRig, pose: PoseEstimate, tracks: tuple[Track, ...]
    ) -> None:
        boxes = boxes_of(tracks, pose)
        for track, found in zip(tracks, self._attributes.read(picture, camera, boxes), strict=True):
            self._memory.add(track.id, found, picture.time_s)

    def _read_lights(self, picture: CameraFrame, pose: PoseEstimate, heads: Mapping[int, Floats]) -> None:
        near = {light: into_vehicle(boxes, pose) for light, boxes in heads.items()}
        reachable = {item: boxes for item, boxes in near.items() if np.hypot(*boxes[:, :2].T).min() < LIGHT_REACH_M}
        read = self._lights.read(picture, self._rig.camera, list(reachable.values()))
        for light, (state, confidence) in zip(reachable, read, strict=True):
            self._shown.add(light, state, confidence, picture.time_s)

    def _remembered(self, tracks: tuple[Track, ...], time_s: float) -> dict[int, Attributes]:
        found = {track.id: self._memory.get(track.id, time_s) for track in tracks}
        self._memory.keep(found)
        return {track: told for track, told in found.items() if told is not None}

    @contextmanager
    def _timed(self, stage: str) -> Iterator[None]:
        began = time.perf_counter()
        yield
        self._stages_ms[stage] = 1e3 * (time.perf_counter() - began)
