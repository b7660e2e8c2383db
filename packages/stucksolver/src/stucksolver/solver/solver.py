"""`StuckSolver`: the object that a driving stack owns. It monitors, queries, checks and returns directives."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Generic, TypeVar

from stucksolver.guard import Guard
from stucksolver.immobilization import Detector, DetectorSettings, Trigger
from stucksolver.interpreter import Interpreter, NoInterpreter, find_reader
from stucksolver.ladder import Ladder, LadderError, find_ladder
from stucksolver.ladder.rung_actions import FIRST_REASONER, Person
from stucksolver.plan import CONTINUE, Directive
from stucksolver.reasoners import Reasoner
from stucksolver.reasoners.factory import make_reasoner
from stucksolver.reasoners.search import SearchReasoner
from stucksolver.scene import MAX_WORDS, Scene, Status, Surroundings
from stucksolver.scene.bounded_values import MalformedError, read_again
from stucksolver.scene.wording import in_one_line
from stucksolver.solver.camera_health import CameraHealth
from stucksolver.solver.event_bus import EventBus
from stucksolver.solver.events import Event, EventKind, Listener
from stucksolver.solver.launch_acceleration import LaunchAcceleration
from stucksolver.solver.monotonic_time import MonotonicTime
from stucksolver.solver.questions import Question, QuestionDesk
from stucksolver.solver.side_texts import swapped_guidance, swapped_question
from stucksolver.solver.situation_text import situation_text
from stucksolver.solver.state_machine.guidance import answerable_question
from stucksolver.solver.state_machine.inputs import Inputs, SceneInput, SolverSetup, SurroundingsInput
from stucksolver.solver.state_machine.pending_transition import BLIND_LIMIT_S
from stucksolver.solver.state_machine.state import Executing, Monitoring, Querying, State
from stucksolver.solver.state_machine.transition import first_state, transition
from stucksolver.solver.status_watch import StatusWatch
from stucksolver.solver.step_listener import SolverInfo, StepListener, TransitionStep
from stucksolver.solver.surroundings_monitor import Read, SurroundingsMonitor
from stucksolver.solver.workers.delivery_clock import DeliveryClock, make_clock
from stucksolver.solver.workers.interpreter_worker import InterpreterWorker
from stucksolver.solver.workers.reasoner_pool import ReasonerPool
from stucksolver.solver.workers.reasoner_worker import ReasonerWorker

T = TypeVar("T")
BRIEF_S = 1.0
"""Longest time with unusable statuses that changes nothing (s): `DetectorSettings.dwell_s`."""
ASK_BACK = "I did not understand that. Shall I wait, drive on, pass, or take another route?"
"""Question to the passenger after an utterance that was not understood."""


class CallOnce(Generic[T]):
    """Function that is called at most once. `result` is its result, None before the call."""

    def __init__(self, make: Callable[[], T]) -> None:
        self._make = make
        self.result: T | None = None

    def __call__(self) -> T:
        if self.result is None:
            self.result = self._make()
        return self.result


MakeScene = Callable[[Surroundings], "Scene | None"]
"""Builds the scene for a reasoner. The stack adds its route, its lanes and its behaviors to the surroundings."""


class StuckSolver:
    """Solver that gets an immobilized vehicle moving again.

    Create one solver, call `step` on every tick, and perform the directive that it returns. `step`, `scene` and
    `surroundings` run in the caller's thread; reasoners run in their own. `guide`, `approve` and `deny` may be called
    from any thread.

    This class owns threads, clocks and monitors. All decisions are made by
    `stucksolver.solver.state_machine.transition`, a pure function of a state and the inputs of a tick.

    Args:
        scene: Builds the scene for a reasoner from the surroundings that the guard reads; may return None.
        ladder: Escalation policy: the name of a profile, a file, or a `Ladder`.
        reasoner: Replacement of the built-in search: a reasoner, or its name, such as `openai:MODEL`.
        models: Reasoners for the other rungs of the ladder, by the names that the ladder uses.
        reader: Interpreter of the passenger's utterances. Default: the network that ships with the package, if its
            packages are installed.
        guard: Checker of every plan. Default: a guard with the ladder's policy. It must not be laxer than that.
        detector: Thresholds of an immobilization.
        clock: Delivery of answers: `wall`, `lockstep`, `latency:SECONDS`, `latency:measured`, or a `DeliveryClock`.
        on_event: Called with every event.
        record: Step listener that receives everything that is needed to derive each step again.
        observe_only: True to check plans, but never perform them, and ask no person.
        vehicle_id: Stable id of the vehicle. It seeds the draw that ends a standoff with another vehicle of its kind.

    Raises:
        LadderError: The ladder cannot be read, or the guard is laxer than the ladder's policy.
        ReasonerNameError: The reasoner is unknown, or cannot be created.
        ValueError: The clock is unknown, or no rung of the ladder can be used.
    """

    def __init__(
        self,
        scene: MakeScene,
        *,
        ladder: Ladder | Path | str | None = None,
        reasoner: Reasoner | str | None = None,
        models: Mapping[str, Reasoner] | None = None,
        reader: Interpreter | None = None,
        guard: Guard | None = None,
        detector: DetectorSettings | None = None,
        clock: DeliveryClock | str = "wall",
        on_event: Listener | None = None,
        record: StepListener | None = None,
        observe_only: bool = False,
        vehicle_id: str = "",
    ) -> None:
        self.ladder = find_ladder(ladder)
        self.guard = guard or Guard(self.ladder.guard_policy())
        laxer = self.guard.policy.laxer_than(self.ladder.guard_policy())
        if laxer:
            raise LadderError(
                f"the guard requires less approval than ladder {self.ladder.name!r} for: {', '.join(laxer)}; "
                "give a stricter guard, or a ladder with these approvals and no guard"
            )
        self.clock = make_clock(clock) if isinstance(clock, str) else clock
        first = make_reasoner(reasoner) if isinstance(reasoner, str) else reasoner
        reasoners = {FIRST_REASONER: first or SearchReasoner(self.ladder.waits.limits()), **(models or {})}
        self.reasoners: Mapping[str, Reasoner] = reasoners
        names = {rung: item.name for rung, item in reasoners.items()}
        self._stack_scene = scene
        self._detector = Detector(detector)
        self._timeline = MonotonicTime()
        self._status = StatusWatch(self._timeline)
        self._senses = SurroundingsMonitor(self.guard.policy.controls)
        self._launches = LaunchAcceleration()
        self._driver_drives = True
        self._camera = CameraHealth()
        self._bus = EventBus(on_event, record)
        self._reasoner = ReasonerWorker(ReasonerPool(reasoners, self.ladder.waits), self.guard, self.clock)
        self._reader = InterpreterWorker(reader or find_reader(), self.clock)
        self._desk = QuestionDesk()
        self._utterances: deque[str] = deque()
        """Utterances since the last step; filled by any thread."""
        interpreter = self._reader.reader
        ask_back = interpreter.why if isinstance(interpreter, NoInterpreter) else ASK_BACK
        settings = self._detector.settings
        self._setup = SolverSetup(self.guard, self.ladder, names, ask_back, observe_only, settings, vehicle_id)
        self._state = first_state(self.ladder, frozenset(reasoners), observe_only=observe_only)
        if record is not None:
            clock, policy = self.clock.name, self.guard.policy
            record.begin(SolverInfo(self.ladder, policy, clock, settings, names, ask_back, observe_only, vehicle_id))

    # ---- called by the stack, a web page, or an operator's desk

    def step(self, status: Status, surroundings: Read | Callable[[], Surroundings]) -> Directive:
        """Return the directive for this tick. Returns at once, except with a lockstep clock.

        Args:
            status: Time (s), speed (m/s) and progress along the route (m) of the ego.
            surroundings: Returns the surroundings in the local frame of their road, or None if there are none. Called
                only when the ego may be immobilized and while a plan runs.

        Returns:
            `Continue` if the stack should drive by itself, otherwise the directive to perform.
        """
        followed = self._status.follow(status)
        if self._status.fault is not None:
            return self._without_status(followed, surroundings)
        assert followed is not None, "a status without a fault is followed"
        status = followed
        self._launches.update(status, own=self._driver_drives)
        self._driver_drives = True
        trigger = self._detector.update(status)
        idle = trigger is None and not self._utterances and self._timeline.jump_s is None
        if idle and not self._state.engaged and not self._reader.busy:
            return CONTINUE
        return self._take_step(status, trigger, CallOnce(lambda: self._look(surroundings, status.time_s)))

    @property
    def state(self) -> State:
        """Current state, a frozen value."""
        return self._state

    @property
    def detector_settings(self) -> DetectorSettings:
        """Thresholds of an immobilization."""
        return self._detector.settings

    def guide(self, text: str) -> None:
        """Store an utterance at any time. Utterances count from the next step on, in their order.

        A call to stop counts first, and no other utterance at about the same time undoes it.

        Args:
            text: Utterance of the passenger; cut after `MAX_WORDS` characters.
        """
        self._utterances.append(text[:MAX_WORDS])

    @property
    def pending_question(self) -> Question | None:
        """Open question to a person, or None."""
        question = self._desk.pending
        return swapped_question(question) if question is not None and self._bus.mirrored else question

    def approve(self, question_id: str | None = None, by: Person = "passenger") -> None:
        """Reply yes to the open question; the reply counts from the next step on.

        Args:
            question_id: Id of the question, or None for the open one.
            by: Person who replies.

        Raises:
            QuestionError: No question is open, another question is open, or the question is for another person.
        """
        self._desk.reply(True, question_id, by)

    def deny(self, question_id: str | None = None, by: Person = "passenger") -> None:
        """Reply no to the open question; the reply counts from the next step on.

        Args:
            question_id: Id of the question, or None for the open one.
            by: Person who replies.

        Raises:
            QuestionError: No question is open, another question is open, or the question is for another person.
        """
        self._desk.reply(False, question_id, by)

    def close(self) -> None:
        """Drop the running query. No further query starts unless `step` is called again."""
        if isinstance(self._state.activity, Querying):
            self._state = replace(self._state, activity=Monitoring())
        self._update_worker()

    def __enter__(self) -> StuckSolver:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # ---- the tick

    def _without_status(self, last: Status | None, surroundings: Read) -> Directive:
        """Return the directive for a tick without a usable status: the vehicle is left to its driver.

        No plan begins. A running plan is supervised with the last status and the surroundings for a limited time. Then
        it ends like a plan without surroundings. Other activities pause for a short time, and then end, too.
        """
        why = self._status.fault
        assert why is not None
        if self._status.is_news():
            intervention, rung = self._state.intervention, self._state.escalation.rung
            number = None if intervention is None else intervention.number
            time_s = (self._timeline.now_s or 0.0) - self._timeline.offset_s
            text = f"{why}. Until then the vehicle is left to its driver"
            self._bus.fault(Event(time_s=time_s, kind=EventKind.FAULT, text=text, intervention=number, rung=rung))
        bad_s, executes = self._status.bad_s, isinstance(self._state.activity, Executing)
        if last is None or (bad_s <= BRIEF_S and not executes):
            return self._state.posture.directive
        if bad_s > BRIEF_S:
            self._detector.forget()
        if not (self._state.engaged or self._reader.busy):
            return CONTINUE
        runs = executes and bad_s <= BLIND_LIMIT_S
        # The fault was reported above, so the input has no fault.
        look = CallOnce(lambda: self._look(surroundings, last.time_s) if runs else SurroundingsInput(None, None, bad_s))
        return self._take_step(last, None, look)

    def _take_step(self, status: Status, trigger: Trigger | None, look: CallOnce[SurroundingsInput]) -> Directive:
        """Run one transition and act on its result.

        The order matters. The question is opened before the worker starts, and the detector is reset before its next
        update. Listeners come last, so that an error in them cannot change the step.
        """
        scene = CallOnce(lambda: self._snapshot(status, look()))
        inputs = self._inputs(status, trigger, look, scene)
        before = self._state
        self._state, directive, outputs = transition(before, inputs, self._setup)
        self._desk.show(self._state.question)
        if self._state.detector_ignored_until_s != before.detector_ignored_until_s:
            self._detector.forget()
        self._update_worker()
        self._driver_drives = directive == CONTINUE
        self._bus.step(TransitionStep(before, inputs, look.result, scene.result, self._state, directive, outputs))
        return directive

    def _inputs(
        self, status: Status, trigger: Trigger | None, look: CallOnce[SurroundingsInput], scene: CallOnce[SceneInput]
    ) -> Inputs:
        """Return the inputs of this tick. Utterances and answers leave their threads when the clock permits."""
        now = status.time_s
        if self._utterances:
            snapshot, question = scene().scene, answerable_question(self._state)
            if question is not None and self._bus.mirrored:
                question = swapped_question(question)
            situation = situation_text(snapshot, question.text if question else None)
            while self._utterances:
                self._reader.take(self._utterances.popleft(), now - self._timeline.offset_s, now, situation)
        guidance = self._reader.poll(now)
        if guidance is not None and self._bus.mirrored:
            guidance = swapped_guidance(guidance)
        answer = self._reasoner.poll(now)
        return Inputs(
            status=status,
            look=look,
            scene=scene,
            trigger=trigger,
            slow_since_s=self._detector.slow_since_s,
            progress_in_window_m=self._detector.progress_in_window_m,
            offset_s=self._timeline.offset_s,
            jump_s=self._timeline.jump_s,
            heard=guidance,
            hearing=self._reader.busy,
            reply=self._desk.take(),
            answer=answer,
            busy=self._reasoner.at_work(),
        )

    def _look(self, read: Read, now_s: float) -> SurroundingsInput:
        surroundings = self._senses.look(read, now_s, now_s - self._timeline.offset_s)
        if surroundings is not None:
            self._bus.mirrored = surroundings.road.mirrored
            surroundings = self._launches.with_measured_acceleration(surroundings)
        return SurroundingsInput(surroundings, self._senses.fault, self._senses.blind_s(now_s))

    def _snapshot(self, status: Status, sight: SurroundingsInput) -> SceneInput:
        """Build the scene from the same surroundings that the guard reads at this tick."""
        if sight.surroundings is None:
            return SceneInput(None, sight.fault or "nothing has been seen yet")
        try:
            scene = self._stack_scene(sight.surroundings)
        except Exception as error:  # noqa: BLE001 - a stack's own fault, of whatever type, must not end the control loop
            return SceneInput(None, f"the stack's scene raised {in_one_line(error)}")
        if scene is None:
            return SceneInput(None, "the stack has no scene to give")
        try:
            read_again(scene, Scene)
        except MalformedError as error:
            return SceneInput(None, f"the stack's scene cannot be used: {error}")
        scene, fault = self._camera.checked(scene, status.progress_m)
        return SceneInput(scene, camera_fault=fault)

    def _update_worker(self) -> None:
        """Start the reasoner on the query in the state, and stop any other query."""
        activity = self._state.activity
        self._reasoner.work_on(activity.query if isinstance(activity, Querying) else None)
