"""Rates: a burst, and then so many a second."""

from __future__ import annotations

from stucksolver_passenger.server.rate_limits import KNOWN, Limiter, RateLimit

TWO_A_SECOND = RateLimit(per_s=2.0, burst=3.0)


class Clock:
    now_s = 100.0

    def __call__(self):
        return self.now_s


def test_a_burst_is_allowed_and_then_so_many_a_second():
    clock = Clock()
    limiter = Limiter(clock)
    assert [limiter.allows(TWO_A_SECOND, "a") for _ in range(4)] == [True, True, True, False]
    clock.now_s += 0.5
    assert [limiter.allows(TWO_A_SECOND, "a") for _ in range(2)] == [True, False]


def test_one_does_not_use_up_what_is_anothers():
    limiter = Limiter(Clock())
    for _ in range(4):
        limiter.allows(TWO_A_SECOND, "a")
    assert limiter.allows(TWO_A_SECOND, "b")


def test_limiter_changing_client_names_use_bounded_memory():
    """A client that always changes its name does not fill the memory of the limiter."""
    limiter = Limiter(Clock())
    for i in range(KNOWN + 100):
        limiter.allows(TWO_A_SECOND, str(i))
    assert len(limiter._left) == KNOWN
