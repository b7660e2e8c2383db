"""Stuck situations of our own and controls: what stands there, what is right, and what is free again when."""

from __future__ import annotations

from dataclasses import replace

import pytest

carla = pytest.importorskip("carla")

from playing import Playing, shipped  # noqa: E402

from stucksolver_eval.scenarios import SCENARIOS, load_all  # noqa: E402
from stucksolver_eval.scenarios.families.reported import ReportedScenario  # noqa: E402

RED, GREEN, OFF = carla.TrafficLightState.Red, carla.TrafficLightState.Green, carla.TrafficLightState.Off
DISTANCE_M = 42.0
RIGHT = {
    "recover": """DisabledCarAndPaperBag DebrisInLane ClosedBoxInLane NarrowRoadStandoff DarkTrafficLight
    DoubleParkedVan AllWayStopDeadlock MergeNeverOpens PictureOfTrafficLight AmbulanceBehind""",
    "ask": "DisabledCarAndRock StuckRedLight",
    "reroute": "RoundaboutLoop ClosedRoad RocksAcrossRoad",
    "wait": """ToyInLane BlockedJunctionBox RoadBlockedForAMinute AnimalsOnRoad Flagger RedLight QueueAtLight
    PedestriansCrossing SchoolBus LevelCrossing EmergencyScene""",
}
BLOCKED = {
    "DisabledCarAndPaperBag": "Accident_1",
    "DisabledCarAndRock": "Accident_1",
    "DebrisInLane": "AccidentTwoWays_1",
    "ClosedBoxInLane": "AccidentTwoWays_1",
    "DoubleParkedVan": "AccidentTwoWays_1",
    "ClosedRoad": "AccidentTwoWays_1",
    "AmbulanceBehind": "AccidentTwoWays_1",
    "PictureOfTrafficLight": "AccidentTwoWays_1",
}
"""Types whose way does not get free by itself, and a route of the suite to play each on."""
FREE_AFTER_S = {
    "ToyInLane": 30.0,
    "RoadBlockedForAMinute": 68.0,
    "AnimalsOnRoad": 36.0,
    "Flagger": 32.0,
    "SchoolBus": 40.0,
    "LevelCrossing": 37.0,
    "EmergencyScene": 47.0,
}
AT_LIGHTS = ("RedLight", "QueueAtLight", "StuckRedLight", "BlockedJunctionBox", "DarkTrafficLight")
LIT = "SignalizedJunctionLeftTurn_1"
IN_ONCOMING_LANE = ("DoubleParkedVan", "PictureOfTrafficLight", "ClosedBoxInLane", "AmbulanceBehind")


def first_quick(kinds):
    """Kinds to play for the better part of a minute each: the first in every run, the others before a release."""
    first, *others = kinds
    return [first, *(pytest.param(other, marks=pytest.mark.release) for other in others)]


@pytest.fixture
def staged(theatre):
    """Plays a type of ours on a route of the public suite."""
    begun = []

    def begin(kind, name, traffic=False, **parameters):
        route = shipped()[name]
        told = {"distance": {"value": str(DISTANCE_M)}, **parameters}
        spec = replace(route.scenarios[0], type=kind, name=f"{kind}_1", parameters=told)
        client = theatre._client_of(route.town)
        begun.append(Playing(client.load_world(route.town), replace(route, scenarios=(spec,)), client, traffic=traffic))
        return begun[-1]

    yield begin
    for item in begun:
        item.close()


def in_way(playing):
    """What reaches into the hero's lane around the place of the scenario."""
    found = []
    for other in playing.others(""):
        s_m, right_m = playing.along(other)
        half_m = max(other.half_width_m, other.half_length_m if abs(playing.facing_deg(other) - 90.0) < 45.0 else 0.0)
        near = abs(s_m - playing.scenario.trigger_s_m - DISTANCE_M) < 14.0
        if near and abs(right_m) - half_m < 1.2:
            found.append(other)
    return found


def test_every_type_of_ours_says_what_is_right():
    load_all()
    ours = {
        name: cls.expected
        for name, cls in SCENARIOS.items()
        if cls.expected is not None and not issubclass(cls, ReportedScenario)
    }
    assert ours == {name: right for right, names in RIGHT.items() for name in names.split()}
    assert all(SCENARIOS[name].timeout_s is None for name in ours)


def test_stuck_scenario_long_wait_suspends_blocked_criterion():
    """A wait of more than a minute does not count as blocked."""
    load_all()
    assert "blocked" in SCENARIOS["RoadBlockedForAMinute"].suspends
    assert SCENARIOS["ClosedRoad"].suspends == {"blocked", "route_deviation"}


