"""Rate limits of the server. The numbers are ours."""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass

BODY_BYTES = 4096
"""Longest body of a request (bytes). The longest accepted sentence has 500 characters."""
TARGET_BYTES = 1024
"""Longest path and query of a request (bytes)."""
PASSENGER_STREAMS = 6
"""Maximum number of pages that may be open at once with one passenger's token."""
ALL_PASSENGER_STREAMS = 200
"""The same limit for all passengers' tokens together."""
OPERATOR_STREAMS = 64
"""The same limit for the operators' token, which all operators share."""
PASSENGER_REQUESTS = 16
"""Number of requests of one passenger's token, with open pages, that newer connections cannot replace."""
ALL_PASSENGER_REQUESTS = 400
"""The same number for all passengers' tokens together."""
OPERATOR_REQUESTS = 128
"""The same number for the operators' token."""
STOP_REQUESTS = 16
"""Number of calls to stop of one token that newer connections cannot replace, in addition to its other requests."""
ALL_STOP_REQUESTS = 400
"""The same number for all tokens together."""
KNOWN = 2000
"""Maximum number of buckets. The least recently used one is removed first."""


@dataclass(frozen=True)
class RateLimit:
    """`per_s` per second on average, and `burst` at once."""

    per_s: float
    burst: float


COMMANDS = RateLimit(per_s=1.0, burst=6.0)
"""Commands of one page."""
ALL_COMMANDS = RateLimit(per_s=5.0, burst=30.0)
"""Commands of all pages of one vehicle and role, except calls to stop and noes."""
STOPS = RateLimit(per_s=5.0, burst=20.0)
"""Calls to stop, for one vehicle and role. This bucket counts nothing else, and nothing else limits them."""
NOES = RateLimit(per_s=5.0, burst=20.0)
"""Noes to questions, for one vehicle and role. Utterances cannot use up this bucket."""
SPOKEN_STOPS = RateLimit(per_s=5.0, burst=20.0)
"""Short sentences with a word such as "stop", for one vehicle and role. Other utterances cannot use up this bucket."""
REQUESTS = RateLimit(per_s=30.0, burst=120.0)
"""Requests of one token at one address, except calls to stop."""
FAILURES = RateLimit(per_s=0.2, burst=10.0)
"""Invalid tokens from one address. They limit only further invalid tokens."""


class Limiter:
    """Token buckets by name (Turner 1986). Each use takes one token, and a bucket refills with time."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._left: OrderedDict[tuple[str, ...], tuple[float, float]] = OrderedDict()

    def allows(self, rate: RateLimit, *name: str, cost: float = 1.0) -> bool:
        """Take `cost` from a bucket. Returns False without taking anything if the bucket has less."""
        now = self._clock()
        left, since_s = self._left.pop(name, (rate.burst, now))
        left = min(rate.burst, left + (now - since_s) * rate.per_s)
        allowed = left >= cost
        self._left[name] = (left - cost if allowed else left, now)
        if len(self._left) > KNOWN:
            self._left.popitem(last=False)
        return allowed
