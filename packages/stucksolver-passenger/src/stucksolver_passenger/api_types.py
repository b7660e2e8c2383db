"""The types of the HTTP API: what a page or an app receives about a vehicle, and what people may send it."""

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
"""Valid ids of vehicles: safe in an address, a file name and a token."""
CLIENT_ID = r"^[A-Za-z0-9_-]{1,40}$"


class Speaker(str, Enum):
    """Who said a line of the conversation."""

    CAR = "car"
    PASSENGER = "passenger"
    OPERATOR = "operator"


class ConversationLine(FrozenModel):
    """One line of the conversation. `number` counts from 1 for each vehicle; a line may be sent again when it is
    complete.
    """

    number: int
    time_s: float
    """By the vehicle's clock (s)."""
    speaker: Speaker
    text: str
    understood: str | None = None
    """How the words were understood, once they are."""


class QuickReplyKind(str, Enum):
    """What a ready answer does."""

    YES = "yes"
    NO = "no"
    SAY = "say"


class QuickReply(FrozenModel):
    """A button that fits the situation. `says` are the words that it stands for."""

    does: QuickReplyKind
    label: str
    says: str | None = None


class OpenQuestion(FrozenModel):
    """The open question to a person."""

    id: str
    to: Person
    kind: QuestionKind
    text: str
    needs: tuple[str, ...] = ()
    """What a yes would release: names of behaviors or of rules, as in the ladder's approvals."""


class VehicleReport(FrozenModel):
    """Everything about a vehicle that a page shows in words."""

    time_s: float
    speed_mps: float
    state: str
    """The names of the solver's states, for those who know them."""
    thought: str
    """What is going on, in a sentence."""
    intention: str
    """What the car will do next."""
    question: OpenQuestion | None = None
    answers: tuple[QuickReply, ...] = ()
    lines: tuple[ConversationLine, ...] = ()
    """The conversation's last lines, the newest last."""
    ended: bool = False
    """True if the ride is over: nothing more is accepted."""


class CommandKind(str, Enum):
    """What people can do."""

    SAY = "say"
    YES = "yes"
    NO = "no"
    STOP = "stop"
    HELP = "help"
    TELL = "tell"
    """An operator's words to the passenger; they are shown and do not affect the driving."""


class PersonCommand(FrozenModel):
    """A person's command, on its way to the vehicle's process."""

    number: int
    kind: CommandKind
    by: Person
    client: str = Field(default="somebody", pattern=CLIENT_ID)
    """Tells apart the holders of the same token; chosen by each page."""
    text: str = Field(default="", max_length=MAX_WORDS)
    question_id: str | None = Field(default=None, max_length=40)


class CommandResult(FrozenModel):
    """The result of a command: taken or not, and why not, in a sentence for people."""

    number: int
    taken: bool
    told: str


class OperatorCall(FrozenModel):
    """An entry of the operator's queue: a vehicle's question, or a passenger's call for help."""

    id: str
    vehicle: str
    name: str
    kind: Literal["question", "help"]
    text: str
    waiting_s: float
    """How long it has waited (s), by the server's clock."""
    question_id: str | None = None
    """For a question: its id."""
