"""The life cycle: when sensors are asked, what is sent, and that one that breaks breaks nothing else."""

from __future__ import annotations

import logging
import socket
from collections.abc import Iterator

import pytest
from mounting import street

from carlette.blueprints import AttributeType, load_catalog
from carlette.blueprints.sensor_definitions import IN_THE_CLIENT
from carlette.geometry import Pose
from carlette.sensors import ALL, Body, Sensor, SensorTick
from carlette.sensors.sensor_manager import SensorManager
from carlette.streaming import MAX_BACKLOG_BYTES, MOST_KEPT, MOST_LATE, StreamHub, Subscriber
from carlette.wire.snapshot import sensor_header
from carlette.world.spawn import spawn
from straight import add


class Told(StreamHub):
    """Everybody listens; keeps what is sent."""

    def __init__(self) -> None:
        super().__init__()
        self.sent: list[tuple[int, bytes]] = []
        self.hears = True

    def listens(self, stream_id: int) -> bool:
        return self.hears

    def publish(self, stream_id: int, *parts: bytes | bytearray | memoryview) -> None:
        self.sent.append((stream_id, b"".join(map(bytes, parts))))


@pytest.fixture
def hub() -> Told:
    return Told()


@pytest.fixture
def suite(hub: Told) -> SensorManager:
    return SensorManager(hub, lambda actor: actor.stream_id, lambda actor: [actor.id])


def tick(world, suite: SensorManager, count: int = 1) -> None:
    for _ in range(count):
        world.tick()
        suite.measure(world)
        suite.publish()


def test_every_sensor_of_the_library_has_its_class() -> None:
    offered = {definition for definition in load_catalog().definitions if definition.startswith("sensor.")}
    assert offered - set(IN_THE_CLIENT) == set(ALL)


def test_sensor_measures_from_spawn_until_removal(hub: Told, suite: SensorManager) -> None:
    """A sensor measures from the tick after its spawn until it is removed."""
    world = street()
    tick(world, suite)
    car = add(world)
    gnss = spawn(world, "sensor.other.gnss", {}, Pose(), car.id)
    tick(world, suite, 2)
    assert len(hub.sent) == 2
    world.remove(gnss.id)
    tick(world, suite, 2)
    assert len(hub.sent) == 2


def test_sensor_stamp_has_tick_frame_time_and_pose(hub: Told, suite: SensorManager) -> None:
    """The stamp contains the frame and the time of the tick and the pose of the sensor."""
    world = street()
    gnss = spawn(world, "sensor.other.gnss", {}, Pose(), add(world).id)
    tick(world, suite)
    place, turn = world.pose(gnss)
    assert hub.sent[0][1][:48] == sensor_header(4, world.frame, world.elapsed_s, (*place, *turn))


def test_sensor_stamp_ignores_changes_after_tick(hub: Told, suite: SensorManager) -> None:
    """A change of the world between the tick and the sending does not change a measurement."""
    world = street()
    gnss = spawn(world, "sensor.other.gnss", {}, Pose())
    world.tick()
    suite.measure(world)
    before = world.pose(gnss)
    world.bodies.position[gnss.row] = 77.0
    suite.publish()
    assert hub.sent[0][1][:48] == sensor_header(4, world.frame, world.elapsed_s, (*before.location, *before.rotation))


@pytest.mark.parametrize(("period", "expected"), [("0.0", 12), ("0.05", 12), ("0.1", 6), ("0.12", 5), ("1", 1)])
def test_periods_are_kept_on_average(hub: Told, suite: SensorManager, period: str, expected: int) -> None:
    world = street()
    spawn(world, "sensor.other.gnss", {"sensor_tick": (AttributeType.FLOAT, period)}, Pose())
    tick(world, suite, 12)
    assert len(hub.sent) == expected


def test_nobody_listens_and_nothing_is_measured(hub: Told, suite: SensorManager) -> None:
    world = street()
    gnss = spawn(world, "sensor.other.gnss", {}, Pose())
    hub.hears = False
    tick(world, suite, 3)
    assert hub.sent == []
    hub.awaited.add(gnss.stream_id)
    tick(world, suite)
    assert len(hub.sent) == 1  # its reader is on the way


def test_failing_sensor_is_logged_once_and_others_continue(
    hub: Told, suite: SensorManager, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """A sensor that fails is logged once, and the other sensors continue."""

    class Broken(Sensor):
        wire_type = 5

        def measure(self, moment: SensorTick) -> Iterator[Body]:
            raise ZeroDivisionError("on purpose")

    monkeypatch.setitem(ALL, "sensor.other.imu", Broken)
    world = street()
    spawn(world, "sensor.other.imu", {}, Pose())
    spawn(world, "sensor.other.gnss", {}, Pose())
    with caplog.at_level(logging.ERROR):
        tick(world, suite, 3)
    assert len(hub.sent) == 3
    assert [record.getMessage().count("sensor.other.imu") for record in caplog.records] == [1]


def test_a_new_world_ends_the_sensors_of_the_old_one(hub: Told, suite: SensorManager) -> None:
    old, new = street(), street()
    spawn(old, "sensor.other.gnss", {}, Pose())
    tick(old, suite)
    tick(new, suite)
    assert len(hub.sent) == 1


def test_a_message_arrives_whole_in_parts_that_were_not_joined() -> None:
    near, far = socket.socketpair()
    near.setblocking(False)
    hub, reader = StreamHub(), Subscriber(near)
    reader.stream_id = 5
    hub.subscribers.add(reader)
    hub.publish(5, b"head", b"", memoryview(bytes(3_000_000)))
    received = bytearray()
    while len(received) < 3_000_008:
        received += far.recv(1 << 20)
        reader.write()
    near.close()
    far.close()
    assert received[:8] == (3_000_004).to_bytes(4, "little") + b"head"
    assert not reader.wants_to_write


def test_subscriber_that_never_reads_is_awaited_once_then_lags() -> None:
    """A subscriber that never reads makes the world wait once, and then counts as lagging."""
    near, far = socket.socketpair()
    near.setblocking(False)
    reader = Subscriber(near)
    half = bytes(MAX_BACKLOG_BYTES // 2 + (8 << 20))
    reader.send(half)
    reader.catch_up(limit_s=0.05)
    assert not reader.lags
    reader.send(half)
    reader.catch_up(limit_s=60.0)  # not waited for again
    near.close()
    far.close()
    assert reader.lags


def test_stream_hub_data_for_absent_readers_is_bounded() -> None:
    """The data that is kept for readers that do not connect is bounded."""
    hub = StreamHub()
    for stream_id in range(10, 10 + 2 * MOST_LATE):
        hub.expect(stream_id)
    hub.wait_no_longer()
    assert not hub.awaited
    assert sum(hub.is_wanted(item) for item in range(10, 10 + 2 * MOST_LATE)) == MOST_LATE
    late = next(item for item in range(10, 10 + 2 * MOST_LATE) if hub.is_wanted(item))
    for _ in range(MOST_KEPT):
        hub.publish(late, b"x")
        assert hub.is_wanted(late)
    hub.publish(late, b"x")
    assert not hub.is_wanted(late)
    hub.forget_late()
    assert not any(hub.is_wanted(item) for item in range(10, 10 + 2 * MOST_LATE))
