"""How scenarios are found, begun, ended and refused; parameters; the page that describes them."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

carla = pytest.importorskip("carla")

from playing import Playing, shipped  # noqa: E402

from stucksolver_eval.routes import Position, RoutePose, ScenarioSpec  # noqa: E402
from stucksolver_eval.scenarios import SCENARIOS, Scenario, ScenarioError, UnsupportedScenarioError, load_all  # noqa: E402
from stucksolver_eval.scenarios.parameters import (  # noqa: E402
    ChoiceParameter,
    LocationParameter,
    NumberParameter,
    RangeParameter,
    parameters_of,
)
from stucksolver_eval.scenarios.registry import scenario, scenario_type  # noqa: E402
from stucksolver_eval.scenarios.scenario_docs import PAGE, page  # noqa: E402

PUBLIC = [
    "Accident",
    "AccidentTwoWays",
    "BlockedIntersection",
    "ConstructionObstacle",
    "ConstructionObstacleTwoWays",
    "ControlLoss",
    "CrossingBicycleFlow",
    "DynamicObjectCrossing",
    "EnterActorFlow",
    "HardBreakRoute",
    "HazardAtSideLane",
    "HazardAtSideLaneTwoWays",
    "HighwayCutIn",
    "HighwayExit",
    "InterurbanActorFlow",
    "InterurbanAdvancedActorFlow",
    "InvadingTurn",
    "MergerIntoSlowTraffic",
    "MergerIntoSlowTrafficV2",
    "NonSignalizedJunctionLeftTurn",
    "NonSignalizedJunctionLeftTurnEnterFlow",
    "NonSignalizedJunctionRightTurn",
    "OppositeVehicleRunningRedLight",
    "OppositeVehicleTakingPriority",
    "ParkedObstacle",
    "ParkedObstacleTwoWays",
    "ParkingCrossingPedestrian",
    "ParkingCutIn",
    "ParkingExit",
    "PedestrianCrossing",
    "SequentialLaneChange",
    "SignalizedJunctionLeftTurn",
    "SignalizedJunctionLeftTurnEnterFlow",
    "SignalizedJunctionRightTurn",
    "StaticCutIn",
    "T_Junction",
    "VanillaNonSignalizedTurn",
    "VanillaNonSignalizedTurnEncounterStopsign",
    "VanillaSignalizedTurnEncounterGreenLight",
    "VanillaSignalizedTurnEncounterRedLight",
    "VehicleOpensDoorTwoWays",
    "VehicleTurningRoute",
    "VehicleTurningRoutePedestrian",
    "YieldToEmergencyVehicle",
]
COUNTS_AS_BLOCKED = [
    "HighwayCutIn",
    "DynamicObjectCrossing",
    "ParkingCrossingPedestrian",
    "PedestrianCrossing",
    "VehicleTurningRoute",
    "VehicleTurningRoutePedestrian",
    "HardBreakRoute",
    "OppositeVehicleTakingPriority",
    "OppositeVehicleRunningRedLight",
    "ParkingCutIn",
    "StaticCutIn",
    "ControlLoss",
    "YieldToEmergencyVehicle",
    "VanillaNonSignalizedTurn",
    "VanillaNonSignalizedTurnEncounterStopsign",
    "VanillaSignalizedTurnEncounterGreenLight",
    "VanillaSignalizedTurnEncounterRedLight",
]


def value(number):
    return {"value": str(number)}


def test_all_public_types_are_there():
    load_all()
    assert set(PUBLIC) <= set(SCENARIOS) and len(PUBLIC) == 44


def test_scenario_types_without_time_limit_match_public_benchmark():
    """The scenario types without a time limit are those of the public benchmark."""
    load_all()
    assert {name for name in PUBLIC if SCENARIOS[name].timeout_s is None} == set(COUNTS_AS_BLOCKED)


def test_an_unknown_type_is_named_with_what_exists():
    with pytest.raises(
        ScenarioError, match=r"unknown scenario type: 'Acident'\. Choose from Accident, AccidentTwoWays"
    ):
        scenario_type("Acident")


def test_two_types_of_one_name_are_refused():
    load_all()
    twin = type("Twin", (Scenario,), {"type": "Accident", "script": lambda self: iter(())})
    with pytest.raises(ValueError, match="duplicate scenario type: 'Accident'"):
        scenario(twin)


class Stub:
    """A scenario's parameters alone."""

    number = NumberParameter("distance", 12.0)
    gaps = RangeParameter("frequency", (20.0, 100.0))
    side = ChoiceParameter("direction", "right", options=("left", "right"))
    place = LocationParameter("start_actor_flow", None)

    def __init__(self, **parameters):
        trigger = RoutePose(Position(0, 0, 0), 0)
        self.spec = ScenarioSpec("Stub_1", "Stub", trigger, parameters)


def test_parameters_are_read_and_have_defaults():
    told = Stub(
        distance=value(4.5),
        frequency={"from": "30", "to": "60"},
        direction=value("left"),
        start_actor_flow={"x": "1", "y": "-2", "z": "3"},
    )
    assert (told.number, told.gaps, told.side, told.place) == (4.5, (30.0, 60.0), "left", (1.0, -2.0, 3.0))
    assert (Stub().number, Stub().gaps, Stub().side, Stub().place) == (12.0, (20.0, 100.0), "right", None)


