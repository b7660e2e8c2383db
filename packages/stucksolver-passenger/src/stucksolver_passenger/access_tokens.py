"""Tokens that name a role, and for a passenger the vehicle.

A token is `p.VEHICLE.MAC` or `o.MAC`. The MAC is HMAC-SHA256 (RFC 2104) over the part before it, with a secret that the
server's owner creates at the start. So the server stores no list of tokens, and every vehicle has its own.
"""

from __future__ import annotations

import base64
import hashlib
import hmac
import secrets
from dataclasses import dataclass

from stucksolver.ladder.rung_actions import Person
from stucksolver_passenger.api_types import VEHICLE_ID

SECRET_BYTES = 32
"""Length of a new secret (bytes): the output size of SHA-256."""
MAC_BYTES = 18
"""Length of the MAC (bytes). 144 bits cannot be guessed and still fit into a QR code."""
LONGEST_TOKEN = 100
"""Longest token that is checked (characters). Ours: above the longest valid one."""


@dataclass(frozen=True)
class TokenHolder:
    """Holder of a token. `vehicle` is the only one that a passenger may access; None for operators."""

    role: Person
    vehicle: str | None = None

    def may_use(self, vehicle: str) -> bool:
        """True if the holder may access this vehicle."""
        return self.role == "operator" or self.vehicle == vehicle


class Tokens:
    """Creates and checks tokens with a secret."""

    def __init__(self, secret: bytes | None = None) -> None:
        self.secret = secret or secrets.token_bytes(SECRET_BYTES)

    def passenger(self, vehicle: str) -> str:
        """Return the token of a vehicle's passengers.

        Raises:
            ValueError: The id of the vehicle is invalid.
        """
        if not VEHICLE_ID.fullmatch(vehicle):
            raise ValueError(f"invalid vehicle id: {vehicle!r}. Use up to 40 letters, digits, - and _")
        return self._sealed(f"p.{vehicle}")

    def operator(self) -> str:
        """Return the operators' token, for all vehicles."""
        return self._sealed("o")

    def holder(self, token: str) -> TokenHolder | None:
        """Return the holder of a token; None for an invalid one. The constant time does not reveal a partial match."""
        if len(token) > LONGEST_TOKEN or not token.isascii():
            return None
        claimed, _, _ = token.rpartition(".")
        if not hmac.compare_digest(token.encode(), self._sealed(claimed).encode()):
            return None
        if claimed == "o":
            return TokenHolder("operator")
        kind, _, vehicle = claimed.partition(".")
        return TokenHolder("passenger", vehicle) if kind == "p" and VEHICLE_ID.fullmatch(vehicle) else None

    def _sealed(self, claimed: str) -> str:
        mac = hmac.digest(self.secret, claimed.encode(), hashlib.sha256)[:MAC_BYTES]
        return f"{claimed}.{base64.urlsafe_b64encode(mac).decode()}"
