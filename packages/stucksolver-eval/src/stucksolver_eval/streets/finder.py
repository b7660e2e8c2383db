"""Finds sites on any OpenDRIVE map where an obstacle that the vehicle could pass can immobilize it.

All data comes from `carla.Map`, so no server is needed. Waypoints are in CARLA's left-handed world frame.
"""

from __future__ import annotations

import random
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import carla

from stucksolver_bridge.traffic_side import inner_lane
from stucksolver_eval.coarse_positions import coarse_positions
from stucksolver_eval.streets.stretches import (
    Line,
    StreetKind,
    Stretch,
    bend_deg,
    lane_runs,
    slope_deg,
    stretches,
    turn_deg,
    yaw_deg,
)

CLEAR_BEFORE_M = 20
"""Length before the obstacle without junctions or changes of lanes (m). Ours."""
CLEAR_PAST_M = 60
"""The same beyond the obstacle (m). Ours."""
MIN_LENGTH_M = 110
"""Shortest street (m). Ours."""
_STRAIGHT_DEG = 15.0
"""Largest change of heading of a straight street (degrees). Ours."""
_FLAT_DEG = 3.0
"""Largest slope of a flat street (degrees). Ours."""
_LONG_SIGHT_M = 150.0
"""Length of visible oncoming lane that counts as long (m). Ours."""
_SIGHT_TO_PASS_M = 250.0
"""Sight distance for a pass (m). Ours."""
_RUN_UP_M = 40
"""Distance from the start to the obstacle, at least (m). Ours."""
_APART_M = 40.0
"""Smallest distance between two streets of one direction (m). Ours."""
_STEP_M = 10
"""Distance between two candidate positions of the obstacle (m). Ours."""
_ONCOMING_LIMIT_M = 400
"""Length of oncoming lane that is searched (m). Ours."""
_FREE, _THROUGH_JUNCTION, _SHORT = range(3)
_CENTER_ORDER = ("broken", "none", "other", "solid")


class StreetError(ValueError):
    """The map has no suitable site. The message names the map, the search and the remedy."""


@dataclass(frozen=True)
class Street:
    """A stretch of one lane with space for an immobilizing situation."""

    kind: StreetKind
    """`one_lane`: one driving lane each way, the oncoming one adjacent.

    `multi_lane`: a lane of the same direction to the left, across a line that may be crossed.
    """
    waypoints: tuple[carla.Waypoint, ...]
    """Waypoints 1 m apart from start to destination along the lane."""
    obstacle_index: int
    """Index in `waypoints` of the position for the obstacle, and its distance from the start (m)."""
    center_line: Line
    """Line to the left neighbor near the obstacle: `broken`, `solid`, `none` or `other`."""
    bend_deg: float
    """Largest change of heading between any two points of the stretch."""
    oncoming_m: float
    """Length of the oncoming lane beyond the obstacle up to a junction (at most 400); 0 on `multi_lane`."""
    junction_free: bool
    """True if the whole stretch has no junction. Near the obstacle there is never one."""

    @property
    def start(self) -> carla.Waypoint:
        """Start of the ego."""
        return self.waypoints[0]

    @property
    def destination(self) -> carla.Waypoint:
        """End of its route."""
        return self.waypoints[-1]

    @property
    def obstacle(self) -> carla.Waypoint:
        """Position for the obstacle."""
        return self.waypoints[self.obstacle_index]

    @property
    def length_m(self) -> int:
        """Length from start to destination along the lane (m)."""
        return len(self.waypoints) - 1


