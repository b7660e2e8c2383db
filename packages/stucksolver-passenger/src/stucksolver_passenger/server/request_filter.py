"""The checks that every request passes first, and the headers of every response: plain ASGI."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Hashable, MutableMapping
from typing import Any

from stucksolver_passenger.server.connection_limits import Place
from stucksolver_passenger.server.rate_limits import BODY_BYTES, TARGET_BYTES

Scope = MutableMapping[str, Any]
Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]
Shares = Callable[[str, str], tuple[tuple[Hashable, int], ...]]
"""Returns, for a path and an authorization header, the shares in which a request counts; none without a valid token."""

PLACE = "place"
"""Key of the connection's place in a request's state."""
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self' data:; "
    "form-action 'none'; base-uri 'none'; frame-ancestors 'none'"
)
"""Nothing inline, nothing from elsewhere, no frames. `data:` is for the camera's image and the page's own icon."""
COMPILING_POLICY = POLICY.replace("script-src 'self'", "script-src 'self' 'wasm-unsafe-eval'")
"""With the speech recognizer WebAssembly may be compiled; text still never becomes a script."""
LENGTH_DIGITS = 12
"""A stated length of more digits is too long; Python refuses to convert very long numbers."""
VOICE = "/voice/"
CACHED = "private, max-age=31536000, immutable"
"""For the recognizer's files, 40 MB under their own version: a phone fetches them once."""
HEADERS = {
    "content-security-policy": POLICY,
    "x-content-type-options": "nosniff",
    "x-frame-options": "DENY",
    "referrer-policy": "no-referrer",
    "cache-control": "no-store",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "permissions-policy": "camera=(), geolocation=(), microphone=(self)",
}
SAME = frozenset({"same-origin", "none"})
"""What a browser sends for the page's own requests, or for an address that a person typed."""


class RequestRejectedError(Exception):
    """A request is refused with a status and a sentence."""

    def __init__(self, status: int, why: str) -> None:
        super().__init__(why)
        self.status = status
        self.why = why


def in_words(refused: RequestRejectedError) -> tuple[bytes, bytes]:
    """Return the content type and the body of a refusal in plain text."""
    return b"text/plain; charset=utf-8", refused.why.encode()


