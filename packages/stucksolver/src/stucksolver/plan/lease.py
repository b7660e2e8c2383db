"""Fallback of a stack when its directive is not renewed: every directive is a lease, counted in the stack's ticks.

`stucksolver_bridge.lease` is a copy for stacks that cannot import this module; a test compares the two.
"""

from __future__ import annotations

from stucksolver.plan.behaviors.wait import Wait
from stucksolver.plan.directive import CONTINUE, Directive, Execute

STAND = Execute(behavior=Wait(duration_s=1.0))
STUCK_TICKS = 200
"""Duration of a stop after which a path that is being finished is aborted (ticks): 10 s at 20 Hz. Ours."""


class Lease:
    """Lease of the current directive.

    Call `renew` with what `step` returns, and `tick` once per tick of the control loop.
    """

    def __init__(self) -> None:
        self._order: Directive = CONTINUE
        self._ticks = 0
        self._fallen = False
        self._finishes = False
        """True if the path is to be finished after expiry, False if the vehicle is to stop."""
        self._rests = 0

    def renew(self, order: Directive) -> None:
        """Store the solver's new directive; its lease starts now."""
        self._order, self._ticks = order, 0
        self._fallen, self._rests = False, 0

    def expire(self) -> None:
        """Expire the directive, because it will not be renewed: its fallback is due on the next tick."""
        if isinstance(self._order, Execute):
            self._ticks = max(self._ticks, self._order.expires_ticks)

    @property
    def order(self) -> Directive:
        """The last directive, or its replacement."""
        return self._order

    @property
    def expired(self) -> bool:
        """True if the directive was not renewed within its lease."""
        return self._fallen

    def tick(self, x_m: float, y_m: float, *, path_is_done: bool, at_rest: bool) -> Directive:
        """Return the directive for this tick: the last one; after it expires, its fallback; after that `Continue`.

        A safe stop does not expire: the vehicle has stopped where it may, and stays.

        Args:
            x_m: x of the vehicle's center in the frame of the path (m).
            y_m: y of the vehicle's center (m).
            path_is_done: True if the vehicle has reached the end of the path.
            at_rest: True if the vehicle has stopped.
        """
        self._ticks += 1
        order = self._order
        if not isinstance(order, Execute) or self._ticks <= order.expires_ticks:
            return order
        if not self._fallen:
            self._fallen, self._finishes = True, order.no_stop_at(x_m, y_m)
        self._rests = self._rests + 1 if at_rest else 0
        if (path_is_done or self._rests > STUCK_TICKS) if self._finishes else at_rest:
            self._order = CONTINUE
            return CONTINUE
        # A directive without motion is its own fallback and keeps its braking.
        return order if self._finishes or not order.path else STAND
