"""Where the server listens, and the names by which it may be called."""

from __future__ import annotations

import ipaddress
import socket
import ssl
from dataclasses import dataclass
from pathlib import Path

from stucksolver_passenger.speech_recognizer import Recognizer

LOOPBACK = "127.0.0.1"


class ServerOptionsError(ValueError):
    """The page cannot be served with these options. The message says why and what to do."""


@dataclass(frozen=True)
class PageOptions:
    """Options of the server.

    Attributes:
        listen: An address of this machine.
        port: 0 for any free port.
        cert: Certificate for HTTPS, a PEM file.
        key: Its key, a PEM file.
        names: Names by which the server may be called besides its addresses, for example `car.example`.
        drawing: Folder of the scripts that draw the view from above; without it there is no such view.
        recognizer: The speech recognizer for the browser; without it pages use the browser's own, if there is one.
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
        """True if only this machine can reach it."""
        return ipaddress.ip_address(self.listen).is_loopback

    def check(self) -> None:
        """Check the options.

        Raises:
            ServerOptionsError: The page cannot be served with them.
        """
        try:
            ipaddress.ip_address(self.listen)
        except ValueError:
            raise ServerOptionsError(
                f"{self.listen!r} is not an address to listen at; give one of this machine's"
            ) from None
        if (self.cert is None) != (self.key is None):
            raise ServerOptionsError("a certificate and its key go together: give both --cert and --key")
        if self.cert is not None and self.key is not None:
            try:
                ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER).load_cert_chain(self.cert, self.key)
            except (OSError, ssl.SSLError) as error:
                raise ServerOptionsError(
                    f"{self.cert} and {self.key} are not a certificate with its key: {error}"
                ) from error

    def bound(self) -> socket.socket:
        """Return a listening socket.

        Raises:
            ServerOptionsError: The address cannot be used.
        """
        family = socket.AF_INET6 if ":" in self.listen else socket.AF_INET
        found = socket.socket(family, socket.SOCK_STREAM)
        found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            found.bind((self.listen, self.port))
            found.listen(128)
        except OSError as error:
            found.close()
            raise ServerOptionsError(
                f"cannot listen at {self.listen}:{self.port}: {error.strerror or error}"
            ) from error
        return found

    def addresses(self, port: int) -> tuple[str, ...]:
        """Return the addresses `HOST:PORT` that a browser may use; the first is the one to print."""
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
    """Return the addresses at which others may reach this machine: the source address of packets to the outside."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))  # an address for documentation (RFC 5737); nothing is sent
        except OSError:
            return []
        return [str(probe.getsockname()[0])]
