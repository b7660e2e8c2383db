"""One vehicle of the gateway: forwards utterances to its solver, and its state to people."""

from __future__ import annotations

import contextlib
import queue
import re
import time
from collections.abc import Callable

from stucksolver.scene import GuidanceIntent, Scene, Status
from stucksolver.scene.plausibility import status_implausibility
from stucksolver.solver import Question, QuestionError, StuckSolver
from stucksolver.solver.state_machine.state import Standstill
from stucksolver.word_safeguards.restraint import alarm
from stucksolver_passenger.api_types import (
    CommandKind,
    CommandResult,
    OpenNotice,
    OpenQuestion,
    PersonCommand,
    Speaker,
    VehicleReport,
)
from stucksolver_passenger.conversation import Conversation, implies_approval
from stucksolver_passenger.quick_replies import STOP_WORDS, ready_answers
from stucksolver_passenger.sentences.questions import question_text
from stucksolver_passenger.sentences.reasons import standstill_sentence
from stucksolver_passenger.side_texts import report_with_sides_swapped
from stucksolver_passenger.status_summary import OVER, StatusSummary, mind

TELL_EVERY_S = 0.25
"""Interval between two reports of the state (s, the vehicle's clock). Ours."""
LOOK_EVERY_S = 1.0
"""Interval between two scenes made only for the page (s). Ours."""
SHOWN_LINES = 40
"""Number of lines of the conversation in a report. Ours."""
WAITING_WORDS = 8
"""Maximum number of waiting sentences, one per tick. Further ones are rejected with a message. Ours."""
HOLD_S = 5.0
"""Time after a passenger's stop during which utterances of others are rejected (s).

Otherwise they could overrule it at once. Ours.
"""
MOVING_MPS = 0.5
"""Speed below which the car counts as stopped (m/s). Ours."""
LONGEST_WORD = 45
"""Longest word in an utterance (characters): as in English dictionaries.

The interpreter was not trained on longer words and may take them for a yes.
"""
CONTROL = re.compile(r"[\x00-\x1f\x7f-\x9f\u200b-\u200f\u202a-\u202e\u2066-\u2069\ufeff]+")
"""Control and direction marks, which could disguise a line."""
ACCEPTED_REPLY = "Heard."
READ_S = 6.0
"""Time after which an utterance without an interpretation is dropped (s). The solver's own limit is 5 s."""


