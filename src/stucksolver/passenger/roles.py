"""Who may do what: tokens that name a role, and for a passenger the vehicle.

A token is `p.VEHICLE.MAC` or `o.MAC`: the MAC is HMAC-SHA256 (RFC 2104) over what stands before it, under a secret that
the server's owner makes at start. So no list of tokens is kept, and every vehicle has its own.
"""

from __future__ import annotations

import base64
import hashlib
import hmac
import secrets
from dataclasses import dataclass

from stucksolver.ladder.moves import Person
from stucksolver.passenger.told import VEHICLE_ID

SECRET_BYTES = 32
MAC_BYTES = 18
"""144 bits: far beyond guessing, and short enough for a QR code."""
LONGEST_TOKEN = 100


@dataclass(frozen=True)
class Holder:
    """Whoever holds a token. `vehicle`: the only one that a passenger may see and talk to; None for operators."""

    role: Person
    vehicle: str | None = None

    def may_use(self, vehicle: str) -> bool:
        """Is this vehicle theirs?"""
        return self.role == "operator" or self.vehicle == vehicle


class Tokens:
    """Makes and checks tokens under a secret."""

    def __init__(self, secret: bytes | None = None) -> None:
        self.secret = secret or secrets.token_bytes(SECRET_BYTES)

    def passenger(self, vehicle: str) -> str:
        """The token of a vehicle's passengers. Raises `ValueError` for what is no id of a vehicle."""
        if not VEHICLE_ID.fullmatch(vehicle):
            raise ValueError(f"{vehicle!r} is not a valid vehicle id; use up to 40 letters, digits, - and _")
        return self._sealed(f"p.{vehicle}")

    def operator(self) -> str:
        """The token of the operators: for all vehicles."""
        return self._sealed("o")

    def holder(self, token: str) -> Holder | None:
        """Who a token belongs to; None for one that is not ours. Takes as long for a near miss as for any other."""
        if len(token) > LONGEST_TOKEN or not token.isascii():
            return None
        claimed, _, _ = token.rpartition(".")
        if not hmac.compare_digest(token.encode(), self._sealed(claimed).encode()):
            return None
        if claimed == "o":
            return Holder("operator")
        kind, _, vehicle = claimed.partition(".")
        return Holder("passenger", vehicle) if kind == "p" and VEHICLE_ID.fullmatch(vehicle) else None

    def _sealed(self, claimed: str) -> str:
        mac = hmac.digest(self.secret, claimed.encode(), hashlib.sha256)[:MAC_BYTES]
        return f"{claimed}.{base64.urlsafe_b64encode(mac).decode()}"
