"""What a driver by sensors brakes for: everything but debris that lies flat on the road."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stucksolver_carla.drivers.behavior.nearby_objects import GroundTruthObjects
from stucksolver_perception.carla.known_posts import KnownPosts
from stucksolver_perception.carla.perceived_objects import PerceivedBoxes, is_flat
from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.tracking import Track


def thing(label: str, length: float, width: float, height: float, number: int = 1) -> Track:
    return Track(
        id=number,
        time_s=0.0,
        label=LABELS.index(label),
        label_confidence=0.9,
        confidence=0.9,
        x_m=10.0 * number,
        y_m=0.0,
        z_m=height / 2.0,
        yaw_rad=0.0,
        vx_mps=0.0,
        vy_mps=0.0,
        length_m=length,
        width_m=width,
        height_m=height,
        covariance=np.diag([0.1, 0.1, 0.1, 0.1, 0.1]) ** 2,
        first_seen_s=-5.0,
        last_seen_s=0.0,
        hits=50,
        hidden=False,
        standing_since_s=-5.0,
        moved_at_s=None,
    )


@pytest.mark.parametrize(
    ("what", "flat"),
    [
        (("debris", 1.4, 1.1, 0.15), True),  # a heap of dirt
        (("debris", 2.4, 1.6, 0.2), True),
        (("debris", 0.4, 0.35, 0.12), False),  # a paper bag
        (("debris", 0.6, 0.6, 0.2), False),  # a tyre that lies
        (("debris", 0.6, 0.5, 0.35), False),  # a rock
        (("debris", 1.7, 0.5, 0.2), False),  # somebody who lies on the road
        (("pedestrian", 1.7, 1.0, 0.2), False),
        (("barrier", 2.0, 1.0, 0.2), False),
    ],
)
def test_only_debris_that_is_low_and_wide_is_flat(what: tuple[str, float, float, float], flat: bool) -> None:
    assert is_flat(thing(*what)) == flat


def test_boxes_sensor_mode_exclude_flat_debris() -> None:
    """In sensor mode, a driver drives over loose dirt and brakes for all other objects."""
    tracks = (thing("debris", 1.4, 1.1, 0.15, 1), thing("debris", 0.6, 0.5, 0.35, 2), thing("car", 4.5, 1.9, 1.5, 3))
    read: Any = PerceivedBoxes.__new__(PerceivedBoxes)
    read._perception, read._range_m = SimpleNamespace(percept=None, now_s=0.0), 60.0
    read._lane_prior, read._far_reports = (
        SimpleNamespace(with_lane_courses=lambda _: tracks),
        SimpleNamespace(reported_tracks=lambda _: ()),
    )
    read._posts = KnownPosts([])
    assert read.read(0.0, 0.0).actor_id == (2, 3)


def test_ground_truth_leaves_no_doubt_and_sensors_do() -> None:
    assert GroundTruthObjects.doubt_m == 0.0
    assert PerceivedBoxes.doubt_m > 0.0
