"""Traffic lights cycle by junction, obey clients, and tell the vehicles in front of them."""

from __future__ import annotations

from random import Random

import pytest

from carlette.geometry import Pose, Rotation, Vector
from carlette.opendrive.map_file import load_map
from carlette.opendrive.road_network import RoadNetwork
from carlette.opendrive.signals import SignalPhase
from carlette.physics.bodies import BodyTable
from carlette.world.actor import ActorKind
from carlette.world.spawn import spawn
from carlette.world.traffic_lights import GREEN_S, RED_S, YELLOW_S, Color, Signals
from carlette.world.world import World

DT = 0.05


def junction_of(phases: int) -> tuple[Signals, BodyTable]:
    signals, bodies = Signals(), BodyTable()
    for _ in range(phases):
        signals.lights.append(row=bodies.append())
    signals.form_groups([SignalPhase("1", place) for place in range(phases)], Random(0))
    return signals, bodies


def run(signals: Signals, bodies: BodyTable, seconds: float) -> list[list[int]]:
    seen = []
    for _ in range(round(seconds / DT)):
        signals.step(bodies, DT)
        seen.append(signals.lights.color.tolist())
    return seen


def test_phase_sequence_is_green_yellow_red_in_turn() -> None:
    """Each phase gets green, then yellow, then red, one phase after the other."""
    signals, bodies = junction_of(3)
    cycle_s = 3 * (GREEN_S + YELLOW_S + RED_S)
    seen = run(signals, bodies, cycle_s)
    for light in range(3):
        green = sum(item[light] == Color.GREEN for item in seen) * DT
        yellow = sum(item[light] == Color.YELLOW for item in seen) * DT
        assert green == pytest.approx(GREEN_S, abs=2 * DT)
        assert yellow == pytest.approx(YELLOW_S, abs=2 * DT)
    assert all(sum(color != Color.RED for color in item) <= 1 for item in seen)


def test_traffic_light_set_by_client_keeps_color_for_set_time() -> None:
    """A light that a client sets keeps its color for the time that is set."""
    signals, bodies = junction_of(3)
    for light in range(3):
        signals.set_color(light, Color.RED)
        signals.set_time(light, Color.RED, 10_000.0)
    assert all(item == [Color.RED] * 3 for item in run(signals, bodies, 60.0))
    assert signals.lights.elapsed[0] == pytest.approx(60.0, abs=0.1)


def test_after_its_time_the_group_takes_a_light_back() -> None:
    signals, bodies = junction_of(2)
    signals.set_color(0, Color.GREEN)
    signals.set_color(1, Color.GREEN)
    run(signals, bodies, GREEN_S + 1.0)
    assert sorted(signals.lights.color.tolist()) != [Color.GREEN, Color.GREEN]


def test_frozen_lights_stand_still_and_go_on_afterwards() -> None:
    signals, bodies = junction_of(2)
    signals.freeze(True)
    before = signals.lights.color.tolist()
    assert all(item == before for item in run(signals, bodies, 40.0))
    signals.freeze(False)
    assert any(item != before for item in run(signals, bodies, 40.0))


def test_a_reset_starts_with_the_first_phase() -> None:
    signals, bodies = junction_of(3)
    run(signals, bodies, 21.0)
    signals.reset([0])
    assert signals.lights.color.tolist() == [Color.GREEN, Color.RED, Color.RED]


def test_a_car_before_a_light_is_told_its_state(town01) -> None:
    world = World(RoadNetwork(load_map(town01)))
    light = next(actor for actor in world.actors.values() if actor.kind is ActorKind.LIGHT)
    pose = world.pose(light)
    before_line = pose.apply(light.box.center)
    yaw = world.roads.waypoint(before_line).transform.rotation.yaw
    car = spawn(world, "vehicle.tesla.model3", {}, Pose(before_line, Rotation(yaw=yaw)))
    away = spawn(world, "vehicle.tesla.model3", {}, Pose(Vector(before_line.x, before_line.y, 60.0)))
    world.signals.set_color(light.index, Color.RED)
    world.tick()
    record = world.bodies.record
    assert (record["has_light"][car.row], record["light_id"][car.row]) == (1, light.id)
    assert record["light_state"][car.row] == Color.RED
    assert record["has_light"][away.row] == 0


def test_phase_durations_match_carla_at_20_hz() -> None:
    """A phase lasts as many ticks as in CARLA at 20 Hz.

    CARLA adds up 32-bit steps and changes when the sum is greater than the time: 200 + 61 + 41 ticks.
    """
    signals, bodies = junction_of(2)
    signals.reset([0])
    seen = [item[0] for item in run(signals, bodies, 4 * 15.1)]
    first = [seen.index(color) for color in (Color.YELLOW, Color.RED)]
    assert [first[0] + 1, first[1] - first[0]] == [200, 61]
    assert seen.index(Color.GREEN, first[1]) - first[1] == 41 + 302
    assert seen.index(Color.YELLOW, first[1]) - first[0] == 604


def test_light_without_controller_cycles_alone_with_longer_red() -> None:
    """A light without a controller changes alone and stays red longer."""
    signals, bodies = Signals(), BodyTable()
    for _ in range(2):
        signals.lights.append(row=bodies.append())
    signals.form_groups([SignalPhase("signal 7", alone=True), SignalPhase("1")], Random(0))
    seen = run(signals, bodies, 46.0)
    assert signals.members(0) == [0]
    red_s = [sum(item[light] == Color.RED for item in seen) * DT for light in range(2)]
    assert red_s == pytest.approx([20.0, 6.0], abs=0.3)
