"""Features of a server and its model: guessed from their names first, then corrected from the server's answers."""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import Any, Literal, get_args
from urllib.parse import urlsplit

from stucksolver_language.llm.api_keys import DEPLOYMENT, is_azure_host

MOST_TOKENS = 1900
"""Limit of an answer (tokens). A normal one takes 300 to 700; one that fills every list and text takes 1,400."""
THINKING_TOKENS = 8000
"""The same limit for a reasoning model, whose thoughts count as tokens of the answer. Ours."""
Effort = Literal["none", "minimal", "low", "medium", "high"]
REASONING = re.compile(r"(?:^|/)(?:o\d|gpt-[5-9](?!.*chat))")
"""OpenAI's reasoning models by name: they accept neither `temperature` nor `max_tokens`."""


class Dialect(Enum):
    """How the function call is requested."""

    STRICT_TOOL = "strict"
    TOOL = "tool"
    JSON_SCHEMA = "schema"
    PROSE = "prose"


class ToolChoice(Enum):
    """How strictly a function call is demanded."""

    NAMED = "named"
    REQUIRED = "required"
    AUTO = "auto"


OPENAI_ORDER = (Dialect.STRICT_TOOL, Dialect.TOOL, Dialect.JSON_SCHEMA, Dialect.PROSE)
OTHERS_ORDER = (Dialect.JSON_SCHEMA, Dialect.TOOL, Dialect.PROSE)
"""Order for other servers.

The servers llama.cpp and Ollama treat a named function as a suggestion but follow a schema; vLLM follows both.
"""
ANTHROPIC_ORDER = (Dialect.TOOL, Dialect.PROSE)
"""Order for Anthropic's compatible endpoint. Its documentation says that it ignores a response format."""


@dataclass(frozen=True)
class ModelOptions:
    """Options that a user may set for a model with `#NAME=VALUE` after its name. None means automatic."""

    pictures: bool = True
    """Send the camera's image. If False, the image is not rendered either."""
    effort: Effort | None = None
    """`reasoning_effort`, for a reasoning model."""
    tokens: int | None = None
    """Upper bound on the tokens of an answer, thoughts included."""
    call: Dialect | None = None
    """The only dialect to use."""


OPTIONS_HELP = "#pictures=off, #effort=low, #tokens=3000, #call=strict|tool|schema|prose"


def parse_options(texts: list[str]) -> ModelOptions:
    """Parse options from `NAME=VALUE` texts.

    Raises:
        ValueError: An option is unknown or its value is invalid.
    """
    options = ModelOptions()
    for text in texts:
        name, _, value = text.partition("=")
        try:
            options = replace(options, **_OPTIONS[name](value))
        except (KeyError, ValueError) as error:
            raise ValueError(f"unknown option: #{text}. Use {OPTIONS_HELP}") from error
    return options


def _tokens(value: str) -> dict[str, Any]:
    count = int(value)
    if not 100 <= count <= 100_000:
        raise ValueError("out of bounds")
    return {"tokens": count}


def _effort(value: str) -> dict[str, Any]:
    if value not in get_args(Effort):
        raise ValueError("unknown effort")
    return {"effort": value}


_OPTIONS: dict[str, Any] = {
    "pictures": lambda value: {"pictures": {"on": True, "off": False}[value]},
    "effort": _effort,
    "tokens": _tokens,
    "call": lambda value: {"call": Dialect(value)},
}


STEP_UP_AFTER = 20
"""Number of answers after which a format that was answered with prose is tried again. It doubles each time. Ours."""


