"""An experiment without the guard: the effect of a reasoner whose plans are not checked."""

from __future__ import annotations

from collections.abc import Sequence

from stucksolver.guard import NOBODY, OK, Approvals, GivingWay, Guard, GuardPolicy, ProvenPlan, Verdict, no_path
from stucksolver.plan.behaviors import REGISTRY, ApprovalLevel, Behavior, NoPathError
from stucksolver.plan.frenet_path import FrenetPath
from stucksolver.scene.frenet_scene import FrenetScene


class PermissiveGuard(Guard):
    """Executes every plan that has a path and never aborts one. For simulators only."""

    def __init__(self) -> None:
        super().__init__(GuardPolicy(releases=dict.fromkeys(REGISTRY, ApprovalLevel.AUTONOMOUS)))

    def accept(
        self,
        behaviors: Sequence[Behavior],
        view: FrenetScene,
        guided: bool,
        approvals: Approvals = NOBODY,
        stops: bool = False,
    ) -> tuple[Verdict, ProvenPlan | None]:
        """Reject only plans without a path."""
        try:
            return OK, self.lay_out(behaviors, view, guided, approvals, stops)
        except NoPathError as error:
            # The error becomes a reject reason.
            return no_path(error), None

    def allows_standing(self, behavior: Behavior, view: FrenetScene, approvals: Approvals = NOBODY) -> Verdict:
        """Accept always: that is the purpose of this system."""
        return OK

    def clear_to_hand_back(self, view: FrenetScene) -> bool:
        """Return True always."""
        return True

    def about_to_touch(self, view: FrenetScene, curvature_per_m: float) -> None:
        """Return nothing: it takes control from no driver."""

    def recheck(self, proven: ProvenPlan, view: FrenetScene, giving_way: GivingWay = False) -> Verdict:
        """Accept always."""
        return OK

    def recheck_way_back(self, path: FrenetPath, view: FrenetScene, giving_way: bool = False) -> Verdict:
        """Accept always."""
        return OK
