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


def test_every_kind_is_dealt_as_often_as_its_share_says_give_or_take_one() -> None:
    dealt = deal(SHARES, 100, Random(1))
    total = sum(share for _, share in SHARES)
    for kind, share in SHARES:
        assert abs(dealt.count(kind) - 100 * share / total) < 1.0


def test_the_largest_are_dealt_first() -> None:
    dealt = deal(((ObjectKind.CONE, 1.0), (ObjectKind.SCHOOL_BUS, 1.0), (ObjectKind.CAR, 1.0)), 6, Random(1))
    assert dealt == [ObjectKind.SCHOOL_BUS] * 2 + [ObjectKind.CAR] * 2 + [ObjectKind.CONE] * 2


def test_a_random_route_is_neither_short_nor_long_and_the_same_for_the_same_seed() -> None:
    spots = [SimpleNamespace(location=carla.Location(90.0 * k, 0.0, 0.0)) for k in range(20)]
    for seed in range(20):
        route = _route("Town01", spots, seed, Random(seed))
        start, end = route.waypoints
        assert NEAREST_M < abs(start.x_m - end.x_m) < FARTHEST_M
        assert route == _route("Town01", spots, seed, Random(seed))


def test_people_in_a_group_stand_close_together_but_not_in_one_another() -> None:
    sizes = set()
    for seed in range(200):
        places = places_of_a_group(Random(seed))
        sizes.add(len(places))
        assert min(dist(a, b) for a, b in combinations(places, 2)) >= APART_M[0] - 1e-9
        for place in places:
            assert min(dist(place, other) for other in places if other is not place) <= 2 * APART_M[1]
        assert max(hypot(*place) for place in places) <= REACH_M + APART_M[1]
    assert sizes == set(range(SIZES[0], SIZES[1] + 1))
