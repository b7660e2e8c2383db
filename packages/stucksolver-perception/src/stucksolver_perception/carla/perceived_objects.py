"""Tracks for the stack: bodies for a driver in CARLA's world, objects for the solver, kinds, lamps."""

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
from stucksolver_perception.carla.lane_motion_prior import OnLanes
from stucksolver_perception.cycle_data import PerceptionResult
from stucksolver_perception.lidar_labels import KIND_OF_LABEL, LABEL_OF_KIND, LABELS
from stucksolver_perception.tracking import Track

if TYPE_CHECKING:
    from stucksolver_perception.carla.ego_perception import EgoPerception

LEFT_BLINKER = 32
RIGHT_BLINKER = 16
BRAKE = 8
SPECIAL = 512
"""Bits of `carla.VehicleLightState`."""
SURE_KIND = 0.6
"""A less certain kind is reported as unknown."""
FLAT_M = 0.2
"""What lies flat is at most this high (m), ..."""
FLAT_SHARE = 4.0
"""... and at least so many times as wide and long. CARLA's heaps of dirt are 0.15 m high and 1 to 2.5 m wide."""
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
"""Blueprints from which `kinds.kind_of` gets the kind again, for drivers that ask the world what an object is."""


class PerceivedBoxes:
    """See `SeesBodies`."""

    doubt_m: ClassVar[float] = 0.3
    """Of the detector's boxes and the localizer's pose together, within seconds (m)."""

    def __init__(self, eyes: EgoPerception, range_m: float) -> None:
        self._eyes, self._range_m = eyes, range_m
        carla_map = eyes.vehicle.get_world().get_map()
        self._near, self._far = OnLanes(carla_map), FarVehicleReports(carla_map, eyes.vehicle)
        self._posts = KnownPosts([to_local(landmark.transform.location) for landmark in carla_map.get_all_landmarks()])

    def read(self, ego_x: float, ego_y: float) -> NearbyObjects:
        """Return all tracks within range of a point of CARLA's world, predicted to this tick.

        Flat ones are left out: every car drives over loose dirt, as the driver with ground truth does
        (`driver.DRIVEN_OVER`). Posts that the map knows are no people.
        """
        percept = self._eyes.percept
        near = [self._posts.told(track) for track in self._near.told(percept) if not is_flat(track)]
        found = bodies((*near, *self._far.reported_tracks(percept)), self._eyes.now_s)
        return found.part((np.abs(found.x - ego_x) < self._range_m) & (np.abs(found.y - ego_y) < self._range_m))


class PerceivedTracker:
    """The counterpart of `carla_stack.tracker.Tracker` that uses the sensors."""

    def __init__(self, eyes: EgoPerception) -> None:
        self._eyes = eyes
        carla_map = eyes.vehicle.get_world().get_map()
        self._near, self._far = OnLanes(carla_map), FarVehicleReports(carla_map, eyes.vehicle)
        self._pushing = PushDetector()
        self._pushed: frozenset[int] = frozenset()

    @property
    def pushes(self) -> bool:
        """True if the ego pushed something at the last look."""
        return bool(self._pushing.pushed_ids)

    def watch(self, ego: EgoFootprint, now_s: float) -> NearbyObjects:
        """Look around and note what the ego pushes."""
        seen = bodies(self._near.told(self._eyes.percept), now_s)
        self._pushed = self._pushing.update(ego, seen)
        return seen

    def update(self, ego: EgoFootprint, now_s: float) -> tuple[TrackedObject, ...]:
        """Return everything tracked, in the local frame."""
        self.watch(ego, now_s)
        percept = self._eyes.percept
        if percept is None:
            return ()
        told = percept.attributes
        tracks = (*self._near.told(percept), *self._far.reported_tracks(percept))
        return tuple(_object(track, told.get(track.id), now_s, track.id in self._pushed) for track in tracks)

    def read_lights(self, now_s: float) -> None:
        """Do nothing: lamps come with each image."""


def is_flat(track: Track) -> bool:
    """True for debris that lies flat on the road: a bag is not wide enough for it, a rock or a tire not low enough."""
    low = LABELS[track.label] == "debris" and track.height_m <= FLAT_M
    return low and min(track.length_m, track.width_m) >= FLAT_SHARE * track.height_m


