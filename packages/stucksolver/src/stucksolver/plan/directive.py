"""The directives that `StuckSolver.step` returns."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Annotated, Literal

from pydantic import Field, TypeAdapter

from stucksolver.plan.behaviors.registry import AnyBehavior
from stucksolver.scene.base_model import FrozenModel

EXPIRES_TICKS = 10
"""Half a second at CARLA's 20 Hz, like the greatest age of surroundings that the guard accepts."""


class PathPoint(FrozenModel):
    """A point of the proven path in the local frame of the surroundings, with an upper bound on the speed.

    `no_stop` is True where a stop would end where no vehicle should stop; finishing the path has been proven.
    """

    x_m: float
    y_m: float
    speed_mps: float
    no_stop: bool = False


class Continue(FrozenModel):
    """Drive as if StuckSolver were not there."""

    kind: Literal["continue"] = "continue"


class Execute(FrozenModel):
    """Perform a behavior. The same object is returned for as long as the same stretch is to be driven.

    An order is valid for `expires_ticks` ticks of the stack's clock, unless `step` returns it or another one again.
    After that the stack must fall back (`Lease` does that): stop, or finish the path where `no_stop` says so.

    Attributes:
        behavior: The behavior.
        path: The path that the guard has proven, in the local frame; empty for a behavior that stands still.
        reverse: The path lies behind the ego, which backs up along it.
        ignore: Ids of objects that the path drives over; do not brake for them.
        brake_mps2: Deceleration for a behavior that stands still (m/s²); None for a normal, gentle stop.
        expires_ticks: Number of ticks for which the order is valid.
    """

    kind: Literal["execute"] = "execute"
    behavior: AnyBehavior
    path: tuple[PathPoint, ...] = ()
    reverse: bool = False
    ignore: tuple[str, ...] = ()
    over_red: bool = False
    """An operator has approved crossing the red light on the path: do not stop for it."""
    brake_mps2: float | None = Field(default=None, gt=0)
    expires_ticks: int = Field(default=EXPIRES_TICKS, ge=1, le=200)

    def no_stop_at(self, x_m: float, y_m: float) -> bool:
        """True if near this place (m, in the path's frame) the path must be finished and the vehicle must not stop."""
        nearest = min(self.path, key=lambda p: (p.x_m - x_m) ** 2 + (p.y_m - y_m) ** 2, default=None)
        return nearest is not None and nearest.no_stop

    def left_m(self, x_m: float, y_m: float) -> float:
        """Return the length of the path beyond its point nearest to a place (m, in its frame); 0 without a path."""
        away = [math.hypot(p.x_m - x_m, p.y_m - y_m) for p in self.path]
        rest = self.path[away.index(min(away)) :] if away else ()
        return sum(math.hypot(b.x_m - a.x_m, b.y_m - a.y_m) for a, b in pairwise(rest))


class Replan(FrozenModel):
    """Replan the route, from a candidate waypoint of the scene or from here (None)."""

    kind: Literal["replan"] = "replan"
    route_start: str | None = None


class SafeStop(FrozenModel):
    """Stop with hazard lights on and stay until another directive; nothing more can be done here."""

    kind: Literal["safe_stop"] = "safe_stop"
    reason: str


Directive = Annotated[Continue | Execute | Replan | SafeStop, Field(discriminator="kind")]
directive_adapter: TypeAdapter[Directive] = TypeAdapter(Directive)
CONTINUE = Continue()
