"""Streams that the hero has to cross or join."""

from __future__ import annotations

import itertools
from dataclasses import replace

import pytest

from grids import sample

carla = pytest.importorskip("carla")

from playing import Playing, shipped  # noqa: E402

pytestmark = pytest.mark.integration

FLOWS = (
    "EnterActorFlow",
    "HighwayExit",
    "MergerIntoSlowTraffic",
    "MergerIntoSlowTrafficV2",
    "InterurbanActorFlow",
    "InterurbanAdvancedActorFlow",
    "CrossingBicycleFlow",
    "NonSignalizedJunctionLeftTurn",
    "NonSignalizedJunctionRightTurn",
    "NonSignalizedJunctionLeftTurnEnterFlow",
    "SignalizedJunctionLeftTurn",
    "SignalizedJunctionRightTurn",
    "SignalizedJunctionLeftTurnEnterFlow",
)
SPEED_MPS = 9.0
FROM_M = 20.0
TO_M = 30.0


def value(number):
    return {"value": str(number)}


def flow_play(play, kind, number=1, **options):
    gaps = {"from": str(FROM_M), "to": str(TO_M)}
    return play(f"{kind}_{number}", traffic=False, flow_speed=value(SPEED_MPS), source_dist_interval=gaps, **options)


def lanes(playing):
    """Cars of the flows by the road that each began on, in driving order."""
    cars = [car for car in playing.setting.cars._cars.values() if car.constant]
    groups = itertools.groupby(sorted(cars, key=_source), key=_source)
    return [sorted(group, key=lambda car: car.member.id) for _, group in groups]


def _source(car):
    first = car.path
    return round(first.yaw[-1], 1), car.start_road


@pytest.mark.parametrize("kind", FLOWS)
def test_a_flow_keeps_its_speed_and_crosses_the_heros_way(play, kind):
    playing = flow_play(play, kind)
    playing.jump(5.0)
    aside_m = 1.0
    met = False
    speeds = []
    seen = {}
    for _ in range(150):
        playing.tick()
        for car in [car for group in lanes(playing) for car in group]:
            speeds.append(car.speed_mps)
            seen.setdefault(car.member.id, []).append((car.state.x, car.state.y))
            s_m, right_m = playing.along(car.member)
            met = met or (s_m > 8.0 and abs(right_m) < aside_m)
    assert len(seen) >= 3
    moving = [speed for speed in speeds if speed > 0.1]
    assert min(moving) > SPEED_MPS - 0.2 and max(moving) < SPEED_MPS + 0.2
    assert met, "no car of the flow came onto the hero's route"


@pytest.mark.parametrize("kind", ["EnterActorFlow", "InterurbanActorFlow", "MergerIntoSlowTraffic"])
def test_cars_of_a_flow_keep_the_spacing_asked_for(play, kind):
    playing = flow_play(play, kind)
    playing.jump(5.0)
    playing.run(8.0)
    cars = sorted((car for car in playing.setting.cars._cars.values() if car.constant), key=lambda car: car.member.id)
    assert len(cars) >= 3
    gaps = [
        combination.state.distance_m(other.state.x, other.state.y)
        for combination, other in itertools.combinations(cars, 2)
    ]
    nearest = [
        min(item.state.distance_m(other.state.x, other.state.y) for other in cars if other is not item) for item in cars
    ]
    # Measured straight; a place in the line is two meters long, and a bend shortens the way.
    assert min(gaps) > 0.75 * FROM_M
    assert sorted(nearest)[len(nearest) // 2] < TO_M + 3.0


@pytest.mark.parametrize(
    "kind",
    sample(
        [
            "SignalizedJunctionLeftTurn",
            "SignalizedJunctionRightTurn",
            "SignalizedJunctionLeftTurnEnterFlow",
            "CrossingBicycleFlow",
        ],
        2,
    ),
)
def test_flow_light_of_ego_turns_green_after_5_s(play, kind):
    """The ego's light is red for 5 s and green from then on."""
    # Not all junctions with bicycle lanes have lights.
    candidates = (flow_play(play, kind, number=number) for number in range(1, 6))
    playing = next(candidate for candidate in candidates if candidate.scenario.own_lights)
    own = playing.scenario.own_lights
    playing.jump(5.0)
    playing.run(0.2)
    red, green = carla.TrafficLightState.Red, carla.TrafficLightState.Green
    assert own and all(light.state == red for light in own)
    playing.run(4.0)
    assert all(light.state == red for light in own)
    playing.run(2.0)
    assert all(light.state == green for light in own)
    playing.run(14.0)
    assert all(light.state == green for light in own)
    playing.play.close()
    playing.world.tick()
    assert not own[0].is_frozen()


@pytest.mark.parametrize("kind", ["EnterActorFlow", "HighwayExit", "NonSignalizedJunctionRightTurn"])
def test_a_flow_ends_where_the_hero_has_left_it_behind(play, kind):
    playing = flow_play(play, kind)
    playing.jump(5.0)
    playing.run(1.0)
    assert not playing.play.finished
    playing.jump(playing.route.length_m - 2.0)
    assert playing.play.finished
    playing.run(0.1)
    assert not playing.others()


def test_flow_car_brakes_only_after_contact_with_ego(play):
    """A car of the traffic flow does not react to the ego, and brakes once it has touched the ego."""
    playing = flow_play(play, "NonSignalizedJunctionLeftTurn")
    playing.jump(5.0)
    playing.run(3.0)
    car = lanes(playing)[0][0]
    # Put the hero right across its way.
    x, y = car.path.point(car.s + 25.0)
    playing.hero.set_transform(carla.Transform(carla.Location(x, y, car.state.z + 0.3), carla.Rotation(yaw=45.0)))
    speeds = []
    for _ in range(120):
        playing.tick()
        if playing.apart_m(car.member) > 8.0 and not car.hit_hero:
            speeds.append(car.speed_mps)
    assert min(speeds) > SPEED_MPS - 0.2
    assert car.hit_hero and car.speed_mps < 2.0


def test_bicycle_flow_without_end_continues_beyond_junction(theatre):
    """If the file gives no end, the bicycles continue for 40 m beyond the junction."""
    route = shipped()["CrossingBicycleFlow_1"]
    (spec,) = route.scenarios
    given = {name: value for name, value in spec.parameters.items() if name != "end_actor_flow"}
    bare = replace(route, scenarios=(replace(spec, parameters=given),))
    client = theatre._client_of(route.town)
    playing = Playing(client.load_world(route.town), bare, client, traffic=False)
    try:
        (line,) = playing.scenario.lines()
        inside = [k for k, waypoint in enumerate(line) if waypoint.is_junction]
        start = line[0].transform.location
        assert start.distance(carla.Location(*(float(given["start_actor_flow"][axis]) for axis in "xyz"))) < 0.5
        beyond_m = line[inside[-1]].transform.location.distance(line[-1].transform.location)
        assert inside and beyond_m == pytest.approx(40.0, abs=5.0)
        assert all(waypoint.lane_type == carla.LaneType.Biking for waypoint in (line[0], line[-1]))
    finally:
        playing.close()
