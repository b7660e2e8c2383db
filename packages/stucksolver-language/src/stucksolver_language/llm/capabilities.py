"""Features of a server and its model: guessed from their names first, then corrected from the server's answers."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Any

from stucksolver_language.llm.dialects import Dialect, ToolChoice
from stucksolver_language.llm.model_families import (
    MOST_TOKENS,
    THINKING_TOKENS,
    ModelFamily,
    ServerKind,
    family_of,
    server_of,
    switch_fields,
)
from stucksolver_language.llm.model_options import ModelOptions
from stucksolver_language.llm.refusal_words import (
    PARAMETERS,
    rejects_calls,
    rejects_dialect,
    rejects_pictures,
    rejects_size,
    rejects_system,
    stated_most_tokens,
)

STEP_UP_AFTER = 20
"""Number of answers after which a format that was answered with prose is tried again. It doubles each time. Ours."""


@dataclass
class ServerCapabilities:
    """Features that requests use now. Each feature is dropped at most once, so the number of retries is bounded."""

    dialects: tuple[Dialect, ...]
    """Remaining dialects. The first one is in use."""
    pictures: bool = True
    temperature: bool = True
    token_field: str = "max_tokens"
    effort: str | None = None
    parallel: bool = True
    """True if `parallel_tool_calls` may be sent."""
    most_tokens: int = MOST_TOKENS
    refused_keywords: frozenset[str] = frozenset()
    """Keywords of a schema that the server is known to refuse."""
    tool_choice: ToolChoice = ToolChoice.NAMED
    limits: bool = True
    """True if a schema may limit numbers and lengths."""
    system: bool = True
    """True if there may be a system turn."""
    returns_calls: bool = True
    """True if the model's calls may be sent back as calls, for a repair or with the guard's verdict."""
    body: dict[str, Any] = field(default_factory=dict)
    """Further fields of each request: the switch of thinking, and the user's."""
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
            self._note(f"tries {self.dialect.value} again", f"{self._answers} good answers without it")
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

    def omit_pictures(self, why: str) -> None:
        """Send no pictures from now on."""
        self.pictures = False
        self._note("omits pictures", why)

    def learn(self, message: str, parameter: str | None, request: dict[str, Any]) -> bool:
        """Drop the features that a rejection names. True if the request had one of them, so that a retry makes sense.

        Args:
            message: The server's message.
            parameter: The field that the server names, if any.
            request: The rejected request.
        """
        returns = self.returns_calls and any(turn.get("tool_calls") for turn in request["messages"])
        if returns and rejects_calls(message):
            return self._quote_calls(message)
        if self.pictures and _has_picture(request) and rejects_pictures(message):
            self.omit_pictures(message)
            return True
        if self.system and rejects_system(message):
            self.system = False
            self._note("gets the system's text in the user's turn", message)
            return True
        names = [parameter, *re.findall(r"[a-z_]+", message.lower())]
        for name in names:
            known = name in self.body or (name in request and name in PARAMETERS)
            if known and self._give_up(str(name), message):
                return True
        if returns:
            # The same request without the calls was accepted.
            return self._quote_calls(message)
        too_hard = ("tools" in request or "response_format" in request) and rejects_size(message)
        if too_hard and self.limits:
            self.limits = False
            self._note("omits limits in the schema", message)
            return True
        return (too_hard or rejects_dialect(message)) and self.step_down(message)

    def _quote_calls(self, why: str) -> bool:
        self.returns_calls = False
        self._note("quotes the model's calls as text", why)
        return True

    def _give_up(self, name: str, message: str) -> bool:
        what = f"omits {name}"
        if name in self.body:
            self.body = {key: value for key, value in self.body.items() if key != name}
        elif name == "temperature":
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
        elif (most := stated_most_tokens(message)) is not None and most < self.most_tokens:
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


def capabilities_of(model: str, base_url: str | None, options: ModelOptions) -> ServerCapabilities:
    """Return the features to try first with a model at an address (None for OpenAI's), from the table of families."""
    family, server = family_of(model), server_of(base_url)
    thinks = family.is_thinking(options.think)
    refused = {*family.refuses, *(family.refuses_thinking if thinks else ())}
    switched = {} if options.think is None else switch_fields(family, server, options.think)
    effort = options.effort or switched.pop("reasoning_effort", family.effort)
    takes = ServerCapabilities(
        dialects=tuple(map(Dialect, server.formats)) if options.call is None else (options.call,),
        pictures=options.pictures,
        temperature="temperature" not in refused,
        token_field="max_completion_tokens" if "max_tokens" in refused else server.tokens,
        effort=effort,
        parallel="parallel_tool_calls" not in refused,
        most_tokens=options.tokens or (family.tokens if thinks else MOST_TOKENS),
        room=options.tokens is None,
        refused_keywords=server.refuses,
        body=_merged(switched, options.body_fields()),
    )
    _note_family(takes, family, server, options)
    return takes


def _note_family(takes: ServerCapabilities, family: ModelFamily, server: ServerKind, options: ModelOptions) -> None:
    if takes.pictures and not family.pictures:
        takes.omit_pictures(f"{family.name} reads text only")
    if options.think is False and family.thinks == "always":
        takes.notes.append(f"thinks all the same: {family.name} cannot be told not to")
    if options.think is None and family.thinks == "default" and family.has_switch(server) and takes.effort is None:
        takes.notes.append("thinks before it answers: #think=off answers sooner")


def _merged(first: dict[str, Any], second: dict[str, Any]) -> dict[str, Any]:
    """Return the fields of both; the second counts where both set one."""
    both = dict(first)
    for key, value in second.items():
        before = both.get(key)
        both[key] = _merged(before, value) if isinstance(before, dict) and isinstance(value, dict) else value
    return both


def _has_picture(request: dict[str, Any]) -> bool:
    return any(isinstance(message.get("content"), list) for message in request["messages"])
