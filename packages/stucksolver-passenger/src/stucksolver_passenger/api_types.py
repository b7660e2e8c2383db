"""The types of the HTTP API: reports about a vehicle, and the commands of people."""

from __future__ import annotations

import re
from enum import Enum
from typing import Literal

from pydantic import Field

from stucksolver.ladder.rung_actions import Person
from stucksolver.scene import MAX_WORDS
from stucksolver.scene.base_model import FrozenModel
from stucksolver.solver import QuestionKind

VEHICLE_ID = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,39}")
"""Valid ids of vehicles. They are safe in an address, a file name and a token."""
CLIENT_ID = r"^[A-Za-z0-9_-]{1,40}$"


class Speaker(str, Enum):
    """Author of a line of the conversation."""

    CAR = "car"
    PASSENGER = "passenger"
    OPERATOR = "operator"


class ConversationLine(FrozenModel):
    """One line of the conversation.

    `number` counts from 1 for each vehicle. A line may be sent again when it is complete.
    """

    number: int
    time_s: float
    """Time on the vehicle's clock (s)."""
    speaker: Speaker
    text: str
    understood: str | None = None
    """Interpretation of the utterance, as soon as it exists."""


class QuickReplyKind(str, Enum):
    """Effect of a quick reply."""

    YES = "yes"
    NO = "no"
    SAY = "say"


class QuickReply(FrozenModel):
    """A button that fits the situation. `says` is the utterance that it replaces."""

    does: QuickReplyKind
    label: str
    says: str | None = None


class OpenQuestion(FrozenModel):
    """An open question to a person."""

    id: str
    to: Person
    kind: QuestionKind
    text: str
    needs: tuple[str, ...] = ()
    """Names of behaviors or rules that a yes approves, as in the ladder's approvals."""


class OpenNotice(FrozenModel):
    """A notice to the operator: why the vehicle stands still. It asks nothing."""

    id: str
    text: str


class VehicleReport(FrozenModel):
    """Everything about a vehicle that a page displays as text."""

    time_s: float
    speed_mps: float
    state: str
    """Names of the solver's states, for experts."""
    thought: str
    """Current situation in one sentence."""
    intention: str
    """Next action of the car."""
    question: OpenQuestion | None = None
    notice: OpenNotice | None = None
    answers: tuple[QuickReply, ...] = ()
    lines: tuple[ConversationLine, ...] = ()
    """Last lines of the conversation, the newest last."""
    ended: bool = False
    """True if the ride is over. Then commands are rejected."""


class CommandKind(str, Enum):
    """Commands of people."""

    SAY = "say"
    YES = "yes"
    NO = "no"
    STOP = "stop"
    HELP = "help"
    TELL = "tell"
    """A message of an operator to the passenger. It is displayed and does not affect the driving."""


class PersonCommand(FrozenModel):
    """A person's command to the vehicle's process."""

    number: int
    kind: CommandKind
    by: Person
    client: str = Field(default="somebody", pattern=CLIENT_ID)
    """Distinguishes the holders of the same token. Each page chooses its own."""
    text: str = Field(default="", max_length=MAX_WORDS)
    question_id: str | None = Field(default=None, max_length=40)


class CommandResult(FrozenModel):
    """Result of a command: accepted, or rejected with a sentence for people."""

    number: int
    taken: bool
    told: str


class OperatorCall(FrozenModel):
    """An entry of the operator's queue: a question or notice of a vehicle, or a passenger's call for help."""

    id: str
    vehicle: str
    name: str
    kind: Literal["question", "help", "notice"]
    text: str
    waiting_s: float
    """Waiting time on the server's clock (s)."""
    question_id: str | None = None
    """Id of the question, if the entry is one."""