def bodies(tracks: Sequence[Track], now_s: float) -> NearbyObjects:
    """Tracks at one moment as boxes in CARLA's world."""
    moved = [track.predict_to(now_s) for track in tracks]
    rows = [
        (
            item.x_m,
            -item.y_m,
            -item.yaw_rad,
            item.length_m / 2.0,
            item.width_m / 2.0,
            item.z_m - item.height_m / 2.0,
            item.z_m + item.height_m / 2.0,
            item.vx_mps,
            -item.vy_mps,
        )
        for item in moved
    ]
    columns = np.array(rows, dtype=np.float64).reshape(len(rows), 9).T
    x, y, yaw, half_length, half_width, bottom, top, vx, vy = columns
    return NearbyObjects(
        actor_id=tuple(item.id for item in moved),
        is_walker=np.array([KIND_OF_LABEL[item.label] in ON_FOOT for item in moved], dtype=np.bool_),
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


def kind_of_track(track: Track, told: Attributes | None) -> tuple[ObjectKind, float]:
    """Return what a track is, with a confidence. The LiDAR's class applies if the camera gives nothing finer.

    If the two disagree, the kind is unknown, since neither is more reliable.
    """
    coarse, sure = KIND_OF_LABEL[track.label], float(track.label_confidence)
    if told is not None and told.kind is not None:
        if LABEL_OF_KIND.get(told.kind) == track.label:
            return told.kind, float(told.kind_confidence)
        if told.kind is not ObjectKind.PROP:
            return ObjectKind.UNKNOWN, min(sure, float(told.kind_confidence))
    return (coarse, sure) if sure >= SURE_KIND else (ObjectKind.UNKNOWN, sure)


def _object(track: Track, told: Attributes | None, now_s: float, pushed: bool) -> TrackedObject:
    kind, sure = kind_of_track(track, told)
    here = track.predict_to(now_s)
    return TrackedObject(
        id=str(track.id),
        kind=kind,
        x_m=here.x_m,
        y_m=here.y_m,
        yaw_rad=here.yaw_rad,
        vx_mps=here.vx_mps,
        vy_mps=here.vy_mps,
        length_m=here.length_m,
        width_m=here.width_m,
        height_m=here.height_m,
        stationary_s=here.stationary_s,
        moved_s_ago=here.moved_s_ago,
        seen_for_s=here.tracked_for_s,
        pushed=pushed,
        kind_confidence=sure,
        position_sd_m=_position_sd_m(here),
        across_sd_m=_across_sd_m(here),
        hazard_lights=None if told is None else told.hazard_lights,
        emergency_lights=None if told is None else told.emergency_lights,
        brake_lights=None if told is None else told.brake_lights,
        door_open=None if told is None else told.door_open,
        gesture=told.gesture if told is not None and kind is ObjectKind.FLAGGER else None,
    )


def actor_proxies(percept: PerceptionResult, ids: Sequence[int]) -> list[Any]:
    """Return the kind of each of these tracks in terms of CARLA's blueprints."""
    found = []
    for track in percept.tracks:
        if track.id in ids:
            kind, _ = kind_of_track(track, percept.attributes.get(track.id))
            special = {"special_type": "emergency"} if kind is ObjectKind.EMERGENCY else {}
            type_id = _TYPE_IDS.get(kind, "vehicle.sensed")
            attributes = {"base_type": kind.value, **special}
            found.append(SimpleNamespace(id=track.id, type_id=type_id, attributes=attributes, parent=None))
    for far in percept.far_tracks:
        if far.id in ids:
            attributes = {"base_type": KIND_OF_LABEL[TRACK_LABELS[far.label]].value}
            found.append(SimpleNamespace(id=far.id, type_id="vehicle.sensed", attributes=attributes, parent=None))
    return found


def lamps_of(percept: PerceptionResult) -> dict[int, int]:
    """Return the lamps by track, as bits of `carla.VehicleLightState`; unknown ones count as off."""
    return {track: _bits(told) for track, told in percept.attributes.items()}


def _bits(told: Attributes) -> int:
    bits = HAZARD_LAMPS if told.hazard_lights else 0
    bits |= LEFT_BLINKER if told.left_blinker else 0
    bits |= RIGHT_BLINKER if told.right_blinker else 0
    bits |= BRAKE if told.brake_lights else 0
    return bits | (SPECIAL if told.emergency_lights else 0)