class VehicleSession:
    """Made by `PassengerGateway.add`.

    Call `tick` once per tick, after `StuckSolver.step`, from the thread that calls `step`.

    Any thread may call `take`. The solver gets at most one sentence per tick, so that none replaces another one before
    its interpretation. A stop precedes all other utterances.
    """

    def __init__(
        self,
        solver: StuckSolver,
        conversation: Conversation,
        publish: Callable[[VehicleReport], None],
        wall_s: Callable[[], float] = time.monotonic,
    ) -> None:
        self._solver = solver
        self._conversation = conversation
        self._publish = publish
        self._wall_s = wall_s
        self._words: queue.Queue[tuple[str, str]] = queue.Queue(WAITING_WORDS)
        self._stop = False
        self._pending_utterance: tuple[int, float] | None = None
        """Number of interpretations at the solver's last utterance, and its time; None after its interpretation."""
        self._speaking = ""
        """The client of the solver's last utterance."""
        self._stopped_by = ""
        self._stopped_s = -HOLD_S
        self._scene: Scene | None = None
        self._looked_s = self._told_s = float("-inf")
        self._time_s = 0.0
        self._ended = False

    def tick(self, status: Status, look: Callable[[], Scene | None] | None = None) -> None:
        """Forward utterances, and send the state to people.

        Args:
            status: The vehicle's status.
            look: Makes a scene; called once a second.
        """
        if status_implausibility(status) is not None:
            # The solver reports the invalid status. People can still stop the vehicle.
            self._forward_utterance()
            self._answer_from_guidance()
            return
        self._time_s = status.time_s
        self._conversation.progress_m = status.progress_m
        self._conversation.moving = status.speed_mps > MOVING_MPS
        self._forward_utterance()
        self._answer_from_guidance()
        if look is not None and status.time_s - self._looked_s >= LOOK_EVERY_S:
            self._looked_s = status.time_s
            self._scene = look()
        if status.time_s - self._told_s >= TELL_EVERY_S:
            self._told_s = status.time_s
            self._publish(self.now(status))

    def end(self) -> None:
        """End the ride and inform people."""
        self._ended = True
        self._conversation.tell(OVER.thought, self._time_s)
        self._publish(self.now(Status(time_s=self._time_s, speed_mps=0.0, progress_m=0.0)))

    def now(self, status: Status) -> VehicleReport:
        """Return the vehicle's state for people."""
        state = self._solver.state
        scene = self._scene or state.scene
        thinks: StatusSummary = OVER if self._ended else mind(state, status, self._conversation.decided, scene)
        question = None if self._ended else self._solver.pending_question
        report = VehicleReport(
            time_s=round(status.time_s, 2),
            speed_mps=round(status.speed_mps, 2),
            state=", ".join(name.value for name in state.names),
            thought=thinks.thought,
            intention=thinks.intention,
            question=None if question is None else _shown(question),
            notice=None if self._ended else _notice(state.standstill, scene),
            answers=() if self._ended else ready_answers(state, question, scene),
            lines=self._conversation.lines(SHOWN_LINES),
            ended=self._ended,
        )
        return report_with_sides_swapped(report) if scene is not None and scene.mirrored else report

    # ---- commands

    def take(self, command: PersonCommand) -> CommandResult:
        """Execute a person's command, or return why not."""
        if self._ended:
            return CommandResult(number=command.number, taken=False, told="The ride is over.")
        taken, reply = self._taken(command)
        return CommandResult(number=command.number, taken=taken, told=reply)

    def _taken(self, command: PersonCommand) -> tuple[bool, str]:
        if command.kind is CommandKind.SAY:
            return self._say(command)
        if command.kind is CommandKind.STOP:
            self._stopped(command.client)
            self._stop = True
            self._conversation.add_utterance(_speaker(command), STOP_WORDS, self._time_s)
            return True, ACCEPTED_REPLY
        if command.kind in (CommandKind.YES, CommandKind.NO):
            return self._answer(command)
        return self._call(command)

    def _say(self, command: PersonCommand) -> tuple[bool, str]:
        text = CONTROL.sub(" ", command.text).strip()
        if not text:
            return False, "You did not say anything."
        if any(len(word) > LONGEST_WORD for word in text.split()):
            return False, "I did not understand that."
        if alarm(text) is not None:  # a call to stop does not queue behind other utterances and has no limit
            self._stopped(command.client)
            self._speaking = command.client
            self._drop_waiting()
            self._solver.guide(text)
            self._conversation.add_utterance(_speaker(command), text, self._time_s)
            return True, ACCEPTED_REPLY
        if self._held(command.client):
            return False, "Somebody else has just told me to stop. I will listen to others again in a few seconds."
        try:
            self._words.put_nowait((text, command.client))
        except queue.Full:
            # The sender gets a sentence, so no utterance is lost silently.
            return False, "That is too much at once. Please wait a moment."
        self._conversation.add_utterance(_speaker(command), text, self._time_s)
        return True, ACCEPTED_REPLY

    def _answer(self, command: PersonCommand) -> tuple[bool, str]:
        yes = command.kind is CommandKind.YES
        if yes and self._held(command.client):
            return False, "Somebody else has just told me to stop. Please answer again in a few seconds."
        answer = self._solver.approve if yes else self._solver.deny
        try:
            answer(command.question_id, command.by)
        except QuestionError as error:
            # The question may have closed meanwhile; the sender gets the reason.
            return False, f"I can't take that answer: {error}."
        self._conversation.add_utterance(_speaker(command), "Yes" if yes else "No", self._time_s)
        return True, ACCEPTED_REPLY

    def _call(self, command: PersonCommand) -> tuple[bool, str]:
        """Handle a call for help or an operator's message.

        They are lines of the conversation and do not reach the solver.
        """
        if command.kind is CommandKind.HELP:
            self._conversation.add_utterance(_speaker(command), "I need help", self._time_s)
            self._conversation.tell("I have called the operator for you.", self._time_s)
            return True, "I have called the operator for you."
        text = CONTROL.sub(" ", command.text).strip()
        if not text:
            return False, "There is nothing to tell."
        self._conversation.add_utterance(Speaker.OPERATOR, text, self._time_s)
        return True, ACCEPTED_REPLY

    # ---- called from the control loop

    def _forward_utterance(self) -> None:
        """Pass one sentence to the solver. A stop comes first and drops the waiting ones."""
        stays, self._conversation.stays = self._conversation.stays, None
        if stays in (GuidanceIntent.WAIT, GuidanceIntent.CANCEL):
            self._stopped(self._speaking)
        if self._stop:
            self._stop = False
            self._drop_waiting()
            self._speaking = self._stopped_by
            self._guide(STOP_WORDS)
        elif not self._is_interpreting():
            # Without a waiting utterance there is nothing to do.
            with contextlib.suppress(queue.Empty):
                text, self._speaking = self._words.get_nowait()
                self._guide(text)

    def _answer_from_guidance(self) -> None:
        """Answer a question that the passenger's own utterance has already answered."""
        question = self._solver.pending_question
        if question is not None and implies_approval(self._solver.state.reading, question):
            # The question may have closed since the check.
            with contextlib.suppress(QuestionError):
                self._solver.approve(question.id, "passenger")

    def _guide(self, text: str) -> None:
        """Pass a sentence to the solver.

        The next one waits until this one is interpreted, so that a resulting stop belongs to a known client.
        """
        self._pending_utterance = (self._conversation.readings, self._wall_s())
        self._solver.guide(text)

    def _drop_waiting(self) -> None:
        """Drop waiting utterances, because they precede the stop."""
        # The loop ends when the queue is empty.
        with contextlib.suppress(queue.Empty):
            while True:
                self._words.get_nowait()

    def _is_interpreting(self) -> bool:
        if self._pending_utterance is not None:
            readings, since_s = self._pending_utterance
            if self._conversation.readings > readings or self._wall_s() - since_s > READ_S:
                self._pending_utterance = None
        return self._pending_utterance is not None

    def _stopped(self, client: str) -> None:
        self._stopped_by, self._stopped_s = client, self._wall_s()

    def _held(self, client: str) -> bool:
        return client != self._stopped_by and self._wall_s() - self._stopped_s < HOLD_S


