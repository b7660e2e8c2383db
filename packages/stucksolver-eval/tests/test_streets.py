"""Sites are where they claim to be, on the demo town and on every CARLA town at hand."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest

from carlette.maps import DEMO_TOWN

carla = pytest.importorskip("carla")

from stucksolver_eval.streets.finder import MIN_LENGTH_M, StreetError, choose_street, find_streets  # noqa: E402

FOLDERS = [Path(folder) for folder in os.environ.get("STUCKSOLVER_MAPS", "").split(os.pathsep) if folder]
KINDS = {
    "demo_town": {"one_lane", "multi_lane"},
    "Town01": {"one_lane"},
    "Town02": {"one_lane"},
    "Town04": {"one_lane", "multi_lane"},
    "Town10HD": {"multi_lane"},
}
CASES = [(town, kind) for town, kinds in KINDS.items() for kind in sorted(kinds)]


def load(town):
    places = [DEMO_TOWN] if town == "demo_town" else [folder / f"{town}.xodr" for folder in FOLDERS]
    for path in places:
        if path.is_file():
            return carla.Map(town, path.read_text(encoding="utf-8"))
    pytest.skip(f"{town}.xodr is in none of the folders of STUCKSOLVER_MAPS")


@pytest.mark.integration
@pytest.mark.parametrize(("town", "kind"), CASES)
def test_every_street_keeps_its_promises(town, kind):
    town_map = load(town)
    streets = find_streets(town_map, kind, seed=1)
    for street in streets:
        assert street.kind == kind
        assert street.length_m >= MIN_LENGTH_M
        assert_follow_each_other(street)
        around = street.waypoints[street.obstacle_index - 20 : street.obstacle_index + 61]
        assert len(around) == 81
        for waypoint in around:
            assert not waypoint.is_junction
            left = waypoint.get_left_lane()
            assert left.lane_type == carla.LaneType.Driving
            assert (left.lane_id * waypoint.lane_id < 0) == (kind == "one_lane")
            if kind == "multi_lane":
                assert "Solid" not in str(waypoint.left_lane_marking.type)


def assert_follow_each_other(street):
    for before, after in zip(street.waypoints, street.waypoints[1:], strict=False):
        assert before.transform.location.distance(after.transform.location) < 1.6


@pytest.mark.parametrize(("town", "kind"), [case for case in CASES if case[0] not in ("Town04", "Town10HD")])
def test_the_best_streets_are_full_length_and_free_of_junctions(town, kind):
    for street in find_streets(load(town), kind, seed=3)[:2]:
        assert street.length_m == 170
        assert street.junction_free
        assert not any(waypoint.is_junction for waypoint in street.waypoints)
        assert street.center_line == "broken"


@pytest.mark.parametrize("kind", ["one_lane", "multi_lane"])
def test_the_demo_town_has_straight_streets(kind):
    best = find_streets(load("demo_town"), kind, seed=0)[0]
    assert best.bend_deg < 15
    assert best.obstacle_index >= 40


def test_oncoming_traffic_has_room_to_come_from_on_the_street():
    best = find_streets(load("demo_town"), "one_lane", seed=0)[0]
    assert 150 <= best.oncoming_m <= 400


def test_short_streets_come_last():
    lengths = [street.length_m for street in find_streets(load("Town01"), "one_lane", seed=0)]
    assert lengths == sorted(lengths, reverse=True)
    assert lengths[-1] < 170


@pytest.mark.integration
def test_a_seed_gives_one_order_and_seeds_differ():
    def order(seed):
        return [(s.start.road_id, s.start.lane_id, s.start.s) for s in find_streets(load("demo_town"), "any", seed)]

    assert order(5) == order(5)
    assert any(order(5) != order(seed) for seed in range(6, 10))


def test_streets_of_one_direction_are_apart():
    streets = find_streets(load("demo_town"), "one_lane", seed=0)
    for number, street in enumerate(streets):
        for other in streets[:number]:
            apart_m = street.obstacle.transform.location.distance(other.obstacle.transform.location)
            assert apart_m >= 40 or street.obstacle.lane_id != other.obstacle.lane_id


def test_streets_unsuitable_map_is_named_with_remedy():
    """A map without a suitable street is named, with the number of searched lanes and a remedy."""
    with pytest.raises(StreetError, match=r"map Town01\. Searched 36 lanes .* use another map"):
        find_streets(load("Town01"), "multi_lane", seed=0)


def test_a_map_without_driving_lanes_is_named():
    text = DEMO_TOWN.read_text(encoding="utf-8").replace('type="driving"', 'type="sidewalk"')
    with pytest.raises(StreetError, match="no driving lane outside junctions: map empty"):
        find_streets(carla.Map("empty", text), "any", seed=0)


def test_street_far_from_the_origin_is_rejected_with_remedy() -> None:
    """At the coordinates of a UTM zone the client's positions come in steps of half a meter."""
    far = re.sub(
        r'(<geometry [^>]*y=")([^"]+)',
        lambda found: f"{found[1]}{float(found[2]) + 5.33e6}",
        DEMO_TOWN.read_text("utf-8"),
    )
    with pytest.raises(StreetError, match=r"map far: coordinates of 5\.33e\+06 m, .* steps of 0\.5 m"):
        choose_street(carla.Map("far", far), "any", seed=0, length_m=170)
