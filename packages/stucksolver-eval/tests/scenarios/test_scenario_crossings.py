"""Who crosses or takes the hero's way all of a sudden."""

from __future__ import annotations

import math

import pytest

carla = pytest.importorskip("carla")

from stucksolver_eval.scenarios.types.bench2drive import parking_crossing_pedestrian  # noqa: E402

pytestmark = pytest.mark.integration

WALKERS = {
    # type: (meters before where it goes at the latest, m/s)
    "DynamicObjectCrossing": (6.0, (1.9, 2.1)),
    "ParkingCrossingPedestrian": (6.0, (1.9, 2.1)),
    "PedestrianCrossing": (12.0, (1.3, 2.0)),
    "VehicleTurningRoutePedestrian": (6.0, (1.7, 1.9)),
}


def value(number):
    return {"value": str(number)}


def speed(playing, member):
    state = playing.cast.state(member)
    return math.hypot(state.vx, state.vy)


@pytest.mark.parametrize("kind", WALKERS)
def test_walkers_wait_for_the_hero_and_cross_its_whole_lane(play, kind):
    near_m, (slowest, fastest) = WALKERS[kind]
    playing = play(f"{kind}_1", traffic=False)
    walkers = playing.others("walker.")
    places = [playing.along(walker) for walker in walkers]
    assert len(walkers) == (3 if kind == "PedestrianCrossing" else 1)
    half_m = playing.route.waypoint_at(places[0][0]).lane_width / 2.0
    assert all(right_m > half_m for _, right_m in places), "someone stands on the road already"
    playing.jump(5.0)
    first_s = min(s_m for s_m, _ in places)
    playing.jump(first_s - near_m - 4.0)
    playing.run(1.0)
    assert all(speed(playing, walker) < 0.1 for walker in walkers)
    playing.jump(first_s - near_m + 2.0)
    speeds = {walker.id: [] for walker in walkers}
    farthest = {walker.id: 0.0 for walker in walkers}
    while not playing.play.finished and len(speeds[walkers[0].id]) < 400:
        playing.tick()
        for walker in walkers:
            if walker.id in playing.cast.members:
                speeds[walker.id].append(speed(playing, walker))
                farthest[walker.id] = min(farthest[walker.id], playing.along(walker)[1])
    assert playing.play.finished
    assert all(slowest - 0.1 < max(series) < fastest + 0.1 for series in speeds.values())
    assert all(right_m < -half_m for right_m in farthest.values()), "someone did not cross the lane"
    assert not playing.others("walker."), "someone stays on the road"


@pytest.mark.parametrize("kind", ["DynamicObjectCrossing", "ParkingCrossingPedestrian"])
def test_something_hides_the_walker_from_the_hero(play, kind):
    playing = play(f"{kind}_1", traffic=False)
    (walker,) = playing.others("walker.")
    blockers = [other for other in playing.others("") if other is not walker]
    playing.jump(5.0)
    place, hero = playing.cast.state(walker), playing.cast.hero
    # The line of sight meets the blocker's box.
    ways = [(hero.x + k / 200 * (place.x - hero.x), hero.y + k / 200 * (place.y - hero.y)) for k in range(200)]
    assert any(_inside(playing, blocker, x, y) for blocker in blockers for x, y in ways)


def test_crossing_without_parking_lane_pedestrian_emerges_behind_car(play, monkeypatch):
    """Without a parking lane, the pedestrian comes from behind a car that is placed beside the ego's lane."""
    monkeypatch.setattr(parking_crossing_pedestrian, "lane_of", lambda *_: None)
    playing = play("ParkingCrossingPedestrian_1", traffic=False)
    (walker,) = playing.others("walker.")
    (car,) = (other for other in playing.others("") if other is not walker)
    s_m, right_m = playing.along(car)
    assert right_m == pytest.approx(playing.route.waypoint_at(s_m).lane_width, abs=0.3)
    playing.jump(5.0)
    playing.jump(playing.along(walker)[0] - 4.0)
    farthest = []
    while not playing.play.finished and len(farthest) < 300:
        playing.tick()
        farthest.append(playing.along(walker)[1] if walker.id in playing.cast.members else 0.0)
    assert playing.play.finished and min(farthest) < -1.5


