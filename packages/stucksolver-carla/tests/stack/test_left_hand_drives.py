"""Drives on a straight road, once with right-hand and once with left-hand traffic: each is the other's mirror image."""

from __future__ import annotations

import math
import os
import sys
from pathlib import Path

import numpy as np
import pytest

carla = pytest.importorskip("carla")

from test_agent_plan import leaderboard_plan  # noqa: E402
from test_behavior_agent import put  # noqa: E402
from test_silence_in_two_processes import Halting  # noqa: E402
from townstage import CAR, TICK_S, Stage  # noqa: E402

from left_hand_maps import left_hand  # noqa: E402
from straight import straight_road  # noqa: E402
from stucksolver.plan import Execute  # noqa: E402
from stucksolver.plan.behaviors import BorrowOncomingLane  # noqa: E402
from stucksolver.scene.mirror import mirrored_surroundings  # noqa: E402
from stucksolver.solver import EventKind, StuckSolver  # noqa: E402
from stucksolver_bridge import AgentDriver, RecoveryClient  # noqa: E402
from stucksolver_bridge.agent_plan import make_agent  # noqa: E402
from stucksolver_carla.drivers.behavior import BehaviorDriver  # noqa: E402
from stucksolver_carla.drivers.planner import PlannerDriver  # noqa: E402
from stucksolver_carla.stack import CarlaStack  # noqa: E402
from stucksolver_eval.simulator_server import carlette_server  # noqa: E402

pytestmark = [pytest.mark.integration, pytest.mark.slow]

ROAD, PARKED_M, END_M = 7, 75.0, 160.0
SIDES = {"RHT": (-1, 1.0), "LHT": (1, -1.0)}
"""The lane along +x, and the sign of CARLA's y (right) there."""


@pytest.fixture(scope="module", params=list(SIDES))
def staged(request, tmp_path_factory):
    """The rule of a road and an empty world on it."""
    folder: Path = tmp_path_factory.mktemp("maps")
    text = straight_road()
    for name, image in (("RHT", text), ("LHT", left_hand(text))):
        (folder / f"{name}.xodr").write_text(image, encoding="utf-8")
    with carlette_server(request.param, str(folder)) as server:
        yield request.param, Stage(server.host, server.port)


def prepared(stage: Stage, rule: str, driver_class) -> tuple:
    """An ego on its way along +x, and a car parked in its lane."""
    lane, _ = SIDES[rule]
    parked = stage.add(CAR, (ROAD, lane, PARKED_M))
    parked.apply_control(carla.VehicleControl(hand_brake=True))
    car = stage.add(CAR, (ROAD, lane, 30.0), role="hero")
    stage.ticks(20)
    driver = driver_class(car, carla_map=stage.map)
    driver.set_destination(stage.map.get_waypoint_xodr(ROAD, lane, END_M).transform.location)
    return car, driver, CarlaStack(car, driver, stage.map)


def aside(rule: str, location) -> float:
    """How far to the side of oncoming traffic, from the center of the ego's lane (m)."""
    return 1.75 - SIDES[rule][1] * location.y


def test_left_hand_pass_is_mirrored(staged):
    """The solver gets mirrored surroundings, and the ego passes on the side of the oncoming lane: LHT on the right."""
    rule, stage = staged
    car, _, stack = prepared(stage, rule, BehaviorDriver)
    events, offsets, paths = [], [], []
    with StuckSolver(stack.scene, clock="lockstep", on_event=events.append) as solver:
        for _ in range(round(60.0 / TICK_S)):
            directive = solver.step(stack.status(), stack.surroundings)
            if isinstance(directive, Execute) and isinstance(directive.behavior, BorrowOncomingLane):
                paths.append((directive, stack.in_map_frame(directive)))
            car.apply_control(stack.perform(directive))
            stage.world.tick()
            offsets.append(aside(rule, car.get_location()))
        seen = stack.surroundings()
    stage.clear()
    assert EventKind.RECOVERED in [event.kind for event in events]
    assert max(offsets) > 2.0
    assert min(offsets) > -0.6
    assert seen.road.mirrored is (rule == "LHT")
    assert seen.ego.y_m == pytest.approx(-1.75, abs=0.3)
    # In the solver's frame, the pass leads to the left; in the map's frame to the right in left-hand traffic.
    given, driven = paths[0]
    assert max(p.y_m for p in given.path) > 0.0
    assert np.allclose([p.y_m for p in driven.path], [p.y_m * SIDES[rule][1] for p in given.path])
    assert all(event.mirrored is (rule == "LHT") for event in events)


