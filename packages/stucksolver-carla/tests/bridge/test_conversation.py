"""Live, no step waits longer than half a tick; where the world waits, for a limited time. The clock is ours."""

from __future__ import annotations

import json
import select
import socket
import struct

import pytest

from stucksolver_bridge import message_socket, solver_exchange
from stucksolver_bridge.message_socket import Wire, WireError
from stucksolver_bridge.solver_exchange import MOST_STRAYS, OLD_TICKS, SolverExchange, SolverTimeoutError, limit_of

TICK_S = 0.05
LIMIT_S = 120.0


class Clock:
    """Stands where `time` does; only waiting makes it go on."""

    def __init__(self):
        self.now_s = 1000.0

    def monotonic(self):
        return self.now_s


class Other:
    """The other end, which says what it is told to, when it is told to."""

    def __init__(self, connected):
        self.socket = connected
        connected.setblocking(False)
        self._heard = b""
        self._waiting = []
        self.number = 0
        """Of the last tick that came."""
        self.later = []
        """(instant, bytes) that come while somebody waits."""

    def says(self, message):
        """An answer to the last tick that came."""
        self._waiting += self._arrived()
        self.raw(framed({"number": self.number, **message}))

    def raw(self, sent):
        self.socket.sendall(sent)

    def heard(self):
        """All messages that have come since the last call."""
        found, self._waiting = [*self._waiting, *self._arrived()], []
        return found

    def _arrived(self):
        try:
            while True:
                self._heard += self.socket.recv(1 << 16)
        except BlockingIOError:
            pass
        found = []
        while len(self._heard) >= 4:
            (length,) = struct.unpack(">I", self._heard[:4])
            if len(self._heard) < 4 + length:
                break
            found.append(json.loads(self._heard[4 : 4 + length]))
            self.number = found[-1]["number"]
            self._heard = self._heard[4 + length :]
        return found


def framed(message):
    text = json.dumps(message).encode()
    return struct.pack(">I", len(text)) + text


@pytest.fixture
def clock(monkeypatch):
    found = Clock()
    monkeypatch.setattr(message_socket, "time", found)
    monkeypatch.setattr(solver_exchange, "time", found)
    return found


@pytest.fixture
def other(clock, monkeypatch):
    """The other end; waiting for it takes no time but that of the clock."""
    ours, theirs = socket.socketpair()
    there = Other(theirs)
    there.ours, there.waited = ours, []

    class Poll:
        def __init__(self):
            self._real = POLL()

        def register(self, *what):
            self._real.register(*what)

        def poll(self, within_ms):
            until = clock.now_s + within_ms / 1000.0
            while there.later and there.later[0][0] <= until and not self._real.poll(0):
                clock.now_s, sent = there.later.pop(0)
                there.raw(sent)
            ready = self._real.poll(0)
            if not ready:
                there.waited.append(within_ms / 1000.0)
                clock.now_s = until
            return ready

    monkeypatch.setattr(message_socket.select, "poll", Poll)
    yield there
    ours.close()
    theirs.close()


POLL = select.poll


def live(other):
    return SolverExchange(Wire(other.ours, message_socket.ANSWER_BYTES), 0.5 * TICK_S, LIMIT_S)


def lockstep(other, limit_s=LIMIT_S):
    return SolverExchange(Wire(other.ours, message_socket.ANSWER_BYTES), None, limit_s)


def ticks(clock, talk, count, **more):
    """So many ticks of a world that goes on; each answer, and the longest step."""
    answers, longest = [], 0.0
    for k in range(count):
        begun = clock.now_s
        answers.append(talk.step({"time": k, **more}, lambda what: what))
        longest = max(longest, clock.now_s - begun)
        clock.now_s = begun + TICK_S
    return answers, longest


def test_live_silent_solver_costs_half_a_tick_once(other, clock):
    """A silent solver costs half a tick once, and nothing after that."""
    answers, longest = ticks(clock, live(other), 200)
    assert set(answers) == {None}
    assert longest <= TICK_S / 2 + 1e-3
    assert sum(other.waited) <= TICK_S / 2 + 1e-3
    assert len(other.heard()) == 1, "nor is it told anything meanwhile"