class RequestFilter:
    """Accepts requests that name one of our hosts and come from our own page.

    A page of another site whose name points at this machine (DNS rebinding) still sends its own name as host. A page
    that posts to us from elsewhere (CSRF) sends its own origin.

    Args:
        hosts: As in the header, for example `127.0.0.1:8765`.
        compiles: The page may compile WebAssembly from here, as the speech recognizer does.
        own: Paths that start with this are for our own pages and for programs only.
        body_bytes: Maximum length of a request's body.
        shares: Tells requests with a valid token from others, if there are tokens.
        told: Returns the content type and the body of a refusal.
    """

    def __init__(
        self,
        app: App,
        hosts: frozenset[str],
        scheme: str,
        *,
        compiles: bool = False,
        own: str = "/api/",
        body_bytes: int = BODY_BYTES,
        shares: Shares | None = None,
        told: Callable[[RequestRejectedError], tuple[bytes, bytes]] = in_words,
    ) -> None:
        self._app = app
        self._headers = HEADERS if not compiles else HEADERS | {"content-security-policy": COMPILING_POLICY}
        self._hosts = frozenset(host.lower() for host in hosts)
        self._origins = frozenset(f"{scheme}://{host}" for host in self._hosts)
        self._own = own
        self._body_bytes = body_bytes
        self._shares = shares
        self._told = told

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Handle one connection."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
        elif scope["type"] == "http":
            await self._http(scope, receive, _with_headers(send, self._headers_for(scope["path"])))
        # There are no websockets: a request for one is closed.

    def _headers_for(self, path: str) -> dict[str, str]:
        return self._headers | {"cache-control": CACHED} if path.startswith(VOICE) else self._headers

    async def _http(self, scope: Scope, receive: Receive, send: Send) -> None:
        place: Place | None = scope.get("state", {}).get(PLACE)
        try:
            body = await self._checked(scope, receive, place)
            if place is not None:
                place.request_read()
            await self._app(scope, _replay(body, receive), send)
        except RequestRejectedError as refused:
            await _answer(send, refused.status, *self._told(refused))
        finally:
            if place is not None:
                place.answered()

    async def _checked(self, scope: Scope, receive: Receive, place: Place | None) -> bytes:
        """Return the request's body.

        Raises:
            RequestRejectedError: The request fails a check.
        """
        if place is not None:
            place.received(0)  # its head may have come together with the request before it
        headers = _single(scope)
        self._check_sender(scope, headers)
        if place is not None and self._shares is not None:
            shares = self._shares(scope["path"], headers.get("authorization", ""))
            if shares:
                place.hold(*shares)
        if scope["method"] in ("GET", "HEAD"):
            return b""
        if scope["method"] != "POST":
            raise RequestRejectedError(405, "Only GET and POST are served.")
        if headers.get("content-type", "").partition(";")[0].strip().lower() != "application/json":
            raise RequestRejectedError(415, "Send JSON: content-type application/json.")
        return await _body(headers.get("content-length", ""), receive, self._body_bytes)

    def _check_sender(self, scope: Scope, headers: dict[str, str]) -> None:
        """Check who is asked, who asks, and the address.

        Raises:
            RequestRejectedError: The request is for another host, or from a page of another site, or its address is
                too long.
        """
        if headers.get("host", "").lower() not in self._hosts:
            raise RequestRejectedError(
                421, "This address is not one of this server's. Use the one that it printed at start."
            )
        origin = headers.get("origin")
        if origin is not None and origin not in self._origins:
            raise RequestRejectedError(403, "Pages of other sites may not talk to this server.")
        if headers.get("sec-fetch-site", "none") not in SAME and scope["path"].startswith(self._own):
            raise RequestRejectedError(403, "Pages of other sites may not talk to this server.")
        if len(scope.get("raw_path") or b"") + len(scope.get("query_string", b"")) > TARGET_BYTES:
            raise RequestRejectedError(414, "The address is too long.")


def _single(scope: Scope) -> dict[str, str]:
    """Return the request's headers by name.

    Raises:
        RequestRejectedError: A header that matters occurs twice.
    """
    found: dict[str, str] = {}
    for raw_name, raw_value in scope["headers"]:
        name = raw_name.decode("latin-1").lower()
        if name in found and name in ("host", "origin", "content-length", "authorization"):
            raise RequestRejectedError(400, f"The header {name} occurs twice.")
        found[name] = raw_value.decode("latin-1")
    return found


async def _body(told: str, receive: Receive, most: int) -> bytes:
    """Return the body up to the limit.

    Raises:
        RequestRejectedError: It is longer. The rest is not read.
    """
    if told.isdecimal() and (len(told) > LENGTH_DIGITS or int(told) > most):
        raise RequestRejectedError(413, f"At most {most} bytes are read.")
    body = bytearray()
    while True:
        message = await receive()
        if message["type"] != "http.request":
            raise RequestRejectedError(400, "The request ended early.")
        body += message.get("body", b"")
        if len(body) > most:
            raise RequestRejectedError(413, f"At most {most} bytes are read.")
        if not message.get("more_body", False):
            return bytes(body)


def _replay(body: bytes, receive: Receive) -> Receive:
    """Return the body that was read, once, and then whatever still comes."""
    given = False

    async def again() -> Message:
        nonlocal given
        if given:
            return await receive()
        given = True
        return {"type": "http.request", "body": body, "more_body": False}

    return again


def _with_headers(send: Send, headers: dict[str, str]) -> Send:
    async def sending(message: Message) -> None:
        if message["type"] == "http.response.start":
            ours = {name.encode(): value.encode() for name, value in headers.items()}
            others = [(name, value) for name, value in message.get("headers", []) if name.lower() not in ours]
            message = {**message, "headers": [*others, *ours.items()]}
        await send(message)

    return sending


async def _answer(send: Send, status: int, kind: bytes, body: bytes) -> None:
    headers = [(b"content-type", kind), (b"content-length", str(len(body)).encode()), (b"connection", b"close")]
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": body})
