"""Vehicles that only the camera sees: followed with honest errors, and handed over to the LiDAR."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from stucksolver_perception.camera.far_detector import FarDetections
from stucksolver_perception.camera.far_range import RangeModel
from stucksolver_perception.far_tracking import (
    FIRST_ID,
    HANDOVER_HITS,
    LOST_S,
    NEAREST_M,
    RATE_SD_MPS,
    FarTrack,
    FarTracker,
    is_refuted,
)
from stucksolver_perception.free_space import AZIMUTHS, CELL_M, FreeSpace
from stucksolver_perception.measurements import PoseEstimate
from stucksolver_perception.rig import load_rig
from stucksolver_perception.tracking import Track

CAMERA = load_rig().camera
MODEL = RangeModel(
    0.0, 3.0, 1.3, ((7.0, -0.5, -0.5), (7.0, -0.5, -0.5), (7.0, -0.5, -0.5)), (0.2,) * 3, (0.0,) * 3, 1.0
)
PICTURE_S = 0.2
LABELS = {"vehicle": 0, "two_wheeler": 1, "person": 2}


def pose(time_s: float, x: float = 0.0, speed: float = 0.0) -> PoseEstimate:
    return PoseEstimate(time_s, x, 0.0, 0.0, 0.0, speed, 0.0, np.diag([0.04, 0.04, 1e-4, 0.0025]))


def picture(
    time_s: float, *ranges: float, aside: float = 0.05, label: str = "vehicle", towards: float = 0.9
) -> FarDetections:
    """Detections at these ranges from the lens by row and size alike, all in a direction `aside` (rad)."""
    away = np.array(ranges)
    n = len(away)
    side = np.exp(7.0) / away if n else np.zeros(0)
    return FarDetections(
        time_s=time_s,
        column=np.full(n, CAMERA.width_px / 2.0 - CAMERA.focal_px * np.tan(aside)),
        row=CAMERA.height_px / 2.0 + CAMERA.focal_px * CAMERA.mount.z_m / away if n else np.zeros(0),
        width=side,
        height=side,
        score=np.full(n, 0.9),
        label=np.full(n, LABELS[label]),
        towards=np.full(n, towards),
        look=np.array([120.0, 5.0]),
    )


def lidar(x: float, y: float, time_s: float, number: int = 7, hits: int = HANDOVER_HITS) -> Track:
    places = {"x_m": x, "y_m": y, "z_m": 0.8, "yaw_rad": 0.0, "vx_mps": 0.0, "vy_mps": 0.0}
    sizes = {"length_m": 4.5, "width_m": 1.9, "height_m": 1.6}
    seen = {"first_seen_s": 0.0, "last_seen_s": time_s, "hits": hits, "hidden": False}
    rest = {"covariance": np.eye(5), "standing_since_s": None, "moved_at_s": None}
    return Track(number, time_s, 0, 0.9, 0.9, **places, **sizes, **seen, **rest)


def followed(
    range_at: Callable[[float], float], seconds: float, speed: float = 0.0, towards: float = 0.9
) -> tuple[FarTracker, tuple[FarTrack, ...]]:
    """One vehicle in five pictures a second, its range from the lens as `range_at(t)` says; the last answer."""
    tracker = FarTracker(CAMERA, MODEL)
    time_s = 0.0
    for k in range(round(seconds / PICTURE_S) + 1):
        time_s = k * PICTURE_S
        tracker.update(picture(time_s, range_at(time_s), towards=towards), pose(time_s, speed * time_s, speed), ())
    return tracker, tracker.tracks(time_s, ())


def test_who_was_found_once_is_not_told_of() -> None:
    assert followed(lambda t: 90.0, 0.0)[1] == ()
    assert len(followed(lambda t: 90.0, PICTURE_S)[1]) == 1


def test_before_a_rate_is_measured_any_rate_is_possible() -> None:
    (track,) = followed(lambda t: 90.0, PICTURE_S)[1]
    assert track.rate_sd_mps > 0.8 * RATE_SD_MPS


def test_the_rate_of_who_comes_is_soon_known() -> None:
    (track,) = followed(lambda t: 150.0 - 15.0 * t, 3.0)[1]
    assert track.rate_mps == pytest.approx(-15.0, abs=1.5)
    assert track.rate_sd_mps < RATE_SD_MPS / 2.5
    assert track.range_m == pytest.approx(105.0, rel=0.03)


def test_far_tracker_stationary_vehicle_has_no_rate_while_approached() -> None:
    """A stationary vehicle has no rate, however fast the ego approaches."""
    (track,) = followed(lambda t: 150.0 - 20.0 * t, 3.0, speed=20.0)[1]
    assert track.rate_mps == pytest.approx(0.0, abs=1.5)
    assert track.x_m == pytest.approx(150.0 * np.cos(0.05) + CAMERA.mount.x_m, rel=0.03)


@pytest.mark.parametrize("share", [0.85, 1.0, 1.15])
def test_far_tracker_biased_range_stays_within_reported_error(share: float) -> None:
    """A range with a constant bias stays within the reported error."""
    (track,) = followed(lambda t: share * (120.0 - 10.0 * t), 4.0)[1]
    assert abs(track.range_m - 80.0) < 2.0 * track.range_sd_m
    assert abs(track.rate_mps + 10.0) < 2.0 * track.rate_sd_mps


def test_errors_that_are_told_are_those_that_are_made() -> None:
    rng = np.random.default_rng(1)
    off = []
    for _ in range(40):
        bias = 1.0 + rng.normal(0.0, 0.1)
        noise = {round(k * PICTURE_S, 3): 1.0 + rng.normal(0.0, 0.05) for k in range(40)}
        (track,) = followed(lambda t, b=bias, n=noise: b * n[round(t, 3)] * (130.0 - 12.0 * t), 2.0)[1]
        off.append(((track.range_m - 106.0) / track.range_sd_m, (track.rate_mps + 12.0) / track.rate_sd_mps))
    assert (np.abs(off) < 2.0).mean(axis=0).min() > 0.9


def test_where_the_front_is_seen_is_remembered_as_coming() -> None:
    assert followed(lambda t: 90.0, 1.0, towards=0.9)[1][0].towards > 0.95
    assert followed(lambda t: 90.0, 1.0, towards=0.1)[1][0].towards < 0.05


def test_what_the_lidar_follows_is_not_followed_twice() -> None:
    tracker = FarTracker(CAMERA, MODEL)
    for k in range(5):
        known = (lidar(61.0, 3.0, k * PICTURE_S),)
        tracker.update(picture(k * PICTURE_S, 60.0), pose(k * PICTURE_S), known)
        assert tracker.tracks(k * PICTURE_S, known) == ()


def test_far_track_ends_when_lidar_detects_vehicle() -> None:
    """A track ends when the LiDAR detects the vehicle, even between images."""
    tracker, told = followed(lambda t: 80.0 - 10.0 * t, 2.0)
    assert len(told) == 1
    assert tracker.tracks(2.1, (lidar(58.0, 3.0, 2.1),)) == ()
    assert tracker.tracks(2.1, ()) == ()


def test_far_track_stays_until_lidar_track_is_confirmed() -> None:
    """A track stays until the LiDAR has tracked its vehicle for a second.

    At the edge of its grid, the LiDAR measures 10 m/s for a car at 20 m/s.
    """
    tracker, (track,) = followed(lambda t: 80.0 - 10.0 * t, 2.0)
    new = (lidar(58.0, 3.0, 2.1, hits=HANDOVER_HITS - 1),)
    assert [item.id for item in tracker.tracks(2.1, new)] == [track.id]


def test_far_tracker_vehicle_in_few_images_is_not_reported() -> None:
    """A vehicle that was found in few of the images is not reported."""
    tracker = FarTracker(CAMERA, MODEL)
    for k in range(7):
        ranges = (120.0,) if k in (0, 1) else ()
        tracker.update(picture(k * PICTURE_S, *ranges), pose(k * PICTURE_S), ())
        assert bool(tracker.tracks(k * PICTURE_S, ())) == (1 <= k <= 5)


def test_a_track_ends_when_the_lidar_takes_its_detection() -> None:
    tracker, (track,) = followed(lambda t: 80.0 - 10.0 * t, 2.0)
    known = (lidar(59.0, 3.0, 2.2),)
    tracker.update(picture(2.2, 58.0), pose(2.2), known)
    assert track.id not in [item.id for item in tracker.tracks(2.2, known)]


def test_far_track_does_not_switch_to_adjacent_lane() -> None:
    """A track does not go over to a vehicle in the adjacent lane."""
    tracker, (track,) = followed(lambda t: 80.0, 1.0)
    for k in range(1, 4):
        t = 1.0 + k * PICTURE_S
        tracker.update(picture(t, 80.0 - 10.0 * (t - 1.0), aside=0.05 + 3.5 / 80.0), pose(t), ())
    told = tracker.tracks(1.6, ())
    assert [item.hits for item in told if item.id == track.id] == [track.hits]
    assert len(told) == 2


def test_far_tracker_vehicle_behind_lidar_track_stays_tracked() -> None:
    """A second vehicle behind one that the LiDAR tracks stays tracked."""
    tracker = FarTracker(CAMERA, MODEL)
    for k in range(5):
        known = (lidar(61.0, 3.0, k * PICTURE_S),)
        tracker.update(picture(k * PICTURE_S, 60.0, 75.0), pose(k * PICTURE_S), known)
        told = tracker.tracks(k * PICTURE_S, known)
    assert [round(item.range_m) for item in told] == [75]


def test_something_that_the_lidar_follows_elsewhere_ends_no_track() -> None:
    tracker, _ = followed(lambda t: 80.0, 1.0)
    assert len(tracker.tracks(1.0, (lidar(80.0, -4.0, 1.0), lidar(30.0, 1.5, 1.0, 8)))) == 1


def test_who_was_missed_goes_on_coming_for_a_while() -> None:
    tracker, (before,) = followed(lambda t: 150.0 - 15.0 * t, 3.0)
    for k in range(1, 6):
        tracker.update(picture(3.0 + k * PICTURE_S), pose(3.0 + k * PICTURE_S), ())
    (after,) = tracker.tracks(4.0, ())
    assert after.id == before.id
    assert after.range_m == pytest.approx(90.0, rel=0.05)
    assert after.rate_sd_mps > before.rate_sd_mps
    tracker.update(picture(3.1 + LOST_S), pose(3.1 + LOST_S), ())
    assert tracker.tracks(3.1 + LOST_S, ()) == ()


def test_what_is_near_and_people_begin_no_track() -> None:
    tracker = FarTracker(CAMERA, MODEL)
    for k in range(4):
        tracker.update(picture(k * PICTURE_S, NEAREST_M - 5.0), pose(k * PICTURE_S), ())
        tracker.update(picture(k * PICTURE_S + 0.1, 80.0, label="person"), pose(k * PICTURE_S + 0.1), ())
    assert tracker.tracks(1.0, ()) == ()


def test_far_track_near_is_not_reported_and_far_again_is() -> None:
    """A track that has come near is not reported, and is reported again when it is far.

    Found on a motorway: a car in the adjacent lane, which the LiDAR tracked elsewhere, ended a pass at 20 m.
    """
    tracker, times = FarTracker(CAMERA, MODEL), np.arange(0.0, 8.0, PICTURE_S)
    ranges = np.interp(times, [0.0, 3.0, 5.0, 8.0], [70.0, 25.0, 25.0, 80.0])
    told = []
    for time_s, range_m in zip(times, ranges, strict=True):
        tracker.update(picture(time_s, range_m), pose(time_s), ())
        told.append([track.range_m + track.range_sd_m for track in tracker.tracks(time_s, ())])
    assert any(told[k] for k in range(15)) and any(told[-10:])
    assert all(far > NEAREST_M for each in told for far in each)
    assert not any(told[20:25])


@pytest.mark.parametrize("noise", [0.0, 0.005, 0.02])
@pytest.mark.parametrize("seed", range(4))
def test_far_tracker_stopped_vehicle_is_reported_stopped_then_approaching(noise, seed):
    """A vehicle far ahead of a stopped ego is reported as stopped, and as approaching as soon as it does.

    Found beside a parked van: a car that waited at 125 m was reported as approaching at 7 m/s while it was stopped.
    """
    rng, tracker = np.random.default_rng(seed), FarTracker(CAMERA, MODEL)
    quick_mps2, began_s = 2.5, 8.0
    for time_s in np.arange(0.0, 12.0, PICTURE_S):
        moving_s = max(time_s - began_s, 0.0)
        range_m = 125.0 - quick_mps2 * moving_s**2 / 2.0
        tracker.update(picture(time_s, range_m * (1.0 + noise * rng.normal())), pose(time_s), ())
        told = tracker.tracks(time_s, ())
        if 6.0 < time_s <= began_s:
            assert abs(told[0].rate_mps) < 0.8
            assert told[0].rate_mps - 2.0 * told[0].rate_sd_mps > (-4.0 if noise < 0.01 else -7.0)
        if time_s > began_s:
            covers_m = range_m - told[0].range_m + 2.0 * told[0].range_sd_m
            # What its speed is underestimated by, for a second, is far less than its place is told to be nearer.
            assert told[0].rate_mps - 2.0 * told[0].rate_sd_mps < -quick_mps2 * moving_s + 2.0
            assert covers_m > 2.5 * 4.0


def test_two_vehicles_side_by_side_keep_their_numbers() -> None:
    tracker = FarTracker(CAMERA, MODEL)
    for k in range(10):
        t = k * PICTURE_S
        left, right = picture(t, 120.0 - 15.0 * t, aside=0.06), picture(t, 70.0 + 5.0 * t, aside=-0.05)
        both = {n: np.concatenate([getattr(left, n), getattr(right, n)]) for n in ("column", "row", "width", "height")}
        more = {n: np.concatenate([getattr(left, n), getattr(right, n)]) for n in ("score", "label", "towards")}
        tracker.update(FarDetections(time_s=t, **both, **more, look=left.look), pose(t), ())
    told = tracker.tracks(1.8, ())
    assert [item.id for item in told] == [FIRST_ID, FIRST_ID + 1]
    assert [round(item.rate_mps / 5.0) for item in told] == [-3, 1]


def free(reach_m: float, but: tuple[float, float] = (0.0, 0.0)) -> FreeSpace:
    """Ground seen all around up to this distance, except for a ring."""
    cells = np.zeros((AZIMUTHS, 170), bool)
    cells[:, : round(reach_m / CELL_M)] = True
    cells[:, round(but[0] / CELL_M) : round(but[1] / CELL_M)] = False
    return FreeSpace(cells, np.full(AZIMUTHS, np.inf), np.zeros(AZIMUTHS), (0.0, 0.0))


def far(range_m: float, sd_m: float = 2.0) -> FarTrack:
    at = {"x_m": range_m, "y_m": 0.0, "bearing_rad": 0.0, "range_m": range_m, "range_sd_m": sd_m}
    rest = {"rate_mps": -8.0, "rate_sd_mps": 1.0, "towards": 0.9, "first_seen_s": 0.0, "last_seen_s": 1.0, "hits": 9}
    return FarTrack(FIRST_ID, 1.0, 0, 0.9, **at, **rest)


def test_far_track_in_proven_free_space_is_refuted() -> None:
    """A far track ends where the LiDAR proves free space, and nowhere else."""
    assert is_refuted(far(25.0), free(50.0), pose(1.0))
    assert not is_refuted(far(25.0, sd_m=9.0), free(50.0), pose(1.0)), "it may be further off than the LiDAR sees"
    assert not is_refuted(far(25.0), free(28.0), pose(1.0))
    assert not is_refuted(far(25.0), free(50.0, but=(27.0, 29.0)), pose(1.0)), "there it may be"
    assert is_refuted(far(25.0), free(50.0, but=(34.0, 36.0)), pose(1.0))
    turned = PoseEstimate(1.0, 0.0, 0.0, 0.0, np.pi / 2.0, 0.0, 0.0, np.zeros((4, 4)))
    ahead = free(50.0)
    ahead.cells[: AZIMUTHS // 2] = False  # what is to the right of the vehicle was not seen
    assert not is_refuted(far(25.0), ahead, turned)
