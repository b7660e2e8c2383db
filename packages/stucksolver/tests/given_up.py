"""A guard that gives a plan up when it is told to."""

from __future__ import annotations

from stucksolver.guard import Guard, RejectCode, RejectReason, Verdict
from stucksolver.plan.behaviors import AbortAction

PRESSED = Verdict(rejects=(RejectReason(code=RejectCode.LANE_ENTRY, detail="a car comes"),), abort=AbortAction.STOP)


class GivesUp(Guard):
    """Sound, but has one plan given up, for the traffic, when a view says so."""

    def __init__(self, when):
        super().__init__()
        self._when = when
        self.gave_up = False

    def recheck(self, proven, view, giving_way=False):
        if not self.gave_up and self._when(view):
            self.gave_up = True
            return PRESSED
        return super().recheck(proven, view, giving_way)

    def accept(self, *arguments):
        verdict = super().accept(*arguments)
        return (PRESSED, None) if self.gave_up and self._when is askew else verdict


def askew(view):
    return abs(view.ego_yaw) > 0.25