def _inside(playing, member, x, y):
    state = playing.cast.state(member)
    cos, sin = math.cos(state.yaw_rad), math.sin(state.yaw_rad)
    ahead, right = (x - state.x) * cos + (y - state.y) * sin, -(x - state.x) * sin + (y - state.y) * cos
    return abs(ahead) < member.half_length_m and abs(right) < member.half_width_m


def test_a_bicycle_crosses_the_road_after_the_turn(play):
    playing = play("VehicleTurningRoute_1", traffic=False)
    (bicycle,) = playing.others()
    s_m, right_m = playing.along(bicycle)
    playing.jump(5.0)
    playing.run(0.5)
    assert speed(playing, bicycle) < 0.1
    playing.jump(s_m - 5.0)
    playing.run(1.0)
    assert speed(playing, bicycle) == pytest.approx(1.8, abs=0.1)
    aside = []
    while not playing.play.finished and len(aside) < 300:
        playing.tick()
        aside.append(playing.along(bicycle)[1] if bicycle.id in playing.cast.members else -right_m)
    assert playing.play.finished and min(aside) < -1.5


@pytest.mark.parametrize("kind", ["OppositeVehicleTakingPriority", "OppositeVehicleRunningRedLight"])
def test_an_emergency_vehicle_would_meet_the_hero_in_the_junction(play, kind):
    name = next(n for n in _names(kind) if _direction(n) != "opposite")
    playing = play(name, traffic=False)
    playing.jump(5.0)
    if kind.endswith("RedLight"):
        playing.run(0.2)
        red, green = carla.TrafficLightState.Red, carla.TrafficLightState.Green
        own = playing.scenario.own_lights
        assert own and all(light.state == green for light in own)
        assert {light.state for light in playing.scenario.lights if light not in own} == {red}
    assert not playing.others()
    playing.go(8.0)
    nearest = math.inf
    for _ in range(480):
        playing.tick()
        if playing.play.finished:
            break
        if playing.others():
            (vehicle,) = playing.others()
            assert vehicle.actor.attributes["special_type"] == "emergency"
            nearest = min(nearest, playing.apart_m(vehicle))
    assert nearest < 6.0 and playing.play.finished and not playing.others()


def _names(kind):
    return [f"{kind}_{k}" for k in range(1, 6)]


def _direction(name):
    from playing import shipped

    return shipped()[name].scenarios[0].parameters["direction"]["value"]


def test_blocked_junction_exit_clears_10_s_after_approach(play):
    """A blocked exit is free 10 s after the ego came near."""
    playing = play("BlockedIntersection_1")
    playing.jump(5.0)
    playing.run(0.2)
    (car,) = playing.others()
    s_m, right_m = playing.along(car)
    assert abs(right_m) < 0.5 and s_m == pytest.approx(playing.scenario.exit_s + 5.0, abs=1.5)
    playing.run(3.0)
    assert playing.others()
    playing.jump(s_m - 12.0)
    playing.run(9.5)
    assert playing.others() == [car]
    playing.run(1.0)
    assert not playing.others() and playing.play.finished


def test_crossing_public_second_test_counts_collision_twice(play):
    """One collision counts twice if the public scenario type has a second collision test."""
    playing = play("VehicleTurningRoutePedestrian_1", traffic=False)
    assert playing.play.extra_criteria == frozenset()
    playing.jump(5.0)
    assert playing.play.extra_criteria == {"collision"}


def test_all_cars_ahead_brake_and_stand_for_ten_seconds(play):
    playing = play("HardBreakRoute_1", before_m=15.0)
    playing.run(1.0)
    playing.go(4.0)
    playing.run(6.0, lambda: bool(playing.play.active))
    playing.go(0.0)
    playing.run(4.0)
    ahead = playing.background.road.ahead
    assert ahead and all(car.speed_mps < 0.1 for car in ahead)
    lit = [car for car in ahead if car.member.actor.get_light_state() == carla.VehicleLightState.Brake]
    assert len(lit) >= 2
    playing.run(5.5)
    assert all(car.speed_mps < 0.1 for car in ahead)
    playing.run(3.0)
    assert any(car.speed_mps > 1.0 for car in ahead)
