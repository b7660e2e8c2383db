"""The LiDAR's classes. Finer kinds (ambulance, flagger, bag or rock) are the camera's task."""

from __future__ import annotations

from stucksolver.scene import ObjectKind

LABELS = ("car", "truck", "two_wheeler", "pedestrian", "animal", "cone", "barrier", "debris")
"""Names of the detector's classes; `truck` is every large vehicle (van, truck, bus), `debris` everything small on
the road.
"""

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
"""The kind of a detection as long as the camera gives nothing finer."""

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
"""For training and for scores. `prop` and `unknown` have none: they are neither trained nor counted as errors."""
LARGE_EMERGENCY_M = 6.0
"""An emergency vehicle longer than this is a `truck` to the LiDAR."""