@dataclass
class ServerCapabilities:
    """Features that requests use now. Each feature is dropped at most once, so the number of retries is bounded."""

    dialects: tuple[Dialect, ...]
    """Remaining dialects. The first one is in use."""
    pictures: bool = True
    temperature: bool = True
    token_field: Literal["max_tokens", "max_completion_tokens"] = "max_tokens"
    effort: Effort | None = None
    parallel: bool = True
    """True if `parallel_tool_calls` may be sent."""
    most_tokens: int = MOST_TOKENS
    strict_subset: bool = False
    """True if a schema must stay within the subset of OpenAI's strict mode."""
    tool_choice: ToolChoice = ToolChoice.NAMED
    limits: bool = True
    """True if a schema may limit numbers and lengths."""
    system: bool = True
    """True if there may be a system turn."""
    returns_calls: bool = True
    """True if the model's calls may be sent back as calls, for a repair or with the guard's verdict."""
    notes: list[str] = field(default_factory=list)
    """Dropped features with the reason, for the user."""
    room: bool = True
    """True if the limit of an answer may be raised for a model that thinks first."""
    _renamed: bool = False
    _unheeded: tuple[Dialect, ...] = ()
    """Dialects that the server accepted and answered with prose."""
    _patience: int = STEP_UP_AFTER
    _answers: int = 0
    _before_room: int | None = None

    @property
    def dialect(self) -> Dialect:
        """The dialect in use."""
        return self.dialects[0]

    def step_down(self, why: str, *, refused: bool = True) -> bool:
        """Switch to the next dialect; False if there is none. A dialect that was not refused is tried again later."""
        if len(self.dialects) == 1:
            return False
        self._note(f"uses {self.dialects[1].value} instead of {self.dialects[0].value}", why)
        self._unheeded = () if refused else (*self._unheeded, self.dialects[0])
        self.dialects, self._answers = self.dialects[1:], 0
        return True

    def answered(self) -> None:
        """Count an answer in the requested form. After enough of them, try the dialects that got prose again."""
        self._answers += 1
        if self._unheeded and self._answers >= self._patience:
            self.dialects, self._unheeded = (*self._unheeded, *self.dialects), ()
            self._answers, self._patience = 0, 2 * self._patience

    def make_room(self, count: int) -> bool:
        """Raise the limit of an answer once, after thoughts that filled it; False if the user has set it."""
        if not self.room or self.most_tokens >= THINKING_TOKENS:
            return False
        self._before_room, self.most_tokens, self.room = self.most_tokens, THINKING_TOKENS, False
        self._note(f"allows an answer {THINKING_TOKENS} tokens", f"its thoughts alone took {count}")
        return True

    def give_room_back(self, why: str) -> bool:
        """Lower the raised limit again, which the server's context cannot hold; False if it was not raised."""
        if self._before_room is None:
            return False
        self.most_tokens, self._before_room = self._before_room, None
        self._note(f"allows an answer {self.most_tokens} tokens again", why)
        return True

    def omit_picture(self, why: str) -> None:
        """Note that one picture was refused, which is omitted from one query only."""
        self._note("omits one picture", why)

    def learn(self, message: str, parameter: str | None, request: dict[str, Any]) -> bool:
        """Drop the features that a rejection names. True if the request had one of them, so that a retry makes sense.

        Args:
            message: The server's message.
            parameter: The field that the server names, if any.
            request: The rejected request.
        """
        returns = self.returns_calls and any(turn.get("tool_calls") for turn in request["messages"])
        if returns and _OF_CALLS.search(message):
            return self._quote_calls(message)
        if self.pictures and _has_picture(request) and rejects_pictures(message):
            self.pictures = False
            self._note("omits pictures", message)
            return True
        if self.system and re.search(
            r"(?i)system.{0,40}(?:not supported|unsupported|not allowed)|roles must alter", message
        ):
            self.system = False
            self._note("gets the system's text in the user's turn", message)
            return True
        names = [parameter, *re.findall(r"[a-z_]+", message.lower())]
        for name in names:
            if name in request and name in _PARAMETERS and self._give_up(str(name), message):
                return True
        if returns:
            # The same request without the calls was accepted.
            return self._quote_calls(message)
        too_hard = self._has_schema(request) and rejects_size(message)
        if too_hard and self.limits:
            self.limits = False
            self._note("omits limits in the schema", message)
            return True
        return (too_hard or any(word in message.lower() for word in _OF_DIALECTS)) and self.step_down(message)

    def _quote_calls(self, why: str) -> bool:
        self.returns_calls = False
        self._note("quotes the model's calls as text", why)
        return True

    def _has_schema(self, request: dict[str, Any]) -> bool:
        return "tools" in request or "response_format" in request

    def _give_up(self, name: str, message: str) -> bool:
        what = f"omits {name}"
        if name == "temperature":
            self.temperature = False
        elif name == "reasoning_effort":
            self.effort = None
        elif name == "parallel_tool_calls":
            self.parallel = False
        elif name == "tool_choice":
            if self.tool_choice is ToolChoice.AUTO:
                return False
            self.tool_choice = ToolChoice.REQUIRED if self.tool_choice is ToolChoice.NAMED else ToolChoice.AUTO
            what = f"uses tool_choice {self.tool_choice.value}"
        elif (most := _most_tokens(message)) is not None and most < self.most_tokens:
            self.most_tokens = most
            what = f"limits an answer to {most} tokens"
        elif self._renamed:
            return False
        else:
            self._renamed = True
            self.token_field = "max_completion_tokens" if name == "max_tokens" else "max_tokens"
        self._note(what, message)
        return True

    def _note(self, what: str, why: str) -> None:
        if not any(note.startswith(f"{what}:") for note in self.notes):
            self.notes.append(f"{what}: {why[:160]}")


