"""All sensors of the running episode: created and removed with their actors, read when due, sent after the snapshot."""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass
from typing import Any, NamedTuple

from carlette.errors import RequestError
from carlette.sensors import LateSensor, Sensor, SensorScene, SensorTick, make_sensor
from carlette.sensors.sensor import Body
from carlette.sensors.sensor_scene import ActorSurfaces
from carlette.streaming import StreamHub
from carlette.wire.snapshot import sensor_header
from carlette.world.actor import Actor, ActorKind
from carlette.world.world import World

EARLY_S = 1e-6
"""Tolerance of a due time (s): sums of float32 steps miss a multiple of the period by less than this. Ours."""
MOST_ASKED = 256
"""Maximum number of measurements that may wait for a map's scenery. Ours; beyond it, the world waits, too."""

log = logging.getLogger(__name__)


@dataclass
class SensorHandle:
    """A sensor and its actor, the number of its stream, and the time from which it is due again."""

    actor: Actor
    sensor: Sensor
    stream_id: int
    due_s: float
    scenery: Future[None] | None
    """Required parts of the map, which are built once; None without any."""
    has_failed: bool = False

    @property
    def is_ready(self) -> bool:
        """True if all required parts of the map are built."""
        return self.scenery is None or self.scenery.done()

    def fail(self, error: BaseException) -> None:
        """Report a failure. One broken sensor must not end the server for all clients."""
        if not self.has_failed:
            log.error("sensor %d (%s) failed; it sends nothing", self.actor.id, self.actor.type_id, exc_info=error)
        self.has_failed = True


class PendingMeasurement(NamedTuple):
    """A measurement in progress."""

    mount: SensorHandle
    header: bytes
    bodies: Future[list[Body]]


class SensorManager:
    """The sensors of one world by actor id. Sensors that a client spawns are found automatically."""

    def __init__(self, hub: StreamHub, stream_of: Callable[[Actor], int], wire: Callable[[Actor], Any]) -> None:
        self._hub = hub
        self._stream_of = stream_of
        self._wire = wire
        self._world: World | None = None
        self._cast = ActorSurfaces()
        self._mounts: dict[int, SensorHandle] = {}
        self._roster = (-1, -1)
        self._asked: deque[PendingMeasurement] = deque()
        """Measurements in the order of the ticks."""

    def measure(self, world: World) -> None:
        """Read all sensors that are due on the tick that `world` has just completed; `publish` sends the results."""
        self._update_mounts(world)
        if not self._mounts:
            return
        scene = SensorScene(world, self._cast)
        due = [(mount, self._moment(mount, scene)) for mount in self._mounts.values() if self._takes_turn(mount)]
        # Start the sensors that work in other threads first.
        for mount, moment in sorted(due, key=lambda pair: not isinstance(pair[0].sensor, LateSensor)):
            if self._hub.is_wanted(mount.stream_id) and self._may_begin(mount, world):
                self._ask(mount, moment)
            else:
                mount.sensor.pass_over(moment)

    def publish(self) -> None:
        """Send the measurements. Nothing after the tick can change them.

        A measurement that waits for its scenery is sent in a later call, up to a limit: the world stops only for work
        that recurs on every tick.
        """
        asked, self._asked = self._asked, deque()
        for item in asked:
            if item.mount.is_ready or len(asked) > MOST_ASKED:
                self._send(item)
            else:
                self._asked.append(item)

    def _send(self, asked: PendingMeasurement) -> None:
        error = asked.bodies.exception()
        if error is not None:
            asked.mount.fail(error)
            return
        for body in asked.bodies.result():
            self._hub.publish(asked.mount.stream_id, asked.header, *body)

    def close(self) -> None:
        """Close all sensors and drop their world."""
        for mount in self._mounts.values():
            mount.sensor.close()
        self._mounts.clear()
        self._asked.clear()
        self._roster = (-1, -1)
        self._world = None

    def _update_mounts(self, world: World) -> None:
        if world is not self._world:
            self.close()
            self._world = world
        if self._roster == world.roster:
            return
        self._roster = world.roster
        actors = world.actors
        for gone in [mount for mount in self._mounts if mount not in actors]:
            self._mounts.pop(gone).sensor.close()
        for actor in actors.values():
            if actor.kind is ActorKind.SENSOR and actor.stream_id and actor.id not in self._mounts:
                try:
                    sensor = make_sensor(actor.type_id, actor.attributes)
                except RequestError as error:
                    # The spawn request was already answered, so the server logs the error and the sensor gets
                    # no stream.
                    log.error("%s", error)
                    actor.stream_id = 0
                else:
                    stream_id, scenery = self._stream_of(actor), sensor.load(world)
                    self._mounts[actor.id] = SensorHandle(actor, sensor, stream_id, world.elapsed_s, scenery)

    def _takes_turn(self, mount: SensorHandle) -> bool:
        now, period = self._now_s, mount.sensor.period_s
        if now < mount.due_s - EARLY_S:
            return False
        # A period shorter than the tick must not accumulate measurements.
        mount.due_s = max(mount.due_s + period, now)
        return True

    @property
    def _now_s(self) -> float:
        return self._world.elapsed_s if self._world else 0.0

    def _moment(self, mount: SensorHandle, scene: SensorScene) -> SensorTick:
        return SensorTick(scene, mount.actor, scene.world.pose(mount.actor), self._wire)

    @staticmethod
    def _may_begin(mount: SensorHandle, world: World) -> bool:
        """Return False for a sensor that must skip this tick.

        As in CARLA, a sensor that is not ready skips it in asynchronous mode.
        """
        return not mount.has_failed and (mount.is_ready or world.settings.synchronous)

    def _ask(self, mount: SensorHandle, moment: SensorTick) -> None:
        world, pose = moment.scene.world, moment.pose
        stamp = (*pose.location, *pose.rotation)
        header = sensor_header(mount.sensor.wire_type, world.frame, world.elapsed_s, stamp)
        self._asked.append(PendingMeasurement(mount, header, _begun(mount.sensor, moment)))


def _begun(sensor: Sensor, moment: SensorTick) -> Future[list[Body]]:
    try:
        if isinstance(sensor, LateSensor):
            return sensor.begin(moment)
        bodies = list(sensor.measure(moment))
    except Exception as error:  # noqa: BLE001
        # `publish` reports the error with those of the other threads.
        failed: Future[list[Body]] = Future()
        failed.set_exception(error)
        return failed
    done: Future[list[Body]] = Future()
    done.set_result(bodies)
    return done
