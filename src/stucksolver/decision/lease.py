"""What a stack performs when nobody renews its order: every order of ours is a lease, counted in the stack's ticks."""

from __future__ import annotations

from stucksolver.decision.behaviors.wait import Wait
from stucksolver.decision.directive import CONTINUE, Directive, Execute

STOP = Execute(behavior=Wait(duration_s=1.0))


class Lease:
    """Call `renew` with whatever `step` returns, and `tick` once on every tick of the stack's control loop."""

    def __init__(self) -> None:
        self._order: Directive = CONTINUE
        self._ticks = 0
        self._finishes = False
        """Once it has expired: is its path finished, or does the vehicle stop?"""

    def renew(self, order: Directive) -> None:
        """The solver has spoken: this holds from now on."""
        self._order, self._ticks = order, 0

    @property
    def expired(self) -> bool:
        """Has the solver been silent for longer than its order is good for?"""
        return isinstance(self._order, Execute) and self._ticks > self._order.expires_ticks

    def tick(self, x_m: float, y_m: float, *, path_is_done: bool, at_rest: bool) -> Directive:
        """What to perform now: the order; once it has expired, its fallback; once that is done, nothing of ours.

        `x_m`, `y_m`: the centre of the vehicle in the frame of the path. `path_is_done`: it is at the end of the
        order's path. `at_rest`: it stands. A safe stop does not expire: the vehicle stands where it may, and stays.
        """
        self._ticks += 1
        order = self._order
        if not self.expired or not isinstance(order, Execute):
            return order
        if self._ticks == order.expires_ticks + 1:
            self._finishes = order.no_stop_at(x_m, y_m)
        if path_is_done if self._finishes else at_rest:
            self._order = CONTINUE
            return CONTINUE
        return order if self._finishes else STOP
