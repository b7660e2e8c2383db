"""Measurements across the bridge: what is asked for is the newest, as it was given; what does not fit is named."""

from __future__ import annotations

import math
import os
from contextlib import contextmanager
from types import SimpleNamespace

import numpy as np
import pytest

from stucksolver_bridge.directive_validation import malformed_reason
from stucksolver_bridge.sensor_data import SensorData, numbers
from stucksolver_bridge.shared_memory import SharedFrames
from stucksolver_carla.perception_interface import SensorError
from stucksolver_perception.carla.declared_sensors import rig_of
from stucksolver_perception.carla.shared_measurements import SharedMeasurements
from stucksolver_perception.rig import load_rig

RIG = load_rig()
DECLARED = [
    {"type": "sensor.camera.rgb", "id": "CAM", "x": 0.8, "y": 0.2, "z": 1.6, "width": 1600, "height": 900, "fov": 70},
    {"type": "sensor.lidar.ray_cast", "id": "LIDAR", "x": 0.0, "y": 0.0, "z": 2.5, "yaw": -90.0},
    {"type": "sensor.other.imu", "id": "IMU"},
    {"type": "sensor.other.gnss", "id": "GPS"},
    {"type": "sensor.speedometer", "id": "SPEED"},
]
BACK = {
    "type": "sensor.camera.rgb",
    "id": "BACK",
    "x": -2.0,
    "z": 1.6,
    "yaw": 180.0,
    "width": 800,
    "height": 450,
    "fov": 70,
}
RANDOM = np.random.default_rng(3)


class StubVehicle:
    """Knows its world's time and its lamps."""

    def __init__(self):
        self.time_s = 0.0

    def get_world(self):
        stamp = SimpleNamespace(elapsed_seconds=self.time_s, delta_seconds=0.05)
        return SimpleNamespace(get_snapshot=lambda: SimpleNamespace(timestamp=stamp, frame=round(self.time_s / 0.05)))

    def get_speed_limit(self):
        return 50.0

    def get_light_state(self):
        return 0


class StubClock:
    """The mirrored world, as far as time goes."""

    time_s = 0.0

    def start_tick(self, tick):
        self.time_s = float(tick["time"])


def data(**others):
    """A tick's data as the leaderboard gives them."""
    given = {
        "CAM": RANDOM.integers(0, 255, (900, 1600, 4), np.uint8),
        "LIDAR": RANDOM.uniform(-50.0, 50.0, (9000, 4)).astype(np.float32),
        "IMU": np.array([0.1, 0.2, 9.8, 0.01, 0.02, 0.03, 1.0]),
        "GPS": np.array([0.0001, 0.0002, 5.0]),
        "SPEED": {"speed": 4.0},
        **others,
    }
    return {name: (7, value) for name, value in given.items() if value is not None}


@pytest.fixture
def both():
    """The agent's side, and the reader at the other end."""
    with sides(DECLARED) as found:
        yield found


@contextmanager
def sides(declared):
    vehicle = StubVehicle()
    facts = SensorData(vehicle, None, declared)
    facts._world = SimpleNamespace(get_snapshot=lambda: vehicle.get_world().get_snapshot())
    opening = {"frames": {"fd": facts.frames.fd, "size": facts.frames.size}, "xodr": ""}
    reader = SharedMeasurements(opening, rig_of(declared, RIG), facts.give, StubClock())
    yield vehicle, facts, reader
    reader.close()
    facts.close()


def test_reader_data_arrive_unchanged_in_vehicle_frame(both):
    _, facts, reader = both
    given = data()
    facts.take_in(given)
    read = reader.read()
    assert np.array_equal(read.picture.rgb, given["CAM"][1][:, :, 2::-1])
    points, told = given["LIDAR"][1], read.sweep.points
    # Turned by 90 degrees to the left, as by Bench2Drive's agents: the sensor's x is the vehicle's left.
    np.testing.assert_allclose(told[:, 1], points[:, 0], atol=1e-4)
    np.testing.assert_allclose(told[:, 0], points[:, 1], atol=1e-4)
    np.testing.assert_allclose(told[:, 2], points[:, 2] + 2.5, atol=1e-4)
    assert read.imu.rotation_rps == (-0.01, 0.02, -0.03)
    assert read.fix.x_m == pytest.approx(math.radians(0.0002) * 6378137.0)
    assert abs(read.wheels.speed_mps - 4.0) < 0.5
    assert read.silent == ()


def test_reader_rear_image_is_independent_of_declaration_order():
    """The rear image is that of the rear camera, whichever camera is declared first."""
    behind = RANDOM.integers(0, 255, (450, 800, 4), np.uint8)
    for declared in ([*DECLARED, BACK], [BACK, *DECLARED]):
        with sides(declared) as (_, facts, reader):
            given = data(BACK=behind)
            facts.take_in(given)
            read = reader.read()
            assert np.array_equal(read.rear.rgb, behind[:, :, 2::-1])
            assert np.array_equal(read.picture.rgb, given["CAM"][1][:, :, 2::-1])
            facts.take_in(data())
            reader._clock.time_s += 1.0
            read = reader.read()
            assert read.rear is None and read.picture is not None


def test_reader_without_rear_camera_has_no_rear_image(both):
    _, facts, reader = both
    facts.take_in(data())
    assert reader.read().rear is None


