"""Client for any server with OpenAI's chat completions API: OpenAI, Azure, vLLM, Ollama, llama.cpp and others."""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from stucksolver.privacy.url_redaction import redacted, without_login
from stucksolver_language.llm.api_keys import Credentials, credentials_for
from stucksolver_language.llm.chat import (
    ChatReply,
    Message,
    PermanentReasonerError,
    Tool,
    TransientKind,
    TransientReasonerError,
    Usage,
)
from stucksolver_language.llm.event_loop import Cancelled, DeadlineError, Loop
from stucksolver_language.llm.model_options import ModelOptions
from stucksolver_language.llm.openai_client import check_url, make_client
from stucksolver_language.llm.openai_format import request_of
from stucksolver_language.llm.refusal_words import rejects_one_picture, rejects_size
from stucksolver_language.llm.reply_selection import answers, is_called, only_thought
from stucksolver_language.llm.response_body import MOST_RAW, failure_in, read_body, reply_of
from stucksolver_language.llm.sdk_errors import (
    REFUSALS,
    ChatError,
    error_for,
    failure_from,
    is_context_overflow,
    translated,
)
from stucksolver_language.llm.server_failure import ServerFailure, one_line
from stucksolver_language.llm.server_memory import remembered
from stucksolver_language.llm.server_text import clean, clean_json, clean_reply
from stucksolver_language.llm.token_usage import usage_in

URL_VARIABLE = "OPENAI_BASE_URL"
SHUT_FOR_S = 60.0
"""Time without requests after an error that a person must fix, such as a wrong key or an unknown model (s). Ours."""


