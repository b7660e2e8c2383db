"""Values of the scenarios' parameters, drawn within the ranges that Bench2Drive's own route files span."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from random import Random

from stucksolver_eval.routes import Parameter


@dataclass(frozen=True)
class Value:
    """`<name value="..."/>`, a whole number between two others."""

    low: int
    high: int

    def draw(self, random: Random) -> Parameter:
        return {"value": str(random.randint(self.low, self.high))}


@dataclass(frozen=True)
class Hundredths:
    """`<name value="..."/>` with two decimals."""

    low: float
    high: float

    def draw(self, random: Random) -> Parameter:
        return {"value": f"{random.uniform(self.low, self.high):.2f}"}


@dataclass(frozen=True)
class Interval:
    """`<name from="..." to="..."/>`, each end within its own range."""

    first: tuple[int, int]
    last: tuple[int, int]

    def draw(self, random: Random) -> Parameter:
        return {"from": str(random.randint(*self.first)), "to": str(random.randint(*self.last))}


@dataclass(frozen=True)
class OneOf:
    """`<name value="..."/>`, one of several words."""

    words: tuple[str, ...]

    def draw(self, random: Random) -> Parameter:
        return {"value": random.choice(self.words)}


Draw = Value | Hundredths | Interval | OneOf

_RIGHT = OneOf(("right",))
_BLOCKERS = OneOf(
    ("static.prop.container", "static.prop.advertisement", "static.prop.busstoplb", "static.prop.foodcart")
)


def _flow(speed: tuple[int, int], first: tuple[int, int], last: tuple[int, int]) -> dict[str, Draw]:
    return {"flow_speed": Value(*speed), "source_dist_interval": Interval(first, last)}


_OURS_ON_A_LANE = (
    "DisabledCarAndPaperBag",
    "DisabledCarAndRock",
    "DebrisInLane",
    "ClosedBoxInLane",
    "ToyInLane",
    "NarrowRoadStandoff",
    "DoubleParkedVan",
    "RoadBlockedForAMinute",
    "PictureOfTrafficLight",
    "AnimalsOnRoad",
    "Flagger",
    "SchoolBus",
    "EmergencyScene",
)

DRAWS: Mapping[str, Mapping[str, Draw]] = {
    "Accident": {"distance": Value(40, 44), "direction": _RIGHT, "speed": Value(50, 60)},
    "AccidentTwoWays": {"distance": Value(40, 45), "frequency": Interval((30, 63), (108, 190))},
    "ConstructionObstacle": {"distance": Value(40, 45), "direction": _RIGHT, "speed": Value(44, 58)},
    "ConstructionObstacleTwoWays": {"distance": Value(40, 45), "frequency": Interval((40, 75), (111, 200))},
    "CrossingBicycleFlow": _flow((8, 12), (5, 15), (25, 30)),
    "DynamicObjectCrossing": {
        "distance": Value(33, 50),
        "direction": _RIGHT,
        "blocker_model": _BLOCKERS,
        "crossing_angle": Value(0, 15),
    },
    "EnterActorFlow": _flow((12, 20), (17, 30), (30, 39)),
    "HazardAtSideLane": {
        "distance": Value(41, 45),
        "speed": Value(30, 60),
        "bicycle_drive_distance": Value(40, 150),
        "bicycle_speed": Value(6, 12),
    },
    "HazardAtSideLaneTwoWays": {
        "distance": Value(41, 45),
        "frequency": Value(75, 100),
        "bicycle_drive_distance": Value(80, 140),
        "bicycle_speed": Value(7, 11),
    },
    "HighwayExit": _flow((10, 15), (11, 20), (33, 46)),
    "InterurbanActorFlow": _flow((15, 20), (33, 54), (78, 99)),
    "InterurbanAdvancedActorFlow": _flow((16, 18), (36, 42), (84, 94)),
    "InvadingTurn": {"distance": Value(50, 60), "offset": Hundredths(0.18, 0.39)},
    "MergerIntoSlowTraffic": _flow((9, 10), (14, 16), (30, 45)),
    "MergerIntoSlowTrafficV2": _flow((10, 10), (11, 15), (30, 35)),
    "NonSignalizedJunctionLeftTurn": _flow((8, 12), (15, 24), (25, 30)),
    "NonSignalizedJunctionLeftTurnEnterFlow": _flow((8, 10), (15, 19), (26, 30)),
    "NonSignalizedJunctionRightTurn": _flow((8, 14), (16, 24), (25, 30)),
    "ParkedObstacle": {"distance": Value(40, 44), "direction": _RIGHT, "speed": Value(40, 59)},
    "ParkedObstacleTwoWays": {"distance": Value(40, 45), "frequency": Interval((31, 61), (106, 200))},
    "ParkingCrossingPedestrian": {"distance": Value(36, 45), "direction": _RIGHT, "crossing_angle": Value(0, 12)},
    "ParkingCutIn": {"direction": _RIGHT},
    "ParkingExit": {
        "direction": _RIGHT,
        "front_vehicle_distance": Value(9, 9),
        "behind_vehicle_distance": Value(9, 9),
    },
    "SignalizedJunctionLeftTurn": _flow((8, 12), (15, 24), (25, 30)),
    "SignalizedJunctionLeftTurnEnterFlow": _flow((8, 10), (16, 24), (25, 30)),
    "SignalizedJunctionRightTurn": _flow((10, 14), (19, 24), (26, 38)),
    "StaticCutIn": {"distance": Value(40, 45), "direction": _RIGHT},
    "VehicleOpensDoorTwoWays": {"distance": Value(37, 59), "frequency": Interval((25, 40), (85, 100))},
    "YieldToEmergencyVehicle": {"distance": Value(26, 30)},
    **{kind: {"distance": Value(40, 48)} for kind in _OURS_ON_A_LANE},
}
"""Scenario type to its parameters, but for those that follow from the site. Types without any are not named."""

_BESIDE_THE_RIDE_M = 100
"""Of a free lane: the hazard's distance, what is left to pass it, and the end."""
_SHORTEST_RIDE_M = 40


def draw(kind: str, random: Random, free_m: int) -> dict[str, Parameter]:
    """The parameters of a type; bicycles ride no further than a free lane of this length permits."""
    drawn = {name: one.draw(random) for name, one in DRAWS.get(kind, {}).items()}
    ride = drawn.get("bicycle_drive_distance")
    if ride is not None:
        longest_m = max(_SHORTEST_RIDE_M, free_m - _BESIDE_THE_RIDE_M)
        drawn["bicycle_drive_distance"] = {"value": str(min(int(ride["value"]), longest_m))}
    return drawn
