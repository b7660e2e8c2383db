"""Cause of a lasting immobilization in each scenario type: the truth for the cause.

Types that are not listed can hold the vehicle for several reasons; their samples teach no cause.
"""

from __future__ import annotations

from stucksolver.plan import CauseCode

CAUSE_OF: dict[str, CauseCode] = {
    "Accident": CauseCode.DISABLED_VEHICLE,
    "AccidentTwoWays": CauseCode.DISABLED_VEHICLE,
    "AllWayStopDeadlock": CauseCode.UNKNOWN,
    "AmbulanceBehind": CauseCode.DISABLED_VEHICLE,
    "ClosedBoxInLane": CauseCode.STATIC_OBSTACLE,
    "ClosedRoad": CauseCode.BLOCKED_ROAD,
    "ConstructionObstacle": CauseCode.STATIC_OBSTACLE,
    "ConstructionObstacleTwoWays": CauseCode.STATIC_OBSTACLE,
    "DarkTrafficLight": CauseCode.UNKNOWN,
    "DebrisInLane": CauseCode.STATIC_OBSTACLE,
    "DisabledCarAndPaperBag": CauseCode.DISABLED_VEHICLE,
    "DisabledCarAndRock": CauseCode.DISABLED_VEHICLE,
    "DoubleParkedVan": CauseCode.DISABLED_VEHICLE,
    "MergeNeverOpens": CauseCode.BLOCKED_ROAD,
    "NarrowRoadStandoff": CauseCode.BLOCKED_ROAD,
    "ParkedObstacle": CauseCode.DISABLED_VEHICLE,
    "ParkedObstacleTwoWays": CauseCode.DISABLED_VEHICLE,
    "ParkingExit": CauseCode.PARKED_VEHICLE,
    "PictureOfTrafficLight": CauseCode.PARKED_VEHICLE,
    "RocksAcrossRoad": CauseCode.BLOCKED_ROAD,
    "RoundaboutLoop": CauseCode.LOOP,
    "ToyInLane": CauseCode.STATIC_OBSTACLE,
    "VehicleOpensDoorTwoWays": CauseCode.PARKED_VEHICLE,
}
