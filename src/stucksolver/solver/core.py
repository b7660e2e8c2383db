"""What the solver is made of, and what all its parts share: telling, pausing, the start and end of an intervention."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from pathlib import Path

from stucksolver.decision import CONTINUE, Continue, RecoveryPlan, SafeStop
from stucksolver.detect import Detector, DetectorSettings, Trigger
from stucksolver.guard import Approvals, Guard, Verdict
from stucksolver.ladder import Ladder, LadderError, find_ladder
from stucksolver.reason import Reasoner, RuleReasoner
from stucksolver.scene import Guidance, Scene, Status
from stucksolver.solver.asking import Asking
from stucksolver.solver.climb import Climb
from stucksolver.solver.clock import Clock, make_clock
from stucksolver.solver.events import Event, EventKind, Facts, Listener, Witness
from stucksolver.solver.failures import Failures, Signature
from stucksolver.solver.listening import Listening
from stucksolver.solver.panel import Answer, Held
from stucksolver.solver.progress import ProgressWatch
from stucksolver.solver.questions import Desk, Question
from stucksolver.solver.running import Running
from stucksolver.solver.telling import Teller
from stucksolver.solver.timeline import Timeline
from stucksolver.solver.words import Words
from stucksolver.words import WordsReader, find_reader

REFUSAL_M = 50.0
"""So far on, what a passenger refused lies behind: about a braking distance and the length of a queue."""


class Core:
    """The parts and their common state. `StuckSolver` documents the arguments."""

    def __init__(
        self,
        scene: Callable[[], Scene | None],
        *,
        ladder: Ladder | Path | str | None = None,
        reasoner: Reasoner | None = None,
        models: Mapping[str, Reasoner] | None = None,
        reader: WordsReader | None = None,
        guard: Guard | None = None,
        detector: DetectorSettings | None = None,
        clock: Clock | str = "wall",
        on_event: Listener | None = None,
        record: Witness | None = None,
        observe_only: bool = False,
    ) -> None:
        self.ladder = find_ladder(ladder)
        self.guard = guard or Guard(self.ladder.guard_policy())
        laxer = self.guard.policy.laxer_than(self.ladder.guard_policy())
        if laxer:
            raise LadderError(
                f"the guard given asks for less than ladder {self.ladder.name!r} does for: {', '.join(laxer)}; "
                "give a stricter one, or a ladder whose approvals say so and no guard"
            )
        self.clock = make_clock(clock) if isinstance(clock, str) else clock
        reasoners = {"rules": reasoner or RuleReasoner(self.ladder.waits.limits()), **(models or {})}
        self.reasoners: Mapping[str, Reasoner] = reasoners
        self._observe_only = observe_only
        self._detector = Detector(detector)
        self._asking = Asking(scene, reasoners, self.ladder.waits, self.clock, self._detector)
        self._climb = Climb(self.ladder, reasoners, only_reasoners=observe_only)
        self._words_climb = Climb(self.ladder, reasoners, only_reasoners=True)
        self._teller = Teller(on_event, record)
        if record is not None:
            names = {rung: one.name for rung, one in reasoners.items()}
            settings = self._detector.settings
            record.begin(Facts(self.ladder, self.guard.policy, self.clock.name, settings, names, observe_only))
        self._running = Running(self.guard, self._teller)
        self._desk = Desk()
        self._words = Words(self.ladder.words.expire_s)
        self._listening = Listening(reader or find_reader(), self.clock)
        self._asked_back = False
        """Were the last words asked back already?"""
        self._progress = ProgressWatch(self.ladder.hand_back.progress_m)
        self._timeline = Timeline()
        self._failures = Failures(self.ladder.asking.remembered)
        self._approved: dict[Signature, Approvals] = {}
        self._said: str | None = None
        self._for_approval: Answer | None = None
        self._held: Held | None = None
        """A plan that waits for a gap in the traffic."""
        self._driven: Answer | None = None
        """What the plan under way comes from; None for the way to the roadside."""
        self._trigger: Trigger | None = None
        self._refused_m: float | None = None
        """Progress at which the passenger refused what would have been done; None where nothing is refused."""
        self._stop: SafeStop | None = None
        self._blocked_at_stop = False
        self._stays = False
        """Is the vehicle held where a plan was given up, since its driver would turn into what stands there?"""
        self._tried_aside = False
        """Was pulling over tried before the stop?"""
        self._done: tuple[RecoveryPlan, float] | None = None
        """The plan that finished last in this intervention, with the progress at its start."""
        self._begun_m = 0.0
        self._helped = False
        """Has a plan been started since the last recovery?"""
        self._recovered = False
        self._open = False
        self._interventions = 0
        self._fault: str | None = None
        self._engaged = False

    # ---- shared by the parts

    @property
    def _busy(self) -> bool:
        waiting = self._words.now or self._said or self._stop or self._desk.pending
        return (
            waiting is not None
            or self._listening.busy
            or self._running.execution is not None
            or self._asking.busy
            or self._stays
        )

    @property
    def _resting(self) -> Continue | SafeStop:
        """What to do while nothing is performed."""
        return self._stop or CONTINUE

    def _failed(self, now: float, *, counts: bool = True) -> None:
        """Whoever was asked did not help: pause, and count it where it counts."""
        if self._words.now is not None:
            self._words_climb.failed(now, counts=False)
        else:
            self._climb.failed(now, counts=counts)

    def _climb_on(self, now: float) -> None:
        """To the next rung, if there is one."""
        if self._climb.climb(now):
            self._tell(now, EventKind.ESCALATED, f"to the rung {self._climb.rung}")

    # ---- telling

    def _tell(
        self, now: float, kind: EventKind, text: str, *, question: Question | None = None, answer: bool | None = None
    ) -> None:
        self._teller.event(
            Event(
                time_s=self._stack_s(now),
                kind=kind,
                text=text,
                intervention=self._interventions if self._open else None,
                rung=self._climb.rung,
                question=question,
                answer=answer,
            )
        )

    def _tell_words(self, now: float, words: Guidance) -> None:
        """What was said, and what it was read as."""
        self._teller.event(
            Event(
                time_s=self._stack_s(now),
                kind=EventKind.GUIDANCE,
                text=words.text,
                intervention=self._interventions if self._open else None,
                rung=self._climb.rung,
                reading=words.reading,
            )
        )

    def _tell_decision(self, now: float, answer: Answer, verdict: Verdict | None, *, waiting: bool = False) -> None:
        self._teller.event(
            Event(
                time_s=self._stack_s(now),
                kind=EventKind.DECIDED,
                text=answer.decision.rationale,
                intervention=self._interventions if self._open else None,
                rung=self._climb.rung,
                trigger=self._trigger.value if self._trigger else None,
                scene=self._asking.scene,
                reasoner=answer.reasoner,
                decision=answer.decision,
                waiting=waiting,
                trace=answer.trace,
                verdict=verdict,
            )
        )

    def _tell_fault(self, now: float, fault: str | None) -> None:
        """Once for each fault that begins."""
        if fault is not None and fault != self._fault:
            self._tell(now, EventKind.FAULT, fault)
        self._fault = fault

    def _stack_s(self, now: float) -> float:
        """The stack's time for the solver's own."""
        return now - self._timeline.offset_s

    # ---- watching

    def _watch(self, status: Status, trigger: Trigger | None) -> None:
        """Notes progress. A legitimate wait is no immobilization: only an open intervention is."""
        if self._climb.quiet_until_s == math.inf:
            self._refused_m = status.progress_m if self._refused_m is None else self._refused_m
            if status.progress_m - self._refused_m > REFUSAL_M:
                self._climb.quiet_until_s, self._refused_m = status.time_s, None
        else:
            self._refused_m = None
        counted = trigger if self._open else None
        recovered_after = self._progress.update(status, self._onset_s(), counted)
        if recovered_after is None:
            return
        self._recovered = True
        if self._helped:
            far = self.ladder.hand_back.progress_m
            text = f"{far:g} m of new progress, {recovered_after:.1f} s after onset"
            self._tell(status.time_s, EventKind.RECOVERED, text)
        self._helped = False

    def _onset_s(self) -> float | None:
        slow, waited = self._detector.slow_since_s, self._climb.last_wait_s
        return slow if slow is None or waited is None else max(slow, waited)

    def _settle(self, status: Status) -> None:
        """The hand-back is verified, or there is nothing more to do: the counters start anew."""
        over = self._recovered or not self._progress.on or status.at_destination
        if not self._open or self._busy or not over:
            return
        self._tell(status.time_s, EventKind.CLOSED, "the vehicle is on its way" if self._recovered else "done")
        self._open = self._recovered = self._helped = False
        self._done = None
        self._tried_aside = False
        self._climb.reset()
        self._failures = Failures(self.ladder.asking.remembered)
        self._approved.clear()

    def _cleared(self, now: float) -> None:
        """The vehicle goes by itself: nobody need answer any more."""
        self._held = None
        self._climb.moved()
        if self._asking.busy:
            self._asking.drop()
            self._tell(now, EventKind.CANCELLED, "the vehicle moves again")
        question = self._desk.withdraw()
        if question is not None:
            self._tell(now, EventKind.CANCELLED, "the vehicle moves again", question=question)

    def _begin(self, status: Status) -> None:
        """From the first answer on that is no legitimate wait, this is an intervention."""
        if self._open:
            return
        self._open, self._recovered = True, False
        self._interventions += 1
        moving = self._trigger in (None, Trigger.GUIDANCE) and self._detector.slow_since_s is None
        self._progress.update(status, self._onset_s(), None if moving else self._trigger)
