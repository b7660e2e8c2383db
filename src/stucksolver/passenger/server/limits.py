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
STREAMS = 100
"""Number of pages that may be open at once."""
KNOWN = 2000
"""Number of buckets kept; the least recently used one is dropped first."""


@dataclass(frozen=True)
class Rate:
    """`per_s` per second in the long run, and `burst` at once."""

    per_s: float
    burst: float


COMMANDS = Rate(per_s=1.0, burst=6.0)
"""For one page."""
ALL_COMMANDS = Rate(per_s=5.0, burst=30.0)
"""For all pages of one vehicle, except calls to stop."""
STOPS = Rate(per_s=5.0, burst=20.0)
"""Calls to stop have their own limit: nobody can crowd them out with words."""
REQUESTS = Rate(per_s=30.0, burst=120.0)
"""For one address, for everything that needs a token."""
FAILURES = Rate(per_s=0.2, burst=10.0)
"""Wrong tokens from one address."""


class Limiter:
    """Token buckets by name (Turner 1986): each use takes one, and they refill with time."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._left: OrderedDict[tuple[str, ...], tuple[float, float]] = OrderedDict()

    def allows(self, rate: Rate, *name: str, cost: float = 1.0) -> bool:
        """Take `cost` from a bucket. Returns False, and takes nothing, if there is not enough in it."""
        now = self._clock()
        left, since_s = self._left.pop(name, (rate.burst, now))
        left = min(rate.burst, left + (now - since_s) * rate.per_s)
        allowed = left >= cost
        self._left[name] = (left - cost if allowed else left, now)
        if len(self._left) > KNOWN:
            self._left.popitem(last=False)
        return allowed

    def exhausted(self, rate: Rate, *name: str) -> bool:
        """True if there is not enough for one more use. Takes nothing."""
        left, since_s = self._left.get(name, (rate.burst, 0.0))
        return name in self._left and left + (self._clock() - since_s) * rate.per_s < 1.0
