"""Any server with OpenAI's chat completions API: OpenAI itself, Azure, vLLM, Ollama, llama.cpp and others."""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from typing import Any
from urllib.parse import parse_qs, urlsplit, urlunsplit

from stucksolver.reason.llm.capabilities import ModelOptions, capabilities_of, has_deployment, is_azure
from stucksolver.reason.llm.chat import ChatReply, Finish, GiveUp, Message, Tool, Trouble, TryAgain, Usage
from stucksolver.reason.llm.failures import KEY_VARIABLE, REFUSALS, parameter_of, said_by, too_long, translated
from stucksolver.reason.llm.loop import Cancelled, Loop, OutOfTime
from stucksolver.reason.llm.wire import reply_of, request_of

AZURE_KEY_VARIABLE = "AZURE_OPENAI_API_KEY"
URL_VARIABLE = "OPENAI_BASE_URL"
SHUT_FOR_S = 60.0
"""After an error that a person must fix (a wrong key, an unknown model), nothing is sent for this long (s)."""


class OpenAiChat:
    """One model at one address. The key comes from the environment, never from a file or an argument.

    Raises:
        ValueError: The address is not valid.
    """

    def __init__(self, model: str, base_url: str | None = None, options: ModelOptions | None = None) -> None:
        self.model, self.base_url = model, base_url or os.environ.get(URL_VARIABLE)
        if self.base_url is not None:
            check_url(self.base_url)
        self.name = f"openai:{model}" + (f"@{base_url}" if base_url else "")
        self.options = options or ModelOptions()
        self.takes = capabilities_of(model, self.base_url, self.options)
        self._loop = Loop()
        self._client: Any = None
        self._shut: tuple[float, str] | None = None

    def chat(
        self, messages: Sequence[Message], tools: Sequence[Tool], must_call: str | None, limit_s: float
    ) -> ChatReply:
        """Run one exchange, as in `ChatModel`. What the server refuses is left out from then on, within the same
        limit.
        """
        if self._shut is not None and time.monotonic() < self._shut[0]:
            raise GiveUp(self._shut[1], lasting=True)
        try:
            return self._loop.run(self._exchange(self._connect(), messages, tools, must_call), limit_s)
        except OutOfTime:
            raise TryAgain(f"{self.where} gave no answer within {limit_s:.1f} s", Trouble.LATE) from None
        except Cancelled:
            raise GiveUp("the question was withdrawn", paid=True) from None
        except GiveUp as error:
            if error.lasting:
                self._shut = (time.monotonic() + SHUT_FOR_S, str(error))
            raise

    def cancel(self) -> None:
        """Cancel the running request; may be called from any thread."""
        self._loop.cancel()

    def described(self, limit_s: float) -> dict[str, Any]:
        """Return this model's entry in the server's list of models; empty if there is none."""
        try:
            return self._loop.run(self._listed(self._connect()), limit_s)
        except (OutOfTime, Cancelled):
            return {}

    @property
    def where(self) -> str:
        """The server, for people."""
        return self.base_url or "api.openai.com"

    def _connect(self) -> Any:
        """Return the SDK's client, created once. Importing the SDK takes most of a second, so that happens here."""
        if self._client is None:
            try:
                import openai
            except ImportError as error:
                raise GiveUp("the openai package is not installed: add the extra [llm] (README, Install)") from error
            if self.base_url is not None and has_deployment(self.base_url):
                self._client = self._azure(openai)
                return self._client
            key = os.environ.get(AZURE_KEY_VARIABLE) if is_azure(self.base_url) else None
            key = key or os.environ.get(KEY_VARIABLE)
            if not key and (self.base_url is None or urlsplit(self.base_url).hostname == "api.openai.com"):
                raise GiveUp(f"no key: set {KEY_VARIABLE}, or name a server of your own as openai:MODEL@BASE_URL")
            # A private server needs no key, but the SDK does.
            self._client = openai.AsyncOpenAI(api_key=key or "none", base_url=self.base_url, max_retries=0)
        return self._client

    def _azure(self, openai: Any) -> Any:
        """Return the client for Azure's older form: the key in its own header, the version in the query."""
        assert self.base_url is not None
        parts = urlsplit(self.base_url)
        version = parse_qs(parts.query).get("api-version") or [os.environ.get("OPENAI_API_VERSION", "")]
        key = os.environ.get(AZURE_KEY_VARIABLE) or os.environ.get(KEY_VARIABLE)
        if not key or not version[0]:
            what = f"no key: set {AZURE_KEY_VARIABLE}" if not key else "no version: end the address with ?api-version=…"
            raise GiveUp(f"{self.where}: {what}")
        base = urlunsplit(parts._replace(query=""))
        return openai.AsyncAzureOpenAI(api_key=key, base_url=base, api_version=version[0], max_retries=0)

    async def _exchange(
        self, client: Any, messages: Sequence[Message], tools: Sequence[Tool], must_call: str | None
    ) -> ChatReply:
        """Run one exchange, and repeat it without what the server refuses."""
        import openai

        spent: Usage | None = None
        while True:
            request = request_of(self.model, messages, tools, must_call, self.takes)
            try:
                answer = await client.chat.completions.create(**request)
                reply = reply_of(answer, self.model, self.takes.pictures)
            except openai.OpenAIError as error:
                if not self._learns(error, request):
                    raise translated(error, self.where, self.model) from error
                continue
            except (ValueError, TypeError, AttributeError, LookupError) as error:
                # The SDK returns bodies that are not completions unchanged, or fails on them in its own ways.
                raise TryAgain(f"{self.where} did not answer with a chat completion", Trouble.BROKEN) from error
            spent = reply.usage if spent is None or reply.usage is None else spent + reply.usage
            if is_called(reply) or not self.takes.step_down(f"answered without a call: {reply.text[:60]!r}"):
                return ChatReply(reply.text, reply.calls, spent, reply.model, reply.finish, reply.saw)

    def _learns(self, error: Any, request: dict[str, Any]) -> bool:
        said = said_by(error)
        if getattr(error, "status_code", None) not in REFUSALS or too_long(said):
            return False
        return self.takes.learn(said, parameter_of(error), request)

    async def _listed(self, client: Any) -> dict[str, Any]:
        """Return the model's entry, if possible: a server may have no such list, or one in another form."""
        import openai

        try:
            models = [entry.model_dump() for entry in (await client.models.list()).data]
        except (openai.OpenAIError, ValueError, TypeError, AttributeError):
            return {}
        named = [entry for entry in models if entry.get("id") == self.model]
        # A server with one model answers under any name, as llama.cpp does.
        found: dict[str, Any] = named[0] if named else models[0] if len(models) == 1 else {}
        return found


def is_called(reply: ChatReply) -> bool:
    """True if the model answered in the requested form, or was cut off while thinking, before any answer."""
    return bool(reply.calls) or "{" in reply.text or (reply.finish is Finish.CUT_OFF and not reply.text.strip())


def check_url(url: str) -> None:
    """Check an address.

    Raises:
        ValueError: It is not the address of a server.
    """
    parts = urlsplit(url)
    if parts.scheme not in ("http", "https") or not parts.hostname or any(c.isspace() for c in url):
        raise ValueError(f"{url!r} is not an address; give one such as http://127.0.0.1:8000/v1")
