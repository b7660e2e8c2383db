"""The other actors: as hostile as `docs/SAFETY.md` assumes, but not more.

They keep their speed and lane, brake by up to 3.5 m/s² at any time, cross straight, or step off a curb. Rear traffic
keeps its distance if the ego has been in its path all along. If the ego enters its path, it brakes after a reaction
time, no harder than necessary.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

from lab.benchmarks.guard_oracle.bodies import Body
from lab.benchmarks.guard_oracle.road import Road
from stucksolver.scene import ObjectKind

K = ObjectKind
SIZES: dict[ObjectKind, tuple[float, float, float]] = {
    K.CAR: (4.6, 1.9, 1.5),
    K.VAN: (5.6, 2.1, 2.4),
    K.TRUCK: (8.5, 2.5, 3.2),
    K.BUS: (11.5, 2.5, 3.1),
    K.EMERGENCY: (5.2, 2.0, 2.2),
    K.MOTORCYCLE: (2.2, 0.8, 1.5),
    K.BICYCLE: (1.8, 0.6, 1.7),
    K.PEDESTRIAN: (0.5, 0.5, 1.7),
    K.CONE: (0.4, 0.4, 0.7),
    K.BARRIER: (0.6, 1.8, 1.0),
}
"""Length, width, height by kind (m). Ours: typical sizes."""
ANSWERS_MPS2, ANSWERS_AFTER_S = 4.5, 1.0
"""Deceleration for a vehicle that has started to enter their lane (m/s²), and the reaction time before it (s)."""
LATE_ANSWER_S = 0.5
"""Reaction time of drivers that react only to objects in their own path, and watch it (s)."""
HARDEST_MPS2 = 8.0
"""Hardest braking of the others (m/s²)."""
SETS_OFF_MPS2 = 1.5
"""Acceleration of a vehicle that sets off (m/s²): that of ordinary traffic, below the 2 m/s² of hazard H2."""
STOOD_LONG_S = 3.0
"""Time for which the ego must be stopped in a lane before traffic there stops for it (s)."""
KEEPS_M = 0.5
"""Distance that a vehicle keeps at standstill (m). Ours."""


class Situation(Protocol):
    """State of the ego as the others use it."""

    road: Road
    t: float
    ego_stood: float
    """Time for which the ego has been stopped (s)."""

    @property
    def ego_speed(self) -> float: ...
    def ego_body(self) -> Body: ...
    def ego_span(self) -> tuple[float, float, float, float]:
        """Return arc lengths of the ego's rear and front, and offsets of its right and left side (m)."""
        ...

    def rear_within(self, right: float, left: float) -> float | None:
        """Return the arc length of the rearmost part of the ego between two offsets; None without such a part."""
        ...


@dataclass
class Other:
    """A stopped road user. `role`: its part in the scene, for the statistics of causes."""

    name: str
    kind: ObjectKind
    body: Body
    height: float
    role: str
    vx: float = 0.0
    """Velocity along x (m/s)."""
    vy: float = 0.0
    """Velocity along y (m/s)."""
    stood: float = 30.0
    """Time for which it has been stopped (s)."""
    moved_ago: float | None = None
    hazard: bool = False
    seen_at: float | None = None
    """Time when it was first in sight (s from the start of the plan)."""

    @property
    def speed(self) -> float:
        return math.hypot(self.vx, self.vy)

    def step(self, world: Situation, dt: float) -> None:
        """Leave the road user at its position."""
        self.stood += dt
        if self.moved_ago is not None:
            self.moved_ago += dt

    def _put(self, x: float, y: float, yaw: float, dt: float) -> None:
        """Move to a position in one step."""
        self.vx, self.vy = (x - self.body.x) / dt, (y - self.body.y) / dt
        self.body.x, self.body.y, self.body.yaw = x, y, yaw
        moves = self.speed > 0.05
        self.stood = 0.0 if moves else self.stood + dt
        if moves:
            self.moved_ago = 0.0
        elif self.moved_ago is not None:
            self.moved_ago += dt


