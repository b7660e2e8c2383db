"""What every reasoner is: a scene in, a decision out. Untrusted; the guard decides."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol, runtime_checkable

from pydantic import ValidationError

from stucksolver.decision import Decision, RecoveryPlan
from stucksolver.scene import Scene
from stucksolver.scene.model import Model


class Reasoner(Protocol):
    """Called off the control loop, one scene at a time."""

    @property
    def name(self) -> str:
        """Shown in every result."""

    def decide(self, scene: Scene) -> Decision:
        """Observe, analyse, decide. Raises `ReasonerError` when it has no answer."""


class ReasonerError(Exception):
    """A reasoner could not answer; the message says why and what to do."""


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


@runtime_checkable
class Traced(Protocol):
    """A reasoner may say how it came to its last answer; read in the thread of `decide`, right after it."""

    @property
    def last_trace(self) -> Trace | None:
        """Of the last `decide`, also of one that raised; None where there is nothing to tell."""


@runtime_checkable
class Cancellable(Protocol):
    """A reasoner may be told, from another thread, that its answer is not wanted any more."""

    def cancel(self) -> None:
        """End the running `decide` soon, by `ReasonerError`; do nothing when none runs."""


PlanCheck = Callable[[RecoveryPlan], str]
"""What the guard would say of a plan now, in words; may be called from the reasoner's thread."""


@runtime_checkable
class AsksGuard(Protocol):
    """A reasoner may want to ask the guard before it commits to a plan."""

    def check_with(self, check: PlanCheck | None) -> None:
        """Given before each `decide`; None where nothing is known of the surroundings."""


@runtime_checkable
class KeepsDeadline(Protocol):
    """A reasoner that may be slow wants to know how long it may take."""

    def answer_within(self, limit_s: float) -> None:
        """Seconds of wall time for each `decide` from now on."""


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
        raise ReasonerError(f"the answer is no decision: {error.errors()[0]['msg']}") from error


PARSERS: dict[str, Parser] = {"decision": _parse_decision}
"""By the `format` of a trace. A reasoner with a form of its own adds its parser when it is imported."""


def parse_trace(trace: Trace, scene: Scene) -> Decision:
    """Read a recorded answer again. Raises `ReasonerError` where that cannot be done."""
    if trace.format not in PARSERS:
        raise ReasonerError(f"no parser for answers in the format {trace.format!r}; known: {', '.join(PARSERS)}")
    if not trace.answers:
        raise ReasonerError("the trace holds no answer")
    return PARSERS[trace.format](trace.answers[-1], scene)
