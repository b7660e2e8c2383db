"""The interface of every reasoner: a scene in, a decision out. Reasoners are untrusted; the guard decides."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from pydantic import ValidationError

from stucksolver.plan import Decision, RecoveryPlan
from stucksolver.scene import Scene
from stucksolver.scene.base_model import FrozenModel

PlanCheck = Callable[[RecoveryPlan], str]
"""Returns, in words, what the guard would say about a plan now. May be called from the reasoner's thread."""
ACCEPTED = "accepted"
"""What a `PlanCheck` says of a plan that the guard accepts; anything else is the reason against it."""


@dataclass(frozen=True)
class ReasonerRequest:
    """A question to a reasoner.

    Attributes:
        scene: What the reasoner may know.
        check: Asks the guard about a plan before the reasoner commits to it. None if the surroundings are unknown.
        deadline_s: Wall time for the answer (s); None for no limit.
    """

    scene: Scene
    check: PlanCheck | None = None
    deadline_s: float | None = None


class ReasonerTrace(FrozenModel):
    """How a reasoner other than the rules arrived at its answer: enough to parse it again offline.

    `answers` are the raw answers in order. The decision was parsed from the last one, by the parser registered under
    `format`.
    """

    format: str = "decision"
    prompt: str | None = None
    answers: tuple[str, ...] = ()
    model: str | None = None
    input_tokens: int | None = None
    output_tokens: int | None = None
    usd: float | None = None
    """Cost of the answers (US dollars), if the model's price is known."""
    seconds: float | None = None


@dataclass(frozen=True)
class ReasonerAnswer:
    """A decision and the name of the reasoner that made it. `trace` is None if it follows from the scene alone."""

    decision: Decision
    reasoner: str
    trace: ReasonerTrace | None = None


class Reasoner(Protocol):
    """The interface of a reasoner. It is called outside the control loop, one request at a time."""

    @property
    def name(self) -> str:
        """Shown in every result."""

    def decide(self, request: ReasonerRequest) -> ReasonerAnswer:
        """Observe, analyse and decide.

        Args:
            request: The scene, a check of plans against the guard, and a deadline.

        Raises:
            ReasonerError: The reasoner has no answer.
        """


class ReasonerError(Exception):
    """A reasoner could not answer. The message says why and what to do; `trace` holds the cost, if it is known."""

    trace: ReasonerTrace | None = None


class MalformedAnswerError(ReasonerError):
    """A reasoner's answer is of a wrong type, too large, nested too deeply, or holds a value that is refused."""


@runtime_checkable
class Cancellable(Protocol):
    """A reasoner that can be told from another thread that its answer is no longer wanted."""

    def cancel(self) -> None:
        """End the running `decide` soon with `ReasonerError`. Does nothing if none is running."""


@runtime_checkable
class SupportsPreflight(Protocol):
    """A reasoner that depends on something external and can check it before a drive."""

    def preflight(self) -> tuple[str, ...]:
        """Return what a person should know, one line each.

        Raises:
            ReasonerError: Questions would fail.
        """


Parser = Callable[[str, Scene], Decision]
"""Parses a raw answer to a scene into a decision. Raises `ReasonerError`."""


def _parse_decision(answer: str, scene: Scene) -> Decision:
    """Parse an answer that is the decision's own JSON form."""
    try:
        return Decision.model_validate_json(answer)
    except ValidationError as error:
        raise ReasonerError(f"the answer is not a decision: {error.errors()[0]['msg']}") from error


PARSERS: dict[str, Parser] = {"decision": _parse_decision}
"""Parsers by the `format` of a trace. A reasoner with its own format registers its parser when it is imported."""


def parse_trace(trace: ReasonerTrace, scene: Scene) -> Decision:
    """Parse a recorded answer again.

    Raises:
        ReasonerError: The trace holds no answer, or there is no parser for its format.
    """
    if trace.format not in PARSERS:
        raise ReasonerError(f"no parser for answers in the format {trace.format!r}; known: {', '.join(PARSERS)}")
    if not trace.answers:
        raise ReasonerError("the trace holds no answer")
    return PARSERS[trace.format](trace.answers[-1], scene)