@dataclass
class AlongLane(Other):
    """Moves along a lane at an offset, with (+1) or against (-1) the ego's direction.

    `brakes_at`, `brakes_by`: time and deceleration of a braking without a reason. `sets_off_at`: time at which a
    stopped one drives off; one that has braked no longer brakes then. `answers`: "lane" – it reacts to road users that
    enter its lane, which is `lane` (right, left); "way" – to those in its path only; "never" – beyond the assumptions.
    """

    s: float = 0.0
    """Arc length (m)."""
    d: float = 0.0
    """Offset to the left (m)."""
    way: int = 1
    """Direction along the road: 1 with, -1 against the ego's."""
    v: float = 0.0
    """Speed (m/s)."""
    lane: tuple[float, float] = (-1.75, 1.75)
    """Borders of its lane: right, left (m)."""
    brakes_at: float = math.inf
    brakes_by: float = 3.5
    """Deceleration of its braking without a reason (m/s²)."""
    sets_off_at: float = math.inf
    cruise: float = 6.0
    """Speed after it sets off (m/s)."""
    answers: str = "lane"
    in_danger: float = 0.0
    """Time for which it has had to react (s)."""
    was_behind: bool = False
    """True if the ego was in its path from the start."""

    def start(self, world: Situation) -> None:
        """Put the vehicle on the road, and note whether the ego is already in its path."""
        self._place(world.road)
        rear = world.rear_within(*self._strip())
        self.was_behind = self.way > 0 and rear is not None and self.front <= rear

    @property
    def front(self) -> float:
        return self.s + self.way * self.body.length / 2

    def step(self, world: Situation, dt: float) -> None:
        was = self.v
        if world.t >= self.sets_off_at:
            self.v = min(self.v + SETS_OFF_MPS2 * dt, self.cruise)
        if self.brakes_at <= world.t and not self.brakes_at < self.sets_off_at <= world.t:
            self.v = max(self.v - self.brakes_by * dt, 0.0)
        if self._answers_now(world, dt):
            self.v = min(self.v, was - (HARDEST_MPS2 if self.keeps_distance else ANSWERS_MPS2) * dt)
        self.v = max(self.v, 0.0)
        self.s += self.way * (was + self.v) / 2 * dt
        x, y, yaw = world.road.point_at(self.s, self.d)
        self._put(x, y, yaw if self.way > 0 else math.remainder(yaw + math.pi, math.tau), dt)

    def _strip(self) -> tuple[float, float]:
        if self.answers == "lane" and not self.was_behind:
            return self.lane
        return self.d - self.body.width / 2, self.d + self.body.width / 2

    def _answers_now(self, world: Situation, dt: float) -> bool:
        if self.v <= 0.0 or self.answers == "never":
            return False
        if self.way < 0 and world.ego_stood < STOOD_LONG_S:
            return False
        dangerous = self.is_too_near(world)
        self.in_danger = self.in_danger + dt if dangerous else 0.0
        if self.keeps_distance:
            return dangerous
        return self.in_danger >= (LATE_ANSWER_S if self.answers == "way" else ANSWERS_AFTER_S)

    @property
    def keeps_distance(self) -> bool:
        """True if it keeps its distance because the ego has been ahead of it all along."""
        return self.was_behind or self.way < 0

    def is_too_near(self, world: Situation) -> bool:
        """True if the gap to the ego is smaller than required by Lemma 2 of the RSS paper."""
        if self.way < 0:
            _, front, right, left = world.ego_span()
            strip = self._strip()
            if right >= strip[1] or left <= strip[0] or self.front < front:
                return False
            return self.front - front < self.v * ANSWERS_AFTER_S + self.v**2 / (2 * ANSWERS_MPS2) + KEEPS_M
        rear_in = world.rear_within(*self._strip())
        if rear_in is None or (self.front > rear_in and self.s > world.ego_span()[1]):
            return False
        ego = max(world.ego_speed, 0.0)
        needed = self.v * ANSWERS_AFTER_S + self.v**2 / (2 * ANSWERS_MPS2) - ego**2 / (2 * HARDEST_MPS2)
        return rear_in - self.front < max(needed, 0.0) + KEEPS_M

    def _place(self, road: Road) -> None:
        x, y, yaw = road.point_at(self.s, self.d)
        heading = yaw if self.way > 0 else math.remainder(yaw + math.pi, math.tau)
        self.body.x, self.body.y, self.body.yaw = x, y, heading
        self.vx, self.vy = self.v * math.cos(heading), self.v * math.sin(heading)
        if self.v > 0.05:
            self.stood, self.moved_ago = 0.0, 0.0


@dataclass
class Straight(Other):
    """Moves straight in the plane: crosses, joins, walks along or across. It may brake, stop, and set off.

    `sets_off_at`: time at which it drives or walks off, up to the speed `cruise`; it no longer brakes then.
    """

    heading: float = 0.0
    """Heading (rad)."""
    v: float = 0.0
    """Speed (m/s)."""
    brakes_at: float = math.inf
    brakes_by: float = 3.5
    """Deceleration of its braking (m/s²)."""
    sets_off_at: float = math.inf
    cruise: float = 6.0
    """Speed after it sets off (m/s)."""

    def start(self, world: Situation) -> None:
        self.vx, self.vy = self.v * math.cos(self.heading), self.v * math.sin(self.heading)
        self.body.yaw = self.heading
        if self.v > 0.05:
            self.stood, self.moved_ago = 0.0, 0.0

    def step(self, world: Situation, dt: float) -> None:
        was = self.v
        if world.t >= self.sets_off_at:
            self.v = min(self.v + SETS_OFF_MPS2 * dt, self.cruise)
        elif world.t >= self.brakes_at:
            self.v = max(self.v - self.brakes_by * dt, 0.0)
        way = (was + self.v) / 2 * dt
        self._put(
            self.body.x + way * math.cos(self.heading), self.body.y + way * math.sin(self.heading), self.heading, dt
        )


@dataclass
class StepsOff(Other):
    """Stands at the curb, steps off when the front of the ego is `trigger` meters away, and walks straight across."""

    s: float = 0.0
    """Arc length (m)."""
    d: float = 0.0
    """Offset to the left (m)."""
    trigger: float = 5.0
    """Distance of the ego's front at which it steps off (m)."""
    pace: float = 1.4
    """Walking speed (m/s)."""
    walks: bool = False

    def start(self, world: Situation) -> None:
        self.body.x, self.body.y, heading = world.road.point_at(self.s, self.d)
        self.body.yaw = heading + (math.pi / 2 if self.d < 0 else -math.pi / 2)

    def step(self, world: Situation, dt: float) -> None:
        front = world.ego_span()[1]
        if not self.walks and front < self.s and self.s - self.body.length / 2 - front < self.trigger:
            self.walks = True
        way = self.pace * dt if self.walks else 0.0
        yaw = self.body.yaw
        self._put(self.body.x + way * math.cos(yaw), self.body.y + way * math.sin(yaw), yaw, dt)


def typical_body(kind: ObjectKind, size: tuple[float, float, float] | None = None) -> tuple[Body, float]:
    """Return a body with the typical size of its kind, not placed yet, and its height (m)."""
    length, width, height = size or SIZES[kind]
    return Body(0.0, 0.0, 0.0, length, width), height
