"""A motorway: an oval of two carriageways with three lanes each, 2.1 km by 0.5 km.

A collector road runs along each straight. It leaves at an exit and returns at an entry, twice: a fast one, then a slow
one. On the outer carriageway an auxiliary lane joins the first entry to the second exit. All other entries lead
straight into the rightmost lane, and all other exits out of it. The lengths are ours.
"""

from __future__ import annotations

import math
from itertools import pairwise

from carlette.maps.build.plan import End, JunctionNode, Plan, PlannedStreet
from carlette.maps.build.sections import LANE_M, MOTORWAY, MOTORWAY_WITH_AUXILIARY, RAMP, SLOW_RAMP, CrossSection
from carlette.maps.reference_lines import Pose2D

_STRAIGHT_M = 1700.0
"""Length of a straight (m)."""
_RADIUS_M = 220.0
"""Radius of the bends (m)."""
_HALF_MEDIAN_M = 6.0
"""Half width of the median (m)."""
_EXITS_AND_ENTRIES_M = (150.0, 680.0, 1010.0, 1500.0)
"""Positions along a straight at which its exits and entries begin (m): exit, entry, exit, entry."""
_JOINT_M = 60.0
"""Length over which a ramp and the motorway diverge or merge (m)."""
_RAMP_LEFT_M = 3 * LANE_M + 3.0
"""Distance from the motorway's reference line to a ramp's (m)."""
_COLLECTOR_M = 34.0
"""Distance from the motorway's reference line to a collector's (m)."""
_CARRIAGEWAYS = ("outer", "inner")
_SIDES = ("south", "north")


def plan() -> Plan:
    """Return the motorway."""
    nodes: list[JunctionNode] = []
    streets: list[PlannedStreet] = []
    for carriageway in _CARRIAGEWAYS:
        names = [f"{carriageway} {side} {index}" for side in _order(carriageway) for index in range(4)]
        poses = {name: _place(name) for name in names}
        nodes.extend(JunctionNode(name, at.x, at.y, crosswalks=False) for name, at in poses.items())
        streets.extend(_motorway(carriageway, item, other, poses) for item, other in pairwise([*names, names[0]]))
        streets.extend(
            _collector(f"{carriageway} {side}", first, section, poses)
            for side in _order(carriageway)
            for first, section in ((0, RAMP), (2, SLOW_RAMP))
        )
    return Plan("motorway", nodes, streets)


def _order(carriageway: str) -> tuple[str, ...]:
    """Return both sides in the order of traffic: counterclockwise on the outer carriageway."""
    return _SIDES if carriageway == "outer" else _SIDES[::-1]


def _start_of(carriageway: str, side: str) -> Pose2D:
    """Return the start of a straight, directed along it."""
    outward = 1 if carriageway == "outer" else -1
    south = side == "south"
    y = -outward * _HALF_MEDIAN_M if south else 2 * _RADIUS_M + outward * _HALF_MEDIAN_M
    eastward = south == (carriageway == "outer")
    return Pose2D(0.0 if eastward else _STRAIGHT_M, y, 0.0 if eastward else math.pi)


def _place(name: str) -> Pose2D:
    carriageway, side, index = name.split()
    return _start_of(carriageway, side).moved(_EXITS_AND_ENTRIES_M[int(index)])


def _motorway(carriageway: str, first: str, second: str, poses: dict[str, Pose2D]) -> PlannedStreet:
    start, end = poses[first], poses[second]
    auxiliary = carriageway == "outer" and first.endswith("1")
    turns = first.endswith("3")
    return PlannedStreet(
        f"Motorway {carriageway}",
        End(first, math.degrees(start.yaw_rad), reach_m=_JOINT_M),
        End(second, math.degrees(end.yaw_rad) + 180, reach_m=0.0),
        MOTORWAY_WITH_AUXILIARY if auxiliary else MOTORWAY,
        _half_circle(carriageway, start) if turns else (),
    )


def _half_circle(carriageway: str, at: Pose2D) -> tuple[Pose2D, ...]:
    """Return the bend at the end of the straight of `at`."""
    to_left = 1 if carriageway == "outer" else -1
    radius_m = _RADIUS_M + to_left * _HALF_MEDIAN_M
    eastward = math.cos(at.yaw_rad) > 0
    begin = Pose2D(_STRAIGHT_M if eastward else 0.0, at.y, at.yaw_rad)
    apex = begin.moved(radius_m, to_left * radius_m)
    finish = begin.moved(0.0, 2 * to_left * radius_m)
    return (
        begin,
        Pose2D(apex.x, apex.y, at.yaw_rad + to_left * math.pi / 2),
        Pose2D(finish.x, finish.y, at.yaw_rad + math.pi),
    )


def _collector(straight: str, first: int, section: CrossSection, poses: dict[str, Pose2D]) -> PlannedStreet:
    """Return the road from an exit to the entry after it."""
    leave, join = f"{straight} {first}", f"{straight} {first + 1}"
    start, end = poses[leave], poses[join]
    heading_deg = math.degrees(start.yaw_rad)
    away, back = start.moved(_JOINT_M * 2.5, -_COLLECTOR_M), end.moved(-_JOINT_M * 1.5, -_COLLECTOR_M)
    return PlannedStreet(
        f"Collector {straight}",
        End(leave, heading_deg, left_m=-_RAMP_LEFT_M, reach_m=_JOINT_M, ramp=True),
        End(join, heading_deg + 180, "yield", left_m=_RAMP_LEFT_M, reach_m=0.0, ramp=True),
        section,
        (away, back),
    )
