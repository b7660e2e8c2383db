"""All sensors of the running episode: made and ended with their actors, asked when due, sent after the snapshot."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

from carlette.errors import RequestError
from carlette.sensors import Moment, Scene, Sensor, make_sensor
from carlette.sensors.base import Body
from carlette.sensors.scene import Cast
from carlette.stream.hub import Hub
from carlette.wire.snapshot import sensor_header
from carlette.world.actor import Actor, Kind
from carlette.world.world import World

EARLY_S = 1e-6
"""Sums of float32 steps miss a period's multiple by less than this."""

log = logging.getLogger(__name__)


@dataclass
class Mount:
    """A sensor and its actor, the number of its stream, and the time from which it is due again."""

    actor: Actor
    sensor: Sensor
    stream_id: int
    due_s: float
    has_failed: bool = False


class Suite:
    """The sensors of one world, keyed by actor id; sensors that a client brought are found by themselves."""

    def __init__(self, hub: Hub, stream_of: Callable[[Actor], int], wire: Callable[[Actor], Any]) -> None:
        self._hub = hub
        self._stream_of = stream_of
        self._wire = wire
        self._world: World | None = None
        self._cast = Cast()
        self._mounts: dict[int, Mount] = {}
        self._roster = (-1, -1)
        self._asked: list[tuple[Mount, bytes, Callable[[], list[Body]]]] = []
        """Who measured in the last tick, the header of the messages, and where to get their bodies."""

    def measure(self, world: World) -> None:
        """Asks all sensors that are due in the tick which `world` has just made; `publish` sends what they say."""
        self._update_mounts(world)
        if not self._mounts:
            return
        scene = Scene(world, self._cast)
        due = [(mount, self._moment(mount, scene)) for mount in self._mounts.values() if self._takes_turn(mount)]
        heard = [pair for pair in due if self._is_heard(pair[0])]
        for mount, moment in heard:
            mount.sensor.prepare(moment)
        for mount, moment in due:
            if self._is_heard(mount):
                self._ask(mount, moment)
            else:
                mount.sensor.pass_over(moment)

    def publish(self) -> None:
        """Sends what was measured; nothing that came after the tick can change it."""
        asked, self._asked = self._asked, []
        for mount, header, bodies in asked:
            for body in bodies():
                self._hub.publish(mount.stream_id, header, *body)

    def close(self) -> None:
        """Ends all sensors."""
        for mount in self._mounts.values():
            mount.sensor.close()
        self._mounts.clear()
        self._asked.clear()
        self._roster = (-1, -1)

    def _update_mounts(self, world: World) -> None:
        if world is not self._world:
            self.close()
            self._world = world
        if self._roster == world.roster:
            return
        self._roster = world.roster
        actors = world.actors
        for gone in [one for one in self._mounts if one not in actors]:
            self._mounts.pop(gone).sensor.close()
        for actor in actors.values():
            if actor.kind is Kind.SENSOR and actor.stream_id and actor.id not in self._mounts:
                try:
                    sensor = make_sensor(actor.type_id, actor.attributes)
                except RequestError as error:
                    log.error("%s", error)
                    actor.stream_id = 0
                else:
                    self._mounts[actor.id] = Mount(actor, sensor, self._stream_of(actor), world.elapsed_s)

    def _takes_turn(self, mount: Mount) -> bool:
        now, period = self._now_s, mount.sensor.period_s
        if now < mount.due_s - EARLY_S:
            return False
        # A period shorter than the tick does not pile up turns.
        mount.due_s = max(mount.due_s + period, now)
        return True

    @property
    def _now_s(self) -> float:
        return self._world.elapsed_s if self._world else 0.0

    def _is_heard(self, mount: Mount) -> bool:
        return self._hub.listens(mount.stream_id) or mount.stream_id in self._hub.awaited

    def _moment(self, mount: Mount, scene: Scene) -> Moment:
        return Moment(scene, mount.actor, scene.world.pose(mount.actor), self._wire)

    def _ask(self, mount: Mount, moment: Moment) -> None:
        world, pose = moment.scene.world, moment.pose
        stamp = (*pose.location, *pose.rotation)
        header = sensor_header(mount.sensor.wire_type, world.frame, world.elapsed_s, stamp)
        said = partial(_said, mount, moment) if mount.sensor.is_ready_later else _said(mount, moment).copy
        self._asked.append((mount, header, said))


def _said(mount: Mount, moment: Moment) -> list[Body]:
    try:
        return list(mount.sensor.measure(moment))
    except Exception:
        # One broken sensor must not end the server for all clients.
        if not mount.has_failed:
            log.exception("sensor %d (%s) failed; it sends nothing", mount.actor.id, mount.actor.type_id)
        mount.has_failed = True
        return []
