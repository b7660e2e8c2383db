"""Converts tracks for the stack: boxes for drivers in CARLA's world frame, objects for the solver, kinds, lamps."""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from stucksolver.scene import ObjectKind, TrackedObject
from stucksolver.scene.objects import ON_FOOT
from stucksolver_carla.drivers.behavior.nearby_objects import HAZARD_LAMPS, NearbyObjects
from stucksolver_carla.stack.carla_frames import to_local
from stucksolver_carla.stack.contact import EgoFootprint, PushDetector
from stucksolver_perception.camera.attributes import Attributes
from stucksolver_perception.carla.far_vehicle_reports import TRACK_LABELS, FarVehicleReports
from stucksolver_perception.carla.known_posts import KnownPosts
from stucksolver_perception.carla.lane_motion_prior import LaneMotionPrior
from stucksolver_perception.cycle_data import PerceptionResult
from stucksolver_perception.lidar_labels import KIND_OF_LABEL, LABEL_OF_KIND, LABELS
from stucksolver_perception.tracking import Track

if TYPE_CHECKING:
    from stucksolver_perception.carla.ego_perception import EgoPerception

LEFT_BLINKER = 32
"""Bit of the left blinker in `carla.VehicleLightState`."""
RIGHT_BLINKER = 16
"""Bit of the right blinker."""
BRAKE = 8
"""Bit of the brake lamps."""
SPECIAL = 512
"""Bit of the emergency lights (`Special1`)."""
MIN_KIND_CONFIDENCE = 0.6
"""Minimum confidence of a kind; a less certain one is reported as unknown. Ours."""
FLAT_M = 0.2
"""Maximum height of flat debris (m). CARLA's heaps of dirt are 0.15 m high and 1 to 2.5 m wide."""
FLAT_SHARE = 4.0
"""Minimum ratio of width and length of flat debris to its height. Ours."""
_TYPE_IDS = {
    ObjectKind.SCHOOL_BUS: "vehicle.sensed.school_bus",
    ObjectKind.PEDESTRIAN: "walker.sensed",
    ObjectKind.FLAGGER: "walker.sensed",
    ObjectKind.ANIMAL: "animal.sensed",
    ObjectKind.CONE: "static.prop.cone",
    ObjectKind.BARRIER: "static.prop.barrier",
    ObjectKind.CROSSING_GATE: "static.prop.crossinggate",
    ObjectKind.BAG: "static.prop.plasticbag",
    ObjectKind.LITTER: "static.prop.garbage",
    ObjectKind.DEBRIS: "static.prop.rock",
    ObjectKind.PROP: "static.prop.sensed",
    ObjectKind.UNKNOWN: "static.prop.sensed",
}
"""Blueprint ids from which `object_kinds.kind_of` restores the kind, for drivers that read actors."""


class PerceivedBoxes:
    """The perceived objects as an `ObjectSource`."""

    doubt_m: ClassVar[float] = 0.3
    """Common error of the detector's boxes and the localizer's pose within seconds (m). Ours."""

    def __init__(self, perception: EgoPerception, range_m: float) -> None:
        self._perception, self._range_m = perception, range_m
        carla_map = perception.vehicle.get_world().get_map()
        self._lane_prior, self._far_reports = (
            LaneMotionPrior(carla_map),
            FarVehicleReports(carla_map, perception.vehicle),
        )
        self._posts = KnownPosts([to_local(landmark.transform.location) for landmark in carla_map.get_all_landmarks()])

    def read(self, ego_x: float, ego_y: float) -> NearbyObjects:
        """Return all tracks within range of a point in CARLA's world frame, predicted to this tick.

        Flat debris is left out, because every car drives over loose dirt, also the driver with ground truth
        (`behavior_driver.DRIVABLE_PROPS`). Posts of the map do not count as pedestrians.
        """
        percept = self._perception.percept
        tracks_near = [
            self._posts.as_post(track) for track in self._lane_prior.with_lane_courses(percept) if not is_flat(track)
        ]
        objects = to_nearby_objects((*tracks_near, *self._far_reports.reported_tracks(percept)), self._perception.now_s)
        return objects.part((np.abs(objects.x - ego_x) < self._range_m) & (np.abs(objects.y - ego_y) < self._range_m))


