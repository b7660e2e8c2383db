"""Turns that answer a model's reply, and the prompt as a record keeps it."""

from __future__ import annotations

import hashlib
import json

from stucksolver_language.llm.chat import ChatReply, Message, ToolCall
from stucksolver_language.llm.reply_selection import only_thought
from stucksolver_language.llm.tool_schema import CHECK_PLAN, DECIDE

MOST_QUOTED = 4_000
"""Longest part of thoughts that is sent back for repair (characters). Ours."""
ONE_CALL = "Not considered: one call at a time."


def cut_off_reason(reply: ChatReply) -> str:
    """Return why an answer was cut off."""
    count = f"{reply.usage.output_tokens} tokens" if reply.usage else "the token limit"
    if only_thought(reply):
        return f"it was cut off at {count} before it began, while the model was thinking; allow more with #tokens=N"
    return f"it was cut off at {count}; say less in each text and list"


def response_turns(reply: ChatReply, text: str) -> list[Message]:
    """Return the reply and the response to it in the protocol's form, which answers each call, or else the text.

    Servers reject a call that is not valid when it is sent back, so such a call is quoted as text.
    """
    if reply.calls and all(map(_is_valid, reply.calls)):
        others = [Message("tool", ONE_CALL, call_id=call.id) for call in reply.calls[1:]]
        first = Message("tool", text, call_id=reply.calls[0].id)
        return [Message("assistant", reply.text, calls=reply.calls, extra=reply.extra), first, *others]
    said = reply.text or "\n".join(call.arguments for call in reply.calls) or reply.thoughts[:MOST_QUOTED]
    return [Message("assistant", said or "(empty)"), Message("user", text)]


def _is_valid(call: ToolCall) -> bool:
    try:
        return call.name in (DECIDE, CHECK_PLAN) and isinstance(json.loads(call.arguments), dict)
    except (ValueError, RecursionError):
        return False


def recorded_prompt(turns: list[Message], saw: bool) -> str:
    """Return the prompt for the record, with the digest of the image if it was sent."""
    plain_turns = [
        {
            "role": turn.role,
            "text": turn.text,
            **({"image_sha256": hashlib.sha256(turn.image.jpeg).hexdigest()} if turn.image and saw else {}),
        }
        for turn in turns
    ]
    return json.dumps(plain_turns, ensure_ascii=False)
