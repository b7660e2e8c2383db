"""Situations from public reports: each is staged on its three sites, and its label stays out of the scene."""

from __future__ import annotations

import math
from collections import Counter

import pytest

carla = pytest.importorskip("carla")

from playing import Playing  # noqa: E402

from stucksolver.scene.base_model import FrozenModel  # noqa: E402
from stucksolver_carla.drivers.behavior import BehaviorDriver, DriverOptions  # noqa: E402
from stucksolver_carla.stack import CarlaStack  # noqa: E402
from stucksolver_carla.stack.front_camera import FrontCamera  # noqa: E402
from stucksolver_eval.scenarios import SCENARIOS, load_all  # noqa: E402
from stucksolver_eval.scenarios.families.reported import ReportedScenario  # noqa: E402
from stucksolver_eval.scenarios.families.situation_rows import Situation, state_at  # noqa: E402
from stucksolver_eval.suites import suite  # noqa: E402

ROUTES = suite("reported").routes
ROUTE_OF = {route.id: route for route in ROUTES}
BEFORE_M = 12.0


def situations() -> dict[str, Situation]:
    load_all()
    return {
        name: cls.situation
        for name, cls in SCENARIOS.items()
        if issubclass(cls, ReportedScenario) and cls is not ReportedScenario
    }


@pytest.fixture
def staged(theatre):
    """Plays a route of the suite without background traffic."""
    begun = []

    def begin(route, before_m=40.0):
        client = theatre._client_of(route.town)
        begun.append(Playing(client.load_world(route.town), route, client, before_m=before_m, traffic=False))
        return begun[-1]

    yield begin
    for item in begun:
        item.close()


def test_suite_has_three_routes_of_each_situation():
    kinds = Counter(route.scenarios[0].type for route in ROUTES)
    assert kinds == dict.fromkeys(situations(), 3) and len(kinds) >= 40


def test_every_situation_names_its_source_and_the_right_reaction():
    for row in situations().values():
        assert row.about.endswith(".") and len(row.source) > 20, row.name
        assert row.within_s > 0.0
        assert (row.free_s is not None) == (row.expected == "wait"), row.name
        assert (row.zone_m is not None) == (row.expected == "leave"), row.name
    assert {row.expected for row in situations().values()} == {"recover", "wait", "ask", "reroute", "leave"}


def test_every_false_stop_has_a_control():
    controls = [row for row in situations().values() if row.source.startswith("Control of ")]
    named = {name for row in controls for name in row.source.removeprefix("Control of ").split(" and ")}
    assert {"FalseRedLight", "PhantomStopLine", "PedestrianNotCrossing"} <= named <= set(situations())
    assert all(row.expected == "wait" for row in controls)


def test_state_of_schedule_holds_from_its_time_on():
    schedule = ((0.0, "red"), (40.0, "green"))
    assert [state_at(schedule, now_s) for now_s in (-1.0, 0.0, 39.9, 40.0, 90.0)] == ["red"] * 3 + ["green"] * 2


@pytest.mark.integration
@pytest.mark.parametrize("route_id", ROUTE_OF, ids=lambda item: f"{ROUTE_OF[item].scenarios[0].type}-{item}")
def test_situation_is_staged_at_its_site(staged, route_id):
    """Every actor is spawned near the place, and the ego's arrival is noted."""
    playing = staged(ROUTE_OF[route_id])
    row = playing.scenario.situation
    place_s = playing.scenario.place_s
    for member, actor in zip(playing.scenario._members, row.actors, strict=True):
        s_m, right_m = playing.along(member)
        assert actor.from_s or (abs(s_m - place_s - actor.ahead_m) < 3.0 and abs(right_m) < 14.0), actor
    playing.jump(playing.scenario.trigger_s_m)
    playing.jump(max(place_s - min(row.near_m, BEFORE_M) + 1.0, playing.scenario.trigger_s_m))
    playing.run(0.3)
    assert "met" in playing.play.marks
    assert "passed" not in playing.play.marks


@pytest.mark.integration
@pytest.mark.parametrize("kind", situations())
def test_label_of_situation_never_reaches_the_scene(staged, kind):
    """Status, surroundings and scene contain neither the name of the situation nor what is right."""
    route = next(item for item in ROUTES if item.scenarios[0].type == kind)
    playing = staged(route)
    ego = playing.play.perceived(playing.hero)
    driver = BehaviorDriver(ego, "normal", DriverOptions(), carla_map=playing.map)
    driver.set_route(playing.route.points)
    stack = CarlaStack(ego, driver, playing.map)
    playing.jump(playing.scenario.trigger_s_m)
    playing.jump(max(playing.scenario.place_s - BEFORE_M, playing.scenario.trigger_s_m))
    parts: tuple[FrozenModel, ...] = (stack.status(), stack.surroundings(), stack.scene())
    text = " ".join(part.model_dump_json() for part in parts).lower()
    row = playing.scenario.situation
    for label in (kind, row.about, row.source, "reported", "scenario", "phantom"):
        assert label.lower() not in text
    for name in ("type_id", "role_name"):
        assert name not in text


