"""Creates the SDK's client: it follows no redirect and sends credentials to the named server only."""

from __future__ import annotations

import os
from typing import Any
from urllib.parse import parse_qs, urlsplit, urlunsplit

from stucksolver.privacy.url_redaction import KEYS_VARIABLE, shown_address
from stucksolver_language.llm.api_keys import (
    AZURE_KEY_VARIABLE,
    KEY_VARIABLE,
    Credentials,
    Origin,
    origin_of,
)
from stucksolver_language.llm.chat import PermanentReasonerError
from stucksolver_language.llm.model_families import has_deployment

PRIVATE_HEADERS = ("authorization", "api-key", "cookie", "proxy-authorization")
"""Headers that identify the client. Requests contain only those of the server's own credentials."""
OPENAI_HEADERS = ("openai-organization", "openai-project")
"""Headers that the SDK fills from the environment. They are for OpenAI's own servers only."""
NO_KEY = "none"
"""Placeholder, because the SDK requires a key. The real key goes only into requests to the right server."""


def make_client(base_url: str | None, credentials: Credentials, server_name: str) -> Any:
    """Return the client for a server (None for OpenAI's).

    The import is here because importing the SDK takes most of a second.

    Raises:
        PermanentReasonerError: The SDK is not installed, or a key or the version of Azure's API is missing.
    """
    try:
        import openai
    except ImportError as error:
        raise PermanentReasonerError(
            "the openai package is not installed: add the extra [llm] (README, Install)"
        ) from error
    http = _http(openai, base_url, credentials)
    if base_url is not None and has_deployment(base_url):
        return _azure(openai, base_url, credentials, server_name, http)
    if not credentials.headers and (base_url is None or urlsplit(base_url).hostname == "api.openai.com"):
        raise PermanentReasonerError(f"no key: set {KEY_VARIABLE}, or name your own server as openai:MODEL@BASE_URL")
    return openai.AsyncOpenAI(api_key=NO_KEY, base_url=base_url, max_retries=0, http_client=http)


def _azure(openai: Any, base_url: str, credentials: Credentials, server_name: str, http: Any) -> Any:
    """Return the client for Azure's older form: the key in its own header, the version in the query."""
    parts = urlsplit(base_url)
    version = parse_qs(parts.query).get("api-version") or [os.environ.get("OPENAI_API_VERSION", "")]
    if not version[0]:
        raise PermanentReasonerError(f"{server_name}: no version: end the address with ?api-version=…")
    if not credentials.headers:
        own = f"{KEYS_VARIABLE}='HOST=KEY' for a server that is not Microsoft's"
        raise PermanentReasonerError(f"{server_name}: no key: set {AZURE_KEY_VARIABLE}, or {own}")
    base = urlunsplit(parts._replace(query=""))
    return openai.AsyncAzureOpenAI(
        api_key=NO_KEY, base_url=base, api_version=version[0], max_retries=0, http_client=http
    )


def _http(openai: Any, base_url: str | None, credentials: Credentials) -> Any:
    own = Origin("https", "api.openai.com", 443) if base_url is None else origin_of(base_url)

    async def identify(request: Any) -> None:
        for name in PRIVATE_HEADERS + (() if credentials.ours else OPENAI_HEADERS):
            request.headers.pop(name, None)
        if origin_of(str(request.url)) == own:
            request.headers.update(credentials.headers)

    return openai.DefaultAsyncHttpxClient(follow_redirects=False, event_hooks={"request": [identify]})


def check_url(url: str) -> None:
    """Check an address.

    Raises:
        ValueError: It is not the address of a server.
    """
    origin_of(url)
    parts = urlsplit(url)
    other = [part for part in parts.query.split("&") if part and not part.startswith("api-version=")]
    if other or parts.fragment:
        raise ValueError(
            f"only ?api-version=… may follow an address: {shown_address(url).partition('?')[0]!r}. "
            f"Keys belong into {KEYS_VARIABLE}"
        )
