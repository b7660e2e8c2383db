"""The collision sensor: one event for each body that the parent hit during the tick."""

from __future__ import annotations

from collections.abc import Iterator

from carlette.sensors.sensor import Body, Sensor, SensorTick
from carlette.wire import encode


class CollisionSensor(Sensor):
    """Reports the world's contacts that involve its parent."""

    wire_type = 0

    def measure(self, moment: SensorTick) -> Iterator[Body]:
        world = moment.scene.world
        for event in world.collisions:
            if event.sensor_id == moment.actor.id:
                actor, other = world.actors.get(event.actor_id), world.actors.get(event.other_id)
                if actor is not None and other is not None:
                    yield (encode.collision(moment.wire(actor), moment.wire(other), event.impulse),)
