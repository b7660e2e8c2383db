"""Holds the current directive, in its JSON form, and its fallback for the time without answers of the solver.

The behavior is that of `stucksolver.plan.Lease`, for stacks that cannot import it. Python 3.7, standard library only.
"""

from __future__ import annotations

from typing import Any, Dict

from stucksolver_bridge.directive_validation import directive_reject_reason

Form = Dict[str, Any]
CONTINUE: Form = {"kind": "continue"}
STAND: Form = {"kind": "execute", "behavior": {"name": "wait", "duration_s": 1.0}}
EXPIRES_TICKS = 10
"""Default for a directive without this field (ticks), as in `stucksolver.plan.directive`."""
STUCK_TICKS = 200
"""Time at rest after which a path that is being finished is aborted (ticks; 10 s at 20 Hz), because it is blocked."""


class JsonLease:
    """The current directive. Call `renew` with the solver's answer, and `tick` once per tick of the control loop.

    No method raises an error.
    """

    def __init__(self) -> None:
        self._order = CONTINUE
        self._ticks = 0
        self._expired = False
        self._finishes_path = False
        """True if the rest of the path is driven after expiry, False if the ego stops."""
        self._rest_ticks = 0
        self.fault: str | None = None
        """Reason why the first invalid directive was rejected; None without one."""

    def renew(self, form: Form | None, late_ticks: int = 0) -> None:
        """Renew the lease with the solver's answer: a new directive, or None for the last one.

        An invalid directive is replaced by a stop. None does not renew an expired directive; request `again` then.

        Args:
            form: The directive's JSON form, or None.
            late_ticks: How many ticks ago the answered tick was (`SolverProcess.late_ticks`).
        """
        if form is None:
            self._ticks = self._ticks if self._expired else min(self._ticks, late_ticks)
            return
        reason = directive_reject_reason(form)
        if reason is not None:
            self.fault = self.fault or reason
        self._order, self._ticks = (form if reason is None else STAND), late_ticks
        self._expired, self._rest_ticks = False, 0

    def expire(self) -> None:
        """Let the directive expire, because no answer will renew it. The next tick performs its fallback."""
        self._ticks = max(self._ticks, self._valid_ticks)

    @property
    def expired(self) -> bool:
        """True if no answer has come for longer than the directive is valid. Request everything `again` then."""
        return self._expired

    @property
    def order(self) -> Form:
        """The last directive, or its replacement."""
        return self._order

    def no_stop_at(self, x_m: float, y_m: float) -> bool:
        """Return True if the path forbids a stop at (x, y), in the frame of the directive's path (m)."""
        points = self._order.get("path") or ()
        nearest = min(points, key=lambda p: (p["x_m"] - x_m) ** 2 + (p["y_m"] - y_m) ** 2, default=None)
        return nearest is not None and bool(nearest.get("no_stop"))

    def tick(self, x_m: float, y_m: float, *, path_is_done: bool, at_rest: bool) -> Form:
        """Return the directive to perform now: the current one, after its expiry the fallback, and then `Continue`.

        A safe stop does not expire, because the ego has stopped where it may stay.

        Args:
            x_m: x of the ego's center in the frame of the path (m).
            y_m: y of the ego's center in the frame of the path (m).
            path_is_done: True if the ego is at the end of the directive's path.
            at_rest: True if the ego is stopped.
        """
        self._ticks += 1
        if self._order["kind"] != "execute" or self._ticks <= self._valid_ticks:
            return self._order
        if not self._expired:
            self._expired, self._finishes_path = True, self.no_stop_at(x_m, y_m)
        self._rest_ticks = self._rest_ticks + 1 if at_rest else 0
        over = (path_is_done or self._rest_ticks > STUCK_TICKS) if self._finishes_path else at_rest
        if over:
            self._order = CONTINUE
            return CONTINUE
        # A directive to stop is its own fallback and keeps its deceleration.
        return self._order if self._finishes_path or not self._order.get("path") else STAND

    @property
    def _valid_ticks(self) -> int:
        return int(self._order.get("expires_ticks", EXPIRES_TICKS))
