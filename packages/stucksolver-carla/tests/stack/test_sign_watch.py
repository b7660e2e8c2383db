"""Signs are read while the ego stands, beside the control loop, with a reader that is made up here."""

from __future__ import annotations

import numpy as np
import pytest

from stucksolver.scene import SignWord
from stucksolver_perception.camera.sign_reader import SignReaderError
from stucksolver_perception.camera.sign_words import DetectedWord
from stucksolver_perception.carla.sign_worker import DELAY_S, MIN_STOPPED_S, PERIOD_S, SignWorker
from stucksolver_perception.measurements import CameraFrame, PoseEstimate
from stucksolver_perception.rig import load_rig

RIG = load_rig().camera
TICK_S = 0.05
SIZE = (RIG.height_px, RIG.width_px, 3)


class Reader:
    """Reads STOP wherever the picture is bright."""

    def __init__(self, error=None):
        self.crops = []
        self._error = error

    def read(self, crop, enlarge):
        if self._error is not None:
            raise self._error
        self.crops.append((crop.shape, enlarge))
        bright = np.argwhere(crop[..., 0] > 128)
        return (DetectedWord(SignWord.STOP, float(bright[:, 1].mean()), 0.0),) if len(bright) else ()


def picture(time_s):
    rgb = np.zeros(SIZE, np.uint8)
    rgb[300:330, 780:820] = 255
    return CameraFrame(time_s, rgb)


def drive(reader, seconds, speed=lambda time_s: 0.0, every_s=0.2, until_s=np.inf):
    """What is told on each tick."""
    watch = SignWorker(RIG, reader, {}, paced=True)
    told, frame = [], None
    for k in range(round(seconds / TICK_S)):
        now_s = k * TICK_S
        if k % round(every_s / TICK_S) == 0 and now_s <= until_s:
            frame = picture(now_s)
        pose = PoseEstimate(now_s, 0.0, 0.0, 0.0, 0.0, speed(now_s), 0.0, np.eye(4))
        watch.tick(now_s, pose, frame, ())
        told.append((now_s, watch.signs))
    watch.close()
    return told


def test_sign_watch_moving_or_just_stopped_reads_nothing():
    """No sign is read while the ego drives or before it has been stopped for long enough."""
    reader = Reader()
    drive(reader, MIN_STOPPED_S - TICK_S)
    drive(reader, 20.0, speed=lambda _: 3.0)
    drive(reader, 20.0, speed=lambda time_s: 0.0 if time_s % 3.0 < 2.5 else 1.0)
    assert reader.crops == []


def test_sign_watch_reads_one_crop_per_s_and_confirms_twice():
    """One crop is read per second, and a word counts after two of them."""
    reader = Reader()
    told = drive(reader, 12.0)
    assert len(reader.crops) == pytest.approx((12.0 - MIN_STOPPED_S) / PERIOD_S, abs=1)
    first_s = next(time_s for time_s, signs in told if signs)
    assert first_s >= MIN_STOPPED_S + PERIOD_S + DELAY_S
    sign = told[-1][1][0]
    assert (sign.word, sign.object_id) == (SignWord.STOP, None)
    assert sign.bearing_rad == pytest.approx(0.0, abs=0.01)


def test_two_drives_tell_the_same_on_the_same_ticks():
    assert drive(Reader(), 12.0) == drive(Reader(), 12.0)


def test_words_are_gone_as_soon_as_the_ego_moves():
    told = drive(Reader(), 14.0, speed=lambda time_s: 0.0 if time_s < 12.0 else 1.0)
    assert any(signs for time_s, signs in told if time_s < 12.0)
    assert not any(signs for time_s, signs in told if time_s >= 12.0)


def test_sign_watch_reads_image_once_so_dead_camera_confirms_nothing():
    """Each image is read once, so a camera that has died confirms nothing."""
    reader = Reader()
    told = drive(reader, 12.0, until_s=MIN_STOPPED_S)
    assert len(reader.crops) == 1
    assert not any(signs for _, signs in told)


def test_without_a_reader_nothing_happens():
    assert not any(signs for _, signs in drive(None, 12.0))


def test_sign_watch_reader_not_loadable_is_reported_once(capsys):
    """A reader that cannot be loaded is reported once and ends the reading."""
    assert not any(signs for _, signs in drive(Reader(SignReaderError("no libGL; install it")), 12.0))
    assert capsys.readouterr().err == "stucksolver: words on signs are not read: no libGL; install it\n"
