"""Directives that `StuckSolver.step` returns."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Annotated, Literal

from pydantic import Field, TypeAdapter

from stucksolver.plan.behaviors.registry import AnyBehavior
from stucksolver.plan.simple_directives import Continue, Replan, SafeStop
from stucksolver.scene.base_model import FrozenModel

EXPIRES_TICKS = 10
"""Default lease of a directive (ticks): 0.5 s at CARLA's 20 Hz, the greatest age of surroundings for the guard."""


class PathPoint(FrozenModel):
    """Point of the proven path in the local frame of the surroundings, with an upper bound on the speed.

    `no_stop` is True where a stop would end in a place where no vehicle should stop. Finishing the path is proven.
    """

    x_m: float
    y_m: float
    speed_mps: float
    no_stop: bool = False


class Execute(FrozenModel):
    """Directive to perform a behavior. The same object is returned while the same path is to be driven.

    The directive is valid for `expires_ticks` ticks of the stack's clock. It is renewed when `step` returns it or
    another directive. After it expires, the stack must fall back (see `Lease`): stop, or finish the path if `no_stop`.

    Attributes:
        behavior: Behavior to perform.
        path: Path that the guard has proven, in the local frame; empty for a behavior without motion.
        reverse: True if the path is behind the ego, which backs up along it.
        ignore: Ids of objects that the path drives over; do not brake for them.
        brake_mps2: Deceleration for a behavior without motion (m/s²); None for a normal, gentle stop.
        expires_ticks: Number of ticks for which the directive is valid.
    """

    kind: Literal["execute"] = "execute"
    behavior: AnyBehavior
    path: tuple[PathPoint, ...] = ()
    reverse: bool = False
    ignore: tuple[str, ...] = ()
    over_red: bool = False
    """True if an operator has approved crossing the red light on the path: do not stop for it."""
    brake_mps2: float | None = Field(default=None, gt=0)
    expires_ticks: int = Field(default=EXPIRES_TICKS, ge=1, le=200)

    def no_stop_at(self, x_m: float, y_m: float) -> bool:
        """True if the path must be finished without a stop from here (m, in the frame of the path)."""
        nearest = min(self.path, key=lambda p: (p.x_m - x_m) ** 2 + (p.y_m - y_m) ** 2, default=None)
        return nearest is not None and nearest.no_stop

    def left_m(self, x_m: float, y_m: float) -> float:
        """Return the length of the path beyond its point nearest to (x, y) (m, in its frame); 0 without a path."""
        away = [math.hypot(p.x_m - x_m, p.y_m - y_m) for p in self.path]
        rest = self.path[away.index(min(away)) :] if away else ()
        return sum(math.hypot(b.x_m - a.x_m, b.y_m - a.y_m) for a, b in pairwise(rest))


Directive = Annotated[Continue | Execute | Replan | SafeStop, Field(discriminator="kind")]
directive_adapter: TypeAdapter[Directive] = TypeAdapter(Directive)
CONTINUE = Continue()
