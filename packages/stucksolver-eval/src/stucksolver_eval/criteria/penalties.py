"""The penalty of each kind of infraction in Bench2Drive (0.0.4), and the driving score of one route."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from stucksolver_eval.criteria.criterion import Infraction

FACTORS = {
    "collisions_layout": 0.65,
    "collisions_pedestrian": 0.5,
    "collisions_vehicle": 0.6,
    "red_light": 0.7,
    "stop_infraction": 0.8,
    "scenario_timeouts": 0.7,
    "yield_emergency_vehicle_infractions": 0.7,
}
"""Penalty factors, one multiplication per event."""
OUTSIDE, MIN_SPEED = "outside_route_lanes", "min_speed_infractions"
KINDS = (
    "collisions_layout",
    "collisions_pedestrian",
    "collisions_vehicle",
    "red_light",
    "stop_infraction",
    OUTSIDE,
    MIN_SPEED,
    "yield_emergency_vehicle_infractions",
    "scenario_timeouts",
    "route_dev",
    "vehicle_blocked",
    "route_timeout",
)
"""The keys of a record's infractions, in the leaderboard's order."""
DIGITS = 6
"""Number of decimals of scores, as in the leaderboard."""


@dataclass(frozen=True)
class RouteScores:
    """Completion (%), penalty (0 to 1) and their product."""

    route: float
    penalty: float
    composed: float


def score_route(completion_pct: float, infractions: Iterable[Infraction]) -> RouteScores:
    """Return the driving score of one route. Low speed has no penalty. The penalty for lanes is the share outside."""
    penalty = 1.0
    for infraction in infractions:
        if infraction.kind == OUTSIDE:
            assert infraction.percentage is not None
            penalty *= 1.0 - infraction.percentage / 100.0
        else:
            penalty *= FACTORS.get(infraction.kind, 1.0)
    composed = max(completion_pct * penalty, 0.0)
    return RouteScores(round(completion_pct, DIGITS), round(penalty, DIGITS), round(composed, DIGITS))
