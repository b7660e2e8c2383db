"""Makes memory entries from a solver's events: solutions tried in an intervention, their guidance and outcome."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from stucksolver.scene import Guidance
from stucksolver.solver import Event, EventKind, QuestionKind
from stucksolver_passenger.memory.features import SceneFeatures, features_of
from stucksolver_passenger.memory.solution import Solution, solution_of
from stucksolver_passenger.memory.tried_solution import SolutionOutcome, TriedSolution

HOW_CHARACTERS = 300
"""Longest description of a plan in an entry (characters). Ours."""
CREDITED_WITHIN_S = 60.0
"""Longest time between a plan's end and a recovery for which the plan gets the credit (s).

The same bound as in the evaluation.
"""


@dataclass
class OpenTrial:
    """One solution in the open intervention. `begun_s` is the last start of its plan; None before the first."""

    scene: SceneFeatures
    solution: Solution
    words: Guidance | None
    behaviors: tuple[str, ...]
    proposer: str
    begun_s: float | None = None
    ended_s: float | None = None
    finished: bool = False
    """True if its plan finished after its last start."""
    ending: SolutionOutcome = SolutionOutcome.REFUSED
    how: str = ""


@dataclass
class ObservedIntervention:
    """History of the open intervention. `last` is the trial with the latest start."""

    trials: dict[tuple[Solution, bool], OpenTrial] = field(default_factory=dict)
    words: tuple[Guidance, SceneFeatures] | None = None
    """The last guidance with a request, and the scene in which no plan for it was found."""
    decided: OpenTrial | None = None
    last: OpenTrial | None = None
    questions: int = 0


class OutcomeObserver:
    """Receives a solver's events, and passes the entries of each intervention to `keep` when it ends.

    The control loop calls it, so it never blocks. `now_s` returns the seconds since 1970.
    """

    def __init__(self, vehicle: str, keep: Callable[[TriedSolution], None], now_s: Callable[[], float]) -> None:
        self._vehicle = vehicle
        self._keep = keep
        self._now_s = now_s
        self._under_way = ObservedIntervention()

    def hear(self, event: Event) -> None:
        """Receive one event."""
        handler = _HANDLERS.get(event.kind)
        if handler is not None:
            handler(self, event)

    def close(self) -> None:
        """End the drive. A plan without a recovery has failed; a running one is unfinished."""
        self._write()

    # ---- events

    def _decided(self, event: Event) -> None:
        if event.scene is None or event.decision is None:
            return
        plan, words = event.decision.plan, event.scene.guidance
        solution = None if plan is None else solution_of(plan)
        if plan is None or solution is None:
            if words is not None:
                self._under_way.words = (words, features_of(event.scene))
            return
        key = (solution, words is not None)
        trial = self._under_way.trials.get(key)
        if trial is None:
            names = tuple(b.name for b in plan.behaviors)
            trial = OpenTrial(features_of(event.scene), solution, words, names, event.reasoner or "")
            self._under_way.trials[key] = trial
        if event.verdict is not None and not event.verdict.accepted:
            trial.how = str(event.verdict)
        self._under_way.decided = trial

    def _started(self, event: Event) -> None:
        trial = self._under_way.decided
        if trial is None:
            self._under_way.last = None  # the path to the roadside
            return
        trial.begun_s, trial.ended_s, trial.finished = event.time_s, None, False
        trial.ending, trial.how = SolutionOutcome.UNFINISHED, ""
        self._under_way.last = trial

    def _ended(self, event: Event) -> None:
        trial = self._under_way.last
        if trial is not None and trial.ending is SolutionOutcome.UNFINISHED:
            trial.ending, trial.how, trial.ended_s = SolutionOutcome.FAILED, event.text, event.time_s
            trial.finished = event.kind is EventKind.FINISHED

    def _recovered(self, event: Event) -> None:
        """Credit the plan with the latest start, unless it was aborted or ended long ago."""
        trial = self._under_way.last
        if trial is None:
            return
        running = trial.ending is SolutionOutcome.UNFINISHED
        late = trial.ended_s is not None and event.time_s - trial.ended_s > CREDITED_WITHIN_S
        if running or (trial.finished and not late):
            trial.ending, trial.how, trial.ended_s = SolutionOutcome.WORKED, event.text, event.time_s

    def _useless(self, event: Event) -> None:
        trial = self._under_way.last
        if trial is not None and trial.ending is SolutionOutcome.FAILED:
            trial.how, trial.finished = event.text, False

    def _asked(self, event: Event) -> None:
        if event.question is not None and event.question.kind is not QuestionKind.ASSISTANCE:
            self._under_way.questions += 1

    def _denied(self, event: Event) -> None:
        trial = self._under_way.decided
        if event.answer is False and trial is not None and trial.begun_s is None:
            trial.how = event.text

    def _stopped(self, event: Event) -> None:
        """Record a call for help: no earlier plan led to a recovery."""
        self._under_way.last = None

    def _closed(self, event: Event) -> None:
        trial = self._under_way.last
        if trial is not None and trial.finished and trial.words is not None:
            # A request without immobilization was executed, so there is nothing to recover from.
            trial.ending = SolutionOutcome.WORKED
        self._write()

    # ---- writing

    def _write(self) -> None:
        under_way, self._under_way = self._under_way, ObservedIntervention()
        at_s = self._now_s()
        for trial in under_way.trials.values():
            self._keep(self._episode(trial, under_way, at_s))
        if under_way.words is not None and not any(t.words is not None for t in under_way.trials.values()):
            words, scene = under_way.words
            self._keep(
                TriedSolution(
                    at_s=at_s,
                    vehicle=self._vehicle,
                    scene=scene,
                    text=words.text,
                    reading=words.reading,
                    ending=SolutionOutcome.REFUSED,
                    how="nothing was found to do",
                    questions=under_way.questions,
                )
            )

    def _episode(self, trial: OpenTrial, under_way: ObservedIntervention, at_s: float) -> TriedSolution:
        begun, ended = trial.begun_s, trial.ended_s
        return TriedSolution(
            at_s=at_s,
            vehicle=self._vehicle,
            scene=trial.scene,
            text="" if trial.words is None else trial.words.text,
            reading=None if trial.words is None else trial.words.reading,
            solution=trial.solution,
            behaviors=trial.behaviors,
            proposer=trial.proposer[:100],
            ending=trial.ending,
            how=trial.how[:HOW_CHARACTERS],
            questions=under_way.questions,
            took_s=None if begun is None or ended is None else round(ended - begun, 2),
        )


_HANDLERS: dict[EventKind, Callable[[OutcomeObserver, Event], None]] = {
    EventKind.DECIDED: OutcomeObserver._decided,
    EventKind.STARTED: OutcomeObserver._started,
    EventKind.FINISHED: OutcomeObserver._ended,
    EventKind.ABORTED: OutcomeObserver._ended,
    EventKind.RECOVERED: OutcomeObserver._recovered,
    EventKind.INEFFECTIVE: OutcomeObserver._useless,
    EventKind.ASKED: OutcomeObserver._asked,
    EventKind.ANSWERED: OutcomeObserver._denied,
    EventKind.STOPPED: OutcomeObserver._stopped,
    EventKind.CLOSED: OutcomeObserver._closed,
}