@pytest.mark.parametrize(
    ("declared", "message"),
    [
        ([*DECLARED, BACK, BACK], "declares 2 rear cameras"),
        ([BACK, *DECLARED[1:]], "declares 0 sensors of type sensor.camera.rgb: perception requires one front camera"),
        ([*DECLARED, BACK | {"width": 1600}], "rear camera has images of 1600 x 450, the rig has 800 x 450"),
        ([*DECLARED, BACK | {"fov": 110}], "rear camera has a field of view of 110 degrees, the rig has 70"),
    ],
)
def test_a_rear_camera_that_does_not_fit_is_named(declared, message):
    with pytest.raises(SensorError, match=message):
        rig_of(declared, RIG)


def test_of_two_ticks_between_two_questions_the_older_is_dropped(both):
    _, facts, reader = both
    facts.take_in(data())
    newest = data()
    facts.take_in(newest)
    assert np.array_equal(reader.read().picture.rgb, newest["CAM"][1][:, :, 2::-1])


def test_reader_takes_image_at_5_hz_and_sweep_each_tick(both):
    """An image is taken five times a second, and a sweep on each tick."""
    vehicle, facts, reader = both
    found = []
    for tick in range(9):
        vehicle.time_s = reader._clock.time_s = 0.05 * tick
        facts.take_in(data())
        found.append(reader.read())
    assert [item.picture is not None for item in found] == [True, False, False, False, True, False, False, False, True]
    assert all(item.sweep is not None and item.silent == () for item in found)


def test_what_is_missing_or_not_finite_is_silent(both):
    _, facts, reader = both
    facts.take_in(data(LIDAR=None, GPS=np.array([np.nan, 0.0, 0.0])))
    read = reader.read()
    assert (read.sweep, read.fix) == (None, None)
    assert set(read.silent) == {"lidar", "gnss"}


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"CAM": np.zeros((450, 800, 4), np.uint8)}, "image is 800 x 450 x 4, the rig has 1600 x 900"),
        ({"CAM": np.zeros((900, 1600, 3), np.uint8)}, "image is 1600 x 900 x 3"),
        ({"CAM": np.zeros((900, 1600, 4), np.float32)}, "numbers of type 'f'; expected 'B'"),
        ({"CAM": "a picture"}, "image is str"),
        ({"LIDAR": np.zeros((10, 3), np.float32)}, r"array of shape \(10, 3\); expected \(n, 4\)"),
        ({"LIDAR": np.zeros((10, 4), np.float64)}, "numbers of type 'd'"),
        ({"LIDAR": np.zeros((2_000_000, 4), np.float32)}, "more than the bridge.s memory for it"),
        ({"IMU": np.zeros(6)}, "the IMU gives 6 numbers; expected 7"),
        ({"GPS": np.zeros(2)}, "the GNSS gives 2 numbers; expected 3"),
    ],
)
def test_data_of_another_sensor_are_named(both, changed, told):
    _, facts, reader = both
    facts.take_in(data(**changed))
    with pytest.raises(SensorError, match=told):
        reader.read()


@pytest.mark.parametrize(
    ("sensors", "told"),
    [
        (DECLARED[1:], r"declares 0 sensors of type sensor\.camera\.rgb: perception requires one front camera"),
        ([*DECLARED, DECLARED[1]], r"declares 2 sensors of type sensor\.lidar\.ray_cast"),
        ([{**DECLARED[0], "width": 800}, *DECLARED[1:]], "800 x 900, the rig has 1600 x 900"),
        ([{**DECLARED[0], "fov": 90}, *DECLARED[1:]], "field of view of 90 degrees, the rig has 70"),
    ],
)
def test_declared_sensors_that_do_not_fit_the_rig_are_named(sensors, told):
    with pytest.raises(SensorError, match=told):
        rig_of(sensors, RIG)


def test_mounts_are_those_that_are_declared():
    rig = rig_of(DECLARED, RIG)
    assert (rig.lidar.mount.yaw_deg, rig.camera.mount.y_m) == (90.0, -0.2)
    assert rig.lidar.channels == RIG.lidar.channels


def test_what_does_not_fit_into_its_place_overwrites_nothing():
    frames = SharedFrames({"small": 8, "next": 8})
    frames.put("next", b"12345678")
    assert frames.put("small", bytes(9))["at"] is None
    told = frames.put("small", b"abcd")
    assert (told["at"], told["bytes"]) == (0, 4)
    assert os.pread(frames.fd, 16, 0) == b"abcd\0\0\0\x0012345678"
    assert frames.put("small", np.zeros((0, 4), np.float32))["shape"] == [0, 4]
    frames.close()


def test_numbers_are_finite_or_nothing():
    assert numbers([1, 2.5]) == [1.0, 2.5]
    assert numbers(None) is numbers([1.0, math.inf]) is numbers([]) is None


@pytest.mark.parametrize(
    "control",
    [
        None,
        [0.5, 0.0, 0.0, False],
        [1.5, 0.0, 0.0, False, False],
        [0.5, math.nan, 0.0, False, False],
        [0, 0, 0, 1, False],
    ],
)
def test_a_control_that_cannot_be_performed_is_refused(control):
    assert malformed_reason({"orders": [["control", [0.5, -1.0, 0.0, False, False]]]}) is None
    assert malformed_reason({"orders": [["control", control]]}) is not None
