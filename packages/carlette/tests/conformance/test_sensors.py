"""Sensors over the wire: one measurement for each tick, stamped with it, read by the client's own types."""

from __future__ import annotations

import math
from contextlib import suppress
from queue import Empty, Queue
from typing import Any

import numpy as np
import pytest
from stage import ahead, blueprint, run, settled, spawn

carla = pytest.importorskip("carla")

ROOF = carla.Transform(carla.Location(z=2.4))
SMALL = {"image_size_x": "160", "image_size_y": "90"}
MEASURING = {
    "sensor.camera.depth": SMALL,
    "sensor.camera.instance_segmentation": SMALL,
    "sensor.camera.rgb": SMALL,
    "sensor.camera.semantic_segmentation": SMALL,
    "sensor.other.gnss": {},
    "sensor.other.imu": {},
    "sensor.other.radar": {},
    "sensor.lidar.ray_cast": {"range": "50"},
    "sensor.lidar.ray_cast_semantic": {"range": "50"},
}


class Listener:
    """A sensor on a car, and what it sends."""

    def __init__(self, world: Any, car: Any, type_id: str, place: Any = ROOF, **attributes: str) -> None:
        self.actor = world.spawn_actor(blueprint(world, type_id, **attributes), place, attach_to=car)
        self._queue: Queue[Any] = Queue()
        self.actor.listen(self._queue.put)

    def next(self) -> Any:
        # The first ray compiles its loops where no other run has: that takes long on a busy machine.
        return self._queue.get(timeout=60.0)

    def rest(self, wait_s: float = 0.3) -> list[Any]:
        """What has come, and comes for a moment."""
        found: list[Any] = []
        with suppress(Empty):
            while True:
                found.append(self._queue.get(timeout=wait_s))
        return found


@pytest.fixture
def car(world, spots) -> Any:
    return settled(world, spots[0])


@pytest.mark.parametrize("type_id", MEASURING)
def test_sensor_sends_one_measurement_per_tick_with_its_stamp(world, car, type_id: str) -> None:
    """Each tick gives one measurement, with the frame, the time and the pose of that tick."""
    one = Listener(world, car, type_id, **MEASURING[type_id])
    car.apply_control(carla.VehicleControl(throttle=0.6))
    for _ in range(10):
        frame = world.tick()
        data, snapshot = one.next(), world.get_snapshot()
        assert (data.frame, data.timestamp) == (frame, snapshot.timestamp.elapsed_seconds)
        place = snapshot.find(one.actor.id).get_transform()
        assert data.transform.location.distance(place.location) < 1e-3
        assert data.transform.rotation.yaw == pytest.approx(place.rotation.yaw, abs=1e-3)
    assert one.rest() == []


def test_a_period_leaves_ticks_out(world, car) -> None:
    one = Listener(world, car, "sensor.other.gnss", sensor_tick="0.2")
    first = world.tick()
    run(world, 11)
    assert [data.frame for data in one.rest()] == [first, first + 4, first + 8]


def test_all_kinds_at_once_stay_in_step(world, car) -> None:
    every = [Listener(world, car, type_id, **MEASURING[type_id]) for type_id in MEASURING]
    for _ in range(5):
        frame = world.tick()
        assert {item.next().frame for item in every} == {frame}


def test_the_gnss_is_where_the_map_says(world, car) -> None:
    one = Listener(world, car, "sensor.other.gnss")
    world.tick()
    data = one.next()
    theirs = world.get_map().transform_to_geolocation(data.transform.location)
    assert data.longitude == pytest.approx(theirs.longitude, rel=5e-4, abs=1e-9)
    assert abs(data.latitude) == pytest.approx(abs(theirs.latitude), rel=5e-4, abs=1e-9)
    assert data.altitude == pytest.approx(data.transform.location.z, abs=1e-4)


def test_imu_at_rest_measures_gravity_and_yaw_compass(world, car) -> None:
    """At rest, the IMU measures gravity upward, and its compass follows from the yaw."""
    one = Listener(world, car, "sensor.other.imu")
    run(world, 4)
    data = one.rest()[-1]
    assert data.accelerometer.z == pytest.approx(9.81, abs=0.1)
    assert math.hypot(data.accelerometer.x, data.accelerometer.y) < 0.3
    assert data.compass == pytest.approx(math.radians(data.transform.rotation.yaw + 90.0) % math.tau, abs=1e-3)
    assert abs(data.gyroscope.z) < 0.01


