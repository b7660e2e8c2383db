"""Selects the answer in a reply: function calls count before text, and text before thoughts."""

from __future__ import annotations

from stucksolver_language.llm.chat import ChatReply, Finish, ToolCall
from stucksolver_language.llm.json_extraction import NoJsonError, asks_guard, extract_call, holds_answer
from stucksolver_language.llm.thoughts import split_thoughts
from stucksolver_language.llm.tool_schema import CHECK_PLAN, DECIDE
from stucksolver_language.llm.written_calls import WrittenCall


def chosen(reply: ChatReply) -> tuple[str, bool]:
    """Return the text of the answer, for the parser, and whether it queries the guard.

    A decision counts before queries to the guard in the same reply, and of several queries only the first counts.
    Different decisions are all returned, and the parser rejects them.
    """
    read = [(call.arguments, _read(call)) for call in reply.calls]
    decisions = [(text, found) for text, found in read if found is not None and not asks_guard(found)]
    checks = [text for text, found in read if found is not None and asks_guard(found)]
    if decisions:
        first = decisions[0][1]
        same = all(found == first for _, found in decisions)
        return decisions[0][0] if same else "\n".join(text for text, _ in decisions), False
    if checks:
        return checks[0], True
    for text in _texts(reply):
        if holds_answer(text):
            return text, _asks(text)
    return (reply.calls[0].arguments if reply.calls else reply.text), False


def answers(reply: ChatReply) -> bool:
    """True if a reply holds arguments of one of our functions, in any form."""
    return any(_read(call) is not None for call in reply.calls) or any(map(holds_answer, _texts(reply)))


def is_called(reply: ChatReply) -> bool:
    """True if the model answered in the requested form, or was cut off while thinking, before any answer."""
    return bool(reply.calls) or "{" in reply.text or only_thought(reply) or answers(reply)


def follows_schema(reply: ChatReply) -> bool:
    """True if a reply, which may be cut off early, is a call of our function, or begins as its schema does."""
    text = "".join(split_thoughts(reply.text)[0].split())
    begins = any(
        f'{{"{part}"'.startswith(text[: len(part) + 3])
        for part in ("observation", "analysis", "decision", "choice")
        if text
    )
    return begins or any(call.name in ("", DECIDE) for call in reply.calls) or f'"{DECIDE}"' in text


def only_thought(reply: ChatReply) -> bool:
    """True if a reply was cut off while the model was thinking, before any answer."""
    return reply.finish is Finish.CUT_OFF and not reply.calls and not split_thoughts(reply.text)[0].strip()


def _texts(reply: ChatReply) -> tuple[str, ...]:
    """Return the texts that may hold the answer. A draft in thoughts that were cut off is no answer."""
    return (reply.text,) if reply.finish is Finish.CUT_OFF else (reply.text, reply.thoughts)


def _read(call: ToolCall) -> WrittenCall | None:
    """Return a call's arguments if they are those of one of our functions. The name that was called counts."""
    if not holds_answer(call.arguments):
        return None
    try:
        one = extract_call(call.arguments)
    except NoJsonError:
        # Several objects in one call: the parser of the answer reports them.
        one = WrittenCall(None)
    return WrittenCall(call.name if call.name in (DECIDE, CHECK_PLAN) else one.name, one.arguments)


def _asks(text: str) -> bool:
    try:
        return asks_guard(extract_call(text))
    except NoJsonError:
        # The parser of the answer reports the missing or second object.
        return False
