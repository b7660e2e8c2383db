"""Bench2Drive's five abilities: success rates of groups of scenario types, and their mean."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

_JUNCTION_TURNS = (
    "EnterActorFlow",
    "CrossingBicycleFlow",
    "NonSignalizedJunctionLeftTurn",
    "NonSignalizedJunctionRightTurn",
    "NonSignalizedJunctionLeftTurnEnterFlow",
    "SignalizedJunctionLeftTurn",
    "SignalizedJunctionRightTurn",
    "SignalizedJunctionLeftTurnEnterFlow",
)
_AT_JUNCTIONS = (
    "BlockedIntersection",
    "OppositeVehicleTakingPriority",
    "OppositeVehicleRunningRedLight",
    "PedestrianCrossing",
    "VehicleTurningRoute",
    "VehicleTurningRoutePedestrian",
)
TRAFFIC_SIGNS = "Traffic_Signs"
ABILITIES: dict[str, frozenset[str]] = {
    "Overtaking": frozenset(
        (
            "Accident",
            "AccidentTwoWays",
            "ConstructionObstacle",
            "ConstructionObstacleTwoWays",
            "HazardAtSideLane",
            "HazardAtSideLaneTwoWays",
            "ParkedObstacle",
            "ParkedObstacleTwoWays",
            "VehicleOpensDoorTwoWays",
        )
    ),
    "Merging": frozenset(
        (
            *_JUNCTION_TURNS,
            "HighwayCutIn",
            "HighwayExit",
            "InterurbanActorFlow",
            "InterurbanAdvancedActorFlow",
            "MergerIntoSlowTraffic",
            "MergerIntoSlowTrafficV2",
            "ParkingExit",
            "SequentialLaneChange",
        )
    ),
    "Emergency_Brake": frozenset(
        (
            *_AT_JUNCTIONS,
            "ControlLoss",
            "DynamicObjectCrossing",
            "HardBreakRoute",
            "ParkingCrossingPedestrian",
            "ParkingCutIn",
            "StaticCutIn",
        )
    ),
    "Give_Way": frozenset(("InvadingTurn", "YieldToEmergencyVehicle")),
    TRAFFIC_SIGNS: frozenset(
        (
            *_AT_JUNCTIONS,
            *_JUNCTION_TURNS,
            "T_Junction",
            "VanillaNonSignalizedTurn",
            "VanillaNonSignalizedTurnEncounterStopsign",
            "VanillaSignalizedTurnEncounterGreenLight",
            "VanillaSignalizedTurnEncounterRedLight",
        )
    ),
}
JUNCTION_POINTS = 8
"""Number of route points beyond the entry of the first junction from which a failed route of Traffic_Signs counts."""


@dataclass(frozen=True)
class AbilityCase:
    """A route with a record, as input of the abilities.

    `first_junction` is the 1-based index of the first junction point among the route's `points`; None without one.
    """

    scenario: str
    success: bool
    completion_pct: float
    obeyed: bool
    """True if the ego ran neither a stop sign nor a red light."""
    first_junction: int | None
    points: int


def ability_scores(cases: Iterable[AbilityCase]) -> dict[str, float | None]:
    """Return the success rate (%) of each group, and `mean` of the five; None for a group without routes.

    The public tool divides by zero if a group is empty. Here the mean is then None.
    """
    noted = list(cases)
    scores = {name: _rate([c for c in noted if c.scenario in types], name) for name, types in ABILITIES.items()}
    known = [score for score in scores.values() if score is not None]
    return {**scores, "mean": sum(known) / len(ABILITIES) if len(known) == len(ABILITIES) else None}


def _rate(cases: list[AbilityCase], group: str) -> float | None:
    if not cases:
        return None
    return 100.0 * sum(c.success or (group == TRAFFIC_SIGNS and passed_junction(c)) for c in cases) / len(cases)


def passed_junction(case: AbilityCase) -> bool:
    """True for the extra credit of Traffic_Signs: far into the first junction without running a sign or a light."""
    if case.first_junction is None:
        return False
    return case.obeyed and case.completion_pct / 100.0 > (case.first_junction + JUNCTION_POINTS) / case.points
