"""Server addresses as people write them, perhaps with a user name and a password that must stay private."""

from __future__ import annotations

import os
import re
from typing import Any

KEYS_VARIABLE = "STUCKSOLVER_KEYS"
"""Name of the environment variable with keys of other servers, separated by spaces.

An entry is `HOST=KEY`, `HOST:PORT=KEY` or `http://HOST:PORT=KEY`. Without a scheme the key is sent over HTTPS only, or
to this machine. `http://USER:PASSWORD@HOST:PORT` is a login.
"""
LOGIN = re.compile(r"(?P<scheme>[a-zA-Z][a-zA-Z0-9+.]*://)(?P<login>[^/\s]*)@(?!https?://)(?P<server>[^/?#,\s]*)")
"""A user name and a password before a host."""
ANY_LOGIN = re.compile(r"(?<=://)(?:(?!://)\S)*@(?!https?://)")
"""The same in an invalid URL, such as one with a slash in the password."""
QUERY = re.compile(r"(://[^\s?#,]+\?)(?!api-version=[\w.-]*(?:[\s#,'\"]|$))[^\s#,'\"]+")
"""Query after an address, in which some services expect a key. The version of Azure's API is not redacted."""
HIDDEN = "***"


def without_login(text: str) -> tuple[str, str | None]:
    """Return a text without the user name and password of the first URL with a login, and that login."""
    match = LOGIN.search(text)
    if match is None:
        return text, None
    return text[: match.start("login")] + text[match.start("server") :], match["login"]


def taken_logins(text: str) -> tuple[str, list[str]]:
    """Return a text without the logins of all URLs in it, and the servers with them, as `http://USER:PASSWORD@HOST`."""
    logins = []
    while (match := LOGIN.search(text)) is not None:
        if match["login"]:
            logins.append(match[0])
        text = text[: match.start("login")] + text[match.start("server") :]
    return text, logins


def without_logins(value: Any) -> Any:
    """Return text or settings without the logins of URLs, which are moved to the environment.

    So no message, result or record that repeats the text contains them, and child processes can use them.
    """
    if isinstance(value, dict):
        return {key: without_logins(item) for key, item in value.items()}
    if isinstance(value, list):
        return [without_logins(item) for item in value]
    if not isinstance(value, str):
        return value
    text, logins = taken_logins(value)
    for entry in logins:
        add_entry(entry)
    return text


def redacted(text: str) -> str:
    """Return a text without user names, passwords and queries of the URLs in it, even if these are invalid."""
    return QUERY.sub(rf"\1{HIDDEN}", ANY_LOGIN.sub(f"{HIDDEN}@", text))


def shown_address(address: str) -> str:
    """Return one address as `redacted` does, also if its password contains a space."""
    return redacted(re.sub(r"(?<=://).*@", f"{HIDDEN}@", address))


def logins_in(text: str) -> list[str]:
    """Return the user names with passwords of all URLs in a text."""
    return [match.removesuffix("@") for match in ANY_LOGIN.findall(text)]


def add_entry(entry: str) -> None:
    """Add an entry to the variable with the keys, for this process and its child processes."""
    before = os.environ.get(KEYS_VARIABLE, "").split()
    if entry not in before:
        os.environ[KEYS_VARIABLE] = " ".join([*before, entry])
