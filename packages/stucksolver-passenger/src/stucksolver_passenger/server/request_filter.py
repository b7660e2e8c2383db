"""Checks that precede every request, and the headers of every response: plain ASGI."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Hashable, MutableMapping
from typing import Any

from stucksolver_passenger.server.connection_limits import ConnectionSlot
from stucksolver_passenger.server.rate_limits import BODY_BYTES, TARGET_BYTES

Scope = MutableMapping[str, Any]
Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]
Shares = Callable[[str, str], tuple[tuple[Hashable, int], ...]]
"""Returns, for a path and an authorization header, the shares in which a request counts; none without a valid token."""

CONNECTION_SLOT = "slot"
"""Key of the connection's slot in a request's state."""
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self' data:; "
    "form-action 'none'; base-uri 'none'; frame-ancestors 'none'"
)
"""No inline code, no content of other hosts, no frames. `data:` is for the camera's image and the page's own icon."""
COMPILING_POLICY = POLICY.replace("script-src 'self'", "script-src 'self' 'wasm-unsafe-eval'")
"""With the speech recognizer, WebAssembly may be compiled. Text still never becomes a script."""
LENGTH_DIGITS = 12
"""Maximum number of digits of a stated length. Python rejects the conversion of very long numbers. Ours."""
VOICE = "/voice/"
CACHED = "private, max-age=31536000, immutable"
"""Cache policy of the recognizer's files, 40 MB with their version in the path: a phone fetches them once."""
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
"""Values that a browser sends for the page's own requests, or for an address that a person typed."""


class RequestRejectedError(Exception):
    """A request is rejected with a status and a sentence."""

    def __init__(self, status: int, why: str) -> None:
        super().__init__(why)
        self.status = status
        self.why = why


def in_words(refused: RequestRejectedError) -> tuple[bytes, bytes]:
    """Return the content type and the body of a rejection in plain text."""
    return b"text/plain; charset=utf-8", refused.why.encode()


class RequestFilter:
    """Accepts only requests to one of the server's hosts and from the server's own page.

    A page of another site whose name points to this machine (DNS rebinding) still sends its own name as host. A page of
    another site that posts to this server (CSRF) sends its own origin.

    Args:
        hosts: Accepted values of the header, for example `127.0.0.1:8765`.
        compiles: The page may compile WebAssembly from this server, as the speech recognizer does.
        own: Prefix of the paths that only the server's own pages and programs may request.
        body_bytes: Maximum length of a request's body.
        shares: Distinguishes requests with a valid token from others, if there are tokens.
        told: Returns the content type and the body of a rejection.
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
        rejection_body: Callable[[RequestRejectedError], tuple[bytes, bytes]] = in_words,
    ) -> None:
        self._app = app
        self._headers = HEADERS if not compiles else HEADERS | {"content-security-policy": COMPILING_POLICY}
        self._hosts = frozenset(host.lower() for host in hosts)
        self._origins = frozenset(f"{scheme}://{host}" for host in self._hosts)
        self._own = own
        self._body_bytes = body_bytes
        self._shares = shares
        self._rejection_body = rejection_body

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Handle one connection."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
        elif scope["type"] == "http":
            await self._http(scope, receive, _with_headers(send, self._headers_for(scope["path"])))
        # The server has no websockets, so it closes a request for one.

    def _headers_for(self, path: str) -> dict[str, str]:
        return self._headers | {"cache-control": CACHED} if path.startswith(VOICE) else self._headers

    async def _http(self, scope: Scope, receive: Receive, send: Send) -> None:
        slot: ConnectionSlot | None = scope.get("state", {}).get(CONNECTION_SLOT)
        try:
            body = await self._checked(scope, receive, slot)
            if slot is not None:
                slot.request_read()
            await self._app(scope, _replay(body, receive), send)
        except RequestRejectedError as refused:
            # The client gets the rejection as its response.
            await _answer(send, refused.status, *self._rejection_body(refused))
        finally:
            if slot is not None:
                slot.answered()

    async def _checked(self, scope: Scope, receive: Receive, slot: ConnectionSlot | None) -> bytes:
        """Return the request's body.

        Raises:
            RequestRejectedError: The request fails a check.
        """
        if slot is not None:
            slot.received(0)  # its head may have arrived together with the previous request
        headers = _single(scope)
        self._check_sender(scope, headers)
        if slot is not None and self._shares is not None:
            shares = self._shares(scope["path"], headers.get("authorization", ""))
            if shares:
                slot.hold(*shares)
        if scope["method"] in ("GET", "HEAD"):
            return b""
        if scope["method"] != "POST":
            raise RequestRejectedError(405, "Only GET and POST are served.")
        if headers.get("content-type", "").partition(";")[0].strip().lower() != "application/json":
            raise RequestRejectedError(415, "Send JSON: content-type application/json.")
        return await _body(headers.get("content-length", ""), receive, self._body_bytes)

    def _check_sender(self, scope: Scope, headers: dict[str, str]) -> None:
        """Check the host, the origin and the address of a request.

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
        RequestRejectedError: A relevant header occurs twice.
    """
    found: dict[str, str] = {}
    for raw_name, raw_value in scope["headers"]:
        name = raw_name.decode("latin-1").lower()
        if name in found and name in ("host", "origin", "content-length", "authorization"):
            raise RequestRejectedError(400, f"The header {name} occurs twice.")
        found[name] = raw_value.decode("latin-1")
    return found


async def _body(stated_length: str, receive: Receive, most: int) -> bytes:
    """Return the body up to the limit.

    Raises:
        RequestRejectedError: The body is longer. The rest is not read.
    """
    if stated_length.isdecimal() and (len(stated_length) > LENGTH_DIGITS or int(stated_length) > most):
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
    """Return a receiver that yields the body once, and then all later messages."""
    delivered = False

    async def again() -> Message:
        nonlocal delivered
        if delivered:
            return await receive()
        delivered = True
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
