"""What a stack performs when the solver falls silent, for directives in their JSON form.

It does the same as `stucksolver.plan.Lease`, for stacks that cannot import that. Python 3.7, standard library only.
"""

from __future__ import annotations

from typing import Any, Dict

from stucksolver_bridge.directive_validation import why_unfit

Form = Dict[str, Any]
CONTINUE: Form = {"kind": "continue"}
STAND: Form = {"kind": "execute", "behavior": {"name": "wait", "duration_s": 1.0}}
EXPIRES_TICKS = 10
"""Default for a directive without this field, as in `stucksolver.plan.directive`."""
STUCK_TICKS = 200
"""A path that is being finished is given up after this time at rest (10 s at 20 Hz): something blocks it."""


class JsonLease:
    """Holds the current order. Call `renew` with the solver's answer, and `tick` once per tick of the control loop.

    No method raises an error.
    """

    def __init__(self) -> None:
        self._order = CONTINUE
        self._ticks = 0
        self._fallen = False
        self._finishes = False
        """After expiry: True if the path is finished, False if the vehicle stops."""
        self._rests = 0
        self.fault: str | None = None
        """What was wrong with the first directive that could not be performed."""

    def renew(self, form: Form | None, late_ticks: int = 0) -> None:
        """Take the solver's answer: a directive that holds from now on, or None to renew the last one.

        A directive that cannot be performed is replaced by a stop. None does not renew an expired one: ask for `again`.

        Args:
            form: The directive's JSON form, or None.
            late_ticks: How many ticks ago the answered tick was (`SolverProcess.late_ticks`).
        """
        if form is None:
            self._ticks = self._ticks if self._fallen else min(self._ticks, late_ticks)
            return
        wrong = why_unfit(form)
        if wrong is not None:
            self.fault = self.fault or wrong
        self._order, self._ticks = (form if wrong is None else STAND), late_ticks
        self._fallen, self._rests = False, 0

    def expire(self) -> None:
        """Let the order expire, because nobody will renew it: the next tick performs its fallback."""
        self._ticks = max(self._ticks, self._good_for)

    @property
    def expired(self) -> bool:
        """True if the solver has been silent for longer than its order was valid. Then ask it to send everything
        `again`.
        """
        return self._fallen

    @property
    def order(self) -> Form:
        """The last order, or its replacement."""
        return self._order

    def no_stop_at(self, x_m: float, y_m: float) -> bool:
        """True if the vehicle should not stop at this place (in the frame of the order's path)."""
        points = self._order.get("path") or ()
        nearest = min(points, key=lambda p: (p["x_m"] - x_m) ** 2 + (p["y_m"] - y_m) ** 2, default=None)
        return nearest is not None and bool(nearest.get("no_stop"))

    def tick(self, x_m: float, y_m: float, *, path_is_done: bool, at_rest: bool) -> Form:
        """Return what to perform now: the order, after its expiry the fallback, and after that `Continue`.

        A safe stop does not expire: the vehicle is where it may stop, and stays there.

        Args:
            x_m: x of the vehicle's center in the frame of the path (m).
            y_m: y of the vehicle's center in the frame of the path (m).
            path_is_done: True if the vehicle is at the end of the order's path.
            at_rest: True if the vehicle is stationary.
        """
        self._ticks += 1
        if self._order["kind"] != "execute" or self._ticks <= self._good_for:
            return self._order
        if not self._fallen:
            self._fallen, self._finishes = True, self.no_stop_at(x_m, y_m)
        self._rests = self._rests + 1 if at_rest else 0
        over = (path_is_done or self._rests > STUCK_TICKS) if self._finishes else at_rest
        if over:
            self._order = CONTINUE
            return CONTINUE
        # An order to stand still is its own fallback and keeps its braking.
        return self._order if self._finishes or not self._order.get("path") else STAND

    @property
    def _good_for(self) -> int:
        return int(self._order.get("expires_ticks", EXPIRES_TICKS))
