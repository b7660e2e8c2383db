"""A town of avenues and streets in a grid, 1120 m by 780 m, with every kind of junction and curb.

        0      280     560     840    1120
    780  .--------T-------L-------T--------.      T  stop or yield on the stem
         |        |       |       =        |      L  traffic lights
    520  T========R=======L=======S========T      R  roundabout
         |        #       |       =        |      S  all-way stop
    260  L--------L-------L-------L--------L      =  bicycle lanes
         |        #       |       |        |      #  parking lanes
      0  '--------T-------L-------T--------'

The outer ring and the row at 260 have two lanes each way, and so has the column at 560, where the outermost lane is for
buses. North of the roundabout is a one-way street; School Street is the southern end of the fourth column.
"""

from __future__ import annotations

import math
from itertools import pairwise

from carlette.maps.build.plan import Control, End, JunctionNode, Plan, PlannedStreet, RoadsidePlot, StreetCrossing
from carlette.maps.build.sections import (
    AVENUE,
    BIKE_STREET,
    BUS_AVENUE,
    ONE_WAY,
    PARKING_STREET,
    RING,
    SLOW_STREET,
    CrossSection,
)
from carlette.maps.reference_lines import Pose2D

_X = (0.0, 280.0, 560.0, 840.0, 1120.0)
_Y = (0.0, 260.0, 520.0, 780.0)
_EAST, _NORTH, _WEST, _SOUTH = 0.0, 90.0, 180.0, 270.0
_CORNER_M = 40.0
"""Radius of the corners (m). Ours."""
_RING_M = 20.0
"""Radius of the roundabout (m). Ours."""
_RING_HALF_DEG = 26.0
"""Angle of a roundabout's node on each side of its arm (degrees). Ours."""
_RING_ARM_M = 40.0
"""Distance of the arms' ends from the roundabout's center (m). Ours."""
_ROUNDABOUT = (1, 2)
_LIT = {(1, 1), (2, 1), (3, 1), (2, 2), (2, 0), (2, 3), (0, 1), (4, 1)}


def plan() -> Plan:
    """Return the town."""
    nodes = [JunctionNode(_name(c, r), _X[c], _Y[r]) for r in range(4) for c in range(5) if _is_junction(c, r)]
    return Plan("grid_town", [*nodes, *_ring_nodes()], [*_ring_road(), *_rows(), *_columns(), *_roundabout()])


def _is_junction(column: int, row: int) -> bool:
    return (column, row) != _ROUNDABOUT and not (column in (0, 4) and row in (0, 3))


def _name(column: int, row: int) -> str:
    return f"{'ABCDE'[column]}{row + 1}"


def _end(column: int, row: int, bearing_deg: float) -> End:
    """Return the end of a street at a crossing of the grid; at the roundabout, at its node of that side."""
    if (column, row) == _ROUNDABOUT:
        return End(f"{_name(column, row)} {bearing_deg:.0f}", bearing_deg, "yield", reach_m=_RING_ARM_M - _RING_M)
    return End(_name(column, row), bearing_deg, _control(column, row, bearing_deg))


def _control(column: int, row: int, bearing_deg: float) -> Control:
    stems: dict[tuple[int, int], Control] = {
        (1, 0): "stop",
        (3, 0): "yield",
        (0, 2): "stop",
        (4, 2): "yield",
        (1, 3): "yield",
        (3, 3): "yield",
    }
    along_ring = (_EAST, _WEST) if row in (0, 3) else (_NORTH, _SOUTH)
    if (column, row) in _LIT:
        return "light"
    if (column, row) == (3, 2):
        return "stop"
    return "none" if bearing_deg in along_ring else stems.get((column, row), "none")


def _ring_road() -> list[PlannedStreet]:
    """Return the four sides and corners, counterclockwise from the south-west."""
    streets = []
    sides = [
        ("South Avenue", [(1, 0), (2, 0), (3, 0)], _EAST),
        ("East Avenue", [(4, 1), (4, 2)], _NORTH),
        ("North Avenue", [(3, 3), (2, 3), (1, 3)], _WEST),
        ("West Avenue", [(0, 2), (0, 1)], _SOUTH),
    ]
    for index, (name, places, bearing) in enumerate(sides):
        for place, other in pairwise(places):
            streets.append(PlannedStreet(name, _end(*place, bearing), _end(*other, (bearing + 180) % 360), AVENUE))
        _, following, next_bearing = sides[(index + 1) % 4]
        start, end = _end(*places[-1], bearing), _end(*following[0], (next_bearing + 180) % 360)
        streets.append(PlannedStreet(f"{name} corner", start, end, AVENUE, _corner(bearing)))
    return streets


