"""Selects the key for each server: OpenAI's key for OpenAI only, and another key only where the user configures it.

The base URL may come from a configuration file in a folder of another author. So a key is bound to the servers that the
user names in the environment, and never follows the URL.
"""

from __future__ import annotations

import base64
import ipaddress
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from urllib.parse import quote, unquote, urlsplit

from stucksolver.privacy.url_redaction import KEYS_VARIABLE, shown_address, without_login

KEY_VARIABLE = "OPENAI_API_KEY"
AZURE_KEY_VARIABLE = "AZURE_OPENAI_API_KEY"
OPENAI_HOST = "api.openai.com"
AZURE_DOMAINS = (".openai.azure.com", ".cognitiveservices.azure.com", ".services.ai.azure.com")
"""Domains of Microsoft's own servers. Other names below azure.com belong to customers with rented machines."""
DEPLOYMENT = "/openai/deployments/"
USUAL_PORTS = {"http": 80, "https": 443}
"""Default ports of HTTP and HTTPS."""
HOST = re.compile(r"(?:[a-z0-9](?:[a-z0-9_.-]*[a-z0-9])?|[0-9a-f:.]+)")
"""Valid hosts. The pattern excludes characters at which some URL parsers end the host and others do not."""
LEAST_SECRET = 4
"""Shortest secret that is searched for in texts (characters). Shorter ones occur by chance. Ours."""


@dataclass(frozen=True)
class Origin:
    """A server: scheme, host and port."""

    scheme: str
    host: str
    port: int

    def __str__(self) -> str:
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"{self.scheme}://{host}:{self.port}"

    @property
    def is_private(self) -> bool:
        """True if the connection cannot be read on the network: HTTPS, or this machine."""
        return self.scheme == "https" or self.is_here

    @property
    def is_here(self) -> bool:
        """True for this machine."""
        try:
            return ipaddress.ip_address(self.host).is_loopback
        except ValueError:
            # Not an IP address, so a name.
            return self.host == "localhost"


@dataclass(frozen=True)
class Credentials:
    """Credentials for a server. The representation hides them.

    Attributes:
        headers: HTTP headers with the key.
        secrets: Texts that no message may contain.
        note: Information for the user about the credentials, or None.
        ours: True for OpenAI's own servers, which also get the organization from the environment.
    """

    headers: Mapping[str, str] = field(repr=False)
    secrets: tuple[str, ...] = field(repr=False)
    note: str | None = None
    ours: bool = False


def origin_of(url: str) -> Origin:
    """Return the server of a URL.

    Raises:
        ValueError: The URL has no valid server. The message contains no credentials.
    """
    wrong = ValueError(f"not an address: {shown_address(url)!r}. Give one such as http://127.0.0.1:8000/v1")
    if any(c.isspace() or not c.isprintable() for c in url):
        raise wrong
    try:
        parts = urlsplit(url)
        host, port = (parts.hostname or "").rstrip("."), parts.port
    except ValueError:
        raise wrong from None
    if parts.scheme not in USUAL_PORTS or not HOST.fullmatch(host) or "\\" in url:
        raise wrong
    return Origin(parts.scheme, host, USUAL_PORTS[parts.scheme] if port is None else port)


def is_azure_host(host: str) -> bool:
    """True for Microsoft's own model servers."""
    return host.endswith(AZURE_DOMAINS)


