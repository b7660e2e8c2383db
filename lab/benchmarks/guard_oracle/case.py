"""A contact with its complete record: the input of the excuses in `causes.py`."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from functools import cached_property

from lab.benchmarks.guard_oracle.contact import Contact
from lab.benchmarks.guard_oracle.counterfactual import Stops
from lab.benchmarks.guard_oracle.drive import EVERY
from lab.benchmarks.guard_oracle.others import Other
from lab.benchmarks.guard_oracle.recording import Frame, Recording, other_of
from lab.benchmarks.guard_oracle.world import AT_REST_MPS, DT, World

Again = Callable[[frozenset[str]], bool]


class Case:
    """A contact and its drive. Ticks count from the start of the plan.

    `again` drives the plan again, without the road users of these names and with a solver that is never silent. It
    returns True if no contact counts then.
    """

    def __init__(self, contact: Contact, recording: Recording, again: Again = lambda _: True) -> None:
        self.contact, self.recording, self.again = contact, recording, again
        self.role = contact.role

    @cached_property
    def frames(self) -> list[Frame]:
        """Frames of the ego and the other from the start to the contact."""
        return self.recording.frames(self.contact.name)

    @cached_property
    def stops(self) -> Stops:
        """Stops at the ticks of the drive."""
        return Stops(self.recording, self.contact.name)

    @cached_property
    def end(self) -> World:
        """The world at the contact."""
        *_, last = self.recording.worlds()
        return last

    @cached_property
    def other(self) -> Other:
        """The other at the contact."""
        return other_of(self.end, self.contact.name)

    @cached_property
    def came_into_sight(self) -> dict[str, int]:
        """Road users that came into sight after the start, except the other, and the tick."""
        first: dict[str, int] = {}
        for tick, world in enumerate(self.recording.worlds()):
            for other in world.others:
                if other.name not in first and world.sees(other):
                    first[other.name] = tick
        return {name: tick for name, tick in first.items() if tick > 0 and name != self.contact.name}

    @property
    def last(self) -> int:
        """Tick of the contact."""
        return len(self.frames) - 1

    @cached_property
    def first_visible(self) -> int | None:
        """First tick at which the other was in sight; None if it was never in sight before the contact."""
        return next((k for k, frame in enumerate(self.frames[:-1]) if frame.visible), None)

    def no_stop_avoids(self, since: int | None, or_going_on: bool = True) -> bool:
        """True if no stop that begins at this tick, or later, avoids the contact. True without such a stop.

        A stop begins when the guard rechecks, at every other tick. If the guard has stopped the ego since then, going
        on must fail as well.
        """
        if since is None:
            return True
        first = _first_look(since)
        return not (or_going_on and self.stops.going_on_avoids(first)) and self.stops.latest(first) is None

    def needs_mps2(self, since: int | None, reaction_s: float) -> float:
        """Return the deceleration with which the other stops before the contact, from a tick on, after a reaction time.

        It is infinite if the other had no time, or if there was no such tick.
        """
        if since is None or since + round(reaction_s / DT) >= self.last:
            return math.inf
        rest = self.frames[since + round(reaction_s / DT) :]
        places = [(frame.other.x, frame.other.y) for frame in rest]
        way = sum(math.dist(a, b) for a, b in itertools.pairwise(places))
        return rest[0].other_speed ** 2 / (2 * way) if way > 0.0 else math.inf

    @cached_property
    def stands_since(self) -> int | None:
        """First tick of the ego's last stop; None if it moved just before the contact."""
        found = None
        for k in range(self.last - 1, -1, -1):
            if abs(self.frames[k].ego_speed) >= AT_REST_MPS:
                break
            found = k
        return found

    def figures(self) -> dict[str, float | None]:
        """Return the numbers of the counterfactual on the page.

        They are the time for which the other had been in sight (s), and the time before the contact at which the latest
        stop had to begin (s); None if no stop avoids it.
        """
        first = self.first_visible
        latest = None if first is None else self.stops.latest(_first_look(first))
        return {
            "visible_s": 0.0 if first is None else round((self.last - first) * DT, 2),
            "stop_s": None if latest is None else round((self.last - latest) * DT, 2),
        }


def _first_look(tick: int) -> int:
    """Return the first tick from this one on at which the guard rechecks."""
    return -(-tick // EVERY) * EVERY
