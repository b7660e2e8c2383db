"""What `StuckSolver.step` returns on every tick."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Annotated, Literal

from pydantic import Field, TypeAdapter

from stucksolver.decision.behaviors.registry import AnyBehavior
from stucksolver.scene.model import Model

EXPIRES_TICKS = 10
"""Half a second at CARLA's 20 Hz: as old as the guard lets surroundings be."""


class PathPoint(Model):
    """A point of the proven path in the local frame of the surroundings, with an upper bound on the speed.

    `no_stop`: a stop from here would not end where a vehicle may stand; finishing the path has been proven.
    """

    x_m: float
    y_m: float
    speed_mps: float
    no_stop: bool = False


class Continue(Model):
    """Drive as if StuckSolver were not there."""

    kind: Literal["continue"] = "continue"


class Execute(Model):
    """Perform a behaviour. `path` is what the guard has proven; empty for a behaviour that stands still.

    The same object is returned for as long as the same stretch is to be driven. `reverse`: the path leads away behind
    the ego, which backs up along it. `ignore`: ids of objects that the path leads over and that must not be braked for.
    `brake_mps2`: how hard to brake for a behaviour that stands still; None for as gently as usual.

    An order is good for `expires_ticks` ticks of the stack's clock unless `step` returns it, or another, again. Then
    the stack performs its fallback (`Lease` does that): to stop, or, where `no_stop` says so, to finish the path.
    """

    kind: Literal["execute"] = "execute"
    behavior: AnyBehavior
    path: tuple[PathPoint, ...] = ()
    reverse: bool = False
    ignore: tuple[str, ...] = ()
    over_red: bool = False
    """Has an operator released the red light that the path leads across? Then it is not stopped for."""
    brake_mps2: float | None = Field(default=None, gt=0)
    expires_ticks: int = Field(default=EXPIRES_TICKS, ge=1, le=200)

    def no_stop_at(self, x_m: float, y_m: float) -> bool:
        """Is finishing what has been proven for a place near the path, given in the frame of its points?"""
        nearest = min(self.path, key=lambda p: (p.x_m - x_m) ** 2 + (p.y_m - y_m) ** 2, default=None)
        return nearest is not None and nearest.no_stop

    def left_m(self, x_m: float, y_m: float) -> float:
        """Length of the path beyond its point nearest to a place (metres); 0 without a path."""
        away = [math.hypot(p.x_m - x_m, p.y_m - y_m) for p in self.path]
        rest = self.path[away.index(min(away)) :] if away else ()
        return sum(math.hypot(b.x_m - a.x_m, b.y_m - a.y_m) for a, b in pairwise(rest))


class Replan(Model):
    """Plan the route anew, from a candidate waypoint of the scene or from here (None)."""

    kind: Literal["replan"] = "replan"
    route_start: str | None = None


class SafeStop(Model):
    """Come to rest with hazard lights on, and stay so until another directive; nothing more can be done here."""

    kind: Literal["safe_stop"] = "safe_stop"
    reason: str


Directive = Annotated[Continue | Execute | Replan | SafeStop, Field(discriminator="kind")]
directive_adapter: TypeAdapter[Directive] = TypeAdapter(Directive)
CONTINUE = Continue()
