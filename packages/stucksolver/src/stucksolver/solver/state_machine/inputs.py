"""The inputs of one tick and the fixed parts of a solver: together with a state, all that a step depends on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from stucksolver.guard import Guard
from stucksolver.immobilization import DetectorSettings, Trigger
from stucksolver.ladder import Ladder
from stucksolver.reasoners import ReasonerAnswer
from stucksolver.scene import Guidance, Scene, Status, Surroundings
from stucksolver.solver.query import NoAnswer
from stucksolver.solver.questions import PersonReply


@dataclass(frozen=True)
class SurroundingsInput:
    """What the senses show at a tick. `blind_s` is the time since anything new was seen (s)."""

    surroundings: Surroundings | None
    fault: str | None
    blind_s: float


@dataclass(frozen=True)
class SceneInput:
    """The stack's scene at a tick, or None with the reason. `camera_fault` says why its image was left out."""

    scene: Scene | None
    why_none: str = ""
    camera_fault: str | None = None


@dataclass(frozen=True)
class GuidanceInput:
    """A passenger's words with their reading. `fault` says why they could not be read."""

    words: Guidance
    fault: str | None = None


@dataclass(frozen=True)
class Inputs:
    """The inputs of one tick.

    `look` and `scene` give the same result each time they are called; what is not called is not measured.

    Attributes:
        status: The status in the solver's own time, which never jumps.
        trigger: What the detector found, if anything.
        slow_since_s: Since when the detector has seen the vehicle slow (s).
        progress_in_window_m: New progress in the detector's window (m).
        offset_s: Subtract this from the solver's time to get the stack's time (s).
        jump_s: How far the stack's clock jumped at this tick (s).
        heard: Words that have been read.
        hearing: True while words are being read.
        reply: A person's yes or no to the open question.
        answer: The result of the question to a reasoner, if there is one.
        busy: Reasoners that are still working on a question, by the ladder's names for them.
    """

    status: Status
    look: Callable[[], SurroundingsInput]
    scene: Callable[[], SceneInput]
    trigger: Trigger | None = None
    slow_since_s: float | None = None
    progress_in_window_m: float | None = None
    offset_s: float = 0.0
    jump_s: float | None = None
    heard: GuidanceInput | None = None
    hearing: bool = False
    reply: PersonReply | None = None
    answer: ReasonerAnswer | NoAnswer | None = None
    busy: frozenset[str] = frozenset()


@dataclass(frozen=True)
class SolverSetup:
    """The parts of a solver that do not change.

    Attributes:
        guard: The guard.
        ladder: The escalation policy.
        reasoners: The reasoners' own names, by the ladder's names for them.
        ask_back: The text for a passenger whose words are not understood.
        observe_only: Judge plans, but never execute them.
        detector: What counts as immobilized.
        vehicle_id: Stable id of the vehicle; empty if it has none.
    """

    guard: Guard
    ladder: Ladder
    reasoners: dict[str, str]
    ask_back: str
    observe_only: bool = False
    detector: DetectorSettings = field(default_factory=DetectorSettings)
    vehicle_id: str = ""
