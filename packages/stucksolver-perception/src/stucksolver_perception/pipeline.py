"""Runs one cycle of perception after another, from sweeps and images to a `PerceptionResult`. It is not thread-safe."""

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
from stucksolver_perception.far_view import FarImage, FarView, occluders_in
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
"""Maximum distance of a light whose state is read (m). There, a head of 0.3 m is 3 pixels wide."""
LIBRARIES = ("onnxruntime", "PIL", "scipy", "filterpy")
"""Names of the modules of the required libraries."""


def missing_libraries() -> str | None:
    """Return the names of the missing libraries with the remedy; None if all are installed."""
    missing = [name for name in LIBRARIES if find_spec(name) is None]
    return f"{', '.join(missing)} not installed; add the extra [perception] (README, Install)" if missing else None


def unavailable_reason(rig_file: Path = SHIPPED) -> str | None:
    """Return why perception cannot run here, with the remedy; None if it can. Load all networks once to check it."""
    reason = missing_libraries()
    if reason:
        return reason
    try:
        PerceptionPipeline(load_rig(rig_file))
    except (RigError, NetworkFileError) as error:
        return str(error)
    return None


class PerceptionPipeline:
    """Perception of one vehicle. The constructor loads all networks.

    Raises:
        NetworkFileError: A network cannot be used.
    """

    def __init__(self, rig: Rig, threads: int = 1) -> None:
        self._rig = rig
        self._buffer = SweepBuffer()
        self._detector = LidarDetector()
        self._tracker = ObjectTracker(rig)
        self._lidar_alignment, self._camera_alignment = LidarAlignment(rig.lidar), CameraAlignment(rig)
        self._attribute_reader, self._attribute_filter = AttributeReader(threads=threads), AttributeFilter()
        self._light_reader, self._light_filter = LightReader(threads=threads), LightFilter()
        self._far_detector = FarDetector(threads=threads)
        self._range_model = RangeModel.from_card(self._far_detector.card)
        self._far_tracker = FarTracker(rig.camera, self._range_model)
        recall = SightModel.from_card(self._far_detector.card)
        self._far_view = FarView((), CameraSight(rig.camera, recall), recall)
        self._picture_s: float | None = None
        self._stages_ms: dict[str, float] = {}

    def perceive(self, cycle_input: PerceptionInput) -> PerceptionResult:
        """Return the perceived surroundings at the time of `cycle_input.pose`."""
        self._stages_ms = {}
        with self._timed("sweeps"):
            for sweep, pose in cycle_input.sweeps:
                self._buffer.add(sweep, pose)
            points = self._buffer.gather(cycle_input.pose)
        with self._timed("lidar"):
            detections = self._detector.detect(points, cycle_input.pose.time_s)
        turn = points[points[:, 4] <= RECENT_S]
        with self._timed("visibility"):
            free_space = FreeSpace.from_points(turn, self._rig.lidar)
        with self._timed("extents"):
            detections = with_measured_extents(detections, points, self._rig.lidar)
            # Extents come first. A row is not measured as one barrier, because its direction and its ends would change
            # from cycle to cycle.
            detections = with_low_trucks_as_barriers(detections, turn, self._rig.lidar)
            detections = with_measured_ends(detections, turn, self._rig.lidar)
        with self._timed("residual"):
            # Pedestrians are dropped and added before the returns are explained, because boxes explain returns.
            standing = standing_returns(turn, self._rig.lidar)
            vehicles = self._vehicles(cycle_input.pose)
            detections = drop_false_pedestrians(detections, standing, vehicles)
            detections = add_close_pedestrians(detections, turn, vehicles)
            detections = with_unexplained(detections, standing, vehicles)
            detections = with_measured_heights(detections, points)
        with self._timed("tracking"):
            tracks = self._tracker.update(detections, cycle_input.pose, free_space, standing)
        with self._timed("alignment"):
            self._check_alignment(cycle_input, tracks)
        with self._timed("unknown"):
            unknown_m = free_space.blocked_otherwise(footprints(boxes_of(tracks, cycle_input.pose)))
        lights = self._process_images(cycle_input, tracks)
        with self._timed("far_tracks"):
            far_tracks = tuple(
                track
                for track in self._far_tracker.tracks(cycle_input.pose.time_s, tracks)
                if not is_refuted(track, free_space, cycle_input.pose)
            )
        newest = self._far_view.images[0].detections if self._far_view.images else None
        return PerceptionResult(
            pose=cycle_input.pose,
            tracks=tracks,
            attributes=self._current_attributes(tracks, cycle_input.pose.time_s),
            lights=lights,
            seen=free_space,
            far=newest,
            picture_time_s=self._picture_s,
            far_tracks=far_tracks,
            far_view=self._far_view if newest is not None else None,
            unknown_m=unknown_m,
            lidar_turned_rad=self._lidar_alignment.turned_rad,
            camera_turned_rad=self._camera_alignment.turned_rad,
            stages_ms=dict(self._stages_ms),
        )

    def _vehicles(self, pose: PoseEstimate) -> Floats:
        """Return (n, 8): boxes of the tracked vehicles in the vehicle frame, and their speeds (m/s)."""
        vehicles = [track for track in self._tracker.predict(pose.time_s) if WHEELED[track.label]]
        speed = [math.hypot(track.vx_mps, track.vy_mps) for track in vehicles]
        return np.column_stack([boxes_of(vehicles, pose), speed])

    def _check_alignment(self, cycle_input: PerceptionInput, tracks: tuple[Track, ...]) -> None:
        """Check with static objects whether LiDAR and camera still have the mounts of the rig."""
        for sweep, pose in cycle_input.sweeps:
            self._lidar_alignment.add(sweep, pose)
        if cycle_input.picture is not None and cycle_input.picture_pose is not None:
            self._camera_alignment.look(cycle_input.picture, cycle_input.picture_pose, cycle_input.sweeps)
        moving = [track for track in tracks if track.standing_since_s is None]
        match = self._lidar_alignment.look(footprints(boxes_of(moving, cycle_input.pose)))
        if match is not None:
            self._camera_alignment.measure(match.turned_rad)

    def _process_images(self, cycle_input: PerceptionInput, tracks: tuple[Track, ...]) -> Mapping[int, LightState]:
        """Process the new images, if there are any, and return the states of the lights."""
        if cycle_input.picture is not None and cycle_input.picture_pose is not None:
            self._picture_s = cycle_input.picture.time_s
            with self._timed("attributes"):
                self._read_attributes(cycle_input.picture, self._rig.camera, cycle_input.picture_pose, tracks)
            with self._timed("lights"):
                self._read_lights(cycle_input.picture, cycle_input.picture_pose, cycle_input.heads)
            if not is_dirty(cycle_input.picture, self._rig.camera):
                self._detect_far(cycle_input.picture, cycle_input.picture_pose, tracks)
        if cycle_input.rear is not None and self._rig.rear_camera is not None:
            with self._timed("rear"):
                self._read_attributes(cycle_input.rear[0], self._rig.rear_camera, cycle_input.rear[1], tracks)
        return {light: self._light_filter.state(light, cycle_input.pose.time_s) for light in cycle_input.heads}

    def _detect_far(self, picture: CameraFrame, pose: PoseEstimate, tracks: tuple[Track, ...]) -> None:
        with self._timed("far"):
            detections = self._far_detector.detect(picture, self._rig.camera)
        with self._timed("far_view"):
            self._track_far(detections, pose, tracks)

    def _track_far(self, detections: FarDetections, pose: PoseEstimate, tracks: tuple[Track, ...]) -> None:
        """Add the detections far ahead to tracker and view."""
        self._far_tracker.update(detections, pose, tracks)
        places = far_places(detections, self._rig.camera, self._range_model)
        occluders = occluders_in(tracks, detections, places, self._rig.camera, pose)
        self._far_view = self._far_view.with_image(FarImage(detections, pose, occluders))

    def _read_attributes(
        self, picture: CameraFrame, camera: CameraRig, pose: PoseEstimate, tracks: tuple[Track, ...]
    ) -> None:
        boxes = boxes_of(tracks, pose)
        for track, attributes in zip(tracks, self._attribute_reader.read(picture, camera, boxes), strict=True):
            self._attribute_filter.add(track.id, attributes, picture.time_s)

    def _read_lights(self, picture: CameraFrame, pose: PoseEstimate, heads: Mapping[int, Floats]) -> None:
        boxes_by_light = {light: into_vehicle(boxes, pose) for light, boxes in heads.items()}
        in_reach = {
            light: boxes for light, boxes in boxes_by_light.items() if np.hypot(*boxes[:, :2].T).min() < LIGHT_REACH_M
        }
        states = self._light_reader.read(picture, self._rig.camera, list(in_reach.values()))
        for light, (state, confidence) in zip(in_reach, states, strict=True):
            self._light_filter.add(light, state, confidence, picture.time_s)

    def _current_attributes(self, tracks: tuple[Track, ...], time_s: float) -> dict[int, Attributes]:
        attributes = {track.id: self._attribute_filter.get(track.id, time_s) for track in tracks}
        self._attribute_filter.keep(attributes)
        return {track_id: item for track_id, item in attributes.items() if item is not None}

    @contextmanager
    def _timed(self, stage: str) -> Iterator[None]:
        start_s = time.perf_counter()
        yield
        self._stages_ms[stage] = 1e3 * (time.perf_counter() - start_s)
