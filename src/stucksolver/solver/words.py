"""A passenger's words: which ones count now, which ones a running plan follows, and when they are done with."""

from __future__ import annotations

from dataclasses import dataclass

from stucksolver.scene import Guidance, Reading


@dataclass
class Words:
    """`doing`: those that the running plan follows."""

    expire_s: float
    now: Guidance | None = None
    doing: Guidance | None = None
    _since_s: float = 0.0

    def take(self, words: Guidance, now_s: float) -> None:
        """New words replace the old ones; `now_s` is the solver's own time."""
        self.now, self._since_s = words, now_s

    @property
    def reading(self) -> Reading | None:
        """What the words that count now were read as."""
        return None if self.now is None else self.now.reading

    def expired(self, now_s: float) -> bool:
        """Have they led to nothing in time?"""
        return self.now is not None and self.now is not self.doing and now_s - self._since_s > self.expire_s
