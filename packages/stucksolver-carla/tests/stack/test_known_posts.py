"""A post that the map knows is no person to a driver; a person beside it, or elsewhere, stays one."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stucksolver_perception.carla.known_posts import POST_M, KnownPosts
from stucksolver_perception.carla.perceived_objects import PerceivedBoxes
from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.tracking import Track

PERSON, CAR = LABELS.index("pedestrian"), LABELS.index("car")
POST = (20.0, 3.0)
SEEN = Track(
    id=1,
    time_s=0.0,
    label=PERSON,
    label_confidence=0.9,
    confidence=0.9,
    x_m=POST[0] + 0.3,
    y_m=POST[1] - 0.2,
    z_m=0.9,
    yaw_rad=0.0,
    vx_mps=0.0,
    vy_mps=0.3,
    length_m=0.4,
    width_m=0.4,
    height_m=1.8,
    covariance=np.diag([0.1] * 5) ** 2,
    first_seen_s=-1.0,
    last_seen_s=0.0,
    hits=10,
    hidden=False,
    standing_since_s=None,
    moved_at_s=None,
)


def test_a_post_is_narrow_and_stands_at_its_place() -> None:
    told = KnownPosts([POST]).as_post(SEEN)
    assert LABELS[told.label] == "barrier"
    assert (told.length_m, told.width_m, told.vy_mps) == (POST_M, POST_M, 0.0)


@pytest.mark.parametrize(
    "other",
    [{"x_m": POST[0] + 1.0}, {"vy_mps": 1.0}, {"width_m": 1.0}, {"label": CAR}],
    ids=["elsewhere", "walks", "wide", "a car"],
)
def test_everything_else_stays_what_it_is(other: dict[str, Any]) -> None:
    track = replace(SEEN, **other)
    assert KnownPosts([POST]).as_post(track) is track


def test_driver_sensor_mode_treats_post_as_object() -> None:
    """In sensor mode, a driver keeps the gap of an object from a post, not that of a pedestrian."""
    read: Any = PerceivedBoxes.__new__(PerceivedBoxes)
    read._perception, read._range_m = SimpleNamespace(percept=None, now_s=0.0), 60.0
    read._lane_prior, read._far_reports = (
        SimpleNamespace(with_lane_courses=lambda _: (SEEN,)),
        SimpleNamespace(reported_tracks=lambda _: ()),
    )
    read._posts = KnownPosts([POST])
    assert not read.read(0.0, 0.0).is_walker.any()
    read._posts = KnownPosts([])
    assert read.read(0.0, 0.0).is_walker.all()
