"""Addresses of servers as people write them, perhaps with a user name and a password, which nobody else may see."""

from __future__ import annotations

import os
import re
from typing import Any

KEYS_VARIABLE = "STUCKSOLVER_KEYS"
"""Keys of other servers, separated by spaces: `HOST=KEY`, `HOST:PORT=KEY`, `http://HOST:PORT=KEY`. Without a scheme the
key is sent over HTTPS only, or to this machine. `http://USER:PASSWORD@HOST:PORT` is a login.
"""
LOGIN = re.compile(r"(?P<scheme>[a-zA-Z][a-zA-Z0-9+.]*://)(?P<login>[^/\s]*)@(?!https?://)(?P<server>[^/?#,\s]*)")
"""A user name and a password before a host."""
ANY_LOGIN = re.compile(r"(?<=://)(?:(?!://)\S)*@(?!https?://)")
"""The same in a URL that is not valid, such as one whose password has a slash."""
QUERY = re.compile(r"(://[^\s?#,]+\?)(?!api-version=[\w.-]*(?:[\s#,'\"]|$))[^\s#,'\"]+")
"""What follows an address, where some services expect a key. The version of Azure's API is none."""
HIDDEN = "***"


def without_login(text: str) -> tuple[str, str | None]:
    """Return a text without the user name and password of the first URL that has them, and these."""
    found = LOGIN.search(text)
    if found is None:
        return text, None
    return text[: found.start("login")] + text[found.start("server") :], found["login"]


def taken_logins(text: str) -> tuple[str, list[str]]:
    """Return a text without the logins of all URLs in it, and the servers with them, as `http://USER:PASSWORD@HOST`."""
    taken = []
    while (found := LOGIN.search(text)) is not None:
        if found["login"]:
            taken.append(found[0])
        text = text[: found.start("login")] + text[found.start("server") :]
    return text, taken


def without_logins(value: Any) -> Any:
    """Return words or settings without the logins of URLs in them, which the environment keeps from then on.

    So no message, result or record that repeats the words has them, and processes that are started here can use them.
    """
    if isinstance(value, dict):
        return {key: without_logins(item) for key, item in value.items()}
    if isinstance(value, list):
        return [without_logins(item) for item in value]
    if not isinstance(value, str):
        return value
    text, taken = taken_logins(value)
    for entry in taken:
        add_entry(entry)
    return text


def shown(text: str) -> str:
    """Return a text without the user names, passwords and queries of URLs in it, even if these cannot be parsed."""
    return QUERY.sub(rf"\1{HIDDEN}", ANY_LOGIN.sub(f"{HIDDEN}@", text))


def shown_address(address: str) -> str:
    """Return one address as `shown` does, also if its password has a space."""
    return shown(re.sub(r"(?<=://).*@", f"{HIDDEN}@", address))


def logins_in(text: str) -> list[str]:
    """Return the user names with passwords of all URLs in a text."""
    return [found.removesuffix("@") for found in ANY_LOGIN.findall(text)]


def add_entry(entry: str) -> None:
    """Add an entry to the variable with the keys, for this process and those that it starts."""
    before = os.environ.get(KEYS_VARIABLE, "").split()
    if entry not in before:
        os.environ[KEYS_VARIABLE] = " ".join([*before, entry])
