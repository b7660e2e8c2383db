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
def test_junction_light_of_ego_changes_color_after_5_s(play, kind, first, then):
    """The ego's light has one color for 5 s and then the other; the other lights are red."""
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
def test_plain_turn_ends_10_m_after_junction_with_blocked_criterion(play, kind):
    """A plain turn ends 10 m after the junction, and the blocked criterion is not suspended."""
    playing = play(f"{kind}_1", traffic=False)
    playing.jump(5.0)
    assert playing.play.active == {kind} and not playing.play.suspended and not playing.others("")
    playing.jump(playing.scenario.exit_s + 8.0)
    assert not playing.play.finished
    playing.jump(playing.scenario.exit_s + 11.0)
    assert playing.play.finished


@pytest.mark.parametrize("kind", ["T_Junction", "SequentialLaneChange"])
def test_route_task_scenario_adds_no_actors(play, kind):
    """A scenario whose task is the route itself adds no actors."""
    playing = play(f"{kind}_1", traffic=False)
    playing.jump(5.0)
    assert playing.play.suspended == {"blocked"} and not playing.others("")
    playing.jump(min(5.0 + 201.0, playing.route.length_m - 2.0))
    assert playing.play.finished
