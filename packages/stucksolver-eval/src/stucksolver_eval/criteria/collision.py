"""Collisions of the ego by kind (CollisionTest)."""

from __future__ import annotations

import time
from collections import deque
from typing import Any, NamedTuple

import carla

from stucksolver_eval.criteria.criterion import STANDING_MPS, Criterion, EgoTick, Infraction, place_text

SAME_PLACE_M = 5.0
"""Distance from the last collision within which no further one counts (m). As in CollisionTest."""
SAME_OTHER_S = 5.0
"""Time for which further collisions with the same actor do not count (s). As in CollisionTest."""
_LATE_EVENTS_S = 0.2
"""Wall time to wait for late events when the route ends (s). Ours."""
_REMEMBERED = 8
"""Number of ticks that are stored until their events have arrived. Ours."""


class ContactEpisode(NamedTuple):
    """One event of the collision sensor."""

    frame: int
    other_id: int
    other_type: str


class CollisionRule:
    """Decides which contacts count.

    No contact counts with the same actor within 5 s, within 5 m of the last one, or while stopped.
    """

    def __init__(self) -> None:
        self._last_id: int | None = None
        self._last_s = 0.0
        self._last_place: Any | None = None

    def pass_time(self, time_s: float, place: Any) -> None:
        """Reset the last collision when the ego has left its position, and its actor after 5 s."""
        if self._last_place is not None and place.distance(self._last_place) > SAME_PLACE_M:
            self._last_place = None
        if self._last_id is not None and time_s - self._last_s > SAME_OTHER_S:
            self._last_id = None

    def counts(self, contact: ContactEpisode, time_s: float, place: Any, speed_mps: float) -> bool:
        """True if this contact counts. It then becomes the last collision."""
        if self._last_id is not None and contact.other_id == self._last_id:
            return False
        if self._last_place is not None and place.distance(self._last_place) <= SAME_PLACE_M:
            return False
        if speed_mps < STANDING_MPS:
            return False
        self._last_s, self._last_place = time_s, place
        if contact.other_id != 0:
            # The level's geometry has the single id 0.
            self._last_id = contact.other_id
        return True


def kind_of(other_type: str) -> str | None:
    """Return the record's key for a collision with an actor type; None if the benchmark does not count it."""
    if ("static" in other_type or "traffic" in other_type) and "sidewalk" not in other_type:
        return "collisions_layout"
    if "vehicle" in other_type:
        return "collisions_vehicle"
    return "collisions_pedestrian" if "walker" in other_type else None


class Collisions(Criterion):
    """A collision sensor on the ego. Contacts of a tick are counted one tick later, when all have arrived."""

    kind = "collisions"

    def __init__(self, world: carla.World, ego: carla.Vehicle) -> None:
        super().__init__()
        self._rule = CollisionRule()
        self._contacts: deque[ContactEpisode] = deque()
        self._moments: deque[EgoTick] = deque(maxlen=_REMEMBERED)
        blueprint = world.get_blueprint_library().find("sensor.other.collision")
        self._sensor: Any | None = world.spawn_actor(blueprint, carla.Transform(), attach_to=ego)
        self._sensor.listen(self._hit)

    def _hit(self, event: Any) -> None:
        # A thread of the client library calls this.
        other = event.other_actor
        self._contacts.append(ContactEpisode(int(event.frame), int(other.id), str(other.type_id)))

    def update(self, moment: EgoTick) -> None:
        if self._sensor is None:
            return
        self._judge(before_frame=moment.frame)
        self._moments.append(moment)
        self._rule.pass_time(moment.time_s, moment.location)

    def _judge(self, before_frame: int) -> None:
        while self._contacts and self._contacts[0].frame < before_frame:
            contact = self._contacts.popleft()
            then = next((m for m in reversed(self._moments) if m.frame <= contact.frame), None)
            if then is not None and self._rule.counts(contact, then.time_s, then.location, then.speed_mps):
                self._count(contact, then)

    def _count(self, contact: ContactEpisode, then: EgoTick) -> None:
        kind = kind_of(contact.other_type)
        if kind is not None:
            text = f"collision with {contact.other_type} (id {contact.other_id}) at {place_text(then.location)}"
            self.infractions.append(Infraction(kind, then.time_s, text))

    def rest(self) -> None:
        """Stop counting. Counted collisions stay."""
        self._contacts.clear()
        self._moments.clear()

    def finish(self) -> None:
        if not self._moments:
            return
        time.sleep(_LATE_EVENTS_S)
        self._judge(before_frame=self._moments[-1].frame + 1)

    def close(self) -> None:
        if self._sensor is not None:
            self._sensor.stop()
            self._sensor.destroy()
            self._sensor = None
