"""A road that turns out to be closed between two junctions: the vehicle turns round and takes another one."""

from __future__ import annotations

import pytest

carla = pytest.importorskip("carla")

from test_behaviors_on_the_simulator import watch_collisions  # noqa: E402
from townstage import TICK_S, Stage  # noqa: E402

from carlette.maps.build import map_xml  # noqa: E402
from carlette.maps.build.plan import End, JunctionNode, Plan, PlannedStreet  # noqa: E402
from carlette.maps.build.sections import PASSING, SOLID, LaneSpec, two_way  # noqa: E402
from carlette.maps.reference_lines import Pose2D  # noqa: E402
from stucksolver.solver import EventKind, StuckSolver  # noqa: E402
from stucksolver_eval.simulator_server import carlette_server  # noqa: E402

pytestmark = pytest.mark.integration

LANE_M, LENGTH_M, BARRIER_AT_M = 5.0, 240.0, 120.0
"""Lanes wide enough for three legs; the straight road, and where along it the barriers stand."""
WIDE = two_way("wide", (LaneSpec("driving", LANE_M, SOLID),), PASSING, 30.0)
NO_PASSING = two_way("no passing", (LaneSpec("driving", LANE_M, SOLID),), SOLID, 30.0)


def town(middle=WIDE):
    """Three roads from one junction to another: straight, and by the north and the south."""

    def bend(y, bearing):
        via = (Pose2D(LENGTH_M / 2, y, 0.0),)
        return PlannedStreet("Bend", End("West", bearing), End("East", 180.0 - bearing), WIDE, via)

    straight = PlannedStreet("Straight", End("West", 0.0), End("East", 180.0), middle)
    nodes = [JunctionNode("West", 0.0, 0.0, crosswalks=False), JunctionNode("East", LENGTH_M, 0.0, crosswalks=False)]
    return map_xml(Plan("closed", nodes, [straight, bend(110.0, 90.0), bend(-110.0, -90.0)]))


@pytest.fixture(scope="module")
def stage(tmp_path_factory):
    yield from staged(tmp_path_factory, town())


@pytest.fixture(scope="module")
def solid_stage(tmp_path_factory):
    """The same, with a solid line in the middle of the straight road."""
    yield from staged(tmp_path_factory, town(NO_PASSING))


def staged(tmp_path_factory, xodr):
    path = tmp_path_factory.mktemp("maps") / "closed.xodr"
    path.write_text(xodr, "utf-8")
    with carlette_server(str(path)) as server:
        yield Stage(server.host, server.port)


def close(stage, x):
    """Barriers side by side over both lanes."""
    blueprint = stage.world.get_blueprint_library().find("static.prop.streetbarrier")
    for k in range(9):
        place = carla.Location(x, -4.8 + 1.2 * k, 0.1)
        stage.actors.append(stage.world.spawn_actor(blueprint, carla.Transform(place, carla.Rotation(yaw=90.0))))


def drive(stage, car, stack, seconds, ladder="evaluation", answer=None):
    """With the solver, until the destination: the events, and the (x, y, heading) of every tick in CARLA's world.

    `answer` gets the solver whenever a question is open.
    """
    events, trail = [], []
    with StuckSolver(stack.scene, ladder=ladder, clock="lockstep", on_event=events.append) as solver:
        for _ in range(round(seconds / TICK_S)):
            if answer is not None and solver.pending_question is not None:
                answer(solver)
            status = stack.status()
            car.apply_control(stack.perform(solver.step(status, stack.surroundings)))
            stage.world.tick()
            where = car.get_transform()
            trail.append((where.location.x, where.location.y, where.rotation.yaw))
            if status.at_destination:
                break
    return events, trail


@pytest.mark.release
@pytest.mark.slow
def test_closed_road_turns_around_and_reaches_destination(stage):
    """Before a closed road, the vehicle turns around and reaches its destination by another road."""
    car, stack = stage.ego((1, -1, 50.0), (3, 1, 150.0))
    close(stage, BARRIER_AT_M)
    hits = watch_collisions(stage, car)
    events, trail = drive(stage, car, stack, 200.0)
    assert "turn_round" in " ".join(e.text for e in events if e.kind is EventKind.STARTED)
    assert any(e.kind is EventKind.FINISHED for e in events), [
        f"{e.time_s:.0f} {e.kind.value} {e.text}" for e in events
    ]
    assert not hits
    assert all(abs(y) < LANE_M for x, y, _ in trail if 25.0 < x < 215.0 and abs(y) < 20.0)
    assert stack.status().at_destination, trail[-1]


def is_turn(question):
    return (
        question is not None and question.plan is not None and "turn_round" in [b.name for b in question.plan.behaviors]
    )


@pytest.mark.release
def test_solid_line_turn_asks_passenger_before_moving(solid_stage):
    """Over a solid line, the passenger is asked before the vehicle moves."""
    car, stack = solid_stage.ego((1, -1, 50.0), (3, 1, 150.0))
    close(solid_stage, BARRIER_AT_M)
    asked = []

    def say_yes(solver):
        question = solver.pending_question
        if is_turn(question):
            asked.append(question)
            solver.approve(question.id)

    events, trail = drive(solid_stage, car, stack, 200.0, "default", say_yes)
    assert [(q.to, q.needs) for q in asked] == [("passenger", ("solid_line",))]
    kinds = [e.kind for e in events]
    assert kinds.index(EventKind.ANSWERED) < kinds.index(EventKind.STARTED)
    assert EventKind.ABORTED not in kinds
    assert stack.status().at_destination, trail[-1]


@pytest.mark.release
def test_after_a_no_the_vehicle_stays_where_it_is(solid_stage):
    car, stack = solid_stage.ego((1, -1, 50.0), (3, 1, 150.0))
    close(solid_stage, BARRIER_AT_M)
    stood = []

    def say_no(solver):
        question = solver.pending_question
        if is_turn(question):
            stood.append(car.get_location().x)
            solver.deny(question.id)

    events, trail = drive(solid_stage, car, stack, 90.0, "default", say_no)
    assert stood
    assert abs(trail[-1][0] - stood[0]) < 0.5
    assert not any(e.kind is EventKind.STARTED and ("turn_round" in e.text or "back_up" in e.text) for e in events)
