"""The outcome of one route in addition to the leaderboard's record: the input of the recovery metrics.

Times are seconds since the start of the route; positions are meters along it.
"""

from __future__ import annotations

from enum import Enum
from typing import Literal

from pydantic import Field

from stucksolver.guard import Verdict
from stucksolver.scene.base_model import FrozenModel

Expected = Literal["recover", "wait", "ask", "reroute", "leave"]
State = Literal["driven", "unsupported", "invalid", "crashed"]


class TimedInfraction(FrozenModel):
    """An infraction, or a near miss, with its time."""

    kind: str
    time_s: float
    text: str


class SpokenGuidance(TimedInfraction):
    """An utterance or reply of a person. `help` is the intended kind of help, empty if none."""

    help: str = ""
    by: str = "passenger"


class NoticeRecord(FrozenModel):
    """A person was told why the vehicle stands."""

    time_s: float
    to: str
    """`passenger` or `operator`."""


class ImmobilizationEpisode(FrozenModel):
    """A time of immobilization: below 5 km/h for 1 s or more, until 15 m of new progress."""

    onset_s: float
    place_m: float
    recovered_after_s: float | None
    """None if the route ended first."""
    ended_s: float


class InterventionRecord(FrozenModel):
    """A plan that was executed."""

    start_s: float
    end_s: float
    place_m: float
    rung: str
    """The rung of the ladder that proposed it: `reasoner` (formerly `rules`), `passenger`, or a timer's action."""
    behaviors: tuple[str, ...]
    moves: bool
    """False for a plan without motion."""
    finished: bool
    text: str = ""


class QueryOutcome(str, Enum):
    """The outcome of a query to the reasoner."""

    NO_PLAN = "nothing to do"
    ACCEPTED = "accepted"
    REFUSED = "refused"
    """A plan that the guard rejected."""
    FAILED = "failed"
    """There was no answer."""


class QueryRecord(FrozenModel):
    """A query to the reasoner."""

    asked_s: float
    answered_s: float | None = None
    took_s: float | None = None
    """Wall time."""
    tokens: int = 0
    usd: float | None = None
    outcome: QueryOutcome | None = None
    """None if the answer was no longer needed."""
    verdict: str = ""
    """The outcome for people, with the reasons."""


def came_to(verdict: Verdict | None) -> tuple[QueryOutcome, str]:
    """Return the outcome of an answer, and a text for people. `verdict` is None if it proposed no plan."""
    if verdict is None:
        return QueryOutcome.NO_PLAN, QueryOutcome.NO_PLAN.value
    if verdict.accepted:
        return QueryOutcome.ACCEPTED, QueryOutcome.ACCEPTED.value
    return QueryOutcome.REFUSED, f"{QueryOutcome.REFUSED.value}: {verdict}"


class Reliability(FrozenModel):
    """Reliability of a reasoner that depends on an external service, in a run."""

    reasoner: str
    asked: int
    """Number of queries that were not canceled."""
    unanswered: int
    why: str = ""
    """Reason of the last one without a usable answer."""
    queries: int = 0
    """Number of queries that reached a language model, also those that were canceled or had no usable answer."""
    tokens: int = 0
    """Input and output tokens of these queries."""
    usd: float | None = None
    """Their cost (US dollars); None if the price of one of them is unknown."""
    latencies_s: tuple[float, ...] = ()
    """Wall time of each of them (s)."""


class RouteOutcome(FrozenModel):
    """One route with one system and one seed."""

    version: Literal[1] = 1
    route_id: str
    scenario: str
    town: str
    seed: int
    arm: str
    state: State = "driven"
    reason: str = ""
    """Reason why it was not driven."""
    expected: Expected | None = None
    """The right action in the scenario, if it is stated."""
    within_s: float | None = None
    """Time for the right action (s), if it is limited."""
    marks: dict[str, float] = Field(default={})
    """Times of the scenario's marks: the ego has `met` the situation, going became right (`free`), the ego has `passed`
    it, or `left` the place where it may not stop."""
    asked_s: float | None = None
    """Time of the call for help, or None."""
    notices: tuple[NoticeRecord, ...] = ()
    ticks: int = 0
    wall_s: float = 0.0
    length_m: float = 0.0
    points: int = 0
    first_junction: int | None = None
    """1-based index of the first junction point of the 1 m route."""
    stuck_end_pct: float | None = None
    """Speed relative to the traffic (%) on the last stretch, if the ego did not complete it."""
    infractions: tuple[TimedInfraction, ...] = ()
    near_misses: tuple[TimedInfraction, ...] = ()
    spells: tuple[ImmobilizationEpisode, ...] = ()
    stopped_s: float | None = None
    """Time with a speed below 0.1 m/s (s); None in results from before this measurement."""
    interventions: tuple[InterventionRecord, ...] = ()
    queries: tuple[QueryRecord, ...] = ()
    reliability: tuple[Reliability, ...] = ()
    guidance: tuple[SpokenGuidance, ...] = ()
    track: tuple[tuple[float, float], ...] = Field(default=())
    """(time, position) once per second."""