class OpenAiChat:
    """One model at one address. The key comes from the environment, never from a file or an argument.

    Args:
        model: Name of the model.
        base_url: Address of its server; None for OpenAI's, or the one in the environment. A user name and password in
            it are sent, but neither stored nor displayed.
        options: Options of the user.
        login: `USER:PASSWORD` of the address, if the caller has already removed it from there.

    Raises:
        ValueError: The address is not valid.
    """

    def __init__(
        self,
        model: str,
        base_url: str | None = None,
        options: ModelOptions | None = None,
        login: str | None = None,
    ) -> None:
        address, own_login = without_login(base_url or os.environ.get(URL_VARIABLE) or "")
        self.model, self.base_url = model, address or None
        self._login = login or own_login
        if self.base_url is not None:
            check_url(self.base_url)
        self.name = f"openai:{model}" + (f"@{self.base_url}" if base_url else "")
        self._credentials: Credentials | None = None
        self.options = options or ModelOptions()
        self.takes = remembered(model, self.base_url, self.options)
        self._loop = Loop()
        self._client: Any = None
        self._shut: tuple[float, str] | None = None

    def chat(
        self, messages: Sequence[Message], tools: Sequence[Tool], must_call: str | None, limit_s: float
    ) -> ChatReply:
        """Run one exchange, as in `ChatModel`.

        Features that the server rejects are omitted from then on. The retries share the same time limit.
        """
        return self._run(messages, tools, must_call, None, limit_s)

    def probe(self, messages: Sequence[Message], tool: Tool, most_tokens: int, limit_s: float) -> ChatReply:
        """Run one exchange with a short limit of tokens. The reply comes back in whatever form it has, also cut off.

        Raises: as `chat`.
        """
        return self._run(messages, [tool], tool.name, most_tokens, limit_s)

    def _run(
        self,
        messages: Sequence[Message],
        tools: Sequence[Tool],
        must_call: str | None,
        probe_tokens: int | None,
        limit_s: float,
    ) -> ChatReply:
        if self._shut is not None and time.monotonic() < self._shut[0]:
            raise PermanentReasonerError(self._shut[1], lasting=True)
        try:
            return self._loop.run(self._exchange(self._connect(), messages, tools, must_call, probe_tokens), limit_s)
        except DeadlineError:
            raise TransientReasonerError(
                f"{self.server_name} gave no answer within {limit_s:.1f} s", TransientKind.LATE
            ) from None
        except Cancelled:
            raise PermanentReasonerError("the query was canceled", paid=True) from None
        except PermanentReasonerError as error:
            if error.lasting:
                self._shut = (time.monotonic() + SHUT_FOR_S, str(error))
            raise

    def cancel(self) -> None:
        """Cancel the running request. Any thread may call this."""
        self._loop.cancel()

    def described(self, limit_s: float) -> dict[str, Any]:
        """Return this model's entry in the server's list of models; empty if there is none."""
        try:
            return self._loop.run(self._listed(self._connect()), limit_s)
        except (DeadlineError, Cancelled):
            # The entry only adds notes, so the preflight succeeds without it.
            return {}

    @property
    def server_name(self) -> str:
        """Name of the server for people."""
        return redacted(self.base_url) if self.base_url else "api.openai.com"

    def _connect(self) -> Any:
        """Return the SDK's client, created once."""
        if self._client is None:
            try:
                sent = credentials_for(self.base_url, self._login)
            except ValueError as error:
                raise PermanentReasonerError(str(error), lasting=True) from error
            if sent.note is not None and sent.note not in self.takes.notes:
                self.takes.notes.append(sent.note)
            self._credentials = sent
            self._client = make_client(self.base_url, sent, self.server_name)
        return self._client

    def _clean(self, text: str) -> str:
        """Return a server's text, safe to display and store."""
        return clean(text, self._secrets)

    @property
    def _secrets(self) -> tuple[str, ...]:
        return () if self._credentials is None else self._credentials.secrets

    async def _exchange(
        self,
        client: Any,
        messages: Sequence[Message],
        tools: Sequence[Tool],
        must_call: str | None,
        probe_tokens: int | None,
    ) -> ChatReply:
        """Run one exchange, and repeat it without the features that the server rejects."""
        spent: Usage | None = None
        retried = omitted = False
        while True:
            request = request_of(self.model, messages, tools, must_call, self.takes)
            if probe_tokens is not None:
                request[self.takes.token_field] = min(probe_tokens, self.takes.most_tokens)
            reply, failure = await self._answer(client, request)
            spent = spent if reply.usage is None else reply.usage if spent is None else spent + reply.usage
            reply = replace(reply, usage=spent, saw=reply.saw and not omitted)
            if failure is not None and not answers(reply):
                if rejects_one_picture(failure.message) and any(m.image for m in messages):
                    messages, omitted = [replace(m, image=None) for m in messages], True
                    self.takes.omit_picture(self._clean(failure.message))
                elif not self._learns(failure, request):
                    raise self._error_for(failure, reply)
            elif probe_tokens is not None and (reply.text.strip() or reply.calls or only_thought(reply) or retried):
                return reply
            elif probe_tokens is None and only_thought(reply) and self.takes.make_room(self.takes.most_tokens):
                continue
            elif probe_tokens is None and is_called(reply):
                self.takes.answered()
                return reply
            elif not reply.text.strip() and not retried:
                # An empty answer now and then says nothing about the server.
                retried = True
            elif not self.takes.step_down(f"answered without a call: {reply.text[:60]!r}", refused=False):
                return reply

    async def _answer(self, client: Any, request: dict[str, Any]) -> tuple[ChatReply, ServerFailure | None]:
        """Send a request. Return the reply, which is empty if there is none, and the failure that the server reports.

        Raises:
            TransientReasonerError: The connection failed, or the response is too long or no response of a chat.
        """
        import openai

        nothing = ChatReply("", (), None, self.model, saw=self.takes.pictures)
        try:
            response = await client.chat.completions.with_raw_response.create(**request)
            raw = response.http_response.content.decode("utf-8-sig", "replace")
        except openai.APIStatusError as error:
            if error.status_code < 400:
                raise self._translated(error) from None
            raw = clean_json(error.response.text[:MOST_RAW], self._secrets)
            return replace(nothing, raw=raw, usage=usage_in(read_body(error.response.text))), failure_from(error)
        except openai.OpenAIError as error:
            raise self._translated(error) from None
        body, raw = read_body(raw), clean_json(raw[:MOST_RAW], self._secrets)
        if body is None:
            text = f"the response of {self.server_name} is not a chat completion. It begins: {one_line(raw)[:160]!r}"
            unread = TransientReasonerError(text, TransientKind.BROKEN)
            unread.raw = raw
            raise unread
        return clean_reply(reply_of(body, raw, self.model, self.takes.pictures), self._secrets), failure_in(body, raw)

    def _learns(self, failure: ServerFailure, request: dict[str, Any]) -> bool:
        """Omit what a failure names, if it rejects a part of the request."""
        message = self._clean(failure.message)
        if is_context_overflow(message):
            return self.takes.give_room_back(message)
        hard_schema = failure.status == 429 and ("schema" in message.lower() or rejects_size(message))
        if failure.withheld or not (failure.status in REFUSALS or hard_schema):
            return False
        return self.takes.learn(message, failure.parameter, request)

    def _translated(self, error: Any) -> ChatError:
        return translated(error, self.server_name, self.model, keyed=self._keyed, clean=self._clean)

    def _error_for(self, failure: ServerFailure, reply: ChatReply) -> ChatError:
        error = error_for(failure, self.server_name, self.model, keyed=self._keyed, clean=self._clean)
        error.raw, error.usage = reply.raw, reply.usage
        return error

    @property
    def _keyed(self) -> bool:
        return self._credentials is not None and bool(self._credentials.headers)

    async def _listed(self, client: Any) -> dict[str, Any]:
        """Return the model's entry, if possible. A server may have no such list, or one in another form."""
        import openai

        try:
            models = [entry.model_dump() for entry in (await client.models.list()).data]
        except (openai.OpenAIError, ValueError, TypeError, AttributeError):
            # The list is optional: see `described`.
            return {}
        named = [entry for entry in models if entry.get("id") == self.model]
        # A server with one model, such as llama.cpp, serves it under any name.
        found: dict[str, Any] = named[0] if named else models[0] if len(models) == 1 else {}
        return found
