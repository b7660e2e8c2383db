"""Admits a proposed plan: is it offered, has it failed before, does the guard accept it, and who must approve it?"""

from __future__ import annotations

from dataclasses import dataclass

from stucksolver.guard import NOBODY, RULES, Approvals, Guard, RejectCode, RejectReason, Verdict
from stucksolver.ladder.rung_actions import Person
from stucksolver.plan import RecoveryPlan
from stucksolver.plan.behaviors import ApprovalLevel
from stucksolver.scene import Scene
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.solver.state_machine.approval_rules import ASKABLE, RED_LIGHT, approvable_rules, check_authorized
from stucksolver.solver.state_machine.execution import Execution
from stucksolver.solver.state_machine.history import AttemptHistory, moving, passes
from stucksolver.solver.state_machine.plan_preview import PlanPreview


@dataclass(frozen=True)
class MissingApproval:
    """An approval that would make a refused plan acceptable."""

    to: Person
    what: tuple[str, ...]

    def to_approvals(self) -> Approvals:
        """The approvals that hold once it is given."""
        names = frozenset(self.what)
        return Approvals(passenger=names) if self.to == "passenger" else Approvals(operator=names)


@dataclass(frozen=True)
class Admission:
    """A plan with its verdict. If the plan is accepted, `execution` is ready to continue.

    Attributes:
        need: The only approval that the plan still lacks.
        passing: True if the plan is refused only because of traffic that will move on.
    """

    plan: RecoveryPlan
    verdict: Verdict
    execution: Execution
    need: MissingApproval | None
    passing: bool


def admit(
    plan: RecoveryPlan,
    view: FrenetScene,
    now_s: float,
    *,
    guard: Guard,
    scene: Scene | None,
    history: AttemptHistory,
    guided: bool,
    approvals: Approvals,
    again: bool = False,
) -> Admission:
    """Judge a plan against the world as it is now.

    Args:
        plan: The proposed plan.
        view: The surroundings in road coordinates.
        now_s: The solver's own time (s).
        guard: The guard that judges the plan.
        scene: The scene that was given to the reasoner, with the behaviors it offered.
        history: The plans that failed before in this intervention.
        guided: True if the passenger's words ask for the plan.
        approvals: What people have approved so far.
        again: True if the plan waits for a gap and is judged on every tick; no approval is then searched for.

    Returns:
        The plan with its verdict and, if one approval is missing, which one.
    """
    execution = Execution(plan, guard, guided, approvals)
    known = check_offered(plan, scene) or history.against(plan)
    verdict = known or check_authorized(plan, guard, approvals) or execution.start(view, now_s)
    if verdict.accepted and not again:
        verdict = PlanPreview(guard, view, lambda _: guided, approvals).later_refusal(plan) or verdict
    need = None
    if known is None and not verdict.accepted and not again:
        need = missing_approval(plan, verdict, guard, view, now_s, guided, approvals)
    return Admission(plan, verdict, execution, need, passes(verdict, moving(view)))


def preview_verdict(plan: RecoveryPlan, view: FrenetScene, now_s: float, *, guard: Guard, guided: bool) -> str:
    """Return what the guard would say about a plan, for a reasoner that checks a plan before it answers."""
    return str(Execution(plan, guard, guided, NOBODY).start(view, now_s))


def check_offered(plan: RecoveryPlan, scene: Scene | None) -> Verdict | None:
    """Refuse a behavior, or a start of a new route, that the stack did not offer in the scene."""
    if scene is None:
        return None
    lacking = [f"behavior {b.name} is not offered" for b in plan.behaviors if not scene.offers(b.name)]
    known = {w.id for w in scene.waypoints}
    starts = (plan.route_start, *(getattr(b, "route_start", None) for b in plan.behaviors))
    lacking += [f"waypoint {w} is not among the scene's" for w in starts if w is not None and w not in known]
    return (
        Verdict(rejects=tuple(RejectReason(code=RejectCode.PRECONDITION, detail=x) for x in lacking))
        if lacking
        else None
    )


def missing_approval(
    plan: RecoveryPlan, verdict: Verdict, guard: Guard, view: FrenetScene, now_s: float, guided: bool, has: Approvals
) -> MissingApproval | None:
    """Return the smallest approval with which the guard accepts a refused plan, or None if no approval would help."""
    if not any(r.code in ASKABLE for r in verdict.rejects):
        return None
    people: tuple[Person, ...] = ("passenger", "operator")
    for to in people:
        named = tuple(dict.fromkeys(b.name for b in plan.behaviors if _needs(guard, b.name, to)))
        for extra in ((), *((rule,) for rule in RULES if rule in approvable_rules(plan))):
            need = MissingApproval(to, (*named, *extra))
            if not need.what:
                continue
            would = Execution(plan, guard, guided, union(has, need.to_approvals())).start(view, now_s)
            # Traffic that will move on does not prevent a question about a light: the plan then waits for a gap.
            if would.accepted or (extra == RED_LIGHT and not _at_red(would) and passes(would, moving(view))):
                return need
    return None


def _at_red(verdict: Verdict) -> bool:
    return any(r.code is RejectCode.RED_LIGHT for r in verdict.rejects)


def _needs(guard: Guard, behavior: str, to: Person) -> bool:
    release = guard.policy.release(behavior)
    return release is ApprovalLevel.PASSENGER or (release is ApprovalLevel.OPERATOR and to == "operator")


def union(first: Approvals, second: Approvals) -> Approvals:
    """The union of two sets of approvals."""
    return Approvals(first.passenger | second.passenger, first.operator | second.operator, first.barred | second.barred)


def with_approval(has: Approvals, by: Person, what: tuple[str, ...]) -> Approvals:
    """The approvals with one more added."""
    return union(has, MissingApproval(by, what).to_approvals())
