"""What a stack performs when nobody renews its order: every order of ours is a lease, counted in the stack's ticks."""

from __future__ import annotations

from stucksolver.decision.behaviors.wait import Wait
from stucksolver.decision.directive import CONTINUE, Continue, Directive, Execute

STOP = Execute(behavior=Wait(duration_s=1.0))


class Lease:
    """Call `renew` with whatever `step` returns, and `tick` once on every tick of the stack's control loop."""

    def __init__(self) -> None:
        self._order: Directive = CONTINUE
        self._ticks = 0

    def renew(self, order: Directive) -> None:
        """The solver has spoken: this holds from now on."""
        self._order, self._ticks = order, 0

    @property
    def expired(self) -> bool:
        """Has the solver been silent for longer than its order is good for?"""
        return isinstance(self._order, Execute) and self._ticks > self._order.expires_ticks

    def tick(self, *, path_is_done: bool = False, at_rest: bool = False) -> Directive:
        """What to perform now: the order; once it has expired, its fallback; once that is done, nothing of ours.

        `path_is_done`: the stack is at the end of the order's path. `at_rest`: the vehicle stands.
        A safe stop does not expire: the vehicle stands where it may, and stays.
        """
        self._ticks += 1
        order = self._order
        if not self.expired or not isinstance(order, Execute):
            return order
        if order.fallback == "finish" and order.path:
            return CONTINUE if path_is_done else order
        return self._release() if at_rest else STOP.model_copy(update={"brake_mps2": order.brake_mps2})

    def _release(self) -> Continue:
        self._order = CONTINUE
        return CONTINUE
