"""One exchange with the solver on each tick, in lockstep or live.

In lockstep the world waits: a step ends when the answer has arrived, or with an error after a generous limit. Live, the
world does not wait: a step waits for half a tick at most, and not at all while an answer is late. A late answer is used
on the tick on which it has arrived.

Each tick has a number, and the answer to it carries the same one. Anything else that arrives is dropped: an answer to
another tick, a second answer, one that came before its tick was sent.
"""

from __future__ import annotations

import math
import time
from typing import Any, Callable

from stucksolver_bridge.message_socket import Wire, WireError

OLD_TICKS = 10
"""An answer this many ticks late is outdated: an order is valid for as long (`EXPIRES_TICKS` of stucksolver)."""
WAIT_SHARE = 0.5
"""A step waits for at most this share of a tick; the rest is left to the stack."""
MOST_STRAYS = 100
"""After so many messages in a row that belong to no tick, the solver counts as failed."""
NEEDS = (
    "surroundings",
    "scene",
    "actors",
    "vehicle_lights",
    "light_state",
    "sensors",
    "sensors_without_picture",
)

Give = Callable[[str], Any]


class SolverTimeoutError(WireError):
    """The solver has not answered within its time limit."""


class SolverExchange:
    """`wait_s`: how long a step may take live; None in lockstep. `limit_s`: longest silence of the solver.

    Raises `WireError`.
    """

    def __init__(self, wire: Wire, wait_s: float | None, limit_s: float) -> None:
        self._wire = wire
        self._wait_s = wait_s
        self._limit_s = limit_s
        self._asked_s: float | None = None
        """When the unanswered tick was sent; None if there is none."""
        self._ticks = 0
        """Ticks since then."""
        self.late_ticks = 0
        """How many ticks ago the tick of the last answer was sent."""
        self.strays = 0
        """Messages so far that belonged to no tick that was asked about."""
        self._strays_in_a_row = 0
        self._number = 0
        """Number of the last tick that was sent."""
        self._words: list[str] = []
        self._again = False

    def step(self, tick: dict[str, Any], give: Give) -> dict[str, Any] | None:
        """Return the answer to this tick, or a late answer to an earlier one; None if there is none yet.

        If `say` and `again` of a tick cannot be sent now, they are sent with the next tick that can be.
        """
        self._keep(tick)
        begun_s = time.monotonic()
        if self._asked_s is None:
            self._drop_waiting()
            self._tell(tick, begun_s)
            self.late_ticks = 0
            return self._answer(begun_s + self._longest_s, give, waits=True)
        self._ticks += 1
        answer = self._answer(begun_s + self._longest_s, give, waits=False)
        if answer is None:
            return None
        self.late_ticks = self._ticks
        old = self._ticks >= OLD_TICKS
        self._again = self._again or old
        # The solver works on this tick meanwhile; its answer is read on the next one.
        self._drop_waiting()
        self._tell(tick, begun_s)
        return None if old else answer

    @property
    def _longest_s(self) -> float:
        return self._limit_s if self._wait_s is None else self._wait_s

    def _keep(self, tick: dict[str, Any]) -> None:
        if "say" in tick:
            self._words.append(str(tick["say"]))
        self._again = self._again or bool(tick.get("again"))

    def _tell(self, tick: dict[str, Any], now_s: float) -> None:
        told = {name: value for name, value in tick.items() if name not in ("say", "again")}
        if self._words:
            told["say"] = self._words.pop(0)
        if self._again:
            told["again"], self._again = True, False
        self._asked_s, self._ticks = now_s, 0
        self._number += 1
        self._wire.post({"tick": told, "number": self._number})

    def _answer(self, until_s: float, give: Give, waits: bool) -> dict[str, Any] | None:
        assert self._asked_s is not None
        while True:
            answer = self._wire.look(until_s, waits)
            if answer is None:
                break
            if self._is_stray(answer):
                continue
            if "need" not in answer:
                self._asked_s, self._strays_in_a_row = None, 0
                del answer["number"]
                return answer
            self._give(answer["need"], give)
            if time.monotonic() >= until_s:
                break
        if time.monotonic() - self._asked_s >= self._limit_s:
            raise SolverTimeoutError(f"no answer within {self._limit_s:g} s")
        return None

    def _drop_waiting(self) -> None:
        """Drop what arrived before the next tick is sent: it cannot be an answer to that tick."""
        while True:
            message = self._wire.look(time.monotonic(), waits=False)
            if message is None:
                return
            self._is_stray(message, waited_for=False)

    def _is_stray(self, message: dict[str, Any], waited_for: bool = True) -> bool:
        """Count a message that is not about the tick that was sent last. Raises `WireError` if there are too many."""
        if "error" in message:
            raise WireError(str(message["error"]))
        number = message.get("number")
        # Not `==` alone: True and 1.0 equal 1.
        if waited_for and type(number) is int and number == self._number:
            return False
        self.strays += 1
        self._strays_in_a_row += 1
        if self._strays_in_a_row > MOST_STRAYS:
            raise WireError(f"{MOST_STRAYS} messages in a row belong to no tick that it was asked about")
        return True

    def _give(self, need: Any, give: Give) -> None:
        if need not in NEEDS:
            raise WireError(f"it asks for {str(need)[:40]!r}, which is not one of {', '.join(NEEDS)}")
        self._wire.post({"given": give(need), "number": self._number})


def limit_of(seconds: float, what: str) -> float:
    """Return a configured time limit, checked. Raises `ValueError`."""
    if isinstance(seconds, bool) or not isinstance(seconds, (int, float)) or not 0.0 < seconds < math.inf:
        raise ValueError(f"{what} must be a number of seconds above 0, not {seconds!r}")
    return float(seconds)
