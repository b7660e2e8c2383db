"""Where the server listens, and under which names it may be called."""

from __future__ import annotations

import ipaddress
import socket
import ssl
from dataclasses import dataclass
from pathlib import Path

from stucksolver.passenger.recognizer import Recognizer

LOOPBACK = "127.0.0.1"


class PageError(ValueError):
    """The page cannot be served so; the message says why, and what to do."""


@dataclass(frozen=True)
class PageOptions:
    """`listen`: an address of this machine. `port`: 0 for any that is free. `cert`, `key`: PEM files, for HTTPS.

    `names`: by which the server may be called beside its addresses, as `car.example`. `drawing`: the folder of the
    scripts that draw the view from above; without it there is no such view.
    `recognizer`: of speech, for the browser; without it pages have their browser's own, if that has one.
    """

    listen: str = LOOPBACK
    port: int = 0
    cert: Path | None = None
    key: Path | None = None
    names: tuple[str, ...] = ()
    drawing: Path | None = None
    recognizer: Recognizer | None = None

    @property
    def scheme(self) -> str:
        """`https` with a certificate."""
        return "http" if self.cert is None else "https"

    @property
    def is_local(self) -> bool:
        """Can nobody but this machine reach it?"""
        return ipaddress.ip_address(self.listen).is_loopback

    def check(self) -> None:
        """Raises `PageError`."""
        try:
            ipaddress.ip_address(self.listen)
        except ValueError:
            raise PageError(f"{self.listen!r} is not an address to listen at; give one of this machine's") from None
        if (self.cert is None) != (self.key is None):
            raise PageError("a certificate and its key go together: give both --cert and --key")
        if self.cert is not None and self.key is not None:
            try:
                ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER).load_cert_chain(self.cert, self.key)
            except (OSError, ssl.SSLError) as error:
                raise PageError(f"{self.cert} and {self.key} are not a certificate with its key: {error}") from error

    def bound(self) -> socket.socket:
        """A socket that listens there. Raises `PageError`."""
        family = socket.AF_INET6 if ":" in self.listen else socket.AF_INET
        found = socket.socket(family, socket.SOCK_STREAM)
        found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            found.bind((self.listen, self.port))
            found.listen(128)
        except OSError as error:
            found.close()
            raise PageError(f"cannot listen at {self.listen}:{self.port}: {error.strerror or error}") from error
        return found

    def addresses(self, port: int) -> tuple[str, ...]:
        """`HOST:PORT` as a browser may call it; the first is the one to print."""
        hosts: list[str] = []
        if ipaddress.ip_address(self.listen).is_unspecified:
            hosts += [*_own_addresses(), LOOPBACK]
        else:
            hosts.append(self.listen)
        if self.is_local or ipaddress.ip_address(self.listen).is_unspecified:
            hosts.append("localhost")
        written = [f"[{host}]" if ":" in host else host for host in (*self.names, *hosts)]
        usual = 443 if self.scheme == "https" else 80
        plain = written if port == usual else []
        return tuple(dict.fromkeys([f"{host}:{port}" for host in written] + plain))


def _own_addresses() -> list[str]:
    """Addresses of this machine that others may reach it at: the one that packets to the world would come from."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))  # an address for documentation (RFC 5737); nothing is sent
        except OSError:
            return []
        return [str(probe.getsockname()[0])]
