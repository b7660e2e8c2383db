"""Stores every request and answer, with images by digest, so that a run can be repeated exactly without a network."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import threading
from collections import defaultdict, deque
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from stucksolver.privacy.private_files import append, write_once
from stucksolver_language.llm.answer_form import USUAL_FORM, AnswerForm, form_of
from stucksolver_language.llm.chat import (
    ChatModel,
    ChatReply,
    Finish,
    Message,
    PermanentReasonerError,
    Tool,
    ToolCall,
    TransientKind,
    TransientReasonerError,
    Usage,
)
from stucksolver_language.llm.tool_schema import DECIDE

TRANSIENT, PERMANENT = "TryAgain", "GiveUp"
"""How stored exchanges name the two kinds of error."""

FILE = "exchanges.jsonl"
IMAGES = "images"


class ExchangesError(Exception):
    """A folder of exchanges cannot be used. The message says why and what to do."""


class RecordingChat:
    """Forwards each query to another model and stores the exchange in a folder.

    If the disk is full, only the record is lost.
    """

    def __init__(self, inner: ChatModel, folder: Path) -> None:
        self.inner, self.folder = inner, folder
        self.name = inner.name
        self.model = getattr(inner, "model", "")
        self.fault: str | None = None
        """Reason why nothing more is stored, after a failure to write; else None."""
        self._lock = threading.Lock()
        try:
            (folder / IMAGES).mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise ExchangesError(f"cannot store exchanges in folder: {folder}: {error.strerror}") from error

    def chat(
        self, messages: Sequence[Message], tools: Sequence[Tool], must_call: str | None, limit_s: float
    ) -> ChatReply:
        """Query the model and store its reply or its failure."""
        try:
            reply = self.inner.chat(messages, tools, must_call, limit_s)
        except TransientReasonerError as error:
            failure = {"error": TRANSIENT, "text": str(error), "trouble": error.trouble.value, **_cost(error)}
            self._keep(messages, tools, must_call, failure)
            raise
        except PermanentReasonerError as error:
            stated: dict[str, Any] = {"error": PERMANENT, "text": str(error), "paid": error.paid, **_cost(error)}
            self._keep(messages, tools, must_call, stated)
            raise
        self._keep(messages, tools, must_call, {"reply": dataclasses.asdict(reply)})
        return reply

    def cancel(self) -> None:
        """Cancel the running query."""
        self.inner.cancel()

    def _keep(
        self, messages: Sequence[Message], tools: Sequence[Tool], must_call: str | None, result: dict[str, Any]
    ) -> None:
        request = request_form(messages, tools, must_call)
        line = {"model": self.name, "key": request_key(request), "request": request, **result}
        try:
            with self._lock:
                for message in messages:
                    self._keep_image(message)
                text = json.dumps(line, ensure_ascii=False) + "\n"
                append(self.folder / FILE, text.encode("utf-8", "replace"))
        except OSError as error:
            # The record is optional and the drive is not: a full disk must not stop the reasoner.
            self.fault = f"exchanges are no longer stored in {self.folder}: {error.strerror}"

    def _keep_image(self, message: Message) -> None:
        if message.image is not None:
            path = self.folder / IMAGES / f"{image_digest(message)}.jpg"
            write_once(path, message.image.jpeg)


class RecordedChat:
    """Answers from a folder and its subfolders: the same request gets the same answers in the same order."""

    def __init__(self, folder: Path) -> None:
        self._answers = _load(folder)
        first = next((line for lines in self._answers.values() for line in lines), None)
        self.model = str(first["model"]) if first else "nothing"
        self.name = f"recorded:{folder.name} of {self.model}"
        self.form = _form(first)
        """Form of the recorded answers: the same queries are made again."""

    def chat(
        self, messages: Sequence[Message], tools: Sequence[Tool], must_call: str | None, limit_s: float
    ) -> ChatReply:
        """Return the recorded reply to the same query.

        Raises:
            PermanentReasonerError: The query was never recorded, or the recorded failure was permanent.
            TransientReasonerError: The recorded failure was temporary.
        """
        key = request_key(request_form(messages, tools, must_call))
        lines = self._answers.get(key)
        if not lines:
            raise PermanentReasonerError("this query is not among the recorded ones; record it again with --exchanges")
        # The last answer to a query stays, because a resumed run repeats that query.
        line = lines.popleft() if len(lines) > 1 else lines[0]
        if "error" in line:
            raise _error(line)
        return _reply(line["reply"])

    def cancel(self) -> None:
        """Do nothing: recorded answers come at once."""


def request_form(messages: Sequence[Message], tools: Sequence[Tool], must_call: str | None) -> dict[str, Any]:
    """Return a request as plain data, with images by digest."""
    turns = []
    for message in messages:
        turn: dict[str, Any] = {"role": message.role, "text": message.text, "call_id": message.call_id}
        turn["calls"] = [_call_form(call) for call in message.calls]
        turn["image_sha256"], turn["extra"] = image_digest(message), message.extra
        turns.append({key: value for key, value in turn.items() if value})
    return {"messages": turns, "tools": [dataclasses.asdict(tool) for tool in tools], "must_call": must_call}


def _call_form(call: ToolCall) -> dict[str, Any]:
    """Return a call as plain data. Data of the provider is omitted where there is none, as in older records."""
    return {key: value for key, value in dataclasses.asdict(call).items() if value or key != "extra"}


def request_key(request: dict[str, Any]) -> str:
    """Return the SHA-256 of a request in its canonical form."""
    return hashlib.sha256(json.dumps(request, sort_keys=True, ensure_ascii=False).encode()).hexdigest()


def image_digest(message: Message) -> str | None:
    """Return the SHA-256 of a message's JPEG."""
    return None if message.image is None else hashlib.sha256(message.image.jpeg).hexdigest()


