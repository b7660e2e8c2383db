"""What a stack performs when nobody renews its order: every order is a lease, counted in the stack's ticks.

`stucksolver_bridge.lease` is the same for stacks that cannot import this one; a test compares the two.
"""

from __future__ import annotations

from stucksolver.decision.behaviors.wait import Wait
from stucksolver.decision.directive import CONTINUE, Directive, Execute

STAND = Execute(behavior=Wait(duration_s=1.0))
STUCK_TICKS = 200
"""After standing this long (10 s at 20 Hz), a path that is being finished is given up: something stands in it."""


class Lease:
    """Holds the current order. Call `renew` with whatever `step` returns, and `tick` once per tick of the control
    loop.
    """

    def __init__(self) -> None:
        self._order: Directive = CONTINUE
        self._ticks = 0
        self._fallen = False
        self._finishes = False
        """After expiry: True if the path is finished, False if the vehicle stops."""
        self._rests = 0

    def renew(self, order: Directive) -> None:
        """Take the solver's new order; it holds from now on."""
        self._order, self._ticks = order, 0
        self._fallen, self._rests = False, 0

    def expire(self) -> None:
        """Nobody will renew the order any more: its fallback is due on the next tick."""
        if isinstance(self._order, Execute):
            self._ticks = max(self._ticks, self._order.expires_ticks)

    @property
    def order(self) -> Directive:
        """The last order, or its replacement."""
        return self._order

    @property
    def expired(self) -> bool:
        """True if the solver has been silent for longer than its order was valid."""
        return self._fallen

    def tick(self, x_m: float, y_m: float, *, path_is_done: bool, at_rest: bool) -> Directive:
        """Return what to perform now: the order, after its expiry the fallback, and after that `Continue`.

        A safe stop does not expire: the vehicle stands where it may, and stays.

        Args:
            x_m: Centre of the vehicle in the frame of the path (m).
            y_m: The same across (m).
            path_is_done: The vehicle is at the end of the order's path.
            at_rest: The vehicle stands.
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
        # An order that stands still is its own fallback and keeps its braking.
        return order if self._finishes or not order.path else STAND