_PARAMETERS = (
    "temperature",
    "max_tokens",
    "max_completion_tokens",
    "reasoning_effort",
    "parallel_tool_calls",
    "tool_choice",
)
_OF_DIALECTS = ("tool", "function", "strict", "schema", "response_format", "guided", "grammar", "json")
_SCHEMA_TOO_HARD = re.compile(
    r"too many states|too complex|complexity|m(?:ax|in)(?:Length|Items|imum)|exclusiveM(?:ax|in)imum"
)
_OF_CALLS = re.compile(
    r"(?i)tool[_ ]?calls?\b|function_?call|\btool (?:message|role|result)|role.{0,60}\btool\b|reasoning_|thought_?signature"
    r"|alternat|arguments"
)
"""Words of servers that reject a call, the response to it, or the thoughts with it, when they come back."""
_TOKEN_BOUND = re.compile(
    r"(?i)(?:at most|maximum(?: value)?(?: of| is)?|less than or equal to|up to|<=|limit(?: of| is)?|\[1,)"
    r"\s{0,3}(\d{2,7})"
)
LEAST_TOKENS = 700
"""An answer with less room cannot be complete (tokens): that much a normal one takes."""


def _most_tokens(message: str) -> int | None:
    """Return the upper bound on the tokens of an answer that a message states, or None."""
    found = _TOKEN_BOUND.search(message)
    return int(found[1]) if found and int(found[1]) >= LEAST_TOKENS else None


def capabilities_of(model: str, base_url: str | None, options: ModelOptions) -> ServerCapabilities:
    """Return the features to try first with a model at an address (None for OpenAI's)."""
    host = (urlsplit(base_url).hostname or "") if base_url else "api.openai.com"
    openai = host == "api.openai.com" or is_azure(base_url)
    thinks = REASONING.search(model) is not None
    order = OPENAI_ORDER if openai else ANTHROPIC_ORDER if host == "api.anthropic.com" else OTHERS_ORDER
    return ServerCapabilities(
        dialects=order if options.call is None else (options.call,),
        pictures=options.pictures,
        temperature=not thinks,
        token_field="max_completion_tokens" if openai or thinks else "max_tokens",
        effort=options.effort or ("low" if thinks else None),
        parallel=not thinks,
        most_tokens=options.tokens or (THINKING_TOKENS if thinks else MOST_TOKENS),
        room=options.tokens is None,
        strict_subset=openai,
    )


def is_azure(base_url: str | None) -> bool:
    """True for an Azure address, with or without a deployment in its path."""
    if base_url is None:
        return False
    parts = urlsplit(base_url)
    return is_azure_host(parts.hostname or "") or has_deployment(base_url)


def has_deployment(base_url: str | None) -> bool:
    """True for Azure's older form of address, with the deployment in the path and the version in the query."""
    return base_url is not None and DEPLOYMENT in urlsplit(base_url).path


def _has_picture(request: dict[str, Any]) -> bool:
    return any(isinstance(message.get("content"), list) for message in request["messages"])


def rejects_pictures(message: str) -> bool:
    """True if a message rejects images in general, not only an image that is too large."""
    text = message.lower()
    if re.search(r"too (?:large|big)|exceed|dimension", text) or rejects_one_picture(message):
        return False
    asks_for_text = "content" in text and "string" in text
    return asks_for_text or re.search(r"image|vision|multi-?modal|modalit|mmproj", text) is not None


def rejects_size(message: str) -> bool:
    """True if a message rejects a schema because of its size or its limits."""
    return _SCHEMA_TOO_HARD.search(message) is not None


def rejects_one_picture(message: str) -> bool:
    """True if a message rejects the image that was sent, not images in general."""
    return _THIS_PICTURE.search(message) is not None


_THIS_PICTURE = re.compile(
    r"(?i)(?:could not|unable to|failed to|cannot) (?:process|decode|load|read|download|parse)\b.{0,30}image"
    r"|(?:invalid|corrupt\w*|truncated|unsafe) image(?! type)|invalid_image|image.{0,40}(?:policy|safety|moderation)"
)
