"""Rate limits of the server."""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass

BODY_BYTES = 4096
"""Of a request. The longest accepted sentence has 500 characters."""
TARGET_BYTES = 1024
"""Of a request's path and query."""
PASSENGER_STREAMS = 6
"""Number of pages that may be open at once with one passenger's token."""
ALL_PASSENGER_STREAMS = 200
"""The same with all passengers' tokens."""
OPERATOR_STREAMS = 64
"""The same with the operators' token, which all of them share."""
PASSENGER_REQUESTS = 16
"""Number of requests of one passenger's token, open pages included, that are safe from newer connections."""
ALL_PASSENGER_REQUESTS = 400
"""The same of all passengers' tokens."""
OPERATOR_REQUESTS = 128
"""The same of the operators' token."""
STOP_REQUESTS = 16
"""Number of calls to stop of one token that are safe from newer connections, besides its other requests."""
ALL_STOP_REQUESTS = 400
"""The same of all tokens."""
KNOWN = 2000
"""Number of buckets kept; the least recently used one is dropped first."""


@dataclass(frozen=True)
class RateLimit:
    """`per_s` per second in the long run, and `burst` at once."""

    per_s: float
    burst: float


COMMANDS = RateLimit(per_s=1.0, burst=6.0)
"""For one page."""
ALL_COMMANDS = RateLimit(per_s=5.0, burst=30.0)
"""For all pages of one vehicle and role, except calls to stop and noes."""
STOPS = RateLimit(per_s=5.0, burst=20.0)
"""Calls to stop, for one vehicle and role. Nothing else is counted here, and nothing else limits them."""
NOES = RateLimit(per_s=5.0, burst=20.0)
"""Noes to questions, for one vehicle and role: words cannot crowd them out."""
SPOKEN_STOPS = RateLimit(per_s=5.0, burst=20.0)
"""Short sentences with a word such as "stop", for one vehicle and role: other words cannot crowd them out."""
REQUESTS = RateLimit(per_s=30.0, burst=120.0)
"""For one token at one address, for everything but calls to stop."""
FAILURES = RateLimit(per_s=0.2, burst=10.0)
"""Wrong tokens from one address. They limit only further wrong tokens."""


class Limiter:
    """Token buckets by name (Turner 1986): each use takes one, and they refill with time."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._left: OrderedDict[tuple[str, ...], tuple[float, float]] = OrderedDict()

    def allows(self, rate: RateLimit, *name: str, cost: float = 1.0) -> bool:
        """Take `cost` from a bucket. Returns False, and takes nothing, if there is not enough in it."""
        now = self._clock()
        left, since_s = self._left.pop(name, (rate.burst, now))
        left = min(rate.burst, left + (now - since_s) * rate.per_s)
        allowed = left >= cost
        self._left[name] = (left - cost if allowed else left, now)
        if len(self._left) > KNOWN:
            self._left.popitem(last=False)
        return allowed
