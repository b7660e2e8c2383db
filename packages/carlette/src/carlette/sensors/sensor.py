"""The base of all sensors: created from the blueprint's attributes, and called once on each tick on which it is due.

A new sensor is one file with a subclass of `Sensor`, one entry in `blueprints/sensors.py` and one line in `ALL` of this
package. `sensor_manager.SensorManager` owns the life cycle.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Future
from dataclasses import dataclass
from typing import Any, ClassVar

from carlette.blueprints import load_catalog
from carlette.errors import RequestError
from carlette.geometry import Pose
from carlette.sensors.sensor_scene import SensorScene
from carlette.world.actor import Actor, Attributes
from carlette.world.world import World

Part = bytes | bytearray | memoryview
Body = tuple[Part, ...]
"""A message without its 48-byte header, in parts that need not be joined (a picture's header and its pixels).

The parts are sent later without being copied, so their memory must not be written again.
"""
LONGEST_PERIOD_S = 1e6
"""Longest time between two measurements that a client may set (s). Ours."""


@dataclass(frozen=True)
class SensorTick:
    """The world right after a tick, as sensors measure it. It does not change during the measurement."""

    scene: SensorScene
    actor: Actor
    """The sensor itself. `parent_id` names its carrier."""
    pose: Pose
    """Pose of the sensor, world frame."""
    wire: Callable[[Actor], Any]
    """Returns an actor in the client's form, for messages that contain one."""

    @property
    def delta_s(self) -> float:
        """Duration of the tick that has just ended (s)."""
        return self.scene.world.step_s


class Sensor(ABC):
    """One sensor of one actor, with its state between measurements."""

    wire_type: ClassVar[int]
    """The sensor's number in the header of its messages."""

    def __init__(self, settings: SensorAttributes) -> None:
        """Read the attributes; raise `RequestError` if one is out of range."""
        self.period_s = settings.number("sensor_tick", 0.0, LONGEST_PERIOD_S) if "sensor_tick" in settings else 0.0

    def load(self, world: World) -> Future[None] | None:
        """Start building slow things, such as a map's static scene; return None if there is nothing to build."""
        del world
        return None

    @abstractmethod
    def measure(self, moment: SensorTick) -> Iterable[Body]:
        """Return the messages of this tick: one for a measuring sensor, any number for one that reports events.

        It is called only while a client is subscribed.
        """

    def pass_over(self, moment: SensorTick) -> None:  # noqa: B027
        """Skip a tick on which the sensor is due but has no subscriber: a LiDAR's head keeps turning."""

    def close(self) -> None:  # noqa: B027
        """Free the resources of the sensor. Its actor or its episode has ended."""


class LateSensor(Sensor):
    """A sensor that works in another thread. Its measurement may come after the snapshot of its tick."""

    @abstractmethod
    def begin(self, moment: SensorTick) -> Future[list[Body]]:
        """Copy the required state of the moment, because the world continues, and start the work.

        It is called only while a client is subscribed, in the order of the ticks.
        """

    def measure(self, moment: SensorTick) -> Iterable[Body]:
        return self.begin(moment).result()


class SensorAttributes(Mapping[str, str]):
    """The attributes of one sensor: the client's values, and the blueprint's defaults."""

    def __init__(self, type_id: str, attributes: Attributes) -> None:
        self.type_id = type_id
        definition = load_catalog().definitions[type_id]
        self._values = {attribute.id: attribute.value for attribute in definition.attributes}
        self._values.update((id, text) for id, (_, text) in attributes.items())

    def number(self, id: str, low: float = -math.inf, high: float = math.inf) -> float:
        """Return a finite number; raise `RequestError` if it is not within `low` to `high`."""
        try:
            value = float(self[id].removesuffix("f"))
        except ValueError:
            # The check below rejects NaN with a message.
            value = math.nan
        if not (math.isfinite(value) and low <= value <= high):
            raise self._refusal(id, f"a number{_span(low, high)}")
        return value

    def whole(self, id: str, low: int, high: int) -> int:
        """Return a whole number; raise `RequestError` if it is not within `low` to `high`."""
        value = self.number(id, low, high)
        if value != int(value):
            raise self._refusal(id, f"a whole number{_span(low, high)}")
        return int(value)

    def flag(self, id: str) -> bool:
        """Return a boolean, in any of the spellings that clients send."""
        text = self[id].lower()
        if text not in ("true", "false", "1", "0"):
            raise self._refusal(id, "true or false")
        return text in ("true", "1")

    def _refusal(self, id: str, wanted: str) -> RequestError:
        return RequestError(f"Spawn of '{self.type_id}' refused: attribute '{id}' is '{self[id]}'; give {wanted}")

    def __getitem__(self, id: str) -> str:
        return self._values[id]

    def __iter__(self) -> Any:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)


def _span(low: float, high: float) -> str:
    if math.isinf(low) and math.isinf(high):
        return ""
    return f" from {low:g} to {high:g}" if math.isfinite(high) else f" from {low:g} up"
