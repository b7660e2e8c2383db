"""Exchanges one tick and one answer with the solver per step, in lockstep or live.

In lockstep the world waits: a step ends when the answer has arrived, or with an error after a generous limit. Live, the
world does not wait: a step waits for half a tick at most, and not at all while an answer is late. A late answer is used
on the tick on which it arrives.

Each tick has a number, and the answer to it carries the same number. All other messages are dropped: an answer to
another tick, a second answer, an answer that came before its tick was sent.
"""

from __future__ import annotations

import math
import time
from typing import Any, Callable

from stucksolver_bridge.message_socket import Wire, WireError

OLD_TICKS = 10
"""Delay from which an answer is outdated (ticks): a directive is valid for as long (`EXPIRES_TICKS` of stucksolver)."""
WAIT_SHARE = 0.5
"""Maximum share of a tick for which a live step waits; the stack uses the rest. Ours."""
MOST_STRAYS = 100
"""Number of messages in a row without a matching tick beyond which the solver counts as failed. Ours."""
NEEDS = (
    "surroundings",
    "scene",
    "actors",
    "vehicle_lights",
    "light_state",
    "sensors",
    "sensors_without_picture",
)
"""Names of the data that the solver may request."""

Give = Callable[[str], Any]


class SolverTimeoutError(WireError):
    """No answer of the solver has come within its time limit."""


class SolverExchange:
    """The exchange over one wire. Its methods raise `WireError`.

    `wait_s`: maximum duration of a live step (s); None in lockstep. `limit_s`: longest time without an answer (s).
    """

    def __init__(self, wire: Wire, wait_s: float | None, limit_s: float) -> None:
        self._wire = wire
        self._wait_s = wait_s
        self._limit_s = limit_s
        self._sent_s: float | None = None
        """Time at which the unanswered tick was sent (s); None without one."""
        self._ticks = 0
        """Ticks since then."""
        self.late_ticks = 0
        """Ticks between the tick of the last answer and the tick on which it came."""
        self.strays = 0
        """Number of messages without a matching tick."""
        self._strays_in_a_row = 0
        self._number = 0
        """Number of the last tick that was sent."""
        self._utterances: list[str] = []
        self._needs_resend = False

    def step(self, tick: dict[str, Any], give: Give) -> dict[str, Any] | None:
        """Return the answer to this tick, or a late answer to an earlier one; None if no answer has come yet.

        While an answer is late, a tick's `say` and `again` are stored and sent with the next tick that is sent.
        """
        self._store_requests(tick)
        begun_s = time.monotonic()
        if self._sent_s is None:
            self._drop_early_messages()
            self._send_tick(tick, begun_s)
            self.late_ticks = 0
            return self._answer(begun_s + self._longest_s, give, waits=True)
        self._ticks += 1
        answer = self._answer(begun_s + self._longest_s, give, waits=False)
        if answer is None:
            return None
        self.late_ticks = self._ticks
        is_outdated = self._ticks >= OLD_TICKS
        self._needs_resend = self._needs_resend or is_outdated
        # This tick is sent at once. The solver works on it meanwhile, and its answer is read on the next tick.
        self._drop_early_messages()
        self._send_tick(tick, begun_s)
        return None if is_outdated else answer

    @property
    def _longest_s(self) -> float:
        return self._limit_s if self._wait_s is None else self._wait_s

    def _store_requests(self, tick: dict[str, Any]) -> None:
        if "say" in tick:
            self._utterances.append(str(tick["say"]))
        self._needs_resend = self._needs_resend or bool(tick.get("again"))

    def _send_tick(self, tick: dict[str, Any], now_s: float) -> None:
        message = {name: value for name, value in tick.items() if name not in ("say", "again")}
        if self._utterances:
            message["say"] = self._utterances.pop(0)
        if self._needs_resend:
            message["again"], self._needs_resend = True, False
        self._sent_s, self._ticks = now_s, 0
        self._number += 1
        self._wire.post({"tick": message, "number": self._number})

    def _answer(self, until_s: float, give: Give, waits: bool) -> dict[str, Any] | None:
        assert self._sent_s is not None
        while True:
            answer = self._wire.poll_message(until_s, waits)
            if answer is None:
                break
            if self._is_stray(answer):
                continue
            if "need" not in answer:
                self._sent_s, self._strays_in_a_row = None, 0
                del answer["number"]
                return answer
            self._send_data(answer["need"], give)
            if time.monotonic() >= until_s:
                break
        if time.monotonic() - self._sent_s >= self._limit_s:
            raise SolverTimeoutError(f"no answer within {self._limit_s:g} s")
        return None

    def _drop_early_messages(self) -> None:
        """Drop messages that arrived before the next tick is sent: they cannot be answers to that tick."""
        while True:
            message = self._wire.poll_message(time.monotonic(), waits=False)
            if message is None:
                return
            self._is_stray(message, is_answer=False)

    def _is_stray(self, message: dict[str, Any], is_answer: bool = True) -> bool:
        """Return True for a message that does not belong to the last tick, and count it.

        Raises `WireError` after too many of them in a row, and for an error message of the solver.
        """
        if "error" in message:
            raise WireError(str(message["error"]))
        number = message.get("number")
        # The type is checked too, because True and 1.0 are equal to 1.
        if is_answer and type(number) is int and number == self._number:
            return False
        self.strays += 1
        self._strays_in_a_row += 1
        if self._strays_in_a_row > MOST_STRAYS:
            raise WireError(f"more than {MOST_STRAYS} messages in a row belong to no tick that was sent")
        return True

    def _send_data(self, need: Any, give: Give) -> None:
        if need not in NEEDS:
            raise WireError(f"the solver requests {str(need)[:40]!r}; it must be one of {', '.join(NEEDS)}")
        self._wire.post({"given": give(need), "number": self._number})


def limit_of(seconds: float, what: str) -> float:
    """Return a configured time limit as a float (s). Raises `ValueError` unless it is a positive number."""
    if isinstance(seconds, bool) or not isinstance(seconds, (int, float)) or not 0.0 < seconds < math.inf:
        raise ValueError(f"{what} must be a number of seconds above 0, not {seconds!r}")
    return float(seconds)
