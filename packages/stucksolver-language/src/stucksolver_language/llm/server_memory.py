"""Remembers what each server accepts, so that every model at an address negotiates once.

Later clients in the same process share what was found. Processes that are started after the preflight, such as the runs
of an evaluation, get it in an environment variable.
"""

from __future__ import annotations

import json
import os
from typing import Any

from stucksolver_language.llm.capabilities import ServerCapabilities, capabilities_of
from stucksolver_language.llm.dialects import Dialect, ToolChoice
from stucksolver_language.llm.model_options import ModelOptions

VARIABLE = "STUCKSOLVER_SERVERS"
"""What was found, as JSON, for processes that this one starts. It holds no keys and no text of a server."""
PLAIN = (
    "pictures",
    "temperature",
    "token_field",
    "effort",
    "parallel",
    "most_tokens",
    "limits",
    "system",
    "returns_calls",
    "body",
    "room",
)

_known: dict[str, ServerCapabilities] = {}


def remembered(model: str, base_url: str | None, options: ModelOptions) -> ServerCapabilities:
    """Return what is known of a model at an address, or a first guess. Clients with the same options share it."""
    key = f"{model}@{base_url or ''}#{options}"
    if key not in _known:
        guess = capabilities_of(model, base_url, options)
        _inherit(guess, _inherited().get(key))
        _known[key] = guess
    return _known[key]


def publish() -> None:
    """Hand down what is known to processes that are started from now on."""
    os.environ[VARIABLE] = json.dumps({**_inherited(), **{key: _plain(takes) for key, takes in _known.items()}})


def forget() -> None:
    """Forget all servers, also for processes that are started from now on."""
    _known.clear()
    os.environ.pop(VARIABLE, None)


def _plain(takes: ServerCapabilities) -> dict[str, Any]:
    return {
        "dialects": [dialect.value for dialect in takes.dialects],
        "tool_choice": takes.tool_choice.value,
        **{name: getattr(takes, name) for name in PLAIN},
    }


def _inherited() -> dict[str, Any]:
    try:
        found = json.loads(os.environ.get(VARIABLE, "{}"))
    except ValueError:
        # Whatever else the variable holds, the servers are asked again.
        return {}
    return found if isinstance(found, dict) else {}


def _inherit(takes: ServerCapabilities, found: Any) -> None:
    """Take over what another process found. Values of another type are ignored."""
    if not isinstance(found, dict):
        return
    for name in PLAIN:
        if name in found and isinstance(found[name], type(getattr(takes, name))):
            setattr(takes, name, found[name])
    if "effort" in found and found["effort"] is None:
        takes.effort = None
    try:
        dialects = tuple(Dialect(value) for value in found.get("dialects", ()))
        takes.tool_choice = ToolChoice(found.get("tool_choice"))
    except (ValueError, TypeError):
        # Another version wrote it.
        return
    takes.dialects = dialects or takes.dialects
