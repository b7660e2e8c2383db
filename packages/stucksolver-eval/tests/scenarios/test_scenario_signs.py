"""Junctions with lights and signs, and what only the route asks for."""

from __future__ import annotations

import pytest

carla = pytest.importorskip("carla")

pytestmark = pytest.mark.integration

RED, GREEN = carla.TrafficLightState.Red, carla.TrafficLightState.Green


@pytest.mark.parametrize(
    ("kind", "first", "then"),
    [
        ("VanillaSignalizedTurnEncounterGreenLight", GREEN, RED),
        ("VanillaSignalizedTurnEncounterRedLight", RED, GREEN),
    ],
)
def test_the_heros_light_has_one_colour_for_five_seconds_then_the_other(play, kind, first, then):
    playing = play(f"{kind}_1", traffic=False)
    playing.jump(5.0)
    playing.run(0.2)
    own = playing.scenario.own_lights
    assert own and all(light.state == first for light in own)
    playing.run(4.6)
    assert all(light.state == first for light in own)
    playing.run(0.6)
    assert all(light.state == then for light in own)
    assert all(light.state == RED for light in playing.scenario.lights if light not in own)
    playing.jump(min(playing.scenario.exit_s + 12.0, playing.route.length_m - 2.0))
    playing.run(0.1)
    assert playing.play.finished and not own[0].is_frozen()


@pytest.mark.parametrize("kind", ["VanillaNonSignalizedTurn", "VanillaNonSignalizedTurnEncounterStopsign"])
def test_a_plain_turn_ends_ten_metres_behind_the_junction_and_being_blocked_counts(play, kind):
    playing = play(f"{kind}_1", traffic=False)
    playing.jump(5.0)
    assert playing.play.active == {kind} and not playing.play.suspended and not playing.others("")
    playing.jump(playing.scenario.exit_s + 8.0)
    assert not playing.play.finished
    playing.jump(playing.scenario.exit_s + 11.0)
    assert playing.play.finished


@pytest.mark.parametrize("kind", ["T_Junction", "SequentialLaneChange"])
def test_nothing_is_put_on_a_route_that_is_the_task_itself(play, kind):
    playing = play(f"{kind}_1", traffic=False)
    playing.jump(5.0)
    assert playing.play.suspended == {"blocked"} and not playing.others("")
    playing.jump(min(5.0 + 201.0, playing.route.length_m - 2.0))
    assert playing.play.finished
