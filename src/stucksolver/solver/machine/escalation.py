"""Where on the ladder the solver stands: tries used up, pauses, waits. It is climbed one way until it is reset."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

from stucksolver.decision import WaitReason
from stucksolver.ladder import AskPerson, AskReasoner, Assist, Ladder, Move, Screen, Waits

DUTIES = frozenset(
    {WaitReason.LIGHT, WaitReason.STOP_SIGN, WaitReason.PEOPLE, WaitReason.YIELD, WaitReason.AT_DESTINATION}
)
"""Waits that no hurry shortens."""
NO_WAITS: Mapping[WaitReason, float] = MappingProxyType({})


@dataclass(frozen=True)
class Rungs:
    """The rungs of a ladder that can be used here, lowest first, by kind. `screens`: rules look first, before each."""

    rungs: tuple[tuple[str, Move], ...]
    screens: bool
    waits: Waits

    @classmethod
    def of(cls, ladder: Ladder, reasoners: Collection[str], *, only_reasoners: bool = False) -> Rungs:
        """`reasoners`: names of those there are; rungs that need another are left out.

        `only_reasoners` leaves out the rungs of people: for words, which are an answer of theirs already, and for those
        who only look on. Raises `ValueError` where nothing is left.
        """
        moves = [(rung.kind, rung.move()) for rung in ladder.rungs]
        usable = tuple(
            (kind, move)
            for kind, move in moves
            if not isinstance(move, Screen)
            and (move.reasoner in reasoners if isinstance(move, AskReasoner) else not only_reasoners)
        )
        if not usable:
            wanted = ", ".join(sorted({m.reasoner for _, m in moves if isinstance(m, AskReasoner)}))
            raise ValueError(f"no rung of ladder {ladder.name!r} can be used: give a reasoner named {wanted}")
        return cls(usable, isinstance(moves[0][1], Screen), ladder.waits)


@dataclass(frozen=True)
class Escalation:
    """A place on the ladder. Times are the solver's own, seconds."""

    on: Rungs = field(repr=False)
    index: int = 0
    tries: int = 0
    repairs: int = 0
    not_before_s: float = -math.inf
    quiet_until_s: float = -math.inf
    """A passenger asked to wait until then."""
    since_s: float = -math.inf
    """When this rung was climbed."""
    waiting: Mapping[WaitReason, float] = field(default_factory=lambda: NO_WAITS)
    """Since when there has been a reason to wait."""
    last_wait_s: float | None = None
    """When waiting was last found to be right."""
    patience: float = 1.0
    """How patient the passenger asked to be: the longest waits for others count so many times as long."""

    def reset(self) -> Escalation:
        """Back to the lowest rung, with all tries."""
        return Escalation(self.on, patience=self.patience)

    @property
    def rung(self) -> str:
        """Name of the rung that it is on."""
        return self.on.rungs[self.index][0]

    @property
    def move(self) -> Move:
        """What is done on that rung."""
        return self.on.rungs[self.index][1]

    @property
    def lowest(self) -> AskReasoner | None:
        """The first reasoner, who is also asked on the rungs of people."""
        return next((move for _, move in self.on.rungs if isinstance(move, AskReasoner)), None)

    @property
    def is_last(self) -> bool:
        """Whether no rung is left above."""
        return self.index == len(self.on.rungs) - 1

    def ready(self, now_s: float) -> bool:
        """May the next thing be asked?"""
        return now_s >= max(self.not_before_s, self.quiet_until_s)

    def paused(self, until_s: float) -> Escalation:
        """The same, with nothing asked before `until_s`."""
        return replace(self, not_before_s=until_s)

    # ---- waiting

    def outlived(self, now_s: float) -> frozenset[WaitReason]:
        """Reasons to wait that have lasted too long to count as such."""
        return frozenset(r for r, since in self.waiting.items() if now_s - since > self._patience(r))

    def waited(self, reason: WaitReason | None, now_s: float) -> Escalation | None:
        """After a look that found this reason to wait; the next look is due when the ladder says.

        None: waiting is not right, or has lasted too long.
        """
        waits = self.on.waits
        if reason is None or not waits.is_wait(reason):
            return None
        since = self.waiting.get(reason, now_s)
        waiting = MappingProxyType({**self.waiting, reason: since})
        if now_s - since > self._patience(reason):
            return None
        due = now_s + waits.patience(reason).check_every_s
        return replace(self, waiting=waiting, last_wait_s=now_s, repairs=0, not_before_s=due)

    def moved(self) -> Escalation:
        """The vehicle goes by itself: whatever it waits for next is a new wait."""
        return self if not self.waiting else replace(self, waiting=NO_WAITS)

    def _patience(self, reason: WaitReason) -> float:
        longest_s = self.on.waits.patience(reason).longest_s
        return longest_s if reason in DUTIES else longest_s * self.patience

    # ---- failing

    def repair(self, now_s: float) -> Escalation | None:
        """A plan was refused: the reasoner is told why and asked again at once; None where no rounds are left."""
        move = self.move if isinstance(self.move, AskReasoner) else None
        if move is None or self.repairs >= move.repair_rounds:
            return None
        return replace(self, repairs=self.repairs + 1, not_before_s=now_s)

    def failed(self, now_s: float, *, counts: bool = True) -> Escalation:
        """A try led to nothing (one that does not count: traffic will go on). On the rungs of people: look again."""
        move = self.move
        if isinstance(move, AskReasoner):
            return replace(self, repairs=0, tries=self.tries + counts, not_before_s=now_s + move.cooldown_s)
        if isinstance(move, AskPerson | Assist):
            return replace(self, repairs=0, not_before_s=now_s + move.look_every_s)
        return replace(self, repairs=0)

    @property
    def exhausted(self) -> bool:
        """Are the tries of this rung used up?"""
        return isinstance(self.move, AskReasoner) and self.tries >= self.move.tries

    def climbed(self, now_s: float) -> Escalation:
        """On the next rung; the last one is stayed on."""
        if self.is_last:
            return replace(self, tries=0, repairs=0)
        return replace(self, index=self.index + 1, tries=0, repairs=0, since_s=now_s, not_before_s=now_s)

    def begun(self) -> Escalation:
        """A plan was accepted: the next refusal may be repaired again."""
        return replace(self, repairs=0)
