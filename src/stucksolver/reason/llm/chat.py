"""What any vendor's chat API comes down to: messages and one tool in, a reply or a typed failure out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
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


@dataclass(frozen=True)
class Reply:
    """What came back: text, calls, or both. `usage` is None where the server does not count."""

    text: str
    calls: tuple[ToolCall, ...]
    usage: Usage | None
    model: str


class ChatModel(Protocol):
    """A vendor's API. One file implements it for each."""

    @property
    def name(self) -> str:
        """As in results: vendor and model."""

    def chat(self, messages: Sequence[Message], tools: Sequence[Tool], must_call: str | None, limit_s: float) -> Reply:
        """One exchange that ends within `limit_s` seconds. `must_call` names the tool that has to be called.

        Raises `TryAgain` for what may pass by itself, `GiveUp` for what needs a person or another model.
        """

    def cancel(self) -> None:
        """End the running `chat` from another thread, by `GiveUp`; nothing where none runs."""


class TryAgain(ReasonerError):
    """The server is busy, slow or broken for the moment; `after_s` is how long it asks us to wait, if it does."""

    def __init__(self, text: str, after_s: float | None = None) -> None:
        super().__init__(text)
        self.after_s = after_s


class GiveUp(ReasonerError):
    """Asking again will not help; the message says what to set or do."""
