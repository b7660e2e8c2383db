"""The solver's place on the ladder: tries used, pauses and waits. It climbs in one direction until it is reset."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

from stucksolver.ladder import AskPerson, AskReasoner, CallAssistance, CheckForWait, Ladder, Move, WaitPolicy
from stucksolver.plan import WaitReason

DUTIES = frozenset(
    {WaitReason.LIGHT, WaitReason.STOP_SIGN, WaitReason.PEOPLE, WaitReason.YIELD, WaitReason.AT_DESTINATION}
)
"""Waits that a hurried passenger cannot shorten."""
NO_WAITS: Mapping[WaitReason, float] = MappingProxyType({})


@dataclass(frozen=True)
class Rungs:
    """The usable rungs of a ladder, lowest first. `screens` is True if the rules look first, before each reasoner."""

    rungs: tuple[tuple[str, Move], ...]
    screens: bool
    waits: WaitPolicy

    @classmethod
    def of(cls, ladder: Ladder, reasoners: Collection[str], *, only_reasoners: bool = False) -> Rungs:
        """Select the rungs that can be used.

        Args:
            ladder: The escalation policy.
            reasoners: Names of the reasoners present; rungs that need another one are left out.
            only_reasoners: Leave out the rungs of people, for words (which are already a person's answer) and for
                observers.

        Returns:
            The usable rungs, lowest first.

        Raises:
            ValueError: No rung is left.
        """
        moves = [(rung.kind, rung.move()) for rung in ladder.rungs]
        usable = tuple(
            (kind, move)
            for kind, move in moves
            if not isinstance(move, CheckForWait)
            and (move.reasoner in reasoners if isinstance(move, AskReasoner) else not only_reasoners)
        )
        if not usable:
            wanted = ", ".join(sorted({m.reasoner for _, m in moves if isinstance(m, AskReasoner)}))
            raise ValueError(f"no rung of ladder {ladder.name!r} can be used: give a reasoner named {wanted}")
        return cls(usable, isinstance(moves[0][1], CheckForWait), ladder.waits)


@dataclass(frozen=True)
class Escalation:
    """A place on the ladder. Times are the solver's own (s)."""

    on: Rungs = field(repr=False)
    index: int = 0
    tries: int = 0
    repairs: int = 0
    not_before_s: float = -math.inf
    quiet_until_s: float = -math.inf
    """The passenger asked to wait until this time."""
    since_s: float = -math.inf
    """The time at which this rung was reached."""
    waiting: Mapping[WaitReason, float] = field(default_factory=lambda: NO_WAITS)
    """For each reason to wait, the time since when it has held."""
    last_wait_s: float | None = None
    """The last time at which waiting was found right."""
    patience: float = 1.0
    """The patience that the passenger asked for: a factor on the longest waits for others."""

    def reset(self) -> Escalation:
        """Return to the lowest rung, with all tries."""
        return Escalation(self.on, patience=self.patience)

    @property
    def rung(self) -> str:
        """Name of the current rung."""
        return self.on.rungs[self.index][0]

    @property
    def move(self) -> Move:
        """The move of the current rung."""
        return self.on.rungs[self.index][1]

    @property
    def lowest(self) -> AskReasoner | None:
        """The first reasoner; it is also asked on the rungs of people."""
        return next((move for _, move in self.on.rungs if isinstance(move, AskReasoner)), None)

    @property
    def is_last(self) -> bool:
        """True on the last rung."""
        return self.index == len(self.on.rungs) - 1

    def ready(self, now_s: float) -> bool:
        """True if the next question may be asked."""
        return now_s >= max(self.not_before_s, self.quiet_until_s)

    def paused(self, until_s: float) -> Escalation:
        """Ask nothing before `until_s`."""
        return replace(self, not_before_s=until_s)

    # ---- waiting

    def expired_waits(self, now_s: float) -> frozenset[WaitReason]:
        """The reasons to wait that have lasted too long to count."""
        return frozenset(r for r, since in self.waiting.items() if now_s - since > self._patience(r))

    def note_wait(self, reason: WaitReason | None, now_s: float) -> Escalation | None:
        """Note that a look found this reason to wait, and schedule the next look as the ladder says.

        Returns:
            The new place, or None if waiting is not right or has lasted too long.
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

    def note_motion(self) -> Escalation:
        """The vehicle is moving on its own: the next wait is a new one."""
        return self if not self.waiting else replace(self, waiting=NO_WAITS)

    def _patience(self, reason: WaitReason) -> float:
        longest_s = self.on.waits.patience(reason).longest_s
        return longest_s if reason in DUTIES else longest_s * self.patience

    # ---- failing

    def repair(self, now_s: float) -> Escalation | None:
        """A plan was refused: tell the reasoner why and ask it again at once.

        Returns:
            The new place, or None if no repair rounds are left.
        """
        move = self.move if isinstance(self.move, AskReasoner) else None
        if move is None or self.repairs >= move.repair_rounds:
            return None
        return replace(self, repairs=self.repairs + 1, not_before_s=now_s)

    def note_failure(self, now_s: float, *, counts: bool = True) -> Escalation:
        """A try led to nothing. With `counts=False` (traffic will move on) it uses up no try. On a person's rung:
        look again.
        """
        move = self.move
        if isinstance(move, AskReasoner):
            return replace(self, repairs=0, tries=self.tries + counts, not_before_s=now_s + move.cooldown_s)
        if isinstance(move, AskPerson | CallAssistance):
            return replace(self, repairs=0, not_before_s=now_s + move.look_every_s)
        return replace(self, repairs=0)

    @property
    def out_of_tries(self) -> bool:
        """True if the tries of this rung are used up."""
        return isinstance(self.move, AskReasoner) and self.tries >= self.move.tries

    def climbed(self, now_s: float) -> Escalation:
        """Go to the next rung; stay if this is the last one."""
        if self.is_last:
            return replace(self, tries=0, repairs=0)
        return replace(self, index=self.index + 1, tries=0, repairs=0, since_s=now_s, not_before_s=now_s)

    def note_accepted(self) -> Escalation:
        """A plan was accepted: the next refusal may be repaired again."""
        return replace(self, repairs=0)