def _corner(bearing_deg: float) -> tuple[Pose2D, Pose2D]:
    """Return the start and the end of the left bend at the end of a side."""
    column, row = {_EAST: (4, 0), _NORTH: (4, 3), _WEST: (0, 3), _SOUTH: (0, 0)}[bearing_deg]
    corner = Pose2D(_X[column], _Y[row], math.radians(bearing_deg))
    after = Pose2D(corner.x, corner.y, math.radians(bearing_deg + 90))
    return corner.moved(-_CORNER_M), after.moved(_CORNER_M)


def _rows() -> list[PlannedStreet]:
    return [
        PlannedStreet(name, _end(column, row, _EAST), _end(column + 1, row, _WEST), section)
        for row, name, section in ((1, "Market Avenue", AVENUE), (2, "Station Street", BIKE_STREET))
        for column in range(4)
    ]


def _columns() -> list[PlannedStreet]:
    kinds: dict[tuple[int, int], tuple[str, CrossSection]] = {
        (1, 0): ("Mill Street", PARKING_STREET),
        (1, 1): ("Mill Street", PARKING_STREET),
        (1, 2): ("Mill Street North", ONE_WAY),
        (2, 0): ("Bus Avenue", BUS_AVENUE),
        (2, 1): ("Bus Avenue", BUS_AVENUE),
        (2, 2): ("Bus Avenue", BUS_AVENUE),
        (3, 0): ("School Street", SLOW_STREET),
        (3, 1): ("Park Street", BIKE_STREET),
        (3, 2): ("Park Street", BIKE_STREET),
    }
    streets = []
    for (column, row), (name, section) in kinds.items():
        south, north = _end(column, row, _NORTH), _end(column, row + 1, _SOUTH)
        is_school = section is SLOW_STREET
        streets.append(
            PlannedStreet(
                name,
                south,
                north,
                section,
                crossings=(StreetCrossing(110.0),) if is_school else (),
                blocks=(RoadsidePlot("School", 110.0, 30.0),) if is_school else (),
            )
        )
    return streets


def _ring_nodes() -> list[JunctionNode]:
    middle = Pose2D(_X[_ROUNDABOUT[0]], _Y[_ROUNDABOUT[1]], 0.0)
    nodes = []
    for bearing_deg in (_EAST, _NORTH, _WEST, _SOUTH):
        at = Pose2D(middle.x, middle.y, math.radians(bearing_deg)).moved(_RING_M)
        nodes.append(JunctionNode(f"{_name(*_ROUNDABOUT)} {bearing_deg:.0f}", at.x, at.y, crosswalks=False))
    return nodes


def _roundabout() -> list[PlannedStreet]:
    """Return one street for each quarter of the ring, counterclockwise, between the nodes of the arms."""
    streets = []
    for bearing_deg in (_EAST, _NORTH, _WEST, _SOUTH):
        following = (bearing_deg + 90) % 360
        start, end = _on_ring(bearing_deg, _RING_HALF_DEG), _on_ring(following, -_RING_HALF_DEG)
        streets.append(PlannedStreet("Mill Circle", start, end, RING))
    return streets


def _on_ring(bearing_deg: float, beyond_deg: float) -> End:
    """Return the end of a quarter, `beyond_deg` further around (counterclockwise) than the node of an arm."""
    half = math.radians(beyond_deg / 2)
    chord_m = 2 * _RING_M * math.sin(abs(half))
    outward_deg = bearing_deg + beyond_deg + math.copysign(90, beyond_deg)
    node = f"{_name(*_ROUNDABOUT)} {bearing_deg:.0f}"
    return End(node, outward_deg, left_m=-chord_m * math.sin(half), reach_m=chord_m * math.cos(half))
