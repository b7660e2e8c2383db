"""Sites for the immobilizing situations that Bench2Drive lacks, and for controls where waiting is right.

The lengths are ours.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import groupby
from typing import TYPE_CHECKING

from stucksolver_eval.sites.junction_sites import ALL_WAYS, LIT, UNLIT, JunctionSites, site_at
from stucksolver_eval.sites.lane_requirements import Fits
from stucksolver_eval.sites.lane_sites import LaneSites
from stucksolver_eval.sites.lane_walk import Path, Town, approach, follow, turn_deg
from stucksolver_eval.sites.movements import JunctionMovement, roundabouts, straight
from stucksolver_eval.sites.site import Site
from stucksolver_eval.sites.suite_placement import Finder

if TYPE_CHECKING:
    import carla

_RUN_UP_M = 75
"""Distance of the route's start before the situation (m)."""
_TRIGGER_M = 38
"""Distance of the trigger before the situation (m)."""
_NEAR_M = 3
"""Distance of marks from a junction (m)."""
_SEEN_AFTER_M = 180
"""Length of lane after the trigger for a pass through the oncoming lane (m).

At a limit of 50 km/h, about 150 m of that must be visible from 30 m after the trigger.
"""
_RAILS = "201"
_FROM_RAILS_M = 30.0
"""Smallest distance of other sites from a level crossing (m)."""
_RAILS_AFTER_SIGN_M = 6
"""Distance of the rails after their sign (m)."""
_BEFORE_RAILS_M = 60
"""Distance of the route's start before the rails (m)."""
_BEYOND_RAILS_M = 110
"""Distance of the route's end beyond the rails (m)."""
_CLOSED_TRIGGER_M = 70
"""Distance of the trigger before a closed street (m)."""
_CLOSED_BEFORE_M = 10
"""Distance of a closure's mark before the junction (m)."""
_BEYOND_CLOSED_M = 60
"""Distance of the route's end beyond the closed street (m)."""
_LONGEST_BLOCK_M = 420
"""Longest block around which a detour leads (m)."""
_SAME_HEADING_DEG = 10.0
"""Tolerance for two equal headings (degrees)."""
_RING_MARK_M = 20
"""Distance between marks in a roundabout (m)."""
_LAPS = 10
"""Number of laps of a loop."""


def to_pass(fits: Fits) -> Finder:
    """Return a finder of sites for a pass through the oncoming lane with enough sight, away from level crossings."""

    def finds(town: Town, stretch: Path) -> bool:
        rails = [sign.transform.location for sign in town.map.get_all_landmarks_of_type(_RAILS)]
        ways = [w.transform.location for w in stretch[::10]]
        return fits(town, stretch) and all(a.distance(b) > _FROM_RAILS_M for a in rails for b in ways)

    return LaneSites(finds, _SEEN_AFTER_M)


def crosswalks(town: Town, ways: list[JunctionMovement]) -> Iterator[Site]:
    """Yield sites with a sidewalk, before a junction without lights."""
    yield from JunctionSites(ALL_WAYS, UNLIT, rightmost=True)(town, ways)


def all_way_stops(town: Town, ways: list[JunctionMovement]) -> Iterator[Site]:
    """Yield four-way all-way stops, without right turns, which have no conflict with traffic from the right."""
    others = {way.junction_id for way in ways if way.control != "stop" or way.arms != 4}
    yield from (site_at(way) for way in ways if way.junction_id not in others and way.turn != "right")


def dark_lights(town: Town, ways: list[JunctionMovement]) -> Iterator[Site]:
    """Yield junctions with lights where a vehicle from the right conflicts with the ego."""
    yield from JunctionSites(frozenset({"left", "straight"}), LIT, from_sides=frozenset({"right"}))(town, ways)


