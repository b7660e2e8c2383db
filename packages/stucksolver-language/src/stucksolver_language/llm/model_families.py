"""Facts about families of models and about servers, from the table `families.toml`."""

from __future__ import annotations

import re
import sys
from dataclasses import dataclass, field
from functools import cache
from importlib.resources import files
from typing import Any, Literal
from urllib.parse import urlsplit

from stucksolver_language.llm.api_keys import DEPLOYMENT

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

TABLE = "families.toml"
THINKING_TOKENS = 8000
"""Limit of an answer of a model that thinks (tokens), unless its row states another. Its thoughts count. Ours."""
MOST_TOKENS = 1900
"""Limit of an answer (tokens). A normal one takes 300 to 700. With prompt 6, one that filled every list took 1,400."""

Thinks = Literal["never", "asked", "default", "always"]
Switch = Literal["effort", "template", "thinking"]


@dataclass(frozen=True)
class ModelFamily:
    """A row of the table. Its columns are explained there."""

    name: str
    models: str
    thinks: Thinks
    source: str
    template: str | None = None
    effort: str | None = None
    effort_off: str | None = None
    effort_on: str | None = None
    thinking_on: dict[str, Any] | None = field(default=None, hash=False)
    tokens: int = THINKING_TOKENS
    pictures: bool = True
    refuses: tuple[str, ...] = ()
    refuses_thinking: tuple[str, ...] = ()

    def is_thinking(self, think: bool | None) -> bool:
        """True if the model thinks. `think` is the user's option; None without one."""
        if self.thinks in ("never", "always"):
            return self.thinks == "always"
        return self.thinks == "default" if think is None else think

    def has_switch(self, server: ServerKind) -> bool:
        """True if thinking can be switched off at a server."""
        return self.thinks in ("asked", "default") and bool(switch_fields(self, server, False))


@dataclass(frozen=True)
class ServerKind:
    """A row of the table. Its columns are explained there."""

    name: str
    formats: tuple[str, ...]
    switches: tuple[Switch, ...]
    source: str
    hosts: tuple[str, ...] = ()
    ports: tuple[int, ...] = ()
    tokens: Literal["max_tokens", "max_completion_tokens"] = "max_tokens"
    refuses: frozenset[str] = frozenset()


UNKNOWN = ModelFamily(
    "unknown",
    "",
    "asked",
    "ours",
    template="enable_thinking",
    effort_off="none",
    effort_on="medium",
    tokens=MOST_TOKENS,
)
"""Family of a model that the table does not have. Nothing is switched unless the user asks for it."""


@cache
def model_families() -> tuple[ModelFamily, ...]:
    """Return the families in the order of the table."""
    return tuple(ModelFamily(**_frozen(row)) for row in _table()["family"])


@cache
def server_kinds() -> tuple[ServerKind, ...]:
    """Return the servers in the order of the table. The last one is for all others."""
    return tuple(ServerKind(**_frozen(row)) for row in _table()["server"])


def family_of(model: str) -> ModelFamily:
    """Return the family of a model by its name."""
    found = (f for f in model_families() if re.search(rf"(?:^|[/:@]){f.models}", model.lower()))
    return next(found, UNKNOWN)


def server_of(base_url: str | None) -> ServerKind:
    """Return the kind of server at an address (None for OpenAI's)."""
    kinds = server_kinds()
    if base_url is None:
        return kinds[0]
    parts = urlsplit(base_url)
    if has_deployment(base_url):
        return kinds[0]
    host = f".{parts.hostname or ''}"
    named = (k for k in kinds if parts.port in k.ports or any(host.endswith(f".{end}") for end in k.hosts))
    return next(named, kinds[-1])


def has_deployment(base_url: str | None) -> bool:
    """True for Azure's older form of address, with the deployment in the path and the version in the query."""
    return base_url is not None and DEPLOYMENT in urlsplit(base_url).path


def listed_price(model: str, base_url: str | None) -> tuple[float, float, float] | None:
    """Return the vendor's price (US dollars per million tokens): input, input from the cache, output; None if unknown.

    The price of a model at another server is unknown, whatever its name.
    """
    name = re.sub(r"-20\d\d-?\d\d-?\d\d$", "", model.lower())
    found = _table()["prices"].get(name) if server_of(base_url).hosts else None
    return None if found is None else (found[0], found[1], found[2])


def switch_fields(family: ModelFamily, server: ServerKind, think: bool) -> dict[str, Any]:
    """Return the fields of a request that switch thinking on or off, in all spellings of a server."""
    fields: dict[str, Any] = {}
    effort = family.effort_on if think else family.effort_off
    if "effort" in server.switches and effort is not None:
        fields["reasoning_effort"] = effort
    if "template" in server.switches and family.template is not None:
        fields["chat_template_kwargs"] = {family.template: think}
    if "thinking" in server.switches and family.thinking_on is not None:
        fields["thinking"] = family.thinking_on if think else {"type": "disabled"}
    return fields


@cache
def _table() -> dict[str, Any]:
    found: dict[str, Any] = tomllib.loads(files(__package__).joinpath(TABLE).read_text(encoding="utf-8"))
    return found


def _frozen(row: dict[str, Any]) -> dict[str, Any]:
    """Return a row with tuples in place of lists."""
    plain = {key: tuple(value) if isinstance(value, list) else value for key, value in row.items()}
    if "hosts" in row or "formats" in row:
        plain["refuses"] = frozenset(row.get("refuses", ()))
    return plain
