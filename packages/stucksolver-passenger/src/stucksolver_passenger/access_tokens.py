"""Roles: tokens that name a role, and for a passenger the vehicle.

A token is `p.VEHICLE.MAC` or `o.MAC`. The MAC is HMAC-SHA256 (RFC 2104) over the part before it, with a secret that the
server's owner makes at the start. So no list of tokens is kept, and every vehicle has its own.
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
MAC_BYTES = 18
"""144 bits: far beyond guessing, and short enough for a QR code."""
LONGEST_TOKEN = 100


@dataclass(frozen=True)
class TokenHolder:
    """The holder of a token. `vehicle` is the only one that a passenger may see and talk to; None for operators."""

    role: Person
    vehicle: str | None = None

    def may_use(self, vehicle: str) -> bool:
        """True if the holder may use this vehicle."""
        return self.role == "operator" or self.vehicle == vehicle


class Tokens:
    """Makes and checks tokens with a secret."""

    def __init__(self, secret: bytes | None = None) -> None:
        self.secret = secret or secrets.token_bytes(SECRET_BYTES)

    def passenger(self, vehicle: str) -> str:
        """Return the token of a vehicle's passengers.

        Raises:
            ValueError: The id of the vehicle is invalid.
        """
        if not VEHICLE_ID.fullmatch(vehicle):
            raise ValueError(f"{vehicle!r} is not a valid vehicle id; use up to 40 letters, digits, - and _")
        return self._sealed(f"p.{vehicle}")

    def operator(self) -> str:
        """Return the operators' token, for all vehicles."""
        return self._sealed("o")

    def holder(self, token: str) -> TokenHolder | None:
        """Return the holder of a token; None for a foreign one. Takes constant time, so that a near miss is not
        revealed.
        """
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