def round_and_round(town: Town, ways: list[JunctionMovement]) -> Iterator[Site]:
    """Yield routes into a roundabout at one arm, around several times, and out at another arm."""
    chains = list(roundabouts(town))
    ring = {item.inside.road_id for chain in chains for item in chain[1:-1]}
    for chain in chains:
        enter, leave = chain[0], chain[-1]
        before = approach(enter.entry, _RUN_UP_M)
        into = _until(follow(enter.inside, 80, through={enter.inside.road_id}), enter.exit.road_id)
        lap = _lap(follow(enter.exit, 200, through=ring))
        last = follow(enter.exit, 200, through={item.inside.road_id for item in chain})
        inside = (*into, *lap * _LAPS, *_until(last, leave.exit.road_id))
        after = follow(leave.exit, _BEYOND_CLOSED_M)
        on_ring = (item for item in inside[_RING_MARK_M:-_NEAR_M] if not item.is_junction)
        marks = (before[0], before[-_NEAR_M], *_apart(on_ring), after[_NEAR_M], after[-1])
        group, place = f"roundabout arm {enter.entry.road_id}", f"{enter.key}>{leave.exit.road_id}"
        yield Site(town, group, place, (*before, *inside, *after), marks, before[-_TRIGGER_M])


def _lap(path: Path) -> Path:
    """Return the path until it returns to its start."""
    start = path[0].transform.location
    far = next(index for index, item in enumerate(path) if item.transform.location.distance(start) > _RING_MARK_M)
    return path[: next(k for k in range(far, len(path)) if path[k].transform.location.distance(start) < 1.0)]


def _apart(path: Iterable[carla.Waypoint]) -> Iterator[carla.Waypoint]:
    """Yield one waypoint in the middle of each piece of road, in driving order."""
    for _, piece in groupby(path, lambda item: item.road_id):
        some = list(piece)
        yield some[len(some) // 2]


def level_crossings(town: Town, ways: list[JunctionMovement]) -> Iterator[Site]:
    """Yield both directions over each level crossing; `distance` is from the trigger to the rails."""
    for sign in town.map.get_all_landmarks_of_type(_RAILS):
        first, last = sign.get_lane_validities()[0]
        lane = town.map.get_waypoint_xodr(sign.road_id, first if abs(first) <= abs(last) else last, sign.s)
        assert lane is not None, "a sign stands at a lane"
        rails = lane.next(float(_RAILS_AFTER_SIGN_M))[0]
        before, after = approach(rails, _BEFORE_RAILS_M + 28), follow(rails, _BEYOND_RAILS_M)
        trigger = before[-_BEFORE_RAILS_M - 1]
        marks = (before[0], rails, after[-1])
        group = f"{lane.road_id}/{lane.lane_id}"
        distance = {"distance": {"value": str(_BEFORE_RAILS_M)}}
        yield Site(town, group, group, (*before, *after[1:]), marks, trigger, fixed=distance)


def closed_streets(town: Town, ways: list[JunctionMovement]) -> Iterator[Site]:
    """Yield right turns into a street that is closed at its entry.

    A vehicle before the closure can still go straight on and around the block. `distance` is from the trigger to the
    closure.
    """
    for mine in ways:
        if mine.turn != "right" or mine.arms != 4 or not _goes_straight_too(mine, ways):
            continue
        # The trigger is farther back than usual, so that the ego arrives at a red light and continues at green, not
        # at yellow.
        site = site_at(mine, _CLOSED_TRIGGER_M)
        beyond = follow(mine.exit, _LONGEST_BLOCK_M)
        crossed = [index for index, item in enumerate(beyond) if item.is_junction]
        is_straight = abs(turn_deg(mine.exit, beyond[-1])) < _SAME_HEADING_DEG
        if not crossed or not is_straight or crossed[-1] + _BEYOND_CLOSED_M >= len(beyond):
            continue
        start = site.path[: site.path.index(mine.exit)]
        after = beyond[: crossed[-1] + _BEYOND_CLOSED_M]
        marks = (*site.marks[:3], after[crossed[0] - _NEAR_M], after[crossed[-1] + _NEAR_M], after[-1])
        gap_m = len(start) - start.index(site.trigger) - _CLOSED_BEFORE_M
        yield replace(site, path=(*start, *after), marks=marks, fixed={"distance": {"value": str(gap_m)}})


def _goes_straight_too(mine: JunctionMovement, ways: list[JunctionMovement]) -> bool:
    """Return True if the same lane also leads straight on."""
    lane = (mine.entry.road_id, mine.entry.lane_id)
    return any((item.entry.road_id, item.entry.lane_id) == lane for item in straight(ways))


def _until(path: Path, road_id: int) -> Path:
    """Return the path up to a road."""
    return path[: next(index for index, item in enumerate(path) if item.road_id == road_id)]
