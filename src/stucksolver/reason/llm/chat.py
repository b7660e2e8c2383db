"""What any vendor's chat API comes down to: messages and one tool in, a reply or a typed failure out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import Any, Literal, Protocol

from stucksolver.reason.reasoner import ReasonerError
from stucksolver.scene import CameraImage


@dataclass(frozen=True)
class ToolCall:
    """A function call that the model asks for; `arguments` is JSON as the model wrote it, unchecked."""

    id: str
    name: str
    arguments: str


@dataclass(frozen=True)
class Message:
    """One turn. `image` only with a user's turn; `calls` are what an assistant asked for; `call_id` answers one."""

    role: Literal["system", "user", "assistant", "tool"]
    text: str
    image: CameraImage | None = None
    calls: tuple[ToolCall, ...] = ()
    call_id: str | None = None


@dataclass(frozen=True)
class Tool:
    """A function with the JSON Schema of its arguments, within the subset that strict structured output takes."""

    name: str
    description: str
    parameters: dict[str, Any] = field(hash=False)


@dataclass(frozen=True)
class Usage:
    """Tokens that a query cost; `cached_tokens` of the input were read from the provider's prompt cache."""

    input_tokens: int
    output_tokens: int
    cached_tokens: int = 0

    def __add__(self, other: Usage) -> Usage:
        return Usage(
            self.input_tokens + other.input_tokens,
            self.output_tokens + other.output_tokens,
            self.cached_tokens + other.cached_tokens,
        )


class Finish(str, Enum):
    """Why an answer ends."""

    WHOLE = "whole"
    CUT_OFF = "cut_off"
    """At the limit of tokens."""
    UNTOLD = "untold"


@dataclass(frozen=True)
class ChatReply:
    """What came back: text, calls, or both. `usage` is None where the server does not count.

    `saw`: False where the server takes no pictures, so that none was sent.
    """

    text: str
    calls: tuple[ToolCall, ...]
    usage: Usage | None
    model: str
    finish: Finish = Finish.UNTOLD
    saw: bool = True


class ChatModel(Protocol):
    """A vendor's API. One file implements it for each."""

    @property
    def name(self) -> str:
        """As in results: vendor and model."""

    def chat(
        self, messages: Sequence[Message], tools: Sequence[Tool], must_call: str | None, limit_s: float
    ) -> ChatReply:
        """One exchange that ends within `limit_s` seconds. `must_call` names the tool that has to be called.

        Raises `TryAgain` for what may pass by itself, `GiveUp` for what needs a person or another model.
        """

    def cancel(self) -> None:
        """End the running `chat` from another thread, by `GiveUp`; nothing where none runs."""


class Trouble(Enum):
    """What kind of failure it is that may pass."""

    BUSY = "busy"
    """The server says so, and may say for how long."""
    LATE = "late"
    """No answer in time; what was asked is paid for all the same."""
    AWAY = "away"
    """Nobody there, or the connection broke."""
    BROKEN = "broken"
    """It answered an error of its own, or nonsense; once more is enough to see whether that stays."""


class TryAgain(ReasonerError):
    """It may pass by itself; `after_s` is how long the server asks us to wait, if it does."""

    def __init__(self, text: str, trouble: Trouble = Trouble.BUSY, after_s: float | None = None) -> None:
        super().__init__(text)
        self.trouble, self.after_s = trouble, after_s


class GiveUp(ReasonerError):
    """Asking again will not help; the message says what to set or do.

    `lasting`: nor will another question, until a person has done that. `paid`: the question was sent, and costs.
    """

    def __init__(self, text: str, *, lasting: bool = False, paid: bool = False) -> None:
        super().__init__(text)
        self.lasting, self.paid = lasting, paid
