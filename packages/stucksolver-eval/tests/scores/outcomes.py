"""Outcomes for tests of recovery's figures."""

from __future__ import annotations

from typing import Any

from stucksolver_eval.results.outcome import (
    ImmobilizationEpisode,
    InterventionRecord,
    RouteOutcome,
    SpokenGuidance,
    TimedInfraction,
)


def outcome(**changes: Any) -> RouteOutcome:
    """A 200 m route that was driven at 1 m/s."""
    usual = {
        "route_id": "1",
        "scenario": "Accident",
        "town": "t",
        "seed": 1,
        "arm": "rules",
        "length_m": 200.0,
        "track": tuple((float(t), float(t)) for t in range(201)),
    }
    return RouteOutcome(**(usual | changes))


def spell(onset_s: float, ended_s: float, recovered: bool = True, place_m: float = 50.0) -> ImmobilizationEpisode:
    after_s = ended_s - onset_s if recovered else None
    return ImmobilizationEpisode(onset_s=onset_s, place_m=place_m, recovered_after_s=after_s, ended_s=ended_s)


def plan(start_s: float, end_s: float, place_m: float | None = None, moves: bool = True) -> InterventionRecord:
    return InterventionRecord(
        start_s=start_s,
        end_s=end_s,
        place_m=start_s if place_m is None else place_m,
        rung="rules",
        behaviors=("change_lane",),
        moves=moves,
        finished=True,
    )


def noted(time_s: float, kind: str = "collisions_vehicle") -> TimedInfraction:
    return TimedInfraction(kind=kind, time_s=time_s, text="")


def spoken(time_s: float, kind: str, help: str = "") -> SpokenGuidance:
    return SpokenGuidance(kind=kind, time_s=time_s, text="", help=help)