@pytest.mark.integration
def test_perceived_light_replaces_the_real_one_for_driver_and_solver_only(staged):
    playing = staged(next(item for item in ROUTES if item.scenarios[0].type == "FalseRedLight"))
    ego = playing.play.perceived(playing.hero)
    playing.jump(playing.scenario.trigger_s_m)
    playing.run(0.3)
    own = {light.id for light in playing.scenario.own_lights}
    real = [light for light in playing.world.get_actors().filter("*traffic_light*") if light.id in own]
    seen = [light for light in ego.get_world().get_actors().filter("*traffic_light*") if light.id in own]
    assert {light.state for light in real} == {carla.TrafficLightState.Green}
    assert {light.get_state() for light in seen} == {carla.TrafficLightState.Red}


@pytest.mark.integration
def test_phantom_light_exists_only_as_perceived_and_turns_green(staged):
    playing = staged(next(item for item in ROUTES if item.scenarios[0].type == "TemporaryLight"))
    ego = playing.play.perceived(playing.hero)
    real = {light.id for light in playing.world.get_actors().filter("*traffic_light*")}
    (phantom,) = [x for x in ego.get_world().get_actors().filter("*traffic_light*") if x.id not in real]
    (line,) = phantom.get_stop_waypoints()
    place = playing.route.waypoint_at(playing.scenario.place_s).transform.location
    assert line.transform.location.distance(place) < 0.1
    assert phantom.state == carla.TrafficLightState.Red
    camera = FrontCamera(ego)
    camera.close()
    playing.jump(playing.scenario.trigger_s_m)
    playing.jump(playing.scenario.place_s - BEFORE_M)
    playing.run(41.0)
    assert phantom.state == carla.TrafficLightState.Green and "free" in playing.play.marks


@pytest.mark.integration
def test_ego_that_backs_out_of_a_forbidden_place_has_left_it(staged):
    playing = staged(next(item for item in ROUTES if item.scenarios[0].type == "StoppedOnRails"))
    playing.jump(playing.scenario.trigger_s_m)
    playing.jump(playing.scenario.place_s - 5.0)
    playing.run(1.0)
    assert "met" in playing.play.marks and "left" not in playing.play.marks
    hero, place = playing.cast.hero, playing.route.waypoint_at(playing.scenario.place_s).transform.location
    assert math.hypot(hero.x - place.x, hero.y - place.y) < 2.0
    playing.jump(playing.scenario.place_s - 9.0)
    playing.tick()
    assert "left" in playing.play.marks


def in_lane(playing, row):
    """Kinds of the actors that reach into the ego's lane between its stop and the end of the situation."""
    found = []
    for member in playing.others(""):
        s_m, right_m = playing.along(member)
        across = abs(playing.facing_deg(member) - 90.0) < 45.0
        half_m = member.half_length_m if across else member.half_width_m
        near = -8.0 < s_m - playing.scenario.place_s < row.past_m
        if near and abs(right_m) - half_m < 1.0 and playing.cast.state(member).z > -1.0:
            found.append(member.type_id)
    return found


MOVES_OFF = [row.name for row in situations().values() if row.expected == "wait" and row.site == "street"]
STAYS_BLOCKED = {"OneLaneBridge", "TemporaryLight"}
"""Rows in which the ego's own lane stays blocked, and the other one becomes free."""


@pytest.mark.integration
@pytest.mark.release
@pytest.mark.parametrize("kind", MOVES_OFF)
def test_place_of_a_wait_is_blocked_and_becomes_free(staged, kind):
    """Before going becomes right something is in the ego's lane, or a light stops it; a little later nothing is."""
    playing = staged(next(item for item in ROUTES if item.scenarios[0].type == kind))
    row = playing.scenario.situation
    playing.jump(playing.scenario.trigger_s_m)
    playing.jump(playing.scenario.place_s - BEFORE_M)
    blocked = playing.run(row.free_s - 2.0, until=lambda: bool(in_lane(playing, row)))
    assert blocked or row.perceived
    playing.run(row.free_s - playing.scenario._now_s + 20.0)
    assert "free" in playing.play.marks
    assert not in_lane(playing, row) or kind in STAYS_BLOCKED
