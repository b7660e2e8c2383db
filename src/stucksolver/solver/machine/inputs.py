"""What one tick brings, and what a solver is made of: with a state, all that a step depends on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from stucksolver.detect import Trigger
from stucksolver.guard import Guard
from stucksolver.ladder import Ladder
from stucksolver.reason import Answer
from stucksolver.scene import Guidance, Scene, Status, Surroundings
from stucksolver.solver.query import NoAnswer
from stucksolver.solver.questions import Reply


@dataclass(frozen=True)
class Sight:
    """What the senses show at a tick. `blind_s`: for how long nothing new has been seen (s)."""

    surroundings: Surroundings | None
    fault: str | None
    blind_s: float


@dataclass(frozen=True)
class Snapshot:
    """The stack's scene at a tick; None with the reason where it gave none.

    `camera_fault`: why its image was left out.
    """

    scene: Scene | None
    why_none: str = ""
    camera_fault: str | None = None


@dataclass(frozen=True)
class Heard:
    """A passenger's words with their reading; `fault`: why they could not be read."""

    words: Guidance
    fault: str | None = None


@dataclass(frozen=True)
class Inputs:
    """One tick. `look` and `scene` give the same each time they are called; what is not called is not measured.

    `status`: in the solver's own time, which never jumps. `offset_s`: what must be taken off it for the stack's time.
    `jump_s`: by how much the stack's clock jumped at this tick. `slow_since_s`, `progress_in_window_m`: what the
    detector says. `hearing`: words are on their way to being read. `reply`: a person's yes or no to the open question.
    `answer`: what came of the question to a reasoner, if it is there. `busy`: reasoners still at a question, by
    the ladder's names for them.
    """

    status: Status
    look: Callable[[], Sight]
    scene: Callable[[], Snapshot]
    trigger: Trigger | None = None
    slow_since_s: float | None = None
    progress_in_window_m: float | None = None
    offset_s: float = 0.0
    jump_s: float | None = None
    heard: Heard | None = None
    hearing: bool = False
    reply: Reply | None = None
    answer: Answer | NoAnswer | None = None
    busy: frozenset[str] = frozenset()


@dataclass(frozen=True)
class Setup:
    """What does not change: the guard, the ladder, the reasoners' own names by the ladder's.

    `ask_back`: what a passenger is told whose words are not understood. `observe_only`: plans are judged, and never
    performed.
    """

    guard: Guard
    ladder: Ladder
    reasoners: dict[str, str]
    ask_back: str
    observe_only: bool = False