def _load(folder: Path) -> dict[str, deque[dict[str, Any]]]:
    paths = sorted(folder.rglob(FILE))
    if not paths:
        raise ExchangesError(
            f"no exchanges in folder: {folder}. It and its subfolders have no {FILE}; record a run first"
        )
    answers: dict[str, deque[dict[str, Any]]] = defaultdict(deque)
    for path in paths:
        try:
            text = path.read_text(encoding="utf-8")
        except OSError as error:
            raise ExchangesError(f"cannot read file: {path}: {error.strerror}") from error
        for number, line in enumerate(text.splitlines(), 1):
            entry = _entry(line, f"{path}, line {number}")
            answers[entry["key"]].append(entry)
    return answers


def _form(line: dict[str, Any] | None) -> AnswerForm:
    """Return the form of the answers that an exchange asks for. Other exchanges than ours have the usual one."""
    try:
        tools = [] if line is None else line["request"]["tools"]
        return next(form_of(tool["parameters"]) for tool in tools if tool["name"] == DECIDE)
    except (KeyError, TypeError, StopIteration):
        return USUAL_FORM


def _entry(line: str, where: str) -> dict[str, Any]:
    try:
        entry: dict[str, Any] = json.loads(line)
        same = request_key(entry["request"]) == entry["key"]
    except (ValueError, KeyError, TypeError) as error:
        raise ExchangesError(f"{where}: not an exchange. Remove the line or record again") from error
    if not same:
        raise ExchangesError(f"{where}: the request does not match its key, so the line was changed. Record again")
    return entry


def _cost(error: TransientReasonerError | PermanentReasonerError) -> dict[str, Any]:
    return {"raw": error.raw, "usage": None if error.usage is None else dataclasses.asdict(error.usage)}


def _error(line: dict[str, Any]) -> TransientReasonerError | PermanentReasonerError:
    error: TransientReasonerError | PermanentReasonerError
    if line["error"] == TRANSIENT:
        error = TransientReasonerError(line["text"], TransientKind(line.get("trouble", TransientKind.BUSY.value)))
    else:
        error = PermanentReasonerError(line["text"], paid=line.get("paid", False))
    error.usage = Usage(**line["usage"]) if line.get("usage") else None
    return error


def _reply(data: dict[str, Any]) -> ChatReply:
    usage = Usage(**data["usage"]) if data["usage"] else None
    calls = tuple(ToolCall(**call) for call in data["calls"])
    finish = Finish(data.get("finish", Finish.UNTOLD.value))
    return ChatReply(
        data["text"],
        calls,
        usage,
        data["model"],
        finish,
        data.get("saw", True),
        data.get("thoughts", ""),
        data.get("raw", ""),
        data.get("extra", {}),
    )