def find_streets(
    carla_map: carla.Map,
    road: StreetKind | Literal["any"] = "any",
    seed: int = 0,
    length_m: int = 170,
    obstacle_m: int = 70,
) -> list[Street]:
    """Return streets of a kind, best first: no junctions, a broken center line, straight and flat, long sight distance.

    `length_m` is the desired length from start to destination, and `obstacle_m` from start to obstacle. Shorter
    streets, down to 110 m, come last. Equally good sites are ordered by `seed`; the same seed gives the same list.
    Streets of one direction are at least 40 m apart. Raises `StreetError` if there is none.
    """
    found = _candidates(carla_map, road, length_m, obstacle_m)
    random.Random(seed).shuffle(found)
    streets = [_street(candidate) for candidate in _apart(sorted(found, key=_badness))]
    if not streets:
        raise StreetError(_nothing_found(carla_map, road, length_m))
    return streets


def choose_street(carla_map: carla.Map, road: StreetKind | Literal["any"], seed: int, length_m: int) -> Street:
    """Return the best street: one with enough sight distance of the oncoming lane for a pass, else any.

    If any kind of road is allowed, streets with one lane each way come first. Raises `StreetError` if there is none,
    or if positions on the map are too coarse for a plan.
    """
    streets = find_streets(carla_map, road, seed, length_m)
    if road == "any":
        streets.sort(key=lambda street: street.kind != "one_lane")
    chosen = next((street for street in streets if _is_open(street)), streets[0])
    if coarse := coarse_positions(chosen.waypoints):
        raise StreetError(f"map {carla_map.name}: {coarse}")
    return chosen


def _is_open(street: Street) -> bool:
    far = street.oncoming_m >= _SIGHT_TO_PASS_M and street.bend_deg < _STRAIGHT_DEG
    return street.junction_free and (far or street.kind == "multi_lane")


class _Chain:
    """Waypoints of a lane. Many sites share them, and querying a heading takes longer than adding it up."""

    def __init__(self, waypoints: list[carla.Waypoint]) -> None:
        self.waypoints = waypoints

    def __len__(self) -> int:
        return len(self.waypoints)

    @cached_property
    def yaws_deg(self) -> list[float]:
        return [yaw_deg(waypoint) for waypoint in self.waypoints]

    @cached_property
    def slopes_deg(self) -> list[float]:
        return [slope_deg(waypoint) for waypoint in self.waypoints]

    def section(self, start: int, end: int) -> _Chain:
        """Return the waypoints from `start` up to `end`."""
        part = _Chain(self.waypoints[start:end])
        part.yaws_deg, part.slopes_deg = self.yaws_deg[start:end], self.slopes_deg[start:end]
        return part


@dataclass(frozen=True)
class _Candidate:
    stretch: Stretch
    route: _Chain
    obstacle_index: int
    ahead_m: int
    """Distance from the obstacle to the end of the junction-free stretch."""
    form: int

    @property
    def obstacle(self) -> carla.Waypoint:
        return self.route.waypoints[self.obstacle_index]


def _candidates(carla_map: carla.Map, road: str, length_m: int, obstacle_m: int) -> list[_Candidate]:
    found: list[_Candidate] = []
    for chain in map(_Chain, lane_runs(carla_map)):
        for stretch in stretches(chain.waypoints):
            if road in (stretch.kind, "any"):
                found.extend(_windows(chain, stretch, length_m, obstacle_m))
    return found


def _windows(chain: _Chain, stretch: Stretch, length_m: int, obstacle_m: int) -> Iterator[_Candidate]:
    """Yield positions for the obstacle in one stretch, each with as much of the lane around it as possible."""
    for place in range(stretch.first + CLEAR_BEFORE_M, stretch.last - CLEAR_PAST_M + 1, _STEP_M):
        start = max(0, place - obstacle_m)
        route, form = chain.section(start, start + length_m + 1), _FREE
        if len(chain) <= MIN_LENGTH_M:
            route, form = _Chain(_continued(route.waypoints, length_m)), _THROUGH_JUNCTION
        elif len(route) <= length_m:
            start = max(0, len(chain) - 1 - length_m)
            route, form = chain.section(start, len(chain)), _FREE if len(chain) > length_m else _SHORT
        if len(route) > MIN_LENGTH_M:
            yield _Candidate(stretch, route, place - start, len(chain) - 1 - place, form)


