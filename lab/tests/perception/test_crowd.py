"""The crowd along a random route."""

from __future__ import annotations

from itertools import combinations
from math import dist, hypot
from random import Random
from types import SimpleNamespace

import carla

from lab.perception.recording.pedestrian_groups import APART_M, REACH_M, SIZES, places_of_a_group
from lab.perception.recording.scattered_kinds import SHARES, deal
from lab.perception.recording.town_routes import FARTHEST_M, NEAREST_M, _route
from stucksolver.scene import ObjectKind


def test_crowd_kinds_are_dealt_by_share_within_one() -> None:
    """Each kind is dealt as often as its share says, with a difference of less than one."""
    dealt = deal(SHARES, 100, Random(1))
    total = sum(share for _, share in SHARES)
    for kind, share in SHARES:
        assert abs(dealt.count(kind) - 100 * share / total) < 1.0


def test_the_largest_are_dealt_first() -> None:
    dealt = deal(((ObjectKind.CONE, 1.0), (ObjectKind.SCHOOL_BUS, 1.0), (ObjectKind.CAR, 1.0)), 6, Random(1))
    assert dealt == [ObjectKind.SCHOOL_BUS] * 2 + [ObjectKind.CAR] * 2 + [ObjectKind.CONE] * 2


def test_random_route_length_is_bounded_and_seed_reproducible() -> None:
    """A random route is neither short nor long, and the same seed gives the same route."""
    spots = [SimpleNamespace(location=carla.Location(90.0 * k, 0.0, 0.0)) for k in range(20)]
    for seed in range(20):
        route = _route("Town01", spots, seed, Random(seed))
        start, end = route.waypoints
        assert NEAREST_M < abs(start.x_m - end.x_m) < FARTHEST_M
        assert route == _route("Town01", spots, seed, Random(seed))


def test_crowd_group_members_are_close_without_overlap() -> None:
    """Pedestrians of a group are close together, but keep a minimum distance to each other."""
    sizes = set()
    for seed in range(200):
        places = places_of_a_group(Random(seed))
        sizes.add(len(places))
        assert min(dist(a, b) for a, b in combinations(places, 2)) >= APART_M[0] - 1e-9
        for place in places:
            assert min(dist(place, other) for other in places if other is not place) <= 2 * APART_M[1]
        assert max(hypot(*place) for place in places) <= REACH_M + APART_M[1]
    assert sizes == set(range(SIZES[0], SIZES[1] + 1))