def test_only_stuck_scenarios_suspend_blocked_and_deviation_criteria():
    """Only StuckSolver's own scenarios suspend these criteria, and the deviation only where a reroute is expected."""
    load_all()
    for cls in SCENARIOS.values():
        if cls.expected is None:
            assert not cls.suspends & {"blocked", "route_deviation"}
        elif "route_deviation" in cls.suspends:
            assert cls.expected == "reroute"


@pytest.mark.integration
@pytest.mark.parametrize("kind", BLOCKED)
def test_the_way_is_blocked_and_stays_so(staged, kind):
    playing = staged(kind, BLOCKED[kind])
    assert playing.play.expected == SCENARIOS[kind].expected
    playing.jump(5.0)
    assert playing.play.suspended == SCENARIOS[kind].suspends
    playing.jump(DISTANCE_M - 8.0)
    assert in_way(playing)
    playing.run(10.0)
    assert in_way(playing) and not playing.play.finished
    playing.jump(5.0 + DISTANCE_M + 27.0)
    # Where a route planned anew replaces the own one, its test stays off to the end of the drive.
    assert playing.play.finished == (playing.play.expected != "reroute") == (not playing.play.suspended)


@pytest.mark.integration
@pytest.mark.parametrize("thing", ["paperbag", "rock"])
def test_disabled_car_scenario_places_object_in_left_lane(staged, thing):
    """The paper bag or the rock lies in the lane to the left of the disabled car, which has its hazard lights on."""
    kind = "DisabledCarAndPaperBag" if thing == "paperbag" else "DisabledCarAndRock"
    playing = staged(kind, "Accident_1", traffic=True)
    playing.jump(5.0)
    playing.run(1.0)
    (found,) = [other for other in playing.others("static.") if other.type_id.endswith(thing)]
    assert playing.along(found)[1] == pytest.approx(-3.5, abs=0.3)
    (car,) = playing.others()
    assert car.actor.get_light_state() == carla.VehicleLightState(
        int(carla.VehicleLightState.LeftBlinker) | int(carla.VehicleLightState.RightBlinker)
    )


@pytest.mark.integration
@pytest.mark.parametrize("kind", first_quick(FREE_AFTER_S))
def test_who_waits_finds_the_way_free(staged, kind):
    playing = staged(kind, "AccidentTwoWays_1")
    playing.jump(5.0)
    assert in_way(playing) or kind == "LevelCrossing"
    playing.jump(5.0 + DISTANCE_M - 20.0)
    playing.run(FREE_AFTER_S[kind] - 25.0)
    assert playing.others("")
    playing.run(27.0)
    assert not [item for item in in_way(playing) if playing.cast.state(item).speed_mps < 1.0]


@pytest.mark.integration
@pytest.mark.parametrize("kind", first_quick(AT_LIGHTS))
def test_lights_are_held_as_told(staged, kind):
    playing = staged(kind, LIT)
    playing.jump(5.0)
    playing.run(0.2)
    own = playing.scenario.own_lights
    first = GREEN if kind == "BlockedJunctionBox" else OFF if kind == "DarkTrafficLight" else RED
    assert own and all(light.state == first for light in own)
    if kind == "QueueAtLight":
        assert len(playing.others()) >= 2
    if kind == "BlockedJunctionBox":
        inside = [playing.map.get_waypoint(other.actor.get_location()).is_junction for other in playing.others()]
        assert len(inside) >= 2 and all(inside)
    playing.jump(playing.scenario.entry_s - 20.0)
    playing.run(29.0)
    assert all(light.state == first for light in own)
    playing.run(12.0)
    then = {"RedLight": GREEN, "QueueAtLight": GREEN}.get(kind, first)
    assert all(light.state == then for light in own)
    if kind == "BlockedJunctionBox":
        assert not [other for other in playing.others() if playing.cast.state(other).speed_mps < 1.0]


@pytest.mark.integration
def test_pedestrians_cross_one_after_the_other_for_half_a_minute(staged):
    playing = staged("PedestriansCrossing", "PedestrianCrossing_1")
    playing.jump(5.0)
    playing.jump(playing.scenario.entry_s - 20.0)
    on_road = []
    for _ in range(140):
        playing.run(0.25)
        on_road.append(any(abs(playing.along(other)[1]) < 1.75 for other in playing.others("walker.")))
    times = [k * 0.25 for k, is_there in enumerate(on_road) if is_there]
    assert times[0] < 8.0 and times[-1] > 22.0
    playing.run(8.0)
    assert not playing.others("walker.")


