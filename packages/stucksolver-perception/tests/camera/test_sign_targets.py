"""What is looked at for words: standing things near ahead, the map's posts, and the road ahead."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from stucksolver.scene import SignWord
from stucksolver_perception.camera.sign_targets import MAX_OBJECTS, bearing_rad, carrier_of, swaths, targets
from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.measurements import PoseEstimate
from stucksolver_perception.rig import load_rig
from stucksolver_perception.tracking import Track

RIG = load_rig().camera
HERE = PoseEstimate(0.0, 100.0, 50.0, 2.0, math.pi / 2, 0.0, 0.0, np.eye(4))
BARRIER = Track(
    id=7,
    time_s=0.0,
    label=LABELS.index("barrier"),
    label_confidence=0.9,
    confidence=0.9,
    x_m=100.0,
    y_m=62.0,
    z_m=2.5,
    yaw_rad=0.0,
    vx_mps=0.0,
    vy_mps=0.0,
    length_m=1.2,
    width_m=0.4,
    height_m=1.0,
    covariance=np.eye(5),
    first_seen_s=-1.0,
    last_seen_s=0.0,
    hits=10,
    hidden=False,
    standing_since_s=-1.0,
    moved_at_s=None,
)
"""12 m ahead of the vehicle, which looks along y."""


def keys(*tracks, posts=()):
    return [target.key for target in targets(RIG, HERE, tracks, dict(enumerate(posts)))]


AHEAD = ["ahead-0", "ahead-1", "ahead-2"]


def test_without_anything_near_the_road_ahead_is_read():
    assert keys() == AHEAD
    parts = [swath for swath in swaths(RIG) if swath is not None]
    assert (parts[0].left, parts[-1].right) == (0, RIG.width_px)
    assert all(left.right > right.left for left, right in itertools.pairwise(parts))


def test_a_barrier_is_read_first_with_what_stands_above_it():
    assert keys(BARRIER) == ["track-7", *AHEAD]
    crop = targets(RIG, HERE, [BARRIER], {})[0]
    face = RIG.project(np.array([[12.0, 0.0, 2.0]]))
    assert crop.left < face[0][0] < crop.right
    assert crop.top < face[1][0] < crop.bottom


@pytest.mark.parametrize(
    "change",
    [{"hidden": True}, {"vx_mps": 1.0}, {"y_m": 95.0}, {"y_m": 40.0}, {"x_m": 120.0}, {"height_m": 0.2}],
)
def test_targets_hidden_moving_far_or_low_objects_are_skipped(change):
    """An object that is occluded, moving, far, behind, to the side or low is not read."""
    assert keys(replace(BARRIER, **change)) == AHEAD


def test_vehicles_come_last_and_few_of_each_are_read():
    cars = [replace(BARRIER, id=20 + k, label=LABELS.index("car"), y_m=60.0 + k) for k in range(5)]
    things = [replace(BARRIER, id=k, y_m=60.0 + k) for k in range(6)]
    told = keys(*cars, *things)
    assert told[:MAX_OBJECTS] == ["track-0", "track-1", "track-2", "track-3"]
    assert told[-3:] == ["track-20", "track-21", "track-22"]


def test_posts_of_the_map_are_read_where_their_face_is():
    posts = [(97.0, 65.0), (97.0, 40.0), (97.0, 150.0)]
    assert keys(posts=posts) == [*AHEAD, "post-0"]
    crop = targets(RIG, HERE, [], dict(enumerate(posts)))[-1]
    column, row, _ = RIG.project(np.array([[15.0, 3.0, 2.25]]))
    assert crop.left < column[0] < crop.right
    assert crop.top < row[0] < crop.bottom
    assert crop.distance_m == pytest.approx(math.hypot(15.0, 3.0), abs=0.05)


def test_carrier_is_nearest_object_that_can_carry_word():
    """A word belongs to the nearest object that can carry it, wherever it was read."""
    far_car = replace(BARRIER, id=9, label=LABELS.index("car"), y_m=65.0)
    found = targets(RIG, HERE, [BARRIER, replace(far_car, id=8, y_m=63.0), far_car], {})
    barrier, road, behind = found[0], found[2], found[-1]
    column, row = (behind.left + behind.right) / 2, (behind.top + behind.bottom) / 2
    carriers = {word: carrier_of(word, column, row, found, road) for word in (SignWord.STOP, SignWord.POLICE)}
    assert {word: carrier and carrier.track_id for word, carrier in carriers.items()} == {
        SignWord.STOP: 7,
        SignWord.POLICE: 8,
    }
    assert carrier_of(SignWord.POLICE, column, row, found[:1], barrier) is None
    assert carrier_of(SignWord.STOP, 10.0, 10.0, found, road) is None


def test_carrier_of_word_at_map_post_is_none():
    """A word at a post of the map belongs to the post."""
    found = targets(RIG, HERE, [BARRIER], {0: (100.0, 63.0)})
    post = found[-1]
    column, row = (post.left + post.right) / 2, (post.top + post.bottom) / 2
    assert found[0].carries(SignWord.STOP, column, row)
    assert carrier_of(SignWord.STOP, column, row, found, post) is None


def test_target_widened_contains_original_and_stays_in_image():
    for target in targets(RIG, HERE, [BARRIER], {}):
        wide = target.widened(RIG)
        assert (
            wide.left <= target.left
            and wide.top <= target.top
            and wide.right >= target.right
            and wide.bottom >= target.bottom
        )
        assert (wide.left, wide.right, wide.bottom) != (target.left, target.right, target.bottom)
        assert min(wide.left, wide.top) >= 0 and wide.right <= RIG.width_px and wide.bottom <= RIG.height_px


def test_bearings_are_positive_to_the_left():
    assert bearing_rad(RIG, 800.0) == 0.0
    assert math.degrees(bearing_rad(RIG, 0.0)) == pytest.approx(35.0, abs=0.1)
