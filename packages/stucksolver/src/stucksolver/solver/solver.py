"""`StuckSolver`: the object that a driving stack owns. It watches, asks, checks and gives directives."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Generic, TypeVar

from stucksolver.guard import Guard
from stucksolver.immobilization import Detector, DetectorSettings, Trigger
from stucksolver.interpreter import Interpreter, NoInterpreter, find_reader
from stucksolver.ladder import Ladder, LadderError, find_ladder
from stucksolver.ladder.rung_actions import Person
from stucksolver.plan import CONTINUE, Directive
from stucksolver.reasoners import Reasoner, RuleReasoner
from stucksolver.reasoners.factory import make_reasoner
from stucksolver.scene import MAX_WORDS, Scene, Status, Surroundings
from stucksolver.scene.bounded_values import MalformedError, read_again
from stucksolver.scene.wording import in_one_line
from stucksolver.solver.camera_health import CameraHealth
from stucksolver.solver.event_bus import EventBus
from stucksolver.solver.events import Event, EventKind, Listener
from stucksolver.solver.launch_acceleration import LaunchAcceleration
from stucksolver.solver.monotonic_time import MonotonicTime
from stucksolver.solver.questions import Question, QuestionDesk
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
"""A status that cannot be used for no longer than this changes nothing (s): as long as `DetectorSettings.dwell_s`."""
ASK_BACK = "I did not understand that. Shall I wait, drive on, go round, or take another way?"


class CallOnce(Generic[T]):
    """A function that is called at most once. `made` is its result, None before the call."""

    def __init__(self, make: Callable[[], T]) -> None:
        self._make = make
        self.made: T | None = None

    def __call__(self) -> T:
        if self.made is None:
            self.made = self._make()
        return self.made


MakeScene = Callable[[Surroundings], "Scene | None"]
"""Builds the scene for a reasoner: the stack adds its route, its lanes and its behaviors to the surroundings."""


class StuckSolver:
    """Gets a stuck vehicle moving again. Make one, call `step` on every tick, and perform the directive it returns.

    `step`, `scene` and `surroundings` run in the caller's thread; reasoners run in their own. `guide`, `approve` and
    `deny` may be called from any thread.

    This class owns threads, clocks and senses. All decisions are made by
    `stucksolver.solver.state_machine.transition`, a pure function of a state and the inputs of a tick.

    Args:
        scene: Builds the scene for a reasoner from the surroundings that the guard sees; may return None.
        ladder: The escalation policy: the name of a profile, a file, or a `Ladder`.
        reasoner: Replaces the built-in rules: a reasoner, or the name of one, such as `distilled`.
        models: Reasoners for the other rungs of the ladder, by the names that the ladder uses.
        reader: Reads the passenger's words. Default: the network that ships with the package, if its packages are
            installed.
        guard: Checks every plan. Default: a guard with the ladder's policy. It must not be laxer than that.
        detector: What counts as immobilized.
        clock: When answers are delivered: `wall`, `lockstep`, `latency:SECONDS`, `latency:measured`, or a
        `DeliveryClock`. on_event: Called with every event. record: Receives everything that is needed to derive each
        step again. observe_only: Judge plans, but never perform them and ask nobody.

    Raises:
        LadderError: The ladder cannot be read, or the guard is laxer than the ladder's policy.
        ReasonerNameError: There is no such reasoner, or the weights of the student are missing or of another version.
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
        first = make_reasoner(reasoner) if isinstance(reasoner, str) else reasoner
        given = {"rules": first or RuleReasoner(self.ladder.waits.limits()), **(models or {})}
        students = {name: make_reasoner(name) for name in self.ladder.students() if name not in given}
        reasoners = {**given, **students}
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
        self._said: deque[str] = deque()
        """What was said since the last step; filled by any thread."""
        unread = self._reader.reader
        ask_back = unread.why if isinstance(unread, NoInterpreter) else ASK_BACK
        self._setup = SolverSetup(self.guard, self.ladder, names, ask_back, observe_only)
        self._state = first_state(self.ladder, frozenset(reasoners), observe_only=observe_only)
        if record is not None:
            settings = self._detector.settings
            clock, policy = self.clock.name, self.guard.policy
            record.begin(SolverInfo(self.ladder, policy, clock, settings, names, ask_back, observe_only))

    # ---- called by the stack, a web page, or an operator's desk

    def step(self, status: Status, surroundings: Read | Callable[[], Surroundings]) -> Directive:
        """Return what the stack should do at this tick. Returns at once, except with a lockstep clock.

        Args:
            status: Time (s), speed (m/s) and progress along the route (m) of the ego.
            surroundings: Returns the surroundings in the local frame of their road, or None if there are none. Called
                only when something may be wrong and while a plan runs.

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
        idle = trigger is None and not self._said and self._timeline.jump_s is None
        if idle and not self._state.engaged and not self._reader.busy:
            return CONTINUE
        return self._take_step(status, trigger, CallOnce(lambda: self._look(surroundings, status.time_s)))

    @property
    def state(self) -> State:
        """The current state, a frozen value."""
        return self._state

    @property
    def detector_settings(self) -> DetectorSettings:
        """What counts as immobilized."""
        return self._detector.settings

    def guide(self, text: str) -> None:
        """Take a person's words at any time; they count from the next step on, in the order in which they were said.

        A call to stop counts first, and whatever else is said at about the same time does not undo it.

        Args:
            text: What the passenger said; cut after `MAX_WORDS` characters.
        """
        self._said.append(text[:MAX_WORDS])

    @property
    def pending_question(self) -> Question | None:
        """The open question to a person, or None."""
        return self._desk.pending

    def approve(self, question_id: str | None = None, by: Person = "passenger") -> None:
        """Say yes to the open question; it counts from the next step on.

        Args:
            question_id: Id of the question, or None for the open one.
            by: Who answers.

        Raises:
            QuestionError: Nothing is asked, another question is open, or it is for another person.
        """
        self._desk.reply(True, question_id, by)

    def deny(self, question_id: str | None = None, by: Person = "passenger") -> None:
        """Say no to the open question; it counts from the next step on.

        Args:
            question_id: Id of the question, or None for the open one.
            by: Who answers.

        Raises:
            QuestionError: Nothing is asked, another question is open, or it is for another person.
        """
        self._desk.reply(False, question_id, by)

    def close(self) -> None:
        """Drop the question under way. Nothing more is asked unless `step` is called again."""
        if isinstance(self._state.activity, Querying):
            self._state = self._state.evolve(activity=Monitoring())
        self._put_to_work()

    def __enter__(self) -> StuckSolver:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # ---- the tick

    def _without_status(self, last: Status | None, surroundings: Read) -> Directive:
        """Handle a tick without a usable status: the vehicle is left to its driver.

        Nothing begins. A running plan is supervised with the last status and the surroundings for a limited time, and
        then ends like one whose surroundings are missing. Everything else rests for a moment, and then ends, too.
        """
        why = self._status.fault
        assert why is not None
        if self._status.is_news():
            under_way, rung = self._state.intervention, self._state.escalation.rung
            number = None if under_way is None else under_way.number
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
        # The fault was reported above, so the sight names none.
        look = CallOnce(lambda: self._look(surroundings, last.time_s) if runs else SurroundingsInput(None, None, bad_s))
        return self._take_step(last, None, look)

    def _take_step(self, status: Status, trigger: Trigger | None, look: CallOnce[SurroundingsInput]) -> Directive:
        """Run one transition and act on its result."""
        scene = CallOnce(lambda: self._snapshot(status, look()))
        inputs = self._inputs(status, trigger, look, scene)
        before = self._state
        self._state, directive, told = transition(before, inputs, self._setup)
        self._desk.show(self._state.question)
        if self._state.detector_ignored_until_s != before.detector_ignored_until_s:
            self._detector.forget()
        self._put_to_work()
        self._driver_drives = directive == CONTINUE
        self._bus.step(TransitionStep(before, inputs, look.made, scene.made, self._state, directive, told))
        return directive

    def _inputs(
        self, status: Status, trigger: Trigger | None, look: CallOnce[SurroundingsInput], scene: CallOnce[SceneInput]
    ) -> Inputs:
        """Collect the inputs of this tick. Words and answers are taken from their threads when the clock delivers
        them.
        """
        now = status.time_s
        if self._said:
            question = answerable_question(self._state)
            situation = situation_text(scene().scene, question.text if question else None)
            while self._said:
                self._reader.take(self._said.popleft(), now - self._timeline.offset_s, now, situation)
        heard = self._reader.poll(now)
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
            heard=heard,
            hearing=self._reader.busy,
            reply=self._desk.take(),
            answer=answer,
            busy=self._reasoner.at_work(),
        )

    def _look(self, read: Read, now_s: float) -> SurroundingsInput:
        seen = self._senses.look(read, now_s, now_s - self._timeline.offset_s)
        seen = None if seen is None else self._launches.with_measured_acceleration(seen)
        return SurroundingsInput(seen, self._senses.fault, self._senses.blind_s(now_s))

    def _snapshot(self, status: Status, sight: SurroundingsInput) -> SceneInput:
        """Build the scene from the same surroundings that the guard sees at this tick."""
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

    def _put_to_work(self) -> None:
        """Start the reasoner on the question in the state, and stop any other question."""
        activity = self._state.activity
        self._reasoner.work_on(activity.query if isinstance(activity, Querying) else None)
