"""Where on the ladder the solver stands: tries used up, pauses, waits. It is climbed one way until it is reset."""

from __future__ import annotations

from collections.abc import Collection

from stucksolver.decision import WaitReason
from stucksolver.ladder import AskPerson, AskReasoner, Assist, Ladder, Move, Screen


class Climb:
    """`reasoners`: names of those there are; rungs that need another are left out.

    `only_reasoners` leaves out the rungs of people: for words, which are an answer of theirs already, and for those who
    only look on.
    """

    def __init__(self, ladder: Ladder, reasoners: Collection[str], *, only_reasoners: bool = False) -> None:
        self._ladder = ladder
        moves = [(rung.kind, rung.move()) for rung in ladder.rungs]
        self.screens = isinstance(moves[0][1], Screen)
        self._rungs: list[tuple[str, Move]] = [
            (kind, move)
            for kind, move in moves
            if not isinstance(move, Screen)
            and (move.reasoner in reasoners if isinstance(move, AskReasoner) else not only_reasoners)
        ]
        if not self._rungs:
            wanted = ", ".join(sorted({m.reasoner for _, m in moves if isinstance(m, AskReasoner)}))
            raise ValueError(f"no rung of ladder {ladder.name!r} can be used: give a reasoner named {wanted}")
        self.reset()

    def reset(self) -> None:
        """Back to the lowest rung, with all tries."""
        self._index = self._tries = self._repairs = 0
        self.not_before_s = float("-inf")
        self.quiet_until_s = float("-inf")
        """A passenger asked to wait until then."""
        self.since_s = float("-inf")
        """When this rung was climbed."""
        self._waiting: dict[WaitReason, float] = {}
        self.last_wait_s: float | None = None
        """When waiting was last found to be right."""

    @property
    def rung(self) -> str:
        return self._rungs[self._index][0]

    @property
    def move(self) -> Move:
        return self._rungs[self._index][1]

    @property
    def lowest(self) -> AskReasoner | None:
        """The first reasoner, who is also asked on the rungs of people."""
        return next((move for _, move in self._rungs if isinstance(move, AskReasoner)), None)

    @property
    def is_last(self) -> bool:
        return self._index == len(self._rungs) - 1

    def ready(self, now_s: float) -> bool:
        """May the next thing be asked?"""
        return now_s >= max(self.not_before_s, self.quiet_until_s)

    def pause(self, until_s: float) -> None:
        self.not_before_s = until_s

    # ---- waiting

    def outlived(self, now_s: float) -> frozenset[WaitReason]:
        """Reasons to wait that have lasted too long to count as such."""
        return frozenset(r for r, since in self._waiting.items() if now_s - since > self._patience(r))

    def waits(self, reason: WaitReason | None, now_s: float) -> bool:
        """Is waiting right for that reason? If so, the next look is due when the ladder says."""
        if reason is None or not self._ladder.waits.is_wait(reason):
            return False
        since = self._waiting.setdefault(reason, now_s)
        if now_s - since > self._patience(reason):
            return False
        self.last_wait_s = now_s
        self._repairs = 0
        self.pause(now_s + self._ladder.waits.patience(reason).check_every_s)
        return True

    def moved(self) -> None:
        """The vehicle goes by itself: whatever it waits for next is a new wait."""
        self._waiting.clear()

    def _patience(self, reason: WaitReason) -> float:
        return self._ladder.waits.patience(reason).longest_s

    # ---- failing

    def may_repair(self, now_s: float) -> bool:
        """A plan was refused: may the reasoner be told why and asked again at once?"""
        move = self.move if isinstance(self.move, AskReasoner) else None
        if move is None or self._repairs >= move.repair_rounds:
            return False
        self._repairs += 1
        self.pause(now_s)
        return True

    def failed(self, now_s: float, *, counts: bool = True) -> None:
        """A try led to nothing (one that does not count: traffic will go on). On the rungs of people: look again."""
        self._repairs = 0
        move = self.move
        if isinstance(move, AskReasoner):
            self._tries += counts
            self.pause(now_s + move.cooldown_s)
        elif isinstance(move, AskPerson | Assist):
            self.pause(now_s + move.look_every_s)

    @property
    def exhausted(self) -> bool:
        """Are the tries of this rung used up?"""
        return isinstance(self.move, AskReasoner) and self._tries >= self.move.tries

    def climb(self, now_s: float) -> bool:
        """To the next rung; false on the last one, which is stayed on."""
        self._tries = self._repairs = 0
        if self.is_last:
            return False
        self._index += 1
        self.since_s = now_s
        self.pause(now_s)
        return True

    def begun(self) -> None:
        """A plan was accepted: the next refusal may be repaired again."""
        self._repairs = 0
