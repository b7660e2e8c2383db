"""Maps with left-hand traffic: streets, junction movements and scenario positions are those of the mirrored map."""

from __future__ import annotations

from collections import Counter
from functools import lru_cache

import pytest

from carlette.maps import DEMO_TOWN

carla = pytest.importorskip("carla")

from left_hand_maps import left_hand  # noqa: E402
from stucksolver_eval.actors.lane_path import LanePath  # noqa: E402
from stucksolver_eval.background_traffic.lanes import adjacent_lane, oncoming_lanes, slots  # noqa: E402
from stucksolver_eval.scenarios.families.junction import _comes_from  # noqa: E402
from stucksolver_eval.scenarios.families.lane_places import (  # noqa: E402
    edge_m,
    lane_of,
    offset_pose,
    side_driving_lane,
)
from stucksolver_eval.scenarios.types.stuck.closed_road import row_across  # noqa: E402
from stucksolver_eval.sites import lane_requirements  # noqa: E402
from stucksolver_eval.sites.lane_walk import Town, follow  # noqa: E402
from stucksolver_eval.sites.movements import arm, movements  # noqa: E402
from stucksolver_eval.streets.finder import find_streets  # noqa: E402


@lru_cache(maxsize=1)
def maps():
    text = DEMO_TOWN.read_text(encoding="utf-8")
    return carla.Map("demo_town", text), carla.Map("demo_left", left_hand(text))


@lru_cache(maxsize=1)
def waypoints():
    """Pairs of the same position on both maps."""
    right, left = maps()
    found = right.generate_waypoints(25.0)
    return [(w, left.get_waypoint_xodr(w.road_id, -w.lane_id, w.s)) for w in found if not w.is_junction]


def lane_key(waypoint):
    """Road, and lane as numbered on the map with right-hand traffic."""
    return None if waypoint is None else (waypoint.road_id, waypoint.lane_id * (1 if waypoint.is_rht else -1))


def same(first, second) -> bool:
    return lane_key(first) == lane_key(second)


def test_left_hand_lanes_are_mirrored():
    """Adjacent, oncoming and edge lanes are the same lanes on both maps."""
    for w, image in waypoints():
        assert slots(w) == slots(image)
        assert [lane_key(x) for x in oncoming_lanes(w)] == [lane_key(x) for x in oncoming_lanes(image)]
        assert same(adjacent_lane(w, 1), adjacent_lane(image, 1))
        for side in ("left", "right"):
            assert same(side_driving_lane(w, side), side_driving_lane(image, side))
            assert edge_m(w, side) == pytest.approx(edge_m(image, side), abs=0.01)
            assert same(lane_of(w, carla.LaneType.Sidewalk, side), lane_of(image, carla.LaneType.Sidewalk, side))


def test_left_hand_positions_are_mirrored():
    """What stands at the edge, turned toward the road, does so on the other side."""
    for w, image in waypoints()[:20]:
        place, other = (offset_pose(x, 2.0, ahead_m=1.0, turn_deg=-90.0) for x in (w, image))
        assert (other.location.x, -other.location.y) == pytest.approx((place.location.x, place.location.y), abs=0.01)
        turn = other.rotation.yaw + place.rotation.yaw
        assert turn % 360.0 == pytest.approx(0.0, abs=0.1) or turn % 360.0 == pytest.approx(360.0, abs=0.1)
        path, mirrored = (LanePath([x], offset_m=0.6, merge=(-3.5, 20.0)) for x in (w, image))
        path.grow(30.0)
        mirrored.grow(30.0)
        assert mirrored.x == pytest.approx(path.x, abs=0.02)
        assert [-y for y in mirrored.y] == pytest.approx(path.y, abs=0.02)


def test_left_hand_barriers_are_mirrored_in_a_bend():
    """A row of barriers across the road into which a lane turns lies on the mirror image of that road."""
    right, left = maps()
    turns = [w for w in right.generate_waypoints(4.0) if w.is_junction]
    for w in turns[::9]:
        row = row_across(right, w)
        image = row_across(left, left.get_waypoint_xodr(w.road_id, -w.lane_id, w.s))
        assert len(row) == len(image) > 0
        for place, other in zip(row, image, strict=True):
            assert (other.location.x, -other.location.y) == pytest.approx(
                (place.location.x, place.location.y), abs=0.02
            )


def test_left_hand_streets_are_found():
    """The same streets serve for passing obstacles, with the oncoming lane on the right."""
    right, left = (find_streets(carla_map, "one_lane", seed=1) for carla_map in maps())
    assert right and len(right) == len(left)
    assert Counter(lane_key(s.obstacle) for s in right) == Counter(lane_key(s.obstacle) for s in left)
    assert all(street.oncoming_m > 0.0 and street.center_line == "broken" for street in left)
    assert all(street.obstacle.get_right_lane().lane_id * street.obstacle.lane_id < 0 for street in left)


def test_left_hand_movements_are_mirrored():
    """A turn across the oncoming lanes is called a left turn on both maps, and so are the arms of a junction."""
    right, left = (movements(Town("town", carla_map)) for carla_map in maps())

    def described(ways):
        counts = Counter()
        for way in ways:
            arms = [len(arm(way, side, ways)) for side in ("left", "opposite", "right")]
            counts[(way.entry.road_id, way.exit.road_id, way.turn, *arms)] += 1
        return counts

    assert right and described(right) == described(left)
    sides = [
        Counter(_comes_from(a.entry, b.entry) for a in ways for b in ways if a.junction_id == b.junction_id)
        for ways in (right, left)
    ]
    assert sides[0] == sides[1]


def test_left_hand_requirements_are_mirrored():
    """A stretch meets a scenario's requirements if its mirror image does."""
    towns = [Town("town", carla_map) for carla_map in maps()]
    checks = (
        lane_requirements.left_lane,
        lane_requirements.right_lane,
        lane_requirements.two_ways,
        lane_requirements.sidewalk,
        lane_requirements.one_lane,
    )
    for w, image in waypoints()[::4]:
        stretches = [follow(x, 60) for x in (w, image)]
        for check in checks:
            assert check(towns[0], stretches[0]) == check(towns[1], stretches[1]), check.__name__
