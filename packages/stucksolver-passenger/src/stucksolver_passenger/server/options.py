"""The address at which the server listens, and the host names that it accepts."""

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
        names: Host names that the server accepts besides its addresses, for example `car.example`.
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
        """True if only this machine can reach the server."""
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
                f"not an address of this machine: {self.listen!r}. Give one of its addresses"
            ) from None
        if (self.cert is None) != (self.key is None):
            raise ServerOptionsError("--cert and --key must be given together")
        if self.cert is not None and self.key is not None:
            try:
                ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER).load_cert_chain(self.cert, self.key)
            except (OSError, ssl.SSLError) as error:
                raise ServerOptionsError(
                    f"not a certificate and its key: {self.cert} and {self.key}: {error}. Give two matching PEM files"
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
                f"cannot listen at address: {self.listen}:{self.port}: {error.strerror or error}. "
                "Choose another port or address"
            ) from error
        return found

    def addresses(self, port: int) -> tuple[str, ...]:
        """Return the addresses `HOST:PORT` for browsers. The first one is for display."""
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
            # Without a network the machine has no address for others.
            return []
        return [str(probe.getsockname()[0])]
