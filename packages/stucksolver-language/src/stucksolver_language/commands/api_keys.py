"""Options of the command line for keys and logins of language models. They apply before any other code reads them."""

from __future__ import annotations

import argparse
import os

from stucksolver.commands.errors import UsageError
from stucksolver.privacy.url_redaction import add_entry, redacted, without_login

PREFIX = "openai:"


def add_send_key(parser: argparse.ArgumentParser) -> None:
    """Add `--send-key`."""
    parser.add_argument(
        "--send-key",
        action="store_true",
        help="also send OPENAI_API_KEY to servers of openai:MODEL@BASE_URL that do not belong to OpenAI",
    )
    parser.set_defaults(prepare=send_key_if_wanted)


def send_key_if_wanted(options: argparse.Namespace) -> None:
    """Permit sending the key if the command line has `--send-key`. Raises `UsageError` as `send_key` does."""
    if options.send_key:
        send_key(options)


def send_key(options: argparse.Namespace) -> None:
    """Permit sending the key to the servers that the options name, in this process and in its child processes.

    Raises:
        UsageError: There is no key, or no server is named.
    """
    # The import is late because reasoners import slowly and most commands need none.
    from stucksolver_language.llm.api_keys import KEY_VARIABLE, origin_of
    from stucksolver_language.llm.openai_api import URL_VARIABLE

    key = os.environ.get(KEY_VARIABLE)
    if not key:
        raise UsageError(f"--send-key: no key. Set {KEY_VARIABLE}")
    urls = []
    for text in (var for var in vars(options).values() if isinstance(var, str)):
        for word in (part.strip() for part in text.split(",")):
            if word.startswith(PREFIX):
                named = word.partition("#")[0].partition("@")[2]
                urls.append(named or os.environ.get(URL_VARIABLE, ""))
    if not any(urls):
        raise UsageError("--send-key: no server. Name one as openai:MODEL@BASE_URL")
    try:
        for url in filter(None, urls):
            add_entry(f"{origin_of(without_login(url)[0])}={key}")
    except ValueError as error:
        raise UsageError(f"--send-key: {redacted(str(error))}") from error
