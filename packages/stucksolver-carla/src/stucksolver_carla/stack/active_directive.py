"""The order that a vehicle performs: checked when it comes, valid for some ticks, then replaced by its fallback."""

from __future__ import annotations

import math
import sys

from stucksolver.plan import Continue, Directive, Execute, Lease, PathPoint, Replan, SafeStop
from stucksolver.plan.frenet_path import landing_m
from stucksolver.plan.lease import STAND
from stucksolver_bridge.directive_validation import FURTHEST_M, HARDEST_MPS2, MOST_IDS, MOST_POINTS, QUICKEST_MPS

AT_REST_MPS = 0.1
APART_M = 0.02
"""A path needs two points this far apart, otherwise no driver can follow it."""


class ActiveDirective:
    """Call `hear` and then `due` on every tick."""

    def __init__(self) -> None:
        self._lease = Lease()
        self._said: Directive | None = None
        self.fault: str | None = None
        """What was wrong with the first order that could not be performed."""

    def hear(self, directive: Directive | None, asked: bool) -> None:
        """Take the solver's directive of this tick, None if there is none.

        `asked` is False if the stack was not asked for anything on this tick; the directive is then not a new one.
        """
        news = directive is not self._said
        self._said = directive
        if directive is None or not (news or asked):
            return
        wrong = rejection_reason(directive) if news else None
        if wrong is not None:
            self.refuse(wrong)
        elif news or self._lease.order is not STAND:
            self._lease.renew(directive)
        else:
            # The same order that was refused before.
            self._lease.renew(STAND)

    def refuse(self, wrong: str) -> Directive:
        """Stop instead of performing it; reported once."""
        if self.fault is None:
            self.fault = f"an order cannot be performed: {wrong}"
            print(f"stucksolver: {self.fault}; the vehicle stands still", file=sys.stderr, flush=True)
        self._lease.renew(STAND)
        return STAND

    def due(self, x_m: float, y_m: float, speed_mps: float) -> Directive:
        """Return what to perform now, for a vehicle at a place in the path's frame."""
        order = self._lease.order
        if not isinstance(order, Execute):
            return order
        done = self._lease.expired and order.left_m(x_m, y_m) < landing_m(speed_mps)
        return self._lease.tick(x_m, y_m, path_is_done=done, at_rest=speed_mps < AT_REST_MPS)


def rejection_reason(directive: object) -> str | None:
    """Return why a directive cannot be performed, in a few words, or None.

    The models refuse most errors when they are made; copies and objects made without validation are checked here.
    """
    if not isinstance(directive, Continue | Execute | Replan | SafeStop):
        return f"a {type(directive).__name__} is not a directive"
    if not isinstance(directive, Execute):
        return None
    if not isinstance(directive.path, tuple) or not all(isinstance(point, PathPoint) for point in directive.path):
        return "the path is not a tuple of points"
    if len(directive.path) > MOST_POINTS:
        return f"the path has {len(directive.path)} points; there may be {MOST_POINTS}"
    if not all(_is_sound(point) for point in directive.path):
        return "a point of the path is not finite, or out of all bounds"
    if directive.path and _extent_m(directive.path) < APART_M:
        return "a path needs two points at different places"
    if not isinstance(directive.ignore, tuple) or len(directive.ignore) > MOST_IDS:
        return f"ignore is not a tuple of at most {MOST_IDS} ids"
    if not all(isinstance(item, str) and item.lstrip("-").isdecimal() for item in directive.ignore):
        return "the id of an object to drive over is not an actor id"
    if directive.brake_mps2 is not None and not _within(directive.brake_mps2, 1e-3, HARDEST_MPS2):
        return "how hard to brake is out of all bounds"
    return None if _within(directive.expires_ticks, 1, math.inf) else "expires_ticks is not a number of ticks"


def _extent_m(path: tuple[PathPoint, ...]) -> float:
    return max(math.hypot(p.x_m - path[0].x_m, p.y_m - path[0].y_m) for p in path)


def _is_sound(point: PathPoint) -> bool:
    places = _within(point.x_m, -FURTHEST_M, FURTHEST_M) and _within(point.y_m, -FURTHEST_M, FURTHEST_M)
    return places and _within(point.speed_mps, 0.0, QUICKEST_MPS)


def _within(value: object, least: float, most: float) -> bool:
    return isinstance(value, int | float) and least <= value <= most