class PerceivedTracker:
    """The counterpart of `stucksolver_carla.stack.ground_truth_tracker.Tracker` that uses the sensors."""

    def __init__(self, perception: EgoPerception) -> None:
        self._perception = perception
        carla_map = perception.vehicle.get_world().get_map()
        self._lane_prior, self._far_reports = (
            LaneMotionPrior(carla_map),
            FarVehicleReports(carla_map, perception.vehicle),
        )
        self._push_detector = PushDetector()
        self._pushed_ids: frozenset[int] = frozenset()

    @property
    def pushes(self) -> bool:
        """True if the ego pushed an object at the last update."""
        return bool(self._push_detector.pushed_ids)

    def watch(self, ego: EgoFootprint, now_s: float) -> NearbyObjects:
        """Update which objects the ego pushes, and return all boxes."""
        boxes = to_nearby_objects(self._lane_prior.with_lane_courses(self._perception.percept), now_s)
        self._pushed_ids = self._push_detector.update(ego, boxes)
        return boxes

    def update(self, ego: EgoFootprint, now_s: float) -> tuple[TrackedObject, ...]:
        """Return all tracks as objects in the local frame."""
        self.watch(ego, now_s)
        percept = self._perception.percept
        if percept is None:
            return ()
        attributes = percept.attributes
        tracks = (*self._lane_prior.with_lane_courses(percept), *self._far_reports.reported_tracks(percept))
        return tuple(_object(track, attributes.get(track.id), now_s, track.id in self._pushed_ids) for track in tracks)

    def read_lights(self, now_s: float) -> None:
        """Do nothing, because the lamps come with each image."""


def is_flat(track: Track) -> bool:
    """Return True for flat debris on the road. A bag is not wide enough for it; a rock or a tire is not low enough."""
    is_low = LABELS[track.label] == "debris" and track.height_m <= FLAT_M
    return is_low and min(track.length_m, track.width_m) >= FLAT_SHARE * track.height_m


def to_nearby_objects(tracks: Sequence[Track], now_s: float) -> NearbyObjects:
    """Return tracks, predicted to `now_s`, as boxes in CARLA's world frame."""
    predicted = [track.predict_to(now_s) for track in tracks]
    rows = [
        (
            track.x_m,
            -track.y_m,
            -track.yaw_rad,
            track.length_m / 2.0,
            track.width_m / 2.0,
            track.z_m - track.height_m / 2.0,
            track.z_m + track.height_m / 2.0,
            track.vx_mps,
            -track.vy_mps,
        )
        for track in predicted
    ]
    columns = np.array(rows, dtype=np.float64).reshape(len(rows), 9).T
    x, y, yaw, half_length, half_width, bottom, top, vx, vy = columns
    return NearbyObjects(
        actor_id=tuple(track.id for track in predicted),
        is_walker=np.array([KIND_OF_LABEL[track.label] in ON_FOOT for track in predicted], dtype=np.bool_),
        x=x,
        y=y,
        yaw=yaw,
        half_length=half_length,
        half_width=half_width,
        bottom=bottom,
        top=top,
        vx=vx,
        vy=vy,
    )


def _position_sd_m(track: Track) -> float:
    """Return the standard deviation in the direction in which it is largest (m)."""
    return float(np.sqrt(max(np.linalg.eigvalsh(track.covariance[:2, :2])[-1], 0.0)))


def _across_sd_m(track: Track) -> float:
    """Return the standard deviation across the track's own axis (m)."""
    side = np.array([-np.sin(track.yaw_rad), np.cos(track.yaw_rad)])
    return float(np.sqrt(max(side @ track.covariance[:2, :2] @ side, 0.0)))


