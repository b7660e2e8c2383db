"""Sites on motorways: entries, exits, and lane changes between them. The lengths are ours."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from typing import Any

import carla

from stucksolver_eval.sites.junction_sites import flow, site_at
from stucksolver_eval.sites.lane_walk import Path, Town, approach, same_way
from stucksolver_eval.sites.movements import JunctionMovement
from stucksolver_eval.sites.site import Site

_MERGE_TRIGGER_M = 45
"""Distance of the trigger before a merge (m)."""
_MERGE_END_M = 150
"""Distance of the route's end after a merge (m)."""
_MERGE_FLOW_M = (60, 120)
"""Length of the flow before and after a merge (m)."""
_EXIT_START_M = 170
"""Distance of the route's start before an exit (m)."""
_EXIT_TRIGGER_M = 140
"""Distance of the trigger before an exit (m)."""
_EXIT_CHANGE_M = 60
"""Distance of the lane change before an exit (m)."""
_EXIT_END_M = 65
"""Distance of the route's end after an exit (m)."""
_EXIT_FLOW_M = (165, 70)
"""Length of the flow before and after an exit (m)."""
_CUT_IN_TRIGGER_M = 110
"""Distance of the trigger before an entry with a cut-in (m)."""
_CUT_IN_FROM_M = 75
"""Distance of the vehicle on the ramp before the entry (m)."""
_CUT_IN_END_M = 90
"""Distance of the route's end after the entry (m)."""
_CHANGES_AFTER_M = (0, 45, 120, 230)
"""Start of the path in each lane, and its end (m)."""
_CHANGES_TRIGGER_M = 15
"""Distance of the trigger after the route's start (m)."""
_CHANGES_STEP_M = 40
"""Distance between two candidate sites (m)."""
_FEW_LANES, _MANY_LANES = 1, 3
"""Smallest number of lanes of a ramp, and of a motorway with lane changes."""


def merges(town: Town, ways: list[JunctionMovement]) -> Iterator[Site]:
    """Yield sites from a ramp straight into the rightmost lane of the motorway, with a flow in that lane."""
    for ramp in ways:
        for other in _beside_ramp(ramp, ways):
            if (ramp.exit.road_id, ramp.exit.lane_id) == (other.exit.road_id, other.exit.lane_id):
                site = site_at(ramp, _MERGE_TRIGGER_M, _MERGE_END_M)
                yield replace(site, positions=flow(other, *_MERGE_FLOW_M))


def exits(town: Town, ways: list[JunctionMovement]) -> Iterator[Site]:
    """Yield sites from the second lane across a flow in the rightmost one onto a ramp."""
    for ramp in ways:
        main = [w for w in ways if _same_lane(w.entry, ramp.entry) and w is not ramp]
        if _lanes(ramp.exit) != _FEW_LANES or _lanes(ramp.entry) < _MANY_LANES or not main:
            continue
        lane = approach(ramp.entry, _EXIT_START_M)
        second = [item for item in (same_way(item, carla.LaneChange.Left) for item in lane) if item is not None]
        if len({item.road_id for item in lane}) > 1 or len(second) < len(lane):
            continue
        changed = len(lane) - _EXIT_CHANGE_M
        last = site_at(ramp, _CHANGES_TRIGGER_M, _EXIT_END_M)
        path = (*second[:changed], *lane[changed:], *last.path[last.path.index(ramp.inside) :])
        trigger = second[-_EXIT_TRIGGER_M]
        marks = (second[0], second[changed - 1], lane[changed + _CHANGES_TRIGGER_M], *last.marks[1:])
        yield replace(last, path=path, marks=marks, trigger=trigger, positions=flow(main[0], *_EXIT_FLOW_M))


def cut_ins(town: Town, ways: list[JunctionMovement]) -> Iterator[Site]:
    """Yield sites along the rightmost lane past an entry, with a position on its ramp."""
    for ramp in ways:
        for other in _beside_ramp(ramp, ways):
            if (ramp.exit.road_id, ramp.exit.lane_id) == (other.exit.road_id, other.exit.lane_id):
                start = approach(ramp.entry, _CUT_IN_FROM_M)[0]
                site = site_at(other, _CUT_IN_TRIGGER_M, _CUT_IN_END_M)
                yield replace(site, positions={"other_actor_location": start})


def lane_changes(town: Town, ways: list[JunctionMovement]) -> Iterator[Site]:
    """Yield sites with lane changes across a motorway, from both sides where there is space."""
    for lane in town.lanes:
        last = len(lane) - _CHANGES_AFTER_M[-1] - _CHANGES_STEP_M
        for start in range(_CHANGES_STEP_M, last, _CHANGES_STEP_M):
            for side in (carla.LaneChange.Left, carla.LaneChange.Right):
                yield from _staircase(town, lane[start : start + _CHANGES_AFTER_M[-1] + 1], side, start)


def _staircase(town: Town, lane: Path, side: Any, start: int) -> Iterator[Site]:
    """Yield sites with two lane changes to one side, from the outermost lane of the other side."""
    other = carla.LaneChange.Right if side == carla.LaneChange.Left else carla.LaneChange.Left
    if _lanes(lane[0]) < _MANY_LANES or same_way(lane[0], other):
        return
    pieces: list[Path] = []
    for first, end in pairwise(_CHANGES_AFTER_M):
        shifted = lane[first:end]
        for _ in pieces:
            adjacent = tuple(item for item in (same_way(item, side) for item in shifted) if item is not None)
            if len(adjacent) < len(shifted):
                return
            shifted = adjacent
        pieces.append(shifted)
    path = tuple(item for piece in pieces for item in piece)
    marks = (path[0], *(piece[-1] for piece in pieces))
    name = f"{lane[0].road_id}/{lane[0].lane_id}"
    yield Site(town, name, f"{name}@{start}", path, marks, path[_CHANGES_TRIGGER_M])


def _beside_ramp(ramp: JunctionMovement, ways: list[JunctionMovement]) -> list[JunctionMovement]:
    """Return the movements in the motorway's rightmost lane where `ramp` joins it."""
    if _lanes(ramp.entry) != _FEW_LANES or _lanes(ramp.exit) < _MANY_LANES:
        return []
    main = [way for way in ways if way.junction_id == ramp.junction_id and _lanes(way.entry) >= _MANY_LANES]
    return [item for item in main if not same_way(item.entry, carla.LaneChange.Right)]


def _lanes(waypoint: carla.Waypoint) -> int:
    """Return the number of lanes in this direction."""
    count = 1
    for side in (carla.LaneChange.Left, carla.LaneChange.Right):
        lane = same_way(waypoint, side)
        while lane is not None:
            count, lane = count + 1, same_way(lane, side)
    return count


def _same_lane(first: Any, second: Any) -> bool:
    return bool((first.road_id, first.lane_id) == (second.road_id, second.lane_id))
