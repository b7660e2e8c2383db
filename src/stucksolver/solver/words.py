"""A passenger's words: which ones count now, which ones a running plan follows, and when they are done with."""

from __future__ import annotations

from dataclasses import dataclass

from stucksolver.scene import Guidance


@dataclass
class Words:
    """`doing`: those that the running plan follows. `heard`: those that were asked about while a plan runs."""

    expire_s: float
    now: Guidance | None = None
    doing: Guidance | None = None
    heard: Guidance | None = None
    _since_s: float = 0.0

    def take(self, text: str, time_s: float, now_s: float) -> Guidance:
        """New words replace the old ones. `time_s` is the stack's time, `now_s` the solver's own."""
        self.now, self._since_s = Guidance(text=text, time_s=time_s), now_s
        return self.now

    def expired(self, now_s: float) -> bool:
        """Have they led to nothing in time?"""
        return self.now is not None and self.now is not self.doing and now_s - self._since_s > self.expire_s

    @property
    def unheard(self) -> bool:
        """Are there words that the running plan neither follows nor has been asked about?"""
        return self.now is not None and self.now is not self.doing and self.now is not self.heard
