"""Letting an emergency vehicle by: pull over, stand until it has passed, and return when the guard proves a gap."""

from __future__ import annotations

import pytest

from stucksolver.guard import Guard, RejectCode
from stucksolver.plan.behaviors import RejoinRoute, Wait
from stucksolver.scene import LineKind, ObjectKind
from stucksolver.solver import EventKind
from test_behaviors import run
from test_guard_abreast import SHOULDER
from worlds import World, drive, said, searched, straight_road, thing

WORDS = "There is a siren behind us, please pull over."
ON_SHOULDER_M = -1.5


def siren(x, speed=12.0, lights=True):
    return thing("siren", x, kind=ObjectKind.EMERGENCY, speed=speed, emergency_lights=lights)


def proposed(*others):
    world = World(SHOULDER, list(others), speed=6.0)
    plan = searched(world, world.scene().model_copy(update={"guidance": said(WORDS)})).plan
    return [b.name for b in plan.behaviors]


def test_siren_behind_plans_pull_over_wait_and_rejoin():
    """For a siren behind, the ego pulls over, waits until it has passed, and returns."""
    assert proposed(siren(10.0)) == ["pull_over", "wait", "rejoin_route"]


@pytest.mark.parametrize(
    "other", [siren(90.0), siren(10.0, lights=False), siren(10.0, speed=0.0)], ids=["ahead", "silent", "parked"]
)
def test_without_one_it_only_pulls_over(other):
    assert proposed(other) == ["pull_over"]


@pytest.mark.parametrize(
    ("other", "passes_s"),
    [(siren(20.0), 3.0), (siren(20.0, lights=False), 0.0), (siren(75.0), 0.0), (siren(-60.0, speed=0.1), 0.0)],
    ids=["comes", "silent", "ahead", "far behind"],
)
def test_the_wait_ends_when_the_siren_is_ahead(other, passes_s):
    world = World(straight_road(), [other])
    run([Wait(duration_s=20.0, until="passed")], world)
    assert world.time_s == pytest.approx(passes_s, abs=0.3)


def test_the_wait_is_bounded():
    world = World(straight_road(), [siren(30.0, speed=0.2)])
    run([Wait(duration_s=6.0, until="passed")], world)
    assert world.time_s == pytest.approx(6.0, abs=0.2)


@pytest.mark.integration
def test_solver_siren_behind_passes_and_ego_rejoins_lane():
    """The ego yields and is back in its lane behind the siren."""
    world = World(SHOULDER, [siren(-5.0)], speed=6.0, cruise_mps=6.0, behind_m=150.0)
    nearest, aside = [], []

    def watch(world):
        nearest.append(world.clearance())
        aside.append(world.y)

    seen = drive(world, 40.0, words={1.0: WORDS}, every_tick=watch)
    assert seen.kinds().count(EventKind.STARTED) == 1 and EventKind.FINISHED in seen.kinds()
    assert min(aside) < ON_SHOULDER_M and min(nearest) > 0.5
    assert world.y == pytest.approx(0.0, abs=0.3) and world.x > 100.0


@pytest.mark.integration
def test_it_returns_only_into_a_gap_that_the_guard_proves():
    """Cars that follow the siren at small gaps: the return waits for the end of the row."""
    row = [thing(f"car{k}", -20.0 - 16.0 * k, speed=8.0) for k in range(6)]
    world = World(SHOULDER, [siren(-5.0), *row], speed=6.0, cruise_mps=6.0, behind_m=150.0)
    begun_m = []

    def watch(world):
        if not begun_m and world.y > ON_SHOULDER_M and world.time_s > 15.0:
            begun_m.append(min(o.x_m for o in world.objects) - world.x)

    drive(world, 60.0, words={1.0: WORDS}, every_tick=watch)
    assert begun_m and begun_m[0] > 0.0


def with_edge_line(road):
    """The same road with a solid line between the lane and the shoulder."""
    lanes = tuple(
        lane.model_copy(update={"line": (LineKind.SOLID,) * len(lane.line)}) if lane.id == "shoulder" else lane
        for lane in road.lanes
    )
    return road.model_copy(update={"key": f"{road.key} edge", "lanes": lanes})


EDGE = with_edge_line(SHOULDER)


@pytest.mark.parametrize("ahead", [thing("moves", 95.0, speed=7.0), thing("queue", 120.0)], ids=lambda o: o.id)
def test_rejoin_over_edge_line_with_lead_is_accepted(ahead):
    """The edge line is crossed back into the lane, with a moving or a stopped vehicle ahead."""
    world = World(EDGE, [ahead], y=-2.4, behind_m=150.0)
    assert Guard().accept([RejoinRoute()], world.view(), False)[0].codes == ()


def test_the_edge_line_is_no_way_into_traffic():
    world = World(EDGE, [thing("comes", 35.0, speed=8.0)], y=-2.4, behind_m=150.0)
    assert RejectCode.LANE_ENTRY in Guard().accept([RejoinRoute()], world.view(), False)[0].codes


@pytest.mark.integration
def test_a_stream_without_gaps_does_not_hold_it_for_good():
    """After 30 s at the roadside the plan ends, and the stack drives on by itself."""
    stream = [thing(f"car{k}", 45.0 - 12.0 * k, speed=6.0) for k in range(40)]
    world = World(EDGE, stream, y=-2.4, behind_m=150.0)
    outcome, _ = run([Wait(duration_s=1.0), RejoinRoute()], world, seconds=80.0)
    assert not outcome.finished and world.time_s == pytest.approx(31.0, abs=1.0)