def kind_of_track(track: Track, attributes: Attributes | None) -> tuple[ObjectKind, float]:
    """Return the kind of a track, with a confidence. The LiDAR's label applies if the camera gives no finer kind.

    If the two disagree, the kind is unknown, because neither is more reliable.
    """
    lidar_kind, confidence = KIND_OF_LABEL[track.label], float(track.label_confidence)
    if attributes is not None and attributes.kind is not None:
        if LABEL_OF_KIND.get(attributes.kind) == track.label:
            return attributes.kind, float(attributes.kind_confidence)
        if attributes.kind is not ObjectKind.PROP:
            return ObjectKind.UNKNOWN, min(confidence, float(attributes.kind_confidence))
    return (lidar_kind, confidence) if confidence >= MIN_KIND_CONFIDENCE else (ObjectKind.UNKNOWN, confidence)


def _object(track: Track, attributes: Attributes | None, now_s: float, pushed: bool) -> TrackedObject:
    kind, confidence = kind_of_track(track, attributes)
    predicted = track.predict_to(now_s)
    return TrackedObject(
        id=str(track.id),
        kind=kind,
        x_m=predicted.x_m,
        y_m=predicted.y_m,
        yaw_rad=predicted.yaw_rad,
        vx_mps=predicted.vx_mps,
        vy_mps=predicted.vy_mps,
        length_m=predicted.length_m,
        width_m=predicted.width_m,
        height_m=predicted.height_m,
        stationary_s=predicted.stationary_s,
        moved_s_ago=predicted.moved_s_ago,
        seen_for_s=predicted.tracked_for_s,
        pushed=pushed,
        kind_confidence=confidence,
        position_sd_m=_position_sd_m(predicted),
        across_sd_m=_across_sd_m(predicted),
        hazard_lights=None if attributes is None else attributes.hazard_lights,
        emergency_lights=None if attributes is None else attributes.emergency_lights,
        brake_lights=None if attributes is None else attributes.brake_lights,
        door_open=None if attributes is None else attributes.door_open,
        gesture=attributes.gesture if attributes is not None and kind is ObjectKind.FLAGGER else None,
    )


def actor_proxies(percept: PerceptionResult, ids: Sequence[int]) -> list[Any]:
    """Return the kinds of the tracks with these ids, as CARLA's blueprint ids and attributes."""
    objects = []
    for track in percept.tracks:
        if track.id in ids:
            kind, _ = kind_of_track(track, percept.attributes.get(track.id))
            special = {"special_type": "emergency"} if kind is ObjectKind.EMERGENCY else {}
            type_id = _TYPE_IDS.get(kind, "vehicle.sensed")
            attributes = {"base_type": kind.value, **special}
            objects.append(SimpleNamespace(id=track.id, type_id=type_id, attributes=attributes, parent=None))
    for far in percept.far_tracks:
        if far.id in ids:
            attributes = {"base_type": KIND_OF_LABEL[TRACK_LABELS[far.label]].value}
            objects.append(SimpleNamespace(id=far.id, type_id="vehicle.sensed", attributes=attributes, parent=None))
    return objects


def lamps_of(percept: PerceptionResult) -> dict[int, int]:
    """Return the lamps of each track, as bits of `carla.VehicleLightState`; unknown ones count as off."""
    return {track: _bits(attributes) for track, attributes in percept.attributes.items()}


def _bits(attributes: Attributes) -> int:
    bits = HAZARD_LAMPS if attributes.hazard_lights else 0
    bits |= LEFT_BLINKER if attributes.left_blinker else 0
    bits |= RIGHT_BLINKER if attributes.right_blinker else 0
    bits |= BRAKE if attributes.brake_lights else 0
    return bits | (SPECIAL if attributes.emergency_lights else 0)
