"""The data of one run's replay: the map around it, all actors and all decisions.

Everything is in the map's right-handed frame (x east, y north, meters; yaw counter-clockwise in degrees), rounded to
centimeters when written.
"""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from stucksolver.scene.base_model import FrozenModel
from stucksolver.scene.failed_attempts import RejectCode
from stucksolver_eval.results.outcome import QueryOutcome

Polyline = tuple[tuple[float, float], ...]
ActorRole = Literal["ego", "scenario", "traffic", "prop"]


class LaneArea(FrozenModel):
    """One stretch of lane as an area between two borders."""

    kind: str
    """`driving`, `shoulder`, `sidewalk`, `parking`, `biking`, `median`, ..."""
    left: Polyline
    right: Polyline


class Marking(FrozenModel):
    """A painted line."""

    points: Polyline
    kind: Literal["broken", "solid", "other"]
    color: str = "white"


class MapView(FrozenModel):
    """The part of the map around a run."""

    name: str
    lanes: tuple[LaneArea, ...]
    markings: tuple[Marking, ...]


class ActorInfo(FrozenModel):
    """An actor that appears in the frames; `RunLogFrame.poses` refers to it by its index in `RunLog.actors`."""

    label: str
    kind: str
    """`car`, `van`, `truck`, `bicycle`, `pedestrian`, `cone`, ... as in the scene."""
    length_m: float
    width_m: float
    role: ActorRole


class RunLogFrame(FrozenModel):
    """One sampled time."""

    time_s: float
    speed_mps: float
    """Speed of the ego."""
    poses: tuple[tuple[int, float, float, float], ...]
    """(index in `RunLog.actors`, x_m, y_m, yaw_deg) of each actor that is present; the ego is actor 0."""
    lights: tuple[tuple[float, float, str], ...] = ()
    """(x_m, y_m, state) of traffic lights nearby: `red`, `yellow`, `green`, `off`."""
    path: Polyline = ()
    """Path of the current recovery behavior, if any."""


class DecisionMoment(FrozenModel):
    """A decision at the time of its delivery, with the guard's verdict."""

    time_s: float
    trigger: str
    """`detector` or `guidance`."""
    decision: dict[str, Any]
    """JSON form of `stucksolver.plan.Decision`: observation, analysis, plan (None: nothing to do), rationale."""
    outcome: QueryOutcome
    codes: tuple[RejectCode, ...] = ()
    """Reasons of the rejection."""
    verdict: str
    """The verdict for people, with details."""
    picture: str | None = None
    """The front camera's image at the time of the query, if there is a camera: a small JPEG in base64."""


class LogEvent(FrozenModel):
    """Any other event in the replay's list."""

    time_s: float
    kind: Literal["guidance", "directive", "abort", "outcome", "infraction", "stuck", "run"]
    text: str


class RunResult(FrozenModel):
    """The metrics of one run, as in the table."""

    status: str
    """`completed`, `blocked`, `timeout`, `collision`, ..."""
    route_completion_pct: float
    infractions: dict[str, int] = Field(default_factory=dict)
    stopped_s: float | None
    """Time with a speed below 0.1 m/s, also at the start and at lights; None in results without this measurement."""
    time_to_recover_s: float | None
    """From the onset of an immobilization to 15 m of new progress; the median of several, None without a recovery."""
    immobilizations: int
    """Number of times that the ego was below 5 km/h for 10 s or more, or that a plan moved it, before 15 m of progress.

    `metrics.recovery` counts the same ones.
    """
    recoveries: int = 0
    """Number of them that were followed by 15 m of new progress."""
    decisions: int
    plans_accepted: int
    duration_s: float
    distance_m: float


class RunLog(FrozenModel):
    """One run from start to end."""

    version: Literal[1] = 1
    scenario: str
    """A short description: `parked car, one lane each way`."""
    arm: str
    """Name of the system: `driver alone`, `StuckSolver`, `StuckSolver + passenger`."""
    seed: int
    driver: str
    reasoner: str
    clock: str
    perception: str
    map: MapView
    route: Polyline
    actors: tuple[ActorInfo, ...]
    frames: tuple[RunLogFrame, ...]
    stuck: tuple[tuple[float, float], ...]
    """The spans of the immobilizations that count (s), each from its onset to 15 m of new progress or the end."""
    decisions: tuple[DecisionMoment, ...]
    events: tuple[LogEvent, ...]
    result: RunResult
