"""Sites for the stuck situations that Bench2Drive lacks, and for controls where waiting is right."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import groupby
from typing import TYPE_CHECKING

from stucksolver_eval.sites.along import Along
from stucksolver_eval.sites.fits import Fits
from stucksolver_eval.sites.movements import Movement, roundabouts, straight
from stucksolver_eval.sites.placed import Finder
from stucksolver_eval.sites.site import Site
from stucksolver_eval.sites.through import ALL_WAYS, LIT, UNLIT, Through, site_at
from stucksolver_eval.sites.walk import Path, Town, approach, follow, turn_deg

if TYPE_CHECKING:
    import carla

_RUN_UP_M = 75
_TRIGGER_M = 38
_NEAR_M = 3
_SEEN_AFTER_M = 180
"""So long is a lane on which one has to pass through the oncoming one: from 30 m after the trigger some 150 m of that
must be seen, where it may be driven at 50 km/h."""
_RAILS = "201"
_FROM_RAILS_M = 30.0
_RAILS_AFTER_SIGN_M = 6
_BEFORE_RAILS_M = 60
_BEYOND_RAILS_M = 110
_CLOSED_TRIGGER_M = 70
_CLOSED_BEFORE_M = 10
_BEYOND_CLOSED_M = 60
_LONGEST_BLOCK_M = 420
_SAME_HEADING_DEG = 10.0
_RING_MARK_M = 20
_LAPS = 10


def to_pass(fits: Fits) -> Finder:
    """Where one may pass through the oncoming lane, and sees enough of it: nowhere at a level crossing."""

    def finds(town: Town, stretch: Path) -> bool:
        rails = [sign.transform.location for sign in town.map.get_all_landmarks_of_type(_RAILS)]
        ways = [w.transform.location for w in stretch[::10]]
        return fits(town, stretch) and all(a.distance(b) > _FROM_RAILS_M for a in rails for b in ways)

    return Along(finds, _SEEN_AFTER_M)


def crosswalks(town: Town, ways: list[Movement]) -> Iterator[Site]:
    """Beside a sidewalk, on the way into a junction without lights."""
    yield from Through(ALL_WAYS, UNLIT, rightmost=True)(town, ways)


def all_way_stops(town: Town, ways: list[Movement]) -> Iterator[Site]:
    """Crossings of four where everybody has to stop; who turns right would meet nobody from the right."""
    others = {one.junction_id for one in ways if one.control != "stop" or one.arms != 4}
    yield from (site_at(one) for one in ways if one.junction_id not in others and one.turn != "right")


def dark_lights(town: Town, ways: list[Movement]) -> Iterator[Site]:
    """Into junctions with lights, where somebody from the right meets the ego."""
    yield from Through(frozenset({"left", "straight"}), LIT, from_sides=frozenset({"right"}))(town, ways)


def round_and_round(town: Town, ways: list[Movement]) -> Iterator[Site]:
    """In at one arm of a roundabout, round and round, and out at another."""
    chains = list(roundabouts(town))
    ring = {one.inside.road_id for chain in chains for one in chain[1:-1]}
    for chain in chains:
        enter, leave = chain[0], chain[-1]
        before = approach(enter.entry, _RUN_UP_M)
        into = _until(follow(enter.inside, 80, through={enter.inside.road_id}), enter.exit.road_id)
        lap = _lap(follow(enter.exit, 200, through=ring))
        last = follow(enter.exit, 200, through={one.inside.road_id for one in chain})
        inside = (*into, *lap * _LAPS, *_until(last, leave.exit.road_id))
        after = follow(leave.exit, _BEYOND_CLOSED_M)
        on_ring = (one for one in inside[_RING_MARK_M:-_NEAR_M] if not one.is_junction)
        marks = (before[0], before[-_NEAR_M], *_apart(on_ring), after[_NEAR_M], after[-1])
        group, place = f"roundabout arm {enter.entry.road_id}", f"{enter.key}>{leave.exit.road_id}"
        yield Site(town, group, place, (*before, *inside, *after), marks, before[-_TRIGGER_M])


def _lap(path: Path) -> Path:
    """The path until it comes back to where it began."""
    start = path[0].transform.location
    far = next(index for index, one in enumerate(path) if one.transform.location.distance(start) > _RING_MARK_M)
    return path[: next(k for k in range(far, len(path)) if path[k].transform.location.distance(start) < 1.0)]


def _apart(path: Iterable[carla.Waypoint]) -> Iterator[carla.Waypoint]:
    """Of each piece of road one waypoint in its middle, in driving order."""
    for _, piece in groupby(path, lambda one: one.road_id):
        some = list(piece)
        yield some[len(some) // 2]


def level_crossings(town: Town, ways: list[Movement]) -> Iterator[Site]:
    """Both ways over each level crossing; `distance` leads from the trigger to the rails."""
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


def closed_streets(town: Town, ways: list[Movement]) -> Iterator[Site]:
    """Right into a street that is closed at its mouth, and on over its far end; who stands before it could still go
    straight on, and round the block. `distance` leads from the trigger to where it is closed."""
    for mine in ways:
        if mine.turn != "right" or mine.arms != 4 or not _goes_straight_too(mine, ways):
            continue
        # From further back than usual: it comes to a red light and drives on with the green, not in the last yellow.
        site = site_at(mine, _CLOSED_TRIGGER_M)
        beyond = follow(mine.exit, _LONGEST_BLOCK_M)
        crossed = [index for index, one in enumerate(beyond) if one.is_junction]
        is_straight = abs(turn_deg(mine.exit, beyond[-1])) < _SAME_HEADING_DEG
        if not crossed or not is_straight or crossed[-1] + _BEYOND_CLOSED_M >= len(beyond):
            continue
        start = site.path[: site.path.index(mine.exit)]
        after = beyond[: crossed[-1] + _BEYOND_CLOSED_M]
        marks = (*site.marks[:3], after[crossed[0] - _NEAR_M], after[crossed[-1] + _NEAR_M], after[-1])
        gap_m = len(start) - start.index(site.trigger) - _CLOSED_BEFORE_M
        yield replace(site, path=(*start, *after), marks=marks, fixed={"distance": {"value": str(gap_m)}})


def _goes_straight_too(mine: Movement, ways: list[Movement]) -> bool:
    """May one go straight on from the same lane?"""
    lane = (mine.entry.road_id, mine.entry.lane_id)
    return any((one.entry.road_id, one.entry.lane_id) == lane for one in straight(ways))


def _until(path: Path, road_id: int) -> Path:
    """The path up to a road."""
    return path[: next(index for index, one in enumerate(path) if one.road_id == road_id)]
