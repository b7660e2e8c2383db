"""Wait, if waiting is right."""

from __future__ import annotations

from typing import ClassVar, Literal

from stucksolver.ladder.rung_actions import CheckForWait
from stucksolver.ladder.rungs.base import Rung


class WaitRung(Rung):
    """Waits if a light, a queue or people hold the vehicle up. The table `waits` says how long that is right."""

    summary: ClassVar[str] = "wait while a light, a queue, people or a duty to yield make waiting right"

    kind: Literal["wait"] = "wait"

    def move(self) -> CheckForWait:
        return CheckForWait()