@pytest.mark.integration
@pytest.mark.parametrize("kind", ["AllWayStopDeadlock", "DarkTrafficLight"])
def test_nobody_goes_until_the_hero_creeps(staged, kind):
    playing = staged(kind, LIT if kind == "DarkTrafficLight" else "OppositeVehicleTakingPriority_1")
    playing.jump(5.0)
    playing.run(3.0)
    cars = playing.others()
    inside = playing.route.xyz[playing.scenario.junction.first : playing.scenario.junction.last + 1, :2]
    nose = min(
        float(((inside - (s.x, s.y)) ** 2).sum(axis=1).min() ** 0.5) for s in (playing.cast.state(car) for car in cars)
    )
    assert nose < 4.5 and all(playing.cast.state(car).speed_mps < 0.1 for car in cars)
    playing.jump(playing.scenario.entry_s - 6.0)
    playing.run(15.0)
    assert all(playing.cast.state(car).speed_mps < 0.1 for car in cars)
    playing.jump(playing.scenario.entry_s - 4.0)
    playing.run(6.0)
    assert any(playing.cast.state(car).speed_mps > 1.0 for car in cars)


@pytest.mark.integration
def test_merge_scenario_dense_flow_opens_after_ego_noses_out(staged):
    """In the merge, cars pass bumper to bumper until the ego noses out; then the cars behind it react."""
    playing = staged("MergeNeverOpens", "MergerIntoSlowTraffic_1", **placed("MergerIntoSlowTraffic_1"))
    playing.jump(5.0)
    playing.run(1.0)
    flow = [car for car in playing.setting.cars._cars.values() if car.constant]
    gaps = sorted(min(a.state.distance_m(b.state.x, b.state.y) for b in flow if b is not a) for a in flow)
    assert len(flow) > 12 and gaps[-1] < 9.0
    playing.run(6.0)
    assert all(car.constant for car in playing.setting.cars._cars.values())
    playing.jump(8.0)
    playing.run(0.5)
    hero = playing.cast.hero
    ahead = {car.constant for car in flow if hero.ahead_m(car.state.x, car.state.y) > 2.0}
    behind = {car.constant for car in flow if hero.ahead_m(car.state.x, car.state.y) < -2.0}
    assert (ahead, behind) == ({True}, {False})


def placed(name):
    """Where the flow of a route of the public suite begins and ends."""
    given = shipped()[name].scenarios[0].parameters
    return {key: given[key] for key in ("start_actor_flow", "end_actor_flow")}


@pytest.mark.integration
@pytest.mark.parametrize("kind", first_quick(IN_ONCOMING_LANE))
def test_oncoming_lane_scenario_leaves_gaps_to_pass(staged, kind):
    """A blocker that can be passed in the oncoming lane leaves gaps of more than 4 s there."""
    playing = staged(kind, "AccidentTwoWays_1", traffic=True)
    playing.jump(5.0)
    free_s, longest_s = 0.0, 0.0
    for _ in range(100):
        playing.run(0.5)
        oncoming = [other for other in playing.others() if abs(playing.facing_deg(other) - 180.0) < 30.0]
        ahead = [playing.along(item)[0] - playing.setting.hero_s_m for item in oncoming]
        free_s = 0.0 if any(-10.0 < gap_m < 90.0 for gap_m in ahead) else free_s + 0.5
        longest_s = max(longest_s, free_s)
    assert longest_s > 4.0


@pytest.mark.integration
def test_a_closed_road_is_closed_in_all_its_lanes(staged):
    playing = staged("ClosedRoad", "Accident_1")
    playing.jump(5.0)
    lane = playing.scenario.ahead(DISTANCE_M)
    lanes = [lane, lane.get_left_lane()]
    lanes.append(lanes[-1].get_left_lane())
    assert lanes[1].lane_id * lane.lane_id > 0 > lanes[2].lane_id * lane.lane_id
    barriers = [playing.cast.state(other) for other in playing.others("static.prop.streetbarrier")]
    for item in lanes:
        place = item.transform.location
        assert sum(state.distance_m(place.x, place.y) < 1.5 for state in barriers) == 3


@pytest.mark.integration
def test_narrow_road_other_car_leaves_after_ego_backs_up(staged):
    """The other car leaves the narrow road when the ego has backed up."""
    playing = staged("NarrowRoadStandoff", "AccidentTwoWays_1")
    playing.jump(5.0)
    playing.jump(DISTANCE_M - 20.0)
    playing.run(1.0)
    assert playing.others()
    back = playing.route.waypoint_at(playing.hero_s - 7.0).transform
    back.location.z += 0.2
    playing.hero.set_transform(back)
    high_water_m = playing.hero_s
    for _ in range(10):
        playing.world.tick()
        playing.play.tick(playing.world.get_snapshot().timestamp.elapsed_seconds, high_water_m)
    assert not playing.others()
