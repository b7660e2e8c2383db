"""What stands in the hero's lane, and what happens in the lane by which it may get past."""

from __future__ import annotations

import itertools

import pytest

carla = pytest.importorskip("carla")

pytestmark = pytest.mark.integration

ONE_WAY = ("Accident", "ParkedObstacle", "ConstructionObstacle")
TWO_WAYS = ("AccidentTwoWays", "ParkedObstacleTwoWays", "ConstructionObstacleTwoWays")
FIRST_M = {"Accident": 0.0, "ParkedObstacle": 0.0, "ConstructionObstacle": -9.0}


def value(number):
    return {"value": str(number)}


def in_lane(playing, distance_m):
    """Members of the scenario that reach into the hero's lane near a distance beyond the trigger."""
    found = []
    for other in playing.others(""):
        s_m, right_m = playing.along(other)
        near = abs(s_m - playing.scenario.trigger_s_m - distance_m) < 20.0
        half_m = playing.route.waypoint_at(s_m).lane_width / 2.0
        if near and abs(right_m) - other.half_width_m < half_m and other.half_height_m > 0.2:
            found.append(other)
    return found


@pytest.mark.parametrize("kind", [*ONE_WAY, *TWO_WAYS])
def test_obstacle_is_in_ego_lane_without_traffic_before_it(play, kind):
    """The obstacle is in the ego's lane, and no car of the traffic is between it and the ego."""
    playing = play(f"{kind}_1", distance=value(42))
    playing.jump(5.0)
    playing.run(1.0)
    blocking = in_lane(playing, 42.0)
    first_m = min(playing.along(item)[0] - playing.scenario.trigger_s_m for item in blocking)
    assert blocking and first_m == pytest.approx(42.0 + FIRST_M[kind.removesuffix("TwoWays")], abs=3.0)
    # Traffic ahead of the hero was moved beyond.
    end_m = max(playing.along(item)[0] for item in blocking)
    hero_lane = [car for car in playing.background.road.ahead if abs(playing.along(car.member)[1]) < 1.5]
    assert all(playing.along(car.member)[0] > end_m for car in hero_lane)


@pytest.mark.parametrize("kind", ONE_WAY)
def test_obstacle_adjacent_traffic_slows_5_s_after_approach(play, kind):
    """The traffic in the adjacent lane is slowed 5 s after the ego came near, until the scenario ends."""
    playing = play(f"{kind}_1", distance=value(42), speed=value(36))
    playing.jump(5.0)
    playing.jump(28.0)
    road = playing.background.road
    playing.run(4.5)
    assert road.cap_mps is None
    playing.run(1.0)
    assert road.cap_mps == pytest.approx(10.0)
    playing.jump(5.0 + 42.0 + 16.0 + 51.0)
    assert playing.play.finished and road.cap_mps is None


@pytest.mark.parametrize("kind", TWO_WAYS)
def test_an_oncoming_flow_with_the_gaps_asked_for_begins(play, kind):
    playing = play(f"{kind}_1", distance=value(42), frequency={"from": "35", "to": "40"})
    playing.jump(5.0)
    playing.jump(28.0)
    standing = len(playing.others())
    playing.run(4.5)
    assert "wrong_lane" not in playing.play.suspended and len(playing.others()) == standing
    playing.run(9.0)
    assert playing.play.suspended == {"wrong_lane", "blocked"}
    flow = playing.others()[standing:]
    assert len(flow) >= 2 and all(playing.facing_deg(item) > 150.0 for item in flow)
    fronts = sorted(playing.along(item)[0] for item in flow)
    gaps = [after - before for before, after in itertools.pairwise(fronts)]
    assert all(34.0 < gap < 50.0 for gap in gaps)


def test_two_bicycles_ride_at_the_edge_and_then_stand(play):
    playing = play("HazardAtSideLane_1", traffic=False, bicycle_speed=value(18), bicycle_drive_distance=value(20))
    playing.jump(5.0)
    first = [playing.along(other) for other in playing.others()]
    assert first[1][0] - first[0][0] == pytest.approx(9.0, abs=0.5)
    assert all(0.5 < right_m < 1.6 for _, right_m in first)
    playing.run(3.0)
    assert all(playing.cast.state(other).speed_mps == pytest.approx(5.0, abs=0.5) for other in playing.others())
    playing.run(4.0)
    assert all(playing.cast.state(other).speed_mps < 0.1 for other in playing.others())
    assert playing.along(playing.others()[0])[0] - first[0][0] == pytest.approx(21.0, abs=3.0)


def test_side_hazard_two_ways_suspends_wrong_lane_criterion(play):
    """With bicycles on a two-way road, the wrong-lane criterion stays suspended after the scenario ends."""
    playing = play("HazardAtSideLaneTwoWays_1", frequency=value(77))
    playing.jump(5.0)
    playing.tick()
    assert playing.background.oncoming.spacing_m == 77.0
    playing.jump(playing.route.length_m - 2.0)
    assert playing.play.finished and playing.play.suspended == {"wrong_lane"}
    assert playing.background.oncoming.spacing_m == 40.0


def test_parked_car_door_opens_when_ego_is_near(play):
    """The door opens into the ego's path only when the ego is near."""
    hits = []
    for near in (False, True):
        playing = play("VehicleOpensDoorTwoWays_1", traffic=False)
        sensor = playing.world.spawn_actor(
            playing.world.get_blueprint_library().find("sensor.other.collision"), carla.Transform(), playing.hero
        )
        sensor.listen(lambda event: hits.append(event.other_actor.type_id))
        car = playing.others()[0]
        place_s = playing.along(car)[0]
        playing.jump(5.0)
        playing.jump(place_s - (9.0 if near else 12.0))
        playing.run(1.0)
        if not near:
            # Closed, and no wider than its lane.
            assert playing.along(car)[1] - car.half_width_m > playing.route.waypoint_at(place_s).lane_width / 2.0
            continue
        hits.clear()
        playing.go(8.0)
        playing.run(3.0, lambda: bool(hits))
        assert car.type_id in hits
        sensor.destroy()


def test_invading_turn_cars_cross_line_but_clear_centered_ego(play):
    """Oncoming cars cross the line, but pass an ego in the middle of its lane without contact."""
    playing = play("InvadingTurn_1", traffic=False, offset=value(0.3))
    playing.jump(5.0)
    nearest = []
    for _ in range(300):
        playing.tick()
        cars = [other for other in playing.others() if playing.apart_m(other) < 30.0]
        nearest += [-playing.along(car)[1] - car.half_width_m for car in cars]
    width_m = playing.route.waypoint_at(5.0).lane_width
    # Their flank: over the line, and beside the hero.
    assert 0.95 < min(nearest) < width_m / 2.0 - 0.2
    assert any(other.type_id == "static.prop.constructioncone" for other in playing.others("static."))
