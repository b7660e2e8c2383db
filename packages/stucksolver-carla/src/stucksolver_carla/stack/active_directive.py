"""Holds the directive that a vehicle performs: validated, valid for some ticks, then replaced by its fallback."""

from __future__ import annotations

import math
import sys

from stucksolver.plan import Continue, Directive, Execute, Lease, PathPoint, Replan, SafeStop
from stucksolver.plan.frenet_path import landing_m
from stucksolver.plan.lease import STAND
from stucksolver_bridge.directive_validation import FURTHEST_M, HARDEST_MPS2, MOST_IDS, MOST_POINTS, QUICKEST_MPS

STOPPED_MPS = 0.1
"""Speed below which the ego counts as stopped (m/s). Ours."""
MIN_LENGTH_M = 0.02
"""Minimum distance between the first and another point of a path (m). No driver can follow a shorter path. Ours."""


class ActiveDirective:
    """The current directive. Call `update` and then `due` on every tick."""

    def __init__(self) -> None:
        self._lease = Lease()
        self._last_directive: Directive | None = None
        self.fault: str | None = None
        """Reason why the first invalid directive was rejected; None without one."""

    def update(self, directive: Directive | None, was_read: bool) -> None:
        """Renew the lease with the solver's directive of this tick; None if there is none.

        `was_read` is False if the solver read nothing from the stack on this tick. The same directive as before is then
        no renewal.
        """
        is_new = directive is not self._last_directive
        self._last_directive = directive
        if directive is None or not (is_new or was_read):
            return
        reason = rejection_reason(directive) if is_new else None
        if reason is not None:
            self.reject(reason)
        elif is_new or self._lease.order is not STAND:
            self._lease.renew(directive)
        else:
            # This directive was rejected before.
            self._lease.renew(STAND)

    def reject(self, reason: str) -> Directive:
        """Replace the directive by a stop, and return the stop. The first rejection is reported."""
        if self.fault is None:
            self.fault = f"invalid directive: {reason}"
            print(f"stucksolver: {self.fault}; the vehicle stops", file=sys.stderr, flush=True)
        self._lease.renew(STAND)
        return STAND

    def due(self, x_m: float, y_m: float, speed_mps: float) -> Directive:
        """Return the directive to perform now, for an ego at (x, y) in the path's frame (m)."""
        directive = self._lease.order
        if not isinstance(directive, Execute):
            return directive
        done = self._lease.expired and directive.left_m(x_m, y_m) < landing_m(speed_mps)
        return self._lease.tick(x_m, y_m, path_is_done=done, at_rest=speed_mps < STOPPED_MPS)


def rejection_reason(directive: object) -> str | None:
    """Return the reason to reject a directive, in a few words; None if it is valid.

    The models reject most errors on creation. This function also covers copies and objects created without validation.
    """
    if not isinstance(directive, Continue | Execute | Replan | SafeStop):
        return f"a {type(directive).__name__} is not a directive"
    if not isinstance(directive, Execute):
        return None
    if not isinstance(directive.path, tuple) or not all(isinstance(point, PathPoint) for point in directive.path):
        return "the path must be a tuple of points"
    if len(directive.path) > MOST_POINTS:
        return f"the path has {len(directive.path)} points; at most {MOST_POINTS} are allowed"
    if not all(_is_valid(point) for point in directive.path):
        return "a point of the path is not finite or out of bounds"
    if directive.path and _extent_m(directive.path) < MIN_LENGTH_M:
        return "a path must have two points at different positions"
    if not isinstance(directive.ignore, tuple) or len(directive.ignore) > MOST_IDS:
        return f"ignore must be a tuple of at most {MOST_IDS} ids"
    if not all(isinstance(item, str) and item.lstrip("-").isdecimal() for item in directive.ignore):
        return "an id in ignore must be an actor id"
    if directive.brake_mps2 is not None and not _within(directive.brake_mps2, 1e-3, HARDEST_MPS2):
        return f"brake_mps2 must be a number up to {HARDEST_MPS2:g}"
    return None if _within(directive.expires_ticks, 1, math.inf) else "expires_ticks must be a number of at least 1"


def _extent_m(path: tuple[PathPoint, ...]) -> float:
    return max(math.hypot(p.x_m - path[0].x_m, p.y_m - path[0].y_m) for p in path)


def _is_valid(point: PathPoint) -> bool:
    is_on_map = _within(point.x_m, -FURTHEST_M, FURTHEST_M) and _within(point.y_m, -FURTHEST_M, FURTHEST_M)
    return is_on_map and _within(point.speed_mps, 0.0, QUICKEST_MPS)


def _within(value: object, least: float, most: float) -> bool:
    return isinstance(value, int | float) and least <= value <= most