class VehicleSessions:
    """The vehicles of one process, by id."""

    def __init__(self) -> None:
        self._sessions: dict[str, VehicleSession] = {}

    def add(self, vehicle_id: str, seat: VehicleSession) -> None:
        """Add a vehicle.

        Raises:
            ValueError: The id is already in use.
        """
        if vehicle_id in self._sessions:
            raise ValueError(f"vehicle id already in use: {vehicle_id!r}. Give each vehicle its own id")
        self._sessions[vehicle_id] = seat

    def take(self, vehicle_id: str, command: PersonCommand) -> CommandResult:
        """Pass a command to its vehicle."""
        seat = self._sessions.get(vehicle_id)
        if seat is None:
            return CommandResult(number=command.number, taken=False, told="There is no such vehicle.")
        return seat.take(command)


def _speaker(command: PersonCommand) -> Speaker:
    return Speaker.OPERATOR if command.by == "operator" else Speaker.PASSENGER


def _notice(standstill: Standstill | None, scene: Scene | None) -> OpenNotice | None:
    """Return the notice to the operator, if there is one."""
    told = () if standstill is None else standstill.told
    notice = next((item for item, _ in told if item.to == "operator"), None)
    return None if notice is None else OpenNotice(id=notice.id, text=standstill_sentence(notice.reason, scene))


def _shown(question: Question) -> OpenQuestion:
    return OpenQuestion(
        id=question.id, to=question.to, kind=question.kind, text=question_text(question), needs=question.needs
    )