@pytest.mark.parametrize(
    ("name", "element", "said"),
    [
        ("number", {"distance": value("near")}, '<distance value="..."/>'),
        ("number", {"distance": value("nan")}, '<distance value="..."/>'),
        ("gaps", {"frequency": {"from": "60", "to": "30"}}, '<frequency from="..." to="..."/>'),
        ("side", {"direction": value("up")}, '<direction value="left|right"/>'),
        ("place", {"start_actor_flow": {"x": "1"}}, '<start_actor_flow x="..." y="..." z="..."/>'),
    ],
)
def test_a_bad_parameter_is_named_with_how_to_write_it(name, element, said):
    with pytest.raises(ScenarioError, match="Stub_1: ") as caught:
        getattr(Stub(**element), name)
    assert said in str(caught.value)


def test_the_page_that_ships_is_what_the_classes_say():
    assert PAGE.read_text("utf-8") == page()


def test_every_type_says_what_it_is():
    load_all()
    for name in PUBLIC:
        cls = SCENARIOS[name]
        assert cls.__doc__ and cls.starts, name
        assert all(parameter.name for parameter in parameters_of(cls)), name


def moved(name, **changes):
    route = shipped()[name]
    spec = replace(route.scenarios[0], **changes)
    return replace(route, scenarios=(spec,))


@pytest.mark.integration
def test_a_trigger_point_off_the_route_is_refused(theatre):
    spec = shipped()["Accident_1"].scenarios[0]
    place = spec.trigger.position
    away = RoutePose(replace(place, x_m=place.x_m + 30.0, y_m=place.y_m + 30.0), spec.trigger.yaw_deg)
    with pytest.raises(ScenarioError, match=r"Accident_1: the trigger point \(.*\) is \d+ m off the route"):
        begin(theatre, moved("Accident_1", trigger=away))


@pytest.mark.integration
def test_scenario_on_unsuitable_map_is_unsupported(theatre):
    """A scenario on a map that lacks what it needs is unsupported, and the error names what is missing."""
    with pytest.raises(UnsupportedScenarioError, match=r"ParkingCutIn.* is unsupported here: .* no parking lane"):
        begin(theatre, moved("Accident_1", type="ParkingCutIn", parameters={}))


@pytest.mark.integration
def test_a_blueprint_that_is_missing_makes_it_unsupported(theatre):
    parameters = {**shipped()["DynamicObjectCrossing_1"].scenarios[0].parameters, "blocker_model": value("static.no")}
    with pytest.raises(UnsupportedScenarioError, match=r"the blueprint library has no static\.no"):
        begin(theatre, moved("DynamicObjectCrossing_1", parameters=parameters))


@pytest.mark.integration
def test_an_obstacle_beyond_the_end_of_the_route_is_refused(theatre):
    with pytest.raises(ScenarioError, match="the route ends less than 900 m beyond the trigger point"):
        begin(theatre, moved("Accident_1", parameters={"distance": value(900)}))


def begin(theatre, route):
    client = theatre._client_of(route.town)
    return Playing(client.load_world(route.town), route, client)


@pytest.mark.integration
def test_a_scenario_that_takes_too_long_ends_with_a_timeout(play, monkeypatch):
    monkeypatch.setattr(scenario_type("T_Junction"), "timeout_s", 1.0)
    playing = play("T_Junction_1", traffic=False)
    playing.jump(5.0)
    playing.run(0.8)
    assert playing.play.suspended == {"blocked"}
    playing.run(0.4)
    assert [event.kind for event in playing.play.events] == ["started", "scenario_timeout", "ended"]
    assert playing.play.finished and not playing.play.suspended


@pytest.mark.integration
def test_what_waits_below_the_ground_is_out_of_everyones_sight(play):
    playing = play("StaticCutIn_1", traffic=False)
    waiting = [playing.cast.state(member) for member in playing.cast.members.values()]
    assert len(waiting) == 6 and all(state.z < -50.0 for state in waiting)
    assert all(state.distance_m(playing.cast.hero.x, playing.cast.hero.y) > 400.0 for state in waiting)


@pytest.mark.integration
def test_closing_takes_the_cast_off_the_world(play):
    playing = play("Accident_1")
    playing.run(1.0)
    playing.play.close()
    playing.world.tick()
    assert [item.id for item in playing.world.get_actors().filter("vehicle.*")] == [playing.hero.id]


@pytest.mark.integration
def test_the_same_seed_gives_the_same_run(play):
    def track():
        playing = play("AccidentTwoWays_1")
        playing.go(6.0)
        playing.run(6.0)
        states = [playing.cast.state(member) for member in playing.cast.members.values()]
        playing.close()
        return [(state.x, state.y, state.speed_mps) for state in states]

    first = track()
    assert len(first) > 5 and all(math.isfinite(x) for state in first for x in state)
    assert track() == first