def test_left_hand_planner_passes_on_its_inner_side(staged):
    """The driver `planner` passes by itself, on the side of the oncoming lane."""
    rule, stage = staged
    car, driver, _ = prepared(stage, rule, PlannerDriver)
    offsets = []
    for _ in range(round(40.0 / TICK_S)):
        car.apply_control(driver.run_step())
        stage.world.tick()
        offsets.append(aside(rule, car.get_location()))
    reached_m = car.get_location().x
    stage.clear()
    assert reached_m > PARKED_M + 20.0
    assert max(offsets) > 2.0
    assert min(offsets) > -0.6


def test_left_hand_scene_is_the_mirror_image(staged):
    """The solver's scene and surroundings agree, and candidates for a new route lie in the lanes that they name."""
    rule, stage = staged
    _, _, stack = prepared(stage, rule, BehaviorDriver)
    surroundings = stack.surroundings()
    scene, own = stack.scene(surroundings), stack.scene()
    stage.clear()
    assert scene.mirrored is own.mirrored is (rule == "LHT")
    assert scene.waypoints == own.waypoints and scene.lanes == own.lanes
    oncoming = next(lane for lane in surroundings.road.lanes if lane.direction.value == "opposite")
    assert oncoming.offset_m[0] == pytest.approx(3.5, abs=0.1)
    ahead = [w for w in scene.waypoints if w.lane_id == scene.ego.lane_id]
    assert ahead and all(abs(w.y_m) < 0.3 for w in ahead)
    back = [w for w in scene.waypoints if w.id.startswith("back")]
    assert back and all(w.y_m == pytest.approx(3.5, abs=0.3) for w in back)
    image = mirrored_surroundings(surroundings)
    assert image.ego.y_m == pytest.approx(-surroundings.ego.y_m)


def test_left_hand_agent_in_two_processes_passes_on_its_inner_side(staged):
    """BehaviorAgent with the solver in another process passes too: the directive's path is in the map's frame."""
    rule, stage = staged
    lane, _ = SIDES[rule]
    put(stage, CAR, (ROAD, lane, PARKED_M), 0.0)
    start, end = (ROAD, lane, 30.0), (ROAD, lane, END_M)
    car = stage.add(CAR, start, role="hero")
    stage.ticks(2)
    agent = make_agent(Halting, car, "normal", stage.map)
    driver = AgentDriver(agent, carla)
    driver.set_plan(leaderboard_plan(stage, agent, start, end))
    settings = {"ladder": "evaluation", "clock": "lockstep"}
    told = []
    path = os.pathsep.join(sys.path)  # the solver of this checkout
    recovery = RecoveryClient(driver, stage.map, carla, settings, sys.executable, path, on_event=told.append)
    offsets, executed = [], []
    for _ in range(round(60.0 / TICK_S)):
        car.apply_control(recovery.run_step())
        stage.world.tick()
        offsets.append(aside(rule, car.get_location()))
        points = recovery.directive.get("path")
        if points and points is not (executed[-1][0] if executed else None):
            executed.append((points, car.get_location()))
    recovery.close()
    reached_m = car.get_location().x
    stage.clear()
    assert reached_m > PARKED_M + 15.0, told
    assert max(offsets) > 2.0
    assert min(offsets) > -0.6
    # Each path begins at the ego.
    assert all(math.hypot(p[0]["x_m"] - at.x, -p[0]["y_m"] - at.y) < 3.0 for p, at in executed)
