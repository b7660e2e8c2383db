"""Options that a user may set for a model with `#NAME=VALUE` after its name."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, field, replace
from typing import Any, Literal, cast, get_args

from stucksolver_language.llm.answer_form import USUAL_FORM, AnswerForm, Chain
from stucksolver_language.llm.dialects import Dialect

Effort = Literal["none", "minimal", "low", "medium", "high"]
OPTIONS_HELP = (
    "#pictures=off, #menu=on|off, #chain=short|long, "
    "#think=on|off, #effort=low, #tokens=3000, #call=strict|tool|schema|prose, #body.FIELD=VALUE, "
    "#intervention.queries|tokens|usd=N|off, #trip.queries|tokens|usd=N|off, #price=IN/CACHED/OUT"
)
LIMITS = tuple(f"{scope}.{what}" for scope in ("intervention", "trip") for what in ("queries", "tokens", "usd"))
"""Bounds of the budgets that an option may set."""
BODY = "body."
OURS = frozenset({"model", "messages", "tools", "tool_choice", "response_format", "stream", "n", "functions"})
"""Fields of a request that no option may set: they carry the query and decide in which form the answer comes."""
SECRETS = ("api_key", "apikey", "password", "secret", "authorization", "token")
"""Ends of field names that hold a secret. Options stand in results and records, so secrets belong elsewhere."""
MOST_DEPTH = 5
"""Deepest field that an option may set. Ours."""


@dataclass(frozen=True)
class ModelOptions:
    """Options of a model. None means automatic."""

    pictures: bool = True
    """Send the camera's image. If False, the image is not rendered either."""
    form: AnswerForm = field(default=USUAL_FORM, repr=False)
    """With a menu of plans or without, and with the short or the long chain. It says nothing about the server."""
    think: bool | None = None
    """Let the model think before it answers, or not, in the spelling of its family and server."""
    effort: Effort | None = None
    """`reasoning_effort`, for a reasoning model."""
    tokens: int | None = None
    """Upper bound on the tokens of an answer, thoughts included."""
    call: Dialect | None = None
    """The only dialect to use."""
    body: tuple[tuple[str, str], ...] = ()
    """Fields to add to each request: path with dots, and value as JSON."""
    limits: tuple[tuple[str, float], ...] = field(default=(), repr=False)
    """Bounds of budgets by their names in `LIMITS`; infinite if there is none. They say nothing about the server."""
    price: tuple[float, float, float] | None = field(default=None, repr=False)
    """Price of the model (US dollars per million tokens): input, input from the prompt cache, output."""

    def body_fields(self) -> dict[str, Any]:
        """Return the fields to add to each request."""
        fields: dict[str, Any] = {}
        for path, value in self.body:
            *parents, name = path.split(".")
            place = fields
            for parent in parents:
                inner = place.setdefault(parent, {})
                if not isinstance(inner, dict):
                    inner = place[parent] = {}
                place = inner
            place[name] = json.loads(value)
        return fields


def parse_options(texts: list[str]) -> ModelOptions:
    """Parse options from `NAME=VALUE` texts.

    Raises:
        ValueError: An option is unknown or its value is invalid.
    """
    options = ModelOptions()
    for text in texts:
        name, _, value = text.partition("=")
        try:
            if name.startswith(BODY):
                options = replace(options, body=(*options.body, _body(name.removeprefix(BODY), value)))
            elif name in ("menu", "chain"):
                options = replace(options, form=_form(options.form, name, value))
            elif name in LIMITS:
                options = replace(options, limits=(*options.limits, (name, _limit(value))))
            else:
                options = replace(options, **_OPTIONS[name](value))
        except (KeyError, ValueError) as error:
            raise ValueError(f"unknown option: #{text}. Use {OPTIONS_HELP}") from error
    return options


def _body(path: str, value: str) -> tuple[str, str]:
    """Return a field and its value as JSON. A value that is no JSON is a text."""
    names = path.split(".")
    if names[0] in OURS or not all(names) or len(names) > MOST_DEPTH or names[-1].lower().endswith(SECRETS):
        raise ValueError("a field that an option may not set")
    try:
        json.loads(value)
    except (ValueError, RecursionError):
        # Texts need no quotes, so that a shell needs none either.
        return path, json.dumps(value)
    return path, value


def _form(form: AnswerForm, name: str, value: str) -> AnswerForm:
    if name == "menu":
        return replace(form, menu=_SWITCH[value])
    if value not in get_args(Chain):
        raise ValueError("unknown chain")
    return replace(form, chain=cast("Chain", value))


def _limit(value: str) -> float:
    bound = math.inf if value == "off" else float(value)
    if not bound >= 0:
        raise ValueError("out of bounds")
    return bound


def _price(value: str) -> dict[str, Any]:
    read, cached, written = (float(part) for part in value.split("/"))
    if not all(0 <= part < math.inf for part in (read, cached, written)):
        raise ValueError("out of bounds")
    return {"price": (read, cached, written)}


def _tokens(value: str) -> dict[str, Any]:
    count = int(value)
    if not 100 <= count <= 100_000:
        raise ValueError("out of bounds")
    return {"tokens": count}


def _effort(value: str) -> dict[str, Any]:
    if value not in get_args(Effort):
        raise ValueError("unknown effort")
    return {"effort": value}


_SWITCH = {"on": True, "off": False}
_OPTIONS: dict[str, Any] = {
    "pictures": lambda value: {"pictures": _SWITCH[value]},
    "think": lambda value: {"think": _SWITCH[value]},
    "effort": _effort,
    "tokens": _tokens,
    "call": lambda value: {"call": Dialect(value)},
    "price": _price,
}
