"""An object at a later moment: what is told of it is what its filter would predict."""

from __future__ import annotations

import numpy as np
import pytest

from stucksolver_perception.lidar_labels import LABELS
from stucksolver_perception.tracking.stationarity import MotionState
from stucksolver_perception.tracking.track_state import TrackState, predict


def body(motion, label="car"):
    """One that has been followed for a while, going askew."""
    root = np.random.default_rng(5).normal(0.0, 0.3, (6, 6))
    found = TrackState(
        1, np.array([10.0, -4.0, 0.8, 0.3, 6.0, 1.5]), root @ root.T, np.array([4.5, 1.9, 1.5]), 2.0, 0.0, 2.0
    )
    found.votes[LABELS.index(label)] = 4.0
    found.motion = motion
    found.standing_since_s = 1.0 if motion is MotionState.STANDING else None
    return found


@pytest.mark.parametrize("motion", [MotionState.MOVING, MotionState.UNDECIDED, MotionState.STANDING])
@pytest.mark.parametrize("label", ["car", "pedestrian", "cone"])
def test_a_track_at_a_later_time_is_what_the_filter_predicts(motion, label):
    followed = body(motion, label)
    later = followed.track().predict_to(2.4)
    predict(followed, 2.4)
    expected = followed.track()
    assert (later.time_s, later.x_m, later.y_m) == pytest.approx((expected.time_s, expected.x_m, expected.y_m))
    np.testing.assert_allclose(later.covariance, expected.covariance, atol=1e-12)


def test_what_stands_stays_where_it_is_and_what_moves_goes_on():
    stands, moves = body(MotionState.STANDING).track(), body(MotionState.MOVING).track()
    assert (stands.predict_to(5.0).x_m, stands.predict_to(5.0).y_m) == (stands.x_m, stands.y_m)
    assert stands.predict_to(5.0).stationary_s == pytest.approx(stands.stationary_s + 3.0)
    assert moves.predict_to(3.0).x_m == pytest.approx(moves.x_m + 6.0)
    assert moves.predict_to(3.0).covariance[0, 0] > moves.predict_to(2.1).covariance[0, 0]


def test_nobody_is_taken_back_in_time():
    track = body(MotionState.MOVING).track()
    assert track.predict_to(1.0) is track
    assert track.predict_to(2.0) is track