def credentials_for(url: str | None, login: str | None = None) -> Credentials:
    """Return the credentials for a server.

    Args:
        url: Address of the server without credentials; None for OpenAI's.
        login: `USER:PASSWORD` of the URL, if it had one.

    Raises:
        ValueError: The variable with the keys cannot be parsed.
    """
    origin = Origin("https", OPENAI_HOST, 443) if url is None else origin_of(url)
    deployment = url is not None and DEPLOYMENT in urlsplit(url).path
    ours = origin.scheme == "https" and (origin.host == OPENAI_HOST or origin.host.endswith(f".{OPENAI_HOST}"))
    named = login or _named(origin)
    if named is not None:
        sent, what = named, f"the login or key from its address or {KEYS_VARIABLE}"
        if named == os.environ.get(KEY_VARIABLE):
            what = KEY_VARIABLE
        where = "" if origin.is_private else " in clear text, over plain HTTP"
        note = None if ours else f"gets {what}{where}"
        return Credentials(_headers(sent, login is not None or _is_login(origin), deployment), _forms(sent), note, ours)
    variable = AZURE_KEY_VARIABLE if origin.scheme == "https" and is_azure_host(origin.host) else KEY_VARIABLE
    key = os.environ.get(variable)
    if key and (ours or variable == AZURE_KEY_VARIABLE):
        return Credentials(_headers(key, False, deployment), _forms(key), None, ours)
    return Credentials({}, (), _withheld(origin), ours)


def secrets_here() -> tuple[str, ...]:
    """Return all keys in the environment, as texts that no message may contain."""
    found = [os.environ.get(name, "") for name in (KEY_VARIABLE, AZURE_KEY_VARIABLE)]
    for entry in os.environ.get(KEYS_VARIABLE, "").split():
        bare, login = without_login(entry)
        found.append(login if login is not None else bare.partition("=")[2])
    return tuple(form for text in found for form in _forms(text))


def _withheld(origin: Origin) -> str | None:
    """Return a note about a key that is not sent; None if there is no such key."""
    for name in (KEY_VARIABLE, AZURE_KEY_VARIABLE):
        if os.environ.get(name):
            return (
                f"gets no key: {name} goes to its own servers only, over HTTPS; --send-key also sends {KEY_VARIABLE} "
                f"here, and {KEYS_VARIABLE}='{origin}=KEY' sends another key"
            )
    return None


def _named(origin: Origin) -> str | None:
    """Return the key or login for a server from the environment, or None."""
    return next((value for where, value, _ in _entries() if _fits(where, origin)), None)


def _is_login(origin: Origin) -> bool:
    return next((login for where, _, login in _entries() if _fits(where, origin)), False)


def _entries() -> list[tuple[str, str, bool]]:
    """Return the server, the secret and whether the secret is a login, for each entry of the variable.

    Raises:
        ValueError: An entry is not valid. The message does not contain it.
    """
    found = []
    for number, entry in enumerate(os.environ.get(KEYS_VARIABLE, "").split(), 1):
        bare, login = without_login(entry)
        where, _, key = (bare, "", login) if login is not None else bare.partition("=")
        try:
            origin_of(where if "://" in where else f"https://{where}")
        except ValueError:
            # The check below reports the entry by its number, because its text may contain a secret.
            key = ""
        if not key:
            raise ValueError(f"{KEYS_VARIABLE}: entry {number} must be HOST=KEY, such as api.example.com=abc")
        found.append((where, key, login is not None))
    return found


def _fits(where: str, origin: Origin) -> bool:
    if "://" in where:
        return origin_of(where) == origin
    if not origin.is_private:
        return False
    named = urlsplit(f"https://{where}")
    return origin_of(f"https://{where}").host == origin.host and named.port in (None, origin.port)


def _headers(secret: str, login: bool, deployment: bool) -> dict[str, str]:
    if login:
        return {"authorization": f"Basic {_basic(secret)}"}
    return {"api-key": secret} if deployment else {"authorization": f"Bearer {secret}"}


def _basic(login: str) -> str:
    user, _, password = login.partition(":")
    return base64.b64encode(f"{unquote(user)}:{unquote(password)}".encode()).decode()


def _forms(secret: str) -> tuple[str, ...]:
    """Return the forms in which a server may repeat a secret.

    The longest comes first, so that no part of it remains.
    """
    parts = {secret, unquote(secret), *secret.split(":", 1), *map(unquote, secret.split(":", 1)), _basic(secret)}
    parts |= {quote(part, safe="") for part in parts} | {base64.b64encode(part.encode()).decode() for part in parts}
    return tuple(sorted((part for part in parts if len(part) >= LEAST_SECRET), key=len, reverse=True))
