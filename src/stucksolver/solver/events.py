"""What the solver tells whoever listens: one event for each thing that a reviewer would want to know."""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum

from stucksolver.decision import Decision
from stucksolver.guard import Verdict
from stucksolver.scene import Scene
from stucksolver.scene.model import Model


class EventKind(str, Enum):
    TRIGGERED = "triggered"
    DECIDED = "decided"
    STARTED = "started"
    ABORTED = "aborted"
    FINISHED = "finished"
    RECOVERED = "recovered"
    GUIDANCE = "guidance"
    GUIDANCE_ENDED = "guidance_ended"
    FAILED = "failed"


class Event(Model):
    """Something that happened, at simulation time `time_s`."""

    time_s: float
    kind: EventKind
    text: str
    trigger: str | None = None
    scene: Scene | None = None
    decision: Decision | None = None
    verdict: Verdict | None = None


Listener = Callable[[Event], None]
