"""The table of situations from public reports: what is placed where, how it moves, and what is right until when.

Positions are relative to the place: a point on the hero's lane `distance` beyond the trigger, or the entry of its next
junction. Times count from the moment at which the hero has arrived. The numbers are ours.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

from stucksolver_eval.scenarios.families.crossing_actors import WALKER_LIFT_M
from stucksolver_eval.scenarios.scenario import Expected
from stucksolver_eval.sites.reported_sites import SiteKind

LateralOrigin = Literal["lane", "edge", "curb", "left", "far", "road"]
Traffic = Literal["empty", "behind", "oncoming", "busy"]
Schedule = tuple[tuple[float, str], ...]
"""States by the time from which they hold (s). The first one holds before that, too."""
PARKED_LIFT_M = 0.3
"""Height at which vehicles spawn (m)."""


@dataclass(frozen=True)
class Move:
    """From `at_s` on for `for_s`, an actor moves at `speed_mps`; vehicles along a lane, others in a direction."""

    at_s: float
    speed_mps: float = 0.0
    for_s: float = math.inf
    turn_deg: float = 0.0
    """Direction relative to the hero's lane, clockwise (degrees); -90 is to the left. Not for vehicles."""
    is_gone: bool = False
    """True if the actor disappears instead."""
    lamps: tuple[str, ...] | None = None
    """New lamps of a vehicle."""


@dataclass(frozen=True)
class Actor:
    """An actor of a situation. Vehicles stay in place until their first move."""

    blueprint: str
    ahead_m: float = 0.0
    right_m: float = 0.0
    """Distance to the right of `origin` (m). For `road`: the share of the road's width from its left edge."""
    origin: LateralOrigin = "lane"
    """Lateral origin. `lane` and `left`: centers of the hero's lane and of the next one to the left. `edge` and `curb`:
    right edges of the hero's lane and of the road. `far`: left edge of the lane to the left."""
    turn_deg: float = 0.0
    lift_m: float = 0.0
    lamps: tuple[str, ...] = ()
    gesture: str = ""
    has_open_door: bool = False
    moves: tuple[Move, ...] = ()
    every_s: float = 0.0
    """Period after which the moves repeat (s); 0 for never."""
    merge_m: float = 0.0
    """Length over which a vehicle joins its lane's center (m); 0 if it keeps its distance from it."""
    yields: bool = True
    from_s: float = 0.0
    """Time at which it appears (s). Not for vehicles."""

    @property
    def origin_m(self) -> float:
        """Height of the actor's origin above the ground (m)."""
        kind = self.blueprint.partition(".")[0]
        return self.lift_m + {"static": 0.0, "vehicle": PARKED_LIFT_M}.get(kind, WALKER_LIFT_M)


@dataclass(frozen=True)
class HeroPose:
    """Pose at which the hero stops, relative to the place; a fault of the driver brought it there."""

    ahead_m: float = 0.0
    right_m: float = 0.0
    turn_deg: float = 0.0


@dataclass(frozen=True)
class Situation:
    """A row of the table: the situation, its source, its staging, and the right reaction."""

    id: int
    """First route id."""
    name: str
    about: str
    source: str
    expected: Expected
    within_s: float
    """Time for the right reaction (s). `recover`, `leave`, `ask` and `reroute`: from the arrival. `wait`: from the time
    at which going becomes right (`free_s`)."""
    actors: tuple[Actor, ...] = ()
    closure: str = ""
    """Blueprint of a row of objects across the whole road."""
    site: SiteKind = "street"
    free_s: float | None = None
    """Earliest time at which going is right where waiting is right before (s)."""
    traffic: Traffic = "empty"
    """`behind`: cars behind the hero. `oncoming`: those, and cars in the oncoming lane. `busy`: cars that cross."""
    near_m: float = 25.0
    """Distance at which the hero has arrived (m)."""
    past_m: float = 15.0
    """Distance beyond the place at which the hero has passed (m)."""
    lights: Schedule = ()
    """States of the hero's light: `red`, `green` or `off`. The other lights are red, or off."""
    perceived: Schedule = ()
    """States of the hero's light as perceived; where no light exists, of a light at the place."""
    hero_pose: HeroPose | None = None
    is_held: bool = False
    """True if the hero does not move from its arrival on, whatever its driver does."""
    zone_m: tuple[float, float] | None = None
    """Start and end of a place where the hero may not stop, along its lane (m)."""


def state_at(schedule: Schedule, now_s: float) -> str:
    """Return the state of a schedule at a time."""
    return [state for at_s, state in schedule if at_s <= now_s or at_s == schedule[0][0]][-1]


def actors_across(blueprint: str, shares: Sequence[float], ahead_m: float = 0.0, **options: Any) -> tuple[Actor, ...]:
    """Return equal actors beside each other, at shares of the road's width from its left edge."""
    return tuple(Actor(blueprint, ahead_m, share, "road", **options) for share in shares)
