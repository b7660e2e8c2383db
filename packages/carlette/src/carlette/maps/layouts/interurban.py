"""Country roads, 1500 m by 1000 m: a two-way main road around a village, with hills and bends.

.-----E---------D----.       A to F, K  T-junctions of side roads with the main road (stop at A, C, E; yield)
     )         (    |       G          all-way stop
F--x--H====M====G--x-C       H          crossroads, the village street goes first
     (    :    x    |       M          a lane too narrow for two cars (:) meets the village street
`-----A----K----B----'       =          village street with parking lanes
                             ( )        winding side roads      x   level crossing
"""

from __future__ import annotations

import math

from carlette.maps.build.plan import Control, End, JunctionNode, Plan, PlannedStreet, StreetCrossing
from carlette.maps.build.sections import LANE_ROAD, NARROW, RURAL, RURAL_BENDS, VILLAGE
from carlette.maps.reference_lines import Pose2D

_EAST, _NORTH, _WEST, _SOUTH = 0.0, 90.0, 180.0, 270.0
_REACH_M = 20.0
"""Distance from the center of a junction to the start of its arms (m). Ours."""
_STEMS: dict[str, Control] = {
    "A": "stop",
    "B": "yield",
    "C": "stop",
    "D": "yield",
    "E": "stop",
    "F": "yield",
    "K": "yield",
}


def plan() -> Plan:
    """Return the roads."""
    places = {
        "A": (380.0, 0.0, 2.0),
        "B": (1100.0, 0.0, 6.0),
        "C": (1500.0, 500.0, 12.0),
        "D": (1100.0, 1000.0, 7.0),
        "E": (380.0, 1000.0, 3.0),
        "F": (0.0, 500.0, 5.0),
        "G": (1100.0, 500.0, 6.0),
        "H": (380.0, 500.0, 2.0),
        "K": (740.0, -35.0, 1.0),
        "M": (740.0, 500.0, 4.0),
    }
    nodes = [JunctionNode(name, *place, reach_m=_REACH_M, crosswalks=name in "GHM") for name, place in places.items()]
    return Plan("interurban", nodes, [*_main_road(), *_side_roads()])


def _main_road() -> list[PlannedStreet]:
    """Return the main road, counterclockwise from A.

    It turns by 90 degrees between B and C, C and D, E and F, F and A.
    """
    return [
        PlannedStreet("Valley Road", End("A", _EAST), End("K", _WEST), RURAL, heights=((0.5, -2.0),)),
        PlannedStreet("Valley Road", End("K", _EAST), End("B", _WEST), RURAL),
        PlannedStreet("Valley Road", End("B", _EAST), End("C", _SOUTH), RURAL, (_pose(1370.0, 130.0, 45.0),)),
        PlannedStreet(
            "Hill Road", End("C", _NORTH), End("D", _EAST), RURAL, (_pose(1370.0, 870.0, 135.0),), ((0.4, 16.0),)
        ),
        PlannedStreet("Hill Road", End("D", _WEST), End("E", _EAST), RURAL, (_pose(740.0, 1040.0, _WEST),)),
        PlannedStreet(
            "West Road", End("E", _WEST), End("F", _NORTH), RURAL, (_pose(130.0, 870.0, 225.0),), ((0.5, 8.0),)
        ),
        PlannedStreet("West Road", End("F", _SOUTH), End("A", _WEST), RURAL, (_pose(130.0, 130.0, 315.0),)),
    ]


def _side_roads() -> list[PlannedStreet]:
    return [
        PlannedStreet(
            "Mill Lane", _stem("A", _NORTH), End("H", _SOUTH, "stop"), RURAL_BENDS, _winding(380.0, 0.0, 70.0)
        ),
        PlannedStreet(
            "Abbey Lane", End("H", _NORTH, "stop"), _stem("E", _SOUTH), RURAL_BENDS, _winding(380.0, 500.0, -70.0)
        ),
        PlannedStreet(
            "Wood Lane", End("G", _NORTH, "stop"), _stem("D", _SOUTH), RURAL_BENDS, _winding(1100.0, 500.0, 60.0)
        ),
        PlannedStreet("Church Lane", _stem("B", _NORTH), End("G", _SOUTH, "stop"), LANE_ROAD, crossings=_rails(230.0)),
        PlannedStreet("Quarry Lane", End("G", _EAST, "stop"), _stem("C", _WEST), LANE_ROAD, crossings=_rails(180.0)),
        PlannedStreet("Rail Lane", _stem("F", _EAST), End("H", _WEST), LANE_ROAD, crossings=_rails(170.0)),
        PlannedStreet("Village Street", End("H", _EAST), End("M", _WEST), VILLAGE),
        PlannedStreet("Village Street", End("M", _EAST), End("G", _WEST, "stop"), VILLAGE),
        PlannedStreet("Drovers Lane", _stem("K", _NORTH), End("M", _SOUTH, "stop"), NARROW),
    ]


def _stem(node: str, bearing_deg: float) -> End:
    """Return the side road's end at the main road."""
    return End(node, bearing_deg, _STEMS[node])


def _rails(at_m: float) -> tuple[StreetCrossing, ...]:
    return (StreetCrossing(at_m, "rails"),)


def _winding(x: float, south: float, swing_m: float) -> tuple[Pose2D, ...]:
    """Return a road northward over 500 m, out to one side and back."""
    return (
        _pose(x + swing_m * 0.5, south + 150.0, 90.0 - math.copysign(35.0, swing_m)),
        _pose(x + swing_m, south + 250.0, _NORTH),
        _pose(x + swing_m * 0.5, south + 350.0, 90.0 + math.copysign(35.0, swing_m)),
    )


def _pose(x: float, y: float, heading_deg: float) -> Pose2D:
    return Pose2D(x, y, math.radians(heading_deg))
