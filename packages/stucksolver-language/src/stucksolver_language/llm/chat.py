"""Interface to any vendor's chat API: messages and tools in, a reply or a typed failure out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import Any, Literal, Protocol

from stucksolver.reasoners.reasoner import ReasonerError
from stucksolver.scene import CameraImage


@dataclass(frozen=True)
class ToolCall:
    """A function call that the model requests. `arguments` is JSON as the model wrote it, unchecked.

    `extra` is data of the provider that must come back with the call, such as a signature of the model's thoughts.
    """

    id: str
    name: str
    arguments: str
    extra: dict[str, Any] = field(default_factory=dict, hash=False)


@dataclass(frozen=True)
class Message:
    """One turn.

    Only a user's turn has an `image`, and only an assistant's has `calls`. `call_id` names the answered call. `extra`
    is data of the provider that must come back with the calls, such as the model's thoughts.
    """

    role: Literal["system", "user", "assistant", "tool"]
    text: str
    image: CameraImage | None = None
    calls: tuple[ToolCall, ...] = ()
    call_id: str | None = None
    extra: dict[str, Any] = field(default_factory=dict, hash=False)


@dataclass(frozen=True)
class Tool:
    """A function with the JSON Schema of its arguments, within the subset of strict structured output."""

    name: str
    description: str
    parameters: dict[str, Any] = field(hash=False)


@dataclass(frozen=True)
class Usage:
    """Tokens used by a query. `cached_tokens` is the part of the input read from the provider's prompt cache."""

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
    """Reason why an answer ended."""

    WHOLE = "whole"
    CUT_OFF = "cut_off"
    """The answer reached the token limit."""
    UNTOLD = "untold"


@dataclass(frozen=True)
class ChatReply:
    """Reply with text, calls, or both. `usage` is None if the server does not count tokens.

    `saw` is False if no image was sent because the server accepts none. `thoughts` are those that the server separates
    from the text. `raw` is the response as it came, without keys, for the record. `extra` belongs to the calls, as in
    `Message`.
    """

    text: str
    calls: tuple[ToolCall, ...]
    usage: Usage | None
    model: str
    finish: Finish = Finish.UNTOLD
    saw: bool = True
    thoughts: str = ""
    raw: str = ""
    extra: dict[str, Any] = field(default_factory=dict, hash=False)


class ChatModel(Protocol):
    """API of a vendor. Each vendor has its own file."""

    @property
    def name(self) -> str:
        """Name in results: vendor and model."""

    def chat(
        self, messages: Sequence[Message], tools: Sequence[Tool], must_call: str | None, limit_s: float
    ) -> ChatReply:
        """Run one exchange.

        Args:
            messages: The conversation up to now.
            tools: The functions that the model may call.
            must_call: Name of the function that must be called, if any.
            limit_s: Wall time for the exchange (s).

        Raises:
            TransientReasonerError: The failure may be temporary.
            PermanentReasonerError: The failure is permanent: it needs a person or another model.
        """

    def cancel(self) -> None:
        """End the running `chat` from another thread with `PermanentReasonerError`.

        Without a running `chat`, do nothing.
        """


class TransientKind(Enum):
    """Kinds of failures that may be temporary."""

    BUSY = "busy"
    """The server reports that it is busy, possibly with the time to wait."""
    LATE = "late"
    """The answer was late. The query costs money all the same."""
    AWAY = "away"
    """No server responds at the address, or the connection broke."""
    BROKEN = "broken"
    """The server reported an internal error or sent an invalid answer. One retry shows whether the failure persists."""


class TransientReasonerError(ReasonerError):
    """The failure may be temporary. `after_s` is the time to wait that the server reported (s), or None."""

    raw: str = ""
    """The response as it came, without keys, for the record; empty without one."""
    usage: Usage | None = None
    """Tokens that the server stated for the failed exchange; None if it stated none."""

    def __init__(self, text: str, trouble: TransientKind = TransientKind.BUSY, after_s: float | None = None) -> None:
        super().__init__(text)
        self.trouble, self.after_s = trouble, after_s


class PermanentReasonerError(ReasonerError):
    """A retry cannot succeed. The message says what to set or do.

    `lasting`: other queries will fail too until a person acts. `paid`: the query was sent and costs money.
    """

    raw: str = ""
    """The response as it came, without keys, for the record; empty without one."""
    usage: Usage | None = None
    """Tokens that the server stated for the failed exchange; None if it stated none."""

    def __init__(self, text: str, *, lasting: bool = False, paid: bool = False) -> None:
        super().__init__(text)
        self.lasting, self.paid = lasting, paid