def _continued(route: list[carla.Waypoint], length_m: int) -> list[carla.Waypoint]:
    """Return the route extended through the following junctions, as straight as possible."""
    route = list(route)
    while len(route) <= length_m:
        following = route[-1].next(1.0)
        if not following:
            break
        route.append(min(following, key=lambda next_one: bend_deg((route[-1], next_one))))
    return route


def _badness(candidate: _Candidate) -> tuple[int, ...]:
    place, stretch = candidate.obstacle_index, candidate.stretch
    in_sight = candidate.route.section(max(0, place - _RUN_UP_M), place + CLEAR_PAST_M + 1)
    return (
        candidate.form,
        _CENTER_ORDER.index(stretch.center_line) if stretch.kind == "one_lane" else 0,
        int(turn_deg(candidate.route.yaws_deg) >= _STRAIGHT_DEG),
        int(turn_deg(in_sight.yaws_deg) >= _STRAIGHT_DEG),
        int(max(in_sight.slopes_deg) - min(in_sight.slopes_deg) >= _FLAT_DEG),
        int(place < _RUN_UP_M),
        int(not stretch.rightmost),
        int(candidate.ahead_m < _LONG_SIGHT_M),
    )


def _apart(ranked: Iterable[_Candidate]) -> list[_Candidate]:
    """Drop candidates if a better one blocks nearly the same position in the same direction."""
    distinct: list[tuple[_Candidate, carla.Transform]] = []
    for candidate in ranked:
        here = candidate.obstacle.transform
        if not any(_same_place(here, other) for _, other in distinct):
            distinct.append((candidate, here))
    return [candidate for candidate, _ in distinct]


def _same_place(first: carla.Transform, second: carla.Transform) -> bool:
    near = first.location.distance(second.location) < _APART_M
    return near and turn_deg((first.rotation.yaw, second.rotation.yaw)) < 90.0


def _street(candidate: _Candidate) -> Street:
    stretch = candidate.stretch
    return Street(
        kind=stretch.kind,
        waypoints=tuple(candidate.route.waypoints),
        obstacle_index=candidate.obstacle_index,
        center_line=stretch.center_line,
        bend_deg=turn_deg(candidate.route.yaws_deg),
        oncoming_m=_oncoming_m(candidate.obstacle) if stretch.kind == "one_lane" else 0.0,
        junction_free=candidate.form != _THROUGH_JUNCTION,
    )


def _oncoming_m(obstacle: carla.Waypoint) -> float:
    """Return the length of the oncoming neighbor ahead of the ego, against the neighbor's own direction (m)."""
    waypoint = inner_lane(obstacle)
    if waypoint is None:
        return 0.0
    for length_m in range(_ONCOMING_LIMIT_M):
        before = waypoint.previous(1.0)
        if len(before) != 1 or before[0].is_junction:
            return float(length_m)
        waypoint = before[0]
    return float(_ONCOMING_LIMIT_M)


def _nothing_found(carla_map: carla.Map, road: str, length_m: int) -> str:
    lanes = len(lane_runs(carla_map))
    if not lanes:
        return (
            f"no driving lane outside junctions: map {carla_map.name}. "
            "Check that the OpenDRIVE file has lanes of type 'driving'"
        )
    kinds = {
        "one_lane": "one driving lane each way with an adjacent oncoming lane",
        "multi_lane": "a lane of the same direction to the left behind a line that may be crossed",
        "any": "a left neighbor lane for passing an obstacle",
    }
    remedy = "use another map" + ("" if road == "any" else ", or ask for any kind of road")
    return (
        f"no suitable street: map {carla_map.name}. Searched {lanes} lanes between junctions for a stretch of "
        f"{MIN_LENGTH_M} to {length_m} m with {kinds[road]} from {CLEAR_BEFORE_M} m before an obstacle to "
        f"{CLEAR_PAST_M} m past it; {remedy}"
    )