def test_one_byte_a_second_holds_no_tick_up(other, clock):
    answer = framed({"directive": {"kind": "continue"}, "number": 1})
    other.later = [(1000.0 + k, answer[k : k + 1]) for k in range(len(answer))]
    talk = live(other)
    answers, longest = ticks(clock, talk, 20 * (len(answer) - 1) + 2)
    assert longest <= TICK_S / 2 + 1e-3
    assert set(answers) == {None}, "what is whole in the end is old news"
    other.says({})
    assert ticks(clock, talk, 2)[0].count({}) == 1, "the next answer counts again"
    assert [m["tick"].get("again") for m in other.heard()] == [None, True, None]


def test_what_is_late_by_a_few_ticks_is_taken_then(other, clock):
    talk = live(other)
    for late in (1, 3, OLD_TICKS - 2):
        assert ticks(clock, talk, late)[0] == [None] * late
        other.says({"late": late})
        assert ticks(clock, talk, 1)[0] == [{"late": late}]
        assert late <= talk.late_ticks <= late + 1
        other.says({"on": "time"})
        assert ticks(clock, talk, 1)[0] == [{"on": "time"}]


def test_step_answer_too_old_is_dropped_and_asked_for_again(other, clock):
    talk = live(other)
    ticks(clock, talk, OLD_TICKS)
    other.says({"directive": {"kind": "execute"}})
    assert ticks(clock, talk, 1)[0] == [None]
    assert [m["tick"].get("again") for m in other.heard()] == [None, True]


def test_what_the_solver_asks_for_late_is_given_then(other, clock):
    talk = live(other)
    ticks(clock, talk, 2)
    other.says({"need": "surroundings"})
    assert ticks(clock, talk, 1)[0] == [None]
    assert other.heard()[-1] == {"given": "surroundings", "number": 1}
    other.says({})
    assert ticks(clock, talk, 1)[0] == [{}]


def test_live_utterance_during_query_is_sent_with_next_tick(other, clock):
    talk = live(other)
    ticks(clock, talk, 1, say="one")
    ticks(clock, talk, 1, say="two")
    for _ in range(3):
        other.says({})
        ticks(clock, talk, 1)
    assert [m["tick"].get("say") for m in other.heard()] == ["one", "two", None, None]


def test_who_asks_for_ever_holds_no_tick_up(other, clock):
    talk = live(other)
    ticks(clock, talk, 1)
    for _ in range(150):
        other.says({"need": "scene"})

    def slowly(what):
        clock.now_s += 0.001
        return what

    for _ in range(20):
        begun = clock.now_s
        assert talk.step({}, slowly) is None
        assert clock.now_s - begun <= TICK_S / 2 + 2e-3
        clock.now_s = begun + TICK_S


def test_step_waiting_world_gets_any_answer_within_the_limit(other, clock):
    talk = lockstep(other)
    other.later = [(1000.0 + LIMIT_S - 1.0, framed({"thought": "long", "number": 1}))]
    assert talk.step({}, str) == {"thought": "long"}
    with pytest.raises(SolverTimeoutError, match="no answer within 120 s"):
        talk.step({}, str)
    assert clock.now_s == pytest.approx(1000.0 + 2 * LIMIT_S - 1.0, abs=0.01)


@pytest.mark.parametrize("talks", [live, lockstep])
def test_one_byte_a_second_does_not_put_the_limit_off(other, clock, talks):
    other.later = [(1000.0 + k, b"\x00\x00\x20\x00"[k : k + 1] if k < 4 else b"x") for k in range(4000)]
    talk = talks(other)
    with pytest.raises(SolverTimeoutError):
        for _ in range(round(2 * LIMIT_S / TICK_S)):
            begun = clock.now_s
            talk.step({}, str)
            clock.now_s = max(clock.now_s, begun + TICK_S)
    assert clock.now_s == pytest.approx(1000.0 + LIMIT_S, abs=2 * TICK_S)


