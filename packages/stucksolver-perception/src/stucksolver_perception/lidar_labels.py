"""Defines the classes of the LiDAR detector. Finer kinds (ambulance, flagger, bag or rock) are the camera's task."""

from __future__ import annotations

from stucksolver.scene import ObjectKind

LABELS = ("car", "truck", "two_wheeler", "pedestrian", "animal", "cone", "barrier", "debris")
"""Names of the classes. `truck` is any large vehicle (van, truck, bus), `debris` any small object on the road."""

KIND_OF_LABEL = (
    ObjectKind.CAR,
    ObjectKind.TRUCK,
    ObjectKind.BICYCLE,
    ObjectKind.PEDESTRIAN,
    ObjectKind.ANIMAL,
    ObjectKind.CONE,
    ObjectKind.BARRIER,
    ObjectKind.DEBRIS,
)
"""Kind of each class, which applies if the camera gives no finer one."""

LABEL_OF_KIND = {
    ObjectKind.CAR: 0,
    ObjectKind.EMERGENCY: 0,
    ObjectKind.VAN: 1,
    ObjectKind.TRUCK: 1,
    ObjectKind.BUS: 1,
    ObjectKind.SCHOOL_BUS: 1,
    ObjectKind.MOTORCYCLE: 2,
    ObjectKind.BICYCLE: 2,
    ObjectKind.PEDESTRIAN: 3,
    ObjectKind.FLAGGER: 3,
    ObjectKind.ANIMAL: 4,
    ObjectKind.CONE: 5,
    ObjectKind.BARRIER: 6,
    ObjectKind.CROSSING_GATE: 6,
    ObjectKind.BAG: 7,
    ObjectKind.LITTER: 7,
    ObjectKind.DEBRIS: 7,
}
"""Class of each kind, for training and scores. `prop` and `unknown` have none; they are neither trained nor scored."""
LARGE_EMERGENCY_M = 6.0
"""Length from which an emergency vehicle has the class `truck` (m). Ours."""
