"""Interface of every reasoner: a scene in, a decision out. Reasoners are untrusted; the guard decides."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from pydantic import ValidationError

from stucksolver.plan import Decision, RecoveryPlan
from stucksolver.plan.assessment import PlanAssessor
from stucksolver.query_budget import QueryBudget
from stucksolver.scene import Scene
from stucksolver.scene.base_model import FrozenModel

PlanCheck = Callable[[RecoveryPlan], str]
"""Returns the guard's verdict on a plan now, as text: `accepted`, or the reject reason.

The reasoner's thread may call it.
"""


@dataclass(frozen=True)
class ReasonerRequest:
    """Query to a reasoner.

    Attributes:
        scene: Scene for the reasoner.
        check: Check of a plan by the guard before the reasoner decides. None if the surroundings are unknown.
        deadline_s: Wall time for the answer (s); None for no limit.
        assess: Assessment of a whole plan by the guard, with margins. None if the surroundings are unknown.
        budget: Bounds of the ladder's rung on the use of the reasoner in one intervention. None for the reasoner's own.
    """

    scene: Scene
    check: PlanCheck | None = None
    deadline_s: float | None = None
    assess: PlanAssessor | None = None
    budget: QueryBudget | None = None


class OfferedPlan(FrozenModel):
    """Plan that a query offered for choice, with the letter that an answer names."""

    letter: str
    plan: RecoveryPlan


class ReasonerTrace(FrozenModel):
    """Origin of an answer by a reasoner other than the rules: enough to parse it again offline.

    `answers` are the raw answers in order. The decision was parsed from the last one, by the parser of `format`.
    `menu` has the plans that the query offered, so that a letter means the same plan again without the guard.
    """

    format: str = "decision"
    prompt: str | None = None
    answers: tuple[str, ...] = ()
    menu: tuple[OfferedPlan, ...] = ()
    model: str | None = None
    input_tokens: int | None = None
    output_tokens: int | None = None
    usd: float | None = None
    """Cost of the answers (US dollars), if the model's price is known."""
    seconds: float | None = None
    notes: tuple[str, ...] = ()
    """Changes in how the reasoner is queried, made during this query: a format given up, or tried again."""


@dataclass(frozen=True)
class ReasonerAnswer:
    """Decision with the name of its reasoner. `trace` is None if it follows from the scene alone."""

    decision: Decision
    reasoner: str
    trace: ReasonerTrace | None = None


class Reasoner(Protocol):
    """Interface of a reasoner. It is called outside the control loop, one request at a time."""

    @property
    def name(self) -> str:
        """Name in every result."""

    def decide(self, request: ReasonerRequest) -> ReasonerAnswer:
        """Return the observation, analysis and decision for a scene.

        Args:
            request: Scene, check of plans against the guard, and deadline.

        Raises:
            ReasonerError: The reasoner has no answer.
        """


class ReasonerError(Exception):
    """Missing answer of a reasoner. The message has the reason and the remedy; `trace` has the cost, if it is known."""

    trace: ReasonerTrace | None = None


class MalformedAnswerError(ReasonerError):
    """Answer of a wrong type, too large, nested too deeply, or with a rejected value."""


@runtime_checkable
class Cancellable(Protocol):
    """Reasoner whose query can be canceled from another thread."""

    def cancel(self) -> None:
        """End the running `decide` soon with `ReasonerError`. Does nothing if none is running."""


@runtime_checkable
class SupportsPreflight(Protocol):
    """Reasoner that depends on an external service and can check it before a run."""

    def preflight(self) -> tuple[str, ...]:
        """Return notes for the user, one line each.

        Raises:
            ReasonerError: The reasoner cannot be used.
        """


Menu = Mapping[str, RecoveryPlan]
"""Plans by letter that a query offered for choice, in the solver's frame."""
Parser = Callable[[str, Scene, Menu], Decision]
"""Parses a raw answer to a scene with a menu into a decision. Raises `ReasonerError`."""


def _parse_decision(answer: str, scene: Scene, menu: Menu) -> Decision:
    """Parse an answer in the JSON form of a decision."""
    try:
        return Decision.model_validate_json(answer)
    except ValidationError as error:
        raise ReasonerError(f"the answer is not a decision: {error.errors()[0]['msg']}") from error


PARSERS: dict[str, Parser] = {"decision": _parse_decision}
"""Parsers by the `format` of a trace. A reasoner with its own format registers its parser when it is imported."""


def parse_trace(trace: ReasonerTrace, scene: Scene) -> Decision:
    """Parse a recorded answer again.

    Raises:
        ReasonerError: The trace contains no answer, or its format has no parser.
    """
    if trace.format not in PARSERS:
        raise ReasonerError(f"no parser for answers in the format {trace.format!r}; known: {', '.join(PARSERS)}")
    if not trace.answers:
        raise ReasonerError("the trace contains no answer")
    menu = {offered.letter: offered.plan for offered in trace.menu}
    return PARSERS[trace.format](trace.answers[-1], scene, menu)
