"""What every reasoner is: a scene in, a decision out. Untrusted; the guard decides."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from pydantic import ValidationError

from stucksolver.decision import Decision, RecoveryPlan
from stucksolver.scene import Scene
from stucksolver.scene.model import Model

PlanCheck = Callable[[RecoveryPlan], str]
"""What the guard would say of a plan now, in words; may be called from the reasoner's thread."""


@dataclass(frozen=True)
class Request:
    """A question to a reasoner.

    `check`: asks the guard about a plan before committing to it; None where nothing is known of the surroundings.
    `deadline_s`: wall time for the answer in seconds; None for as long as it likes.
    """

    scene: Scene
    check: PlanCheck | None = None
    deadline_s: float | None = None


class Trace(Model):
    """How a reasoner that is no set of rules came to its answer: enough to read it again offline.

    `answers` are raw, in the order in which they came; the last one is what the decision was parsed from, by the
    parser registered under `format`.
    """

    format: str = "decision"
    prompt: str | None = None
    answers: tuple[str, ...] = ()
    model: str | None = None
    input_tokens: int | None = None
    output_tokens: int | None = None
    usd: float | None = None
    """What the answers cost, where the model's price is known."""
    seconds: float | None = None


@dataclass(frozen=True)
class Answer:
    """A decision, the name of who made it, and how; `trace` is None for one that is derived from the scene alone."""

    decision: Decision
    reasoner: str
    trace: Trace | None = None


class Reasoner(Protocol):
    """Called off the control loop, one request at a time."""

    @property
    def name(self) -> str:
        """Shown in every result."""

    def decide(self, request: Request) -> Answer:
        """Observe, analyse, decide. Raises `ReasonerError` when it has no answer."""


class ReasonerError(Exception):
    """A reasoner could not answer; the message says why and what to do. `trace`: what it cost, where that is known."""

    trace: Trace | None = None


@runtime_checkable
class Cancellable(Protocol):
    """A reasoner may be told, from another thread, that its answer is not wanted any more."""

    def cancel(self) -> None:
        """End the running `decide` soon, by `ReasonerError`; do nothing when none runs."""


@runtime_checkable
class Preflighted(Protocol):
    """A reasoner that rests on something outside can say before a drive whether that is in order."""

    def preflight(self) -> tuple[str, ...]:
        """What a person should know, a line each. Raises `ReasonerError` where its answers would fail."""


Parser = Callable[[str, Scene], Decision]
"""Makes a decision of a raw answer to a scene. Raises `ReasonerError`."""


def _parse_decision(answer: str, scene: Scene) -> Decision:
    """The answer is the decision's own JSON form."""
    try:
        return Decision.model_validate_json(answer)
    except ValidationError as error:
        raise ReasonerError(f"the answer is not a decision: {error.errors()[0]['msg']}") from error


PARSERS: dict[str, Parser] = {"decision": _parse_decision}
"""By the `format` of a trace. A reasoner with a form of its own adds its parser when it is imported."""


def parse_trace(trace: Trace, scene: Scene) -> Decision:
    """Read a recorded answer again. Raises `ReasonerError` where that cannot be done."""
    if trace.format not in PARSERS:
        raise ReasonerError(f"no parser for answers in the format {trace.format!r}; known: {', '.join(PARSERS)}")
    if not trace.answers:
        raise ReasonerError("the trace holds no answer")
    return PARSERS[trace.format](trace.answers[-1], scene)