def test_an_other_side_that_takes_nothing_holds_no_tick_up(other, clock):
    talk = live(other)
    other.later = [(clock.now_s + 1e-3, framed({"need": "actors", "number": 1}))]
    given = []
    assert talk.step({}, lambda what: given.append(what) or "x" * 10_000_000) is None and given
    clock.now_s += TICK_S
    begun = clock.now_s
    assert talk.step({}, str) is None
    assert clock.now_s == begun


@pytest.mark.parametrize("need", ["password", 7, None, ["scene"], {}])
def test_what_it_cannot_have_is_a_fault(other, clock, need):
    other.later = [(clock.now_s + 1e-3, framed({"need": need, "number": 1}))]
    with pytest.raises(WireError, match="requests"):
        live(other).step({}, str)


def test_an_answer_that_is_no_message_is_a_fault(other, clock):
    for sent in (struct.pack(">I", 1 << 25), struct.pack(">I", 4) + b"[[[[", struct.pack(">I", 2) + b"\xff\xff"):
        other.raw(sent)
        with pytest.raises(WireError):
            live(other).step({}, str)
    deep = b"[" * 100_000
    other.raw(struct.pack(">I", len(deep)) + deep)
    with pytest.raises(WireError):
        live(other).step({}, str)


OTHER_NUMBERS = [None, True, 1.0, "1", [1], {"a": 1}, 0, -1, 2, 10**30, float("1e300")]


@pytest.mark.parametrize("number", OTHER_NUMBERS)
@pytest.mark.parametrize("talks", [live, lockstep])
def test_step_answer_to_another_tick_is_dropped(other, clock, talks, number):
    """The right answer that comes after it is used."""
    wrong = framed({"directive": "wrong", "number": number} if number is not None else {"directive": "wrong"})
    right = framed({"directive": "right", "number": 1})
    talk = talks(other)
    other.later = [(clock.now_s, wrong), (clock.now_s + 1e-3, right)]
    assert talk.step({}, str) == {"directive": "right"}
    assert talk.strays == 1


def test_step_answer_before_its_tick_is_dropped(other, clock):
    talk = live(other)
    other.raw(framed({"too": "early", "number": 1}))
    assert talk.step({}, str) is None and talk.strays == 1
    clock.now_s += TICK_S
    other.says({"in": "time"})
    other.raw(framed({"too": "early", "number": 2}))
    assert talk.step({}, str) == {"in": "time"}
    clock.now_s += TICK_S
    assert talk.step({}, str) is None and talk.strays == 2


def test_step_second_answer_to_a_tick_is_dropped(other, clock):
    talk = live(other)
    for tick in range(5):
        ticks(clock, talk, 1)
        for _ in range(3):
            other.says({"tick": tick})
        assert ticks(clock, talk, 1)[0] == [{"tick": tick}]
        other.says({"next": tick})
        assert ticks(clock, talk, 1)[0] == [{"next": tick}]
    assert talk.strays == 10


def test_step_need_of_another_tick_is_given_nothing(other, clock):
    asked, talk = [], live(other)
    other.later = [(clock.now_s + 1e-3, framed({"need": "scene", "number": 7}))]
    assert talk.step({}, asked.append) is None and not asked


@pytest.mark.parametrize("message", [{}, {"number": 1}, {"number": 99}, {"need": "scene"}, {"directive": 3}])
def test_step_flood_is_read_to_limit_then_fault(other, clock, message):
    """A flood of messages is read up to a limit and is then a fault.

    A solver that sends a flood of messages fails: no tick reads more than a hundred.
    """
    talk = live(other)
    talk.step({}, str)
    other.says({})
    clock.now_s += TICK_S
    assert talk.step({}, str) == {}
    flood = framed(message) * (MOST_STRAYS + 1)
    other.raw(flood)
    with pytest.raises(WireError, match="belong to no tick"):
        for _ in range(3):
            clock.now_s += TICK_S
            assert talk.step({}, str) is None
    assert talk.strays == MOST_STRAYS + 1


@pytest.mark.parametrize("seconds", [0, -1, float("nan"), float("inf"), "long", None, True])
def test_a_limit_that_is_none_is_named(seconds):
    with pytest.raises(ValueError, match="answer_limit_s"):
        limit_of(seconds, "answer_limit_s")
