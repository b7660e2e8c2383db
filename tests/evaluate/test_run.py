"""Whole runs with everything real: the simulator, the client, the driver, the solver with its rules and its guard.

Runs with the client's traffic manager are made in a process of their own, as the program makes them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path

import pytest

carla = pytest.importorskip("carla")

from stucksolver.decision import Directive, Execute  # noqa: E402
from stucksolver.reason import RuleReasoner  # noqa: E402
from stucksolver.solver import Event, EventKind, StuckSolver  # noqa: E402
from stucksolver.stacks.carla_stack import CarlaStack  # noqa: E402
from stucksolver.stacks.driver import BehaviorDriver  # noqa: E402
from stucksolver_eval.jobs import Job, make  # noqa: E402
from stucksolver_eval.run import DT_S, run_job  # noqa: E402
from stucksolver_eval.runlog import RunLog  # noqa: E402
from stucksolver_eval.server import Server, carlette_server  # noqa: E402
from stucksolver_eval.situation import Scenario, into_gear  # noqa: E402

pytestmark = pytest.mark.integration

WORDS = (8.0, "please overtake them")
Run = Callable[..., RunLog]


@pytest.fixture(scope="module")
def server() -> Iterator[Server]:
    with carlette_server("demo_town") as found:
        yield found


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("runs")


def job(log: Path, **changes: object) -> Job:
    usual = {
        "scenario": Scenario.PARKED_CAR,
        "arm": "StuckSolver",
        "with_solver": True,
        "guidance": (),
        "map_name": "demo_town",
        "maps": None,
        "road": "any",
        "oncoming": 0,
        "seed": 1,
        "profile": "normal",
        "clock": "lockstep",
        "log": log,
    }
    return Job(**(usual | changes))


@pytest.fixture(scope="module")
def here(server: Server, folder: Path) -> Run:
    """Makes a run without traffic in this process, each kind once."""

    @cache
    def run(**changes: object) -> RunLog:
        return run_job(job(folder / "x.json", host=server.host, port=server.port, **changes), server, lambda _: None)

    return run


@pytest.fixture(scope="module")
def apart(folder: Path) -> Run:
    """Makes a run in a process and on a server of its own."""

    def run(**changes: object) -> RunLog:
        told: list[float] = []
        log, repeated = make(job(folder / "apart.json", **changes), told.append)
        assert repeated == 0
        assert told == sorted(told) and len(told) > log.result.duration_s / 10
        return log

    return run


def test_the_driver_alone_stays_behind_the_parked_car_until_it_counts_as_blocked(here: Run) -> None:
    log = here(with_solver=False, arm="driver alone")
    result = log.result
    assert (result.status, result.infractions, result.decisions, result.plans_accepted) == ("blocked", {}, 0, 0)
    assert 20.0 < result.route_completion_pct < 50.0
    assert 60.0 < result.stopped_s < 61.0
    assert (result.immobilizations, result.time_to_recover_s) == (1, None)
    assert log.reasoner == "none"
    ((begin, end),) = log.stuck
    assert end - begin > 59.0


def test_with_the_solver_the_ego_gets_past_the_parked_car(here: Run) -> None:
    log = here()
    result = log.result
    assert (result.status, result.route_completion_pct, result.infractions) == ("completed", 100.0, {})
    assert 0.0 < result.time_to_recover_s < 20.0
    assert result.plans_accepted == 1
    (accepted,) = [d for d in log.decisions if d.verdict == "accepted"]
    assert accepted.trigger == "detector"
    assert accepted.decision["plan"]["behaviors"][0]["name"] == "borrow_oncoming_lane"
    assert accepted.decision["analysis"]["cause"] == "parked_vehicle"
    assert log.perception == "privileged"


def test_the_log_replays_the_run(here: Run) -> None:
    log = here()
    times = [frame.time_s for frame in log.frames]
    assert times == pytest.approx([k * 0.1 for k in range(len(times))], abs=0.03)
    assert log.actors[0].role == "ego" and {a.role for a in log.actors} == {"ego", "scenario"}
    assert [e.time_s for e in log.events] == sorted(e.time_s for e in log.events)
    assert "execute borrow_oncoming_lane" in [e.text for e in log.events if e.kind == "directive"]
    assert any(frame.path for frame in log.frames)
    assert not log.frames[-1].path
    assert RunLog.model_validate_json(log.model_dump_json()) == log


def test_the_same_seed_is_the_same_run(folder: Path) -> None:
    runs = []
    for _ in range(2):
        # An actor's id never comes back, so only on servers of their own are all ids the same, too.
        with carlette_server("demo_town") as fresh:
            runs.append(run_job(job(folder / "x.json", host=fresh.host, port=fresh.port), fresh, lambda _: None))
    assert runs[0] == runs[1]


def test_where_there_is_a_lane_of_our_direction_it_changes_into_that(here: Run) -> None:
    log = here(road="multi_lane")
    assert (log.result.status, log.result.infractions, log.result.plans_accepted) == ("completed", {}, 1)
    (accepted,) = [d for d in log.decisions if d.verdict == "accepted"]
    assert {b["name"] for b in accepted.decision["plan"]["behaviors"]} <= {"change_lane", "keep_lane"}


def test_a_slow_answer_is_a_late_one_and_helps_all_the_same(here: Run) -> None:
    quick, slow = here(), here(clock="latency:2")
    assert slow.result.status == "completed" and slow.result.infractions == {}
    wait_s = slow.decisions[0].time_s - quick.decisions[0].time_s
    assert wait_s == pytest.approx(2.0, abs=0.11)


def test_without_words_nobody_overtakes_the_cyclists(apart: Run) -> None:
    result = apart(scenario=Scenario.CYCLISTS).result
    assert (result.status, result.plans_accepted, result.infractions) == ("completed", 0, {})


def test_with_a_passenger_s_words_the_ego_overtakes_the_cyclists_once(apart: Run) -> None:
    log = apart(scenario=Scenario.CYCLISTS, guidance=(WORDS,))
    result = log.result
    assert (result.status, result.plans_accepted, result.infractions) == ("completed", 1, {})
    (accepted,) = [d for d in log.decisions if d.verdict == "accepted"]
    assert accepted.trigger == "guidance" and accepted.time_s >= WORDS[0]
    assert any(WORDS[1] in e.text for e in log.events if e.kind == "guidance")
    assert {a.kind for a in log.actors} == {"car", "bicycle"}
    # The traffic manager repeats itself too: the same seed is the same run in every process.
    assert apart(scenario=Scenario.CYCLISTS, guidance=(WORDS,)) == log


def test_oncoming_cars_are_let_by_before_their_lane_is_borrowed(apart: Run) -> None:
    log = apart(oncoming=2, road="one_lane")
    assert (log.result.status, log.result.infractions, log.result.plans_accepted) == ("completed", {}, 1)
    assert sum(a.role == "traffic" for a in log.actors) == 2
    waits = [d.decision["analysis"]["wait"] for d in log.decisions]
    assert "yield" in waits and log.decisions[-1].verdict == "accepted"


# ---- a red light


class Crossing:
    """The ego on its way through a junction whose light stays as it is set."""

    def __init__(self, server: Server) -> None:
        client = carla.Client(server.host, server.port)
        client.set_timeout(15.0)
        self.world = client.load_world("demo_town")
        settings = self.world.get_settings()
        settings.synchronous_mode, settings.fixed_delta_seconds = True, DT_S
        self.world.apply_settings(settings)
        town = self.world.get_map()
        lights = self.world.get_actors().filter("*traffic_light*")
        self.light = next(one for one in lights if any(w.road_id == 11 for w in one.get_stop_waypoints()))
        (self.line,) = self.light.get_stop_waypoints()
        start = town.get_waypoint_xodr(11, 1, 60.0).transform
        start.location.z += 0.2
        self.ego = self.world.spawn_actor(self.world.get_blueprint_library().find("vehicle.tesla.model3"), start)
        into_gear(self.ego)
        for _ in range(10):
            self.world.tick()
        driver = BehaviorDriver(self.ego, carla_map=town)
        driver.set_destination(town.get_waypoint_xodr(21, -1, 30.0).transform.location)
        self.stack = CarlaStack(self.ego, driver, town)
        self.events: list[Event] = []
        self.solver = StuckSolver(
            self.stack.scene,
            reasoner=RuleReasoner(),
            ladder="evaluation",
            clock="lockstep",
            on_event=self.events.append,
        )

    def show(self, state: object) -> None:
        self.light.set_state(state)
        self.light.freeze(True)

    def drive(self, seconds: float) -> list[Directive]:
        found = []
        for _ in range(round(seconds / DT_S)):
            status = self.stack.status()
            found.append(self.solver.step(status, self.stack.surroundings))
            self.ego.apply_control(self.stack.perform(found[-1]))
            self.world.tick()
        return found

    def decisions(self) -> list[Event]:
        return [e for e in self.events if e.kind is EventKind.DECIDED]

    def before_the_line_m(self) -> float:
        """From the front bumper to the stop line; the ego drives towards lower x here."""
        return float(self.ego.get_location().x - self.ego.bounding_box.extent.x - self.line.transform.location.x)


def test_before_a_red_light_the_ego_waits_whatever_is_said_and_goes_at_green(server: Server) -> None:
    crossing = Crossing(server)
    with crossing.solver:
        crossing.show(carla.TrafficLightState.Red)
        directives = crossing.drive(25.0)
        assert crossing.stack.status().speed_mps < 0.1
        assert 0.0 < crossing.before_the_line_m() < 6.0
        assert not any(isinstance(d, Execute) for d in directives)
        decided = crossing.decisions()
        assert decided and all(e.decision.plan is None for e in decided)
        assert {e.decision.analysis.wait.value for e in decided} == {"light"}
        crossing.solver.guide("just go")
        directives = crossing.drive(8.0)
        assert all(e.decision.plan is None for e in crossing.decisions())
        assert not any(isinstance(d, Execute) for d in directives)
        assert 0.0 < crossing.before_the_line_m() < 6.0
        crossing.show(carla.TrafficLightState.Green)
        crossing.drive(14.0)
        assert crossing.stack.status().at_destination
        assert all(e.decision.plan is None for e in crossing.decisions())