def test_lidar_tick_covers_half_turn_by_channel(world, car) -> None:
    """At 10 Hz, a tick of the LiDAR covers half a turn, with the points ordered by channel."""
    settings = {"channels": "16", "range": "60", "points_per_second": "64000", "rotation_frequency": "10"}
    one = Listener(
        world, car, "sensor.lidar.ray_cast", dropoff_general_rate="0", dropoff_zero_intensity="0", **settings
    )
    world.tick()
    data = one.next()
    points = np.frombuffer(data.raw_data, np.float32).reshape(-1, 4)
    assert data.channels == 16 and sum(data.get_point_count(i) for i in range(16)) == len(points) == len(data)
    assert data.horizontal_angle == pytest.approx(math.pi, abs=1e-3)
    azimuth = np.degrees(np.arctan2(points[:, 1], points[:, 0]))
    assert azimuth.max() < 0.5 and azimuth.min() < -178.0
    height = points[(np.abs(points[:, 1]) < 2.0) & (points[:, 0] < -4.0), 2]
    assert np.median(height) == pytest.approx(-2.4, abs=0.15)


def test_semantic_lidar_points_on_car_lie_in_its_box(world, car) -> None:
    """The points of the semantic LiDAR with the id of the car ahead lie in the bounding box of that car."""
    other = spawn(world, ahead(car.get_transform(), 12.0), "vehicle.tesla.model3")
    run(world, 20)
    settings = {"channels": "32", "range": "60", "points_per_second": "400000", "rotation_frequency": "20"}
    one = Listener(world, car, "sensor.lidar.ray_cast_semantic", **settings)
    world.tick()
    mine = [point for point in one.next() if point.object_idx == other.id]
    assert len(mine) > 50 and {point.object_tag for point in mine} == {14}
    to_world, to_car = one.actor.get_transform(), other.get_transform().get_inverse_matrix()
    box = other.bounding_box
    for point in mine:
        place = to_world.transform(point.point)
        local = np.array(to_car) @ (place.x, place.y, place.z, 1.0)
        gap = np.abs(local[:3] - (box.location.x, box.location.y, box.location.z))
        assert (gap <= np.array([box.extent.x, box.extent.y, box.extent.z]) + 0.15).all()
        assert 0.0 < point.cos_inc_angle <= 1.0 + 1e-5


def test_the_radar_sees_a_car_drive_away(world, car) -> None:
    other = spawn(world, ahead(car.get_transform(), 15.0), "vehicle.tesla.model3")
    bumper = carla.Transform(carla.Location(x=2.6, z=0.8))
    one = Listener(world, car, "sensor.other.radar", bumper, points_per_second="20000", vertical_fov="6")
    other.enable_constant_velocity(carla.Vector3D(5.0, 0.0, 0.0))
    run(world, 10)
    fastest = [max(detection.velocity for detection in data) for data in one.rest()]
    assert fastest[-1] == pytest.approx(5.0, abs=0.2)


def test_obstacle_detector_names_object_ahead_and_its_parent(world, car) -> None:
    """The obstacle detector names the object ahead and the actor that carries the sensor."""
    other = spawn(world, ahead(car.get_transform(), 9.0), "vehicle.tesla.model3")
    bumper = carla.Transform(carla.Location(x=2.6, z=0.8))
    one = Listener(world, car, "sensor.other.obstacle", bumper, distance="20")
    world.tick()
    event = one.next()
    assert (event.actor.id, event.other_actor.id) == (car.id, other.id)
    assert 0.5 < event.distance < 9.0


def test_a_destroyed_sensor_is_gone_and_the_world_goes_on(world, car) -> None:
    one = Listener(world, car, "sensor.lidar.ray_cast")
    world.tick()
    one.next()
    one.actor.stop()
    one.actor.destroy()
    run(world, 3)
    assert len(world.get_actors().filter("sensor.*")) == 0


@pytest.mark.carlette_only
def test_absurd_attributes_are_refused_by_name(world, car) -> None:
    with pytest.raises(RuntimeError, match="'channels' is '-3'"):
        Listener(world, car, "sensor.lidar.ray_cast", channels="-3")


@pytest.mark.carlette_only
@pytest.mark.parametrize("type_id", ["sensor.camera.dvs", "sensor.camera.optical_flow", "sensor.other.rss"])
def test_what_is_not_built_is_not_in_the_library(world, type_id: str) -> None:
    assert len(world.get_blueprint_library().filter(type_id)) == 0
