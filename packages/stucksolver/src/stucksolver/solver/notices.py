"""Notices: what keeps the vehicle from going on, for people who need not act on it."""

from __future__ import annotations

from stucksolver.guard import RejectCode, RejectReason, Verdict
from stucksolver.ladder.rung_actions import Person
from stucksolver.plan import CauseCode, WaitReason
from stucksolver.scene.base_model import FrozenModel
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.wording import whereabouts

NO_CONSTRAINT = frozenset({RejectCode.REPEATED, RejectCode.NOT_IMMOBILIZED})
"""Reject codes that say nothing about the world."""
LATER = frozenset(
    {RejectCode.RED_LIGHT, RejectCode.STALE, RejectCode.WAIT_FIRST, RejectCode.NO_ABORT, RejectCode.PATH_NOT_VISIBLE}
)
"""Reject codes that may end without a change of the plan; others bind first."""


class StandstillReason(FrozenModel):
    """What keeps a stopped vehicle from going on: a legitimate wait, a verdict's binding constraint, or a cause."""

    text: str
    wait: WaitReason | None = None
    reject: RejectReason | None = None
    cause: CauseCode | None = None
    """Cause of the immobilization according to the reasoner, if no plan was refused."""
    traffic: bool = False
    """True if the object of that constraint moves: it is one of several road users that pass."""
    immovable: bool = False
    """True if the vehicle does not move although it drives."""

    @property
    def key(self) -> str:
        """Key of the reason. It stays the same while only numbers, or the one of several road users, change."""
        if self.wait is not None:
            return self.wait.value
        if self.reject is not None:
            return "traffic" if self.traffic else f"{self.reject.code.value} {self.reject.object_id or ''}".strip()
        return self.text if self.cause is None else self.cause.value


NOT_KNOWN = StandstillReason(text="the vehicle has stopped, and the reason is not known yet")


IN_VAIN_S = 5.0
"""Time for which motion is commanded without an effect before the vehicle counts as immovable (s). Ours: longer than a
change of gear and the start on a slope.
"""
IMMOVABLE = StandstillReason(
    text=f"the vehicle does not move although it drives: motion commanded for {IN_VAIN_S:g} s without an effect, and "
    "nothing touches it or is in its path",
    immovable=True,
)


class Notice(FrozenModel):
    """Notice to a person about a stopped vehicle. It asks nothing of the person."""

    id: str
    time_s: float
    """Time of the stack's clock (s)."""
    to: Person
    reason: StandstillReason


def binding_reject(verdict: Verdict, view: FrenetScene | None = None) -> RejectReason | None:
    """Return the reject reason that would have to change first, or None without one.

    A reason that ends by itself, such as passing traffic, comes after those that do not.

    Args:
        verdict: The verdict.
        view: Current surroundings, which show what moves; None if unknown.
    """
    rejects = [reason for reason in verdict.rejects if reason.code not in NO_CONSTRAINT]
    lasting = (reason for reason in rejects if reason.code not in LATER and not _moves(reason, view))
    return next(lasting, next(iter(rejects), None))


def _moves(reason: RejectReason, view: FrenetScene | None) -> bool:
    index = None if view is None or reason.object_id is None else view.index_of(reason.object_id)
    return view is not None and index is not None and bool(view.moving[index])


def reject_text(reason: RejectReason, view: FrenetScene | None) -> str:
    """Return a reject reason with the place of its object and how much is missing.

    Args:
        reason: Reject reason.
        view: Current surroundings, for the place of the object; None if unknown.
    """
    index = None if view is None or reason.object_id is None else view.index_of(reason.object_id)
    place = "" if view is None or index is None else f" ({whereabouts(max(float(view.gap[index]), 0.0))})"
    missing = ""
    if reason.needed_m is not None and reason.seen_m is not None:
        missing = f", {max(reason.needed_m - reason.seen_m, 0.0):.0f} m missing"
    return f"{reason.detail}{missing}{place}"


def verdict_reason(verdict: Verdict, view: FrenetScene | None) -> StandstillReason | None:
    """Return the reason for the binding constraint of a verdict; None if it names none."""
    reject = binding_reject(verdict, view)
    if reject is None:
        return None
    return StandstillReason(text=reject_text(reject, view), reject=reject, traffic=_moves(reject, view))
