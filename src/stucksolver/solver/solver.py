"""`StuckSolver`: the object that a driving stack owns. It watches, asks, checks, and tells what to do."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from stucksolver.decision import CONTINUE, Decision, Directive, GuidanceIntent, RecoveryPlan, Replan
from stucksolver.detect import Detector, DetectorSettings, Trigger
from stucksolver.guard import Guard, Reject, RejectCode, Verdict
from stucksolver.reason import Reasoner, ReasonerError, RuleReasoner
from stucksolver.scene import Guidance, PastAttempt, Scene, Status, Surroundings
from stucksolver.scene.view import View
from stucksolver.solver.clock import Clock, make_clock
from stucksolver.solver.events import Event, EventKind, Listener
from stucksolver.solver.execution import Execution, Outcome
from stucksolver.solver.progress import ProgressWatch
from stucksolver.solver.thinking import Thinking


@dataclass(frozen=True)
class SolverSettings:
    """How often and for how long it tries."""

    recheck_s: float = 1.0
    """After an answer without a plan, the scene is looked at again this much later."""
    after_refusal_s: float = 2.0
    guidance_expires_s: float = 30.0
    repair_rounds: int = 1
    """How often a refused reasoner is told why and asked again at once."""
    remembered_attempts: int = 5


class StuckSolver:
    """Three lines around a stack's own loop: make one, call `step` on every tick, perform what it returns.

    `scene` is called only when something may be wrong; `surroundings` (an argument of `step`) only while a plan is
    pending or running. Everything is called from the thread that calls `step`, except the reasoner.
    """

    def __init__(
        self,
        scene: Callable[[], Scene],
        *,
        reasoner: Reasoner | None = None,
        guard: Guard | None = None,
        detector: DetectorSettings | None = None,
        clock: Clock | str = "wall",
        settings: SolverSettings | None = None,
        on_event: Listener | None = None,
    ) -> None:
        self._scene = scene
        self._guard = guard or Guard()
        self._detector = Detector(detector)
        self._settings = settings or SolverSettings()
        clock = make_clock(clock) if isinstance(clock, str) else clock
        self._thinking = Thinking(reasoner or RuleReasoner(), clock)
        self._emit = on_event or (lambda event: None)
        self._progress = ProgressWatch()
        self._guidance: Guidance | None = None
        self._doing: Guidance | None = None
        """The words that the running plan follows."""
        self._heard: Guidance | None = None
        """The words that were asked about while a plan runs."""
        self._helped = False
        """Has a plan been started since the last recovery?"""
        self._words: str | None = None
        self._execution: Execution | None = None
        self._attempts: tuple[PastAttempt, ...] = ()
        self._repairs = 0
        self._ask_not_before_s = 0.0
        self._trigger: Trigger | None = None

    def guide(self, text: str) -> None:
        """Take a passenger's words, at any time; they count from the next step on. Longer than 500 is cut."""
        self._words = text[:500]

    def step(self, status: Status, surroundings: Callable[[], Surroundings]) -> Directive:
        """What the stack is to do at this tick. Returns at once (a lockstep clock waits for the reasoner)."""
        trigger = self._detector.update(status)
        if self._words is not None:
            self._take_guidance(status.time_s)
        self._expire_guidance(status.time_s)
        if trigger is None and self._guidance is None and self._execution is None and not self._thinking.busy:
            self._watch(status, None)
            return CONTINUE
        self._watch(status, trigger)
        if self._execution is not None:
            self._listen(self._execution, status)
            return self._execute(status, surroundings)
        if self._thinking.busy:
            return self._take_answer(status, trigger, surroundings)
        self._ask(status, trigger)
        return CONTINUE

    def close(self) -> None:
        """Forget the question under way; nothing is asked any more unless `step` is called again."""
        self._thinking.drop()

    def __enter__(self) -> StuckSolver:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # ---- watching

    def _take_guidance(self, now_s: float) -> None:
        assert self._words is not None
        self._guidance, self._words = Guidance(text=self._words, time_s=now_s), None
        self._ask_not_before_s = now_s
        self._attempts = ()
        if self._execution is None:
            self._thinking.drop()
        self._tell(now_s, EventKind.GUIDANCE, self._guidance.text)

    def _expire_guidance(self, now_s: float) -> None:
        """Words that led to nothing in time are dropped, with the last reason; a question about them too."""
        words = self._guidance
        if words is None or words is self._doing or now_s - words.time_s <= self._settings.guidance_expires_s:
            return
        if self._execution is None:
            self._thinking.drop()
        last = self._attempts[-1].outcome if self._attempts else "no occasion"
        self._end_guidance(now_s, f"expired ({last})")

    def _watch(self, status: Status, trigger: Trigger | None) -> None:
        recovered_after = self._progress.update(status, self._detector.slow_since_s, trigger)
        if recovered_after is not None:
            self._attempts = ()
            if self._helped:
                text = f"15 m of new progress, {recovered_after:.1f} s after onset"
                self._tell(status.time_s, EventKind.RECOVERED, text)
            self._helped = False

    # ---- asking

    def _ask(self, status: Status, trigger: Trigger | None) -> None:
        now = status.time_s
        if now < self._ask_not_before_s or (trigger is None and self._guidance is None):
            return
        self._trigger = Trigger.GUIDANCE if self._guidance is not None else trigger
        assert self._trigger is not None
        slow_since = self._detector.slow_since_s
        scene = self._scene()
        ego = scene.ego.model_copy(
            update={
                "stopped_for_s": 0.0 if slow_since is None else round(now - slow_since, 2),
                "progress_20s_m": self._detector.progress_in_window_m,
            }
        )
        scene = scene.model_copy(update={"ego": ego, "guidance": self._guidance, "attempts": self._attempts})
        self._tell(now, EventKind.TRIGGERED, self._trigger.value)
        self._thinking.ask(scene)

    def _take_answer(
        self, status: Status, trigger: Trigger | None, surroundings: Callable[[], Surroundings]
    ) -> Directive:
        now = status.time_s
        try:
            decision = self._thinking.poll(now)
        except ReasonerError as error:
            self._ask_not_before_s = now + self._settings.after_refusal_s
            self._tell(now, EventKind.FAILED, f"the reasoner gave no answer: {error}")
            return CONTINUE
        if decision is None:
            return CONTINUE
        if decision.plan is None:
            return self._nothing_to_do(decision, now)
        return self._judge(decision, decision.plan, status, trigger, surroundings)

    def _nothing_to_do(self, decision: Decision, now: float) -> Directive:
        self._ask_not_before_s = now + self._settings.recheck_s
        self._repairs = 0
        self._tell_decision(now, decision, None)
        intent = decision.analysis.guidance_intent
        if self._guidance is not None and intent in (GuidanceIntent.WAIT, GuidanceIntent.UNCLEAR):
            self._end_guidance(now, "nothing to do")
        return CONTINUE

    def _judge(
        self,
        decision: Decision,
        plan: RecoveryPlan,
        status: Status,
        trigger: Trigger | None,
        surroundings: Callable[[], Surroundings],
    ) -> Directive:
        """Check a plan against the world as it is now, not as it was when the question was asked."""
        now = status.time_s
        guided = self._guidance is not None
        if trigger is None and not guided:
            gone = Reject(code=RejectCode.NOT_IMMOBILIZED, detail="the vehicle moves again")
            self._tell_decision(now, decision, Verdict(rejects=(gone,)))
            return CONTINUE
        view = View(surroundings())
        execution = Execution(plan, self._guard, guided)
        verdict = _against_offers(plan, self._thinking.scene) or execution.start(view, now)
        self._tell_decision(now, decision, verdict)
        if not verdict.accepted:
            return self._refused(plan, verdict, status, trigger)
        self._repairs = 0
        self._execution, self._doing = execution, self._guidance
        self._helped = True
        self._tell(now, EventKind.STARTED, ", ".join(b.name for b in plan.behaviors))
        return self._execute(status, surroundings, view)

    def _refused(self, plan: RecoveryPlan, verdict: Verdict, status: Status, trigger: Trigger | None) -> Directive:
        """Tell the reasoner why, at once while repair rounds last, later otherwise."""
        self._remember(plan, str(verdict), status.time_s)
        if self._repairs < self._settings.repair_rounds:
            self._repairs += 1
            self._ask_not_before_s = status.time_s
            self._ask(status, trigger)
        else:
            self._repairs = 0
            self._ask_not_before_s = status.time_s + self._settings.after_refusal_s
        return CONTINUE

    # ---- executing

    def _listen(self, execution: Execution, status: Status) -> None:
        """New words while a plan runs: if they take it back, it is given up as soon as that is safe."""
        words = self._guidance
        if words is None or words is self._doing or words is self._heard:
            return
        if not self._thinking.busy:
            self._ask(status, None)
            return
        try:
            decision = self._thinking.poll(status.time_s)
        except ReasonerError as error:
            self._heard = words
            self._tell(status.time_s, EventKind.FAILED, f"the reasoner gave no answer: {error}")
            return
        if decision is None:
            return
        self._heard = words
        self._tell_decision(status.time_s, decision, None)
        if decision.analysis.guidance_intent is GuidanceIntent.WAIT:
            execution.withdraw()
            self._end_guidance(status.time_s, "the plan is given up")

    def _execute(self, status: Status, surroundings: Callable[[], Surroundings], view: View | None = None) -> Directive:
        assert self._execution is not None
        result = self._execution.tick(view or View(surroundings()), status.time_s)
        if not isinstance(result, Outcome):
            return result
        plan, self._execution = self._execution.plan, None
        spoken, self._doing = self._doing, None
        return self._ended(plan, result, status.time_s, spoken)

    def _ended(self, plan: RecoveryPlan, outcome: Outcome, now: float, spoken: Guidance | None) -> Directive:
        kind = EventKind.FINISHED if outcome.finished else EventKind.ABORTED
        self._tell(now, kind, outcome.text)
        if not outcome.finished:
            self._remember(plan, f"aborted: {outcome.text}", now)
            self._ask_not_before_s = now + self._settings.recheck_s
            return CONTINUE
        if spoken is not None and spoken is self._guidance:
            self._end_guidance(now, "done")
        self._detector.forget()
        return Replan(route_start=plan.route_start) if plan.replan_route else CONTINUE

    # ---- small things

    def _remember(self, plan: RecoveryPlan, outcome: str, now: float) -> None:
        attempt = PastAttempt(time_s=now, behaviors=tuple(b.name for b in plan.behaviors), outcome=outcome)
        self._attempts = (*self._attempts, attempt)[-self._settings.remembered_attempts :]

    def _end_guidance(self, now: float, how: str) -> None:
        assert self._guidance is not None
        self._tell(now, EventKind.GUIDANCE_ENDED, f'"{self._guidance.text}": {how}')
        self._guidance = None
        self._attempts = ()

    def _tell_decision(self, now: float, decision: Decision, verdict: Verdict | None) -> None:
        self._emit(
            Event(
                time_s=now,
                kind=EventKind.DECIDED,
                text=decision.rationale,
                trigger=self._trigger.value if self._trigger else None,
                scene=self._thinking.scene,
                decision=decision,
                verdict=verdict,
            )
        )

    def _tell(self, now: float, kind: EventKind, text: str) -> None:
        self._emit(Event(time_s=now, kind=kind, text=text))


def _against_offers(plan: RecoveryPlan, scene: Scene | None) -> Verdict | None:
    """Refuses what the stack did not offer in the scene: a behaviour, or a start for a new route."""
    if scene is None:
        return None
    offered = {b.name for b in scene.behaviors}
    lacking = [f"behaviour {b.name} is not offered" for b in plan.behaviors if b.name not in offered]
    if plan.route_start is not None and plan.route_start not in {w.id for w in scene.waypoints}:
        lacking.append(f"waypoint {plan.route_start} is not among the scene's")
    return Verdict(rejects=tuple(Reject(code=RejectCode.PRECONDITION, detail=x) for x in lacking)) if lacking else None
