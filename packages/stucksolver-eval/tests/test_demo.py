"""The demonstration's streets with everything real: the simulator, the client, the driver, the rules and the guard."""

from __future__ import annotations

import json
import re
from functools import cache
from itertools import pairwise
from pathlib import Path

import pytest

pytest.importorskip("carla")

from stucksolver_carla.client_connection import ServerError
from stucksolver_eval.demo import ALONE, CYCLISTS, GUIDED, HELPED, PARKED_CAR, DemoSpec, demo
from stucksolver_eval.metrics.columns import number
from stucksolver_eval.metrics.recovery import recovery_figures
from stucksolver_eval.results.outcome import RouteOutcome
from stucksolver_eval.results.run_log import RunLog
from stucksolver_eval.run_table import recovered_text
from stucksolver_eval.runner.isolated_process import RunError
from stucksolver_eval.simulator_server import carlette_server
from stucksolver_eval.streets.finder import StreetError
from stucksolver_eval.systems.factory import SystemSpecError

pytestmark = pytest.mark.integration


@pytest.fixture(scope="module")
def shown(tmp_path_factory):
    """Drives one street with one arm, each kind once."""

    @cache
    def driven(street, arm, again, changes) -> RunLog:
        class One(DemoSpec):
            arms = ((street, arm),)

        told: list[str] = []
        spec = One(out=tmp_path_factory.mktemp("demo"), **dict(changes))
        (log,), report = demo(spec, told.append)
        assert report.exists() and told[-1].endswith("s\n") and len(told) > log.result.duration_s / 10
        return log

    def drive(street=PARKED_CAR, arm=HELPED, again=0, **changes: object) -> RunLog:
        changes = {"seed": 1, "oncoming": 0, "pictures": False} | changes
        return driven(street, arm, again, tuple(sorted(changes.items())))

    return drive


@pytest.fixture(scope="module")
def both(tmp_path_factory):
    """The parked car without and with the solver in one demonstration: its folder, the two logs and the page."""

    class Both(DemoSpec):
        arms = ((PARKED_CAR, ALONE), (PARKED_CAR, HELPED))

    out = tmp_path_factory.mktemp("both")
    logs, report = demo(Both(out=out, seed=1, oncoming=0, pictures=False), lambda _: None)
    return out, logs, report


def accepted(log):
    return [d for d in log.decisions if d.verdict == "accepted"]


@pytest.mark.slow
def test_demo_driver_alone_stays_blocked_behind_parked_car(both):
    """The driver alone stays behind the parked car until it counts as blocked."""
    log, _ = both[1]
    result = log.result
    assert (result.status, result.infractions) == ("Failed - Agent got blocked", {"vehicle_blocked": 1})
    assert (result.decisions, result.plans_accepted) == (0, 0)
    assert 20.0 < result.route_completion_pct < 50.0
    assert 58.0 < result.stopped_s < 66.0
    assert (result.immobilizations, result.recoveries, result.time_to_recover_s) == (1, 0, None)
    assert (log.arm, log.reasoner) == ("driver alone", "none")
    ((begin, end),) = log.stuck
    assert end - begin > 59.0


@pytest.mark.slow
def test_with_the_solver_the_ego_gets_past_the_parked_car(both):
    _, log = both[1]
    result = log.result
    assert (result.status, result.route_completion_pct, result.infractions) == ("Completed", 100.0, {})
    assert 0.0 < result.time_to_recover_s < 20.0
    assert result.plans_accepted == 1
    (decided,) = accepted(log)
    assert decided.trigger == "detector"
    assert decided.decision["plan"]["behaviors"][0]["name"] == "borrow_oncoming_lane"
    assert decided.decision["analysis"]["cause"] == "parked_vehicle"
    assert (log.scenario, log.arm) == ("parked car, one lane each way", "StuckSolver")
    assert log.perception == "privileged"


@pytest.mark.slow
def test_demo_figures_are_the_same_on_table_page_and_summary(both):
    """One drive stands until it fails, the other one recovers."""
    out, logs, report = both
    page = json.loads(
        re.search(r'type="application/json"[^>]*>(.*?)</script>', report.read_text(encoding="utf-8"), re.DOTALL)[1]
    )
    for k, (log, shown) in enumerate(zip(logs, page["runs"], strict=True), 1):
        (path,) = (out / "runs" / f"{k}").glob("seed-1/outcomes/*.json")
        outcome = RouteOutcome.model_validate_json(path.read_text(encoding="utf-8"))
        figures = recovery_figures([outcome])
        assert (log.result.immobilizations, log.result.recoveries) == (figures.met, figures.left) == (1, k - 1)
        assert log.result.time_to_recover_s == figures.median_s
        said = "never" if figures.median_s is None else number(figures.median_s, 1)
        assert shown["recovered"] == recovered_text(log.result) == said
        assert shown["stopped"] == f"{outcome.stopped_s:.1f}"
        told = [e.text for e in log.events if e.text.startswith("recovered")]
        assert told == ([] if k == 1 else [f"recovered: 15 m of new progress, {said} s after the onset"])
        still_s = sum(b.time_s - a.time_s for a, b in pairwise(log.frames) if a.speed_mps < 0.1)
        assert outcome.stopped_s == pytest.approx(still_s, abs=1.0)
    assert logs[1].result.stopped_s < figures.median_s, "it does not include the drive after the standstill"


@pytest.mark.slow
def test_the_log_replays_the_run(both):
    _, log = both[1]
    times = [frame.time_s for frame in log.frames]
    assert times == pytest.approx([k * 0.1 for k in range(len(times))], abs=0.03)
    assert log.actors[0].role == "ego" and {a.role for a in log.actors} == {"ego", "scenario"}
    assert [e.time_s for e in log.events] == sorted(e.time_s for e in log.events)
    assert "execute borrow_oncoming_lane" in [e.text for e in log.events if e.kind == "directive"]
    assert any(frame.path for frame in log.frames)
    assert not log.frames[-1].path


@pytest.mark.release
def test_demo_same_seed_reproduces_run_with_traffic(shown):
    """The same seed gives the same run, also with oncoming cars and cyclists."""
    first, second = (shown(CYCLISTS, GUIDED, again=k, oncoming=3, road="one_lane") for k in range(2))
    assert first == second
    assert {a.kind for a in first.actors} == {"car", "bicycle"}


@pytest.mark.release
def test_another_seed_is_another_place_or_other_cars(shown):
    one, other = (shown(seed=seed, oncoming=3, road="one_lane") for seed in (1, 2))
    assert one.actors != other.actors


@pytest.mark.release
def test_demo_several_lanes_ego_uses_adjacent_lane(shown):
    """With an adjacent lane in its direction, the ego changes into that lane."""
    log = shown(road="multi_lane")
    assert (log.result.status, log.result.infractions, log.result.plans_accepted) == ("Completed", {}, 1)
    (decided,) = accepted(log)
    assert {b["name"] for b in decided.decision["plan"]["behaviors"]} <= {"change_lane", "keep_lane"}
    assert log.scenario == "parked car, several lanes"


@pytest.fixture(scope="module")
def slow_elsewhere(shown):
    """A drive with slow answers on a server that runs already, and whether that server is then on its own clock."""
    import carla

    with carlette_server("demo_town") as server:
        log = shown(host=server.host, port=server.port, clock="latency:2")
        settings = carla.Client(server.host, server.port).get_world().get_settings()
        return log, not settings.synchronous_mode


@pytest.mark.release
@pytest.mark.slow
def test_demo_slow_reasoner_delays_but_still_succeeds(both, slow_elsewhere):
    """A reasoner that answers 2 s late makes the decision 2 s later, and the run still succeeds."""
    (_, quick), (slow, _) = both[1], slow_elsewhere
    assert slow.result.status == "Completed" and slow.result.infractions == {}
    wait_s = slow.decisions[0].time_s - quick.decisions[0].time_s
    assert wait_s == pytest.approx(2.0, abs=0.11)


@pytest.mark.release
def test_without_words_nobody_overtakes_the_cyclists(shown):
    result = shown(CYCLISTS).result
    assert (result.status, result.plans_accepted, result.infractions) == ("Completed", 0, {})


@pytest.mark.slow
def test_demo_guided_ego_overtakes_cyclists_once(shown):
    """With the passenger's guidance, the ego overtakes the cyclists once."""
    log = shown(CYCLISTS, GUIDED, oncoming=3, road="one_lane")  # as above: one drive does for both tests
    assert (log.result.status, log.result.plans_accepted, log.result.infractions) == ("Completed", 1, {})
    (decided,) = accepted(log)
    assert decided.trigger == "guidance" and decided.time_s >= 8.0
    assert any("please overtake them" in e.text for e in log.events if e.kind == "guidance")


@pytest.mark.slow
def test_oncoming_cars_are_let_by_before_their_lane_is_borrowed(shown):
    log = shown(oncoming=3, road="one_lane")
    assert (log.result.status, log.result.infractions, log.result.plans_accepted) == ("Completed", {}, 1)
    assert sum(a.role == "traffic" for a in log.actors) == 3
    waits = [d.decision["analysis"]["wait"] for d in log.decisions]
    assert "yield" in waits and log.decisions[-1].verdict == "accepted"


@pytest.mark.release
def test_demo_user_driver_needs_solver_to_pass_parked_car(shown):
    """A driver of the user's stays behind the parked car alone, and passes it with the solver."""
    own = {"driver": "examples.own_driver:PurePursuit"}
    alone, helped = shown(arm=ALONE, **own), shown(**own)
    assert (alone.driver, helped.driver) == (own["driver"],) * 2
    assert (alone.result.status, alone.result.immobilizations) == ("Failed - Agent got blocked", 1)
    assert alone.result.decisions == 0 and alone.result.route_completion_pct < 50.0
    assert helped.result.status == "Completed" and helped.result.plans_accepted >= 1
    assert not [kind for log in (alone, helped) for kind in log.result.infractions if kind.startswith("collision")]


def test_demo_running_server_is_used_and_keeps_clock(slow_elsewhere):
    """A server that runs already is used and keeps its own clock afterwards."""
    log, own_clock = slow_elsewhere
    assert log.result.status == "Completed"
    assert own_clock


def test_what_cannot_be_shown_is_told_before_anything_is_driven(tmp_path: Path):
    with pytest.raises(ServerError, match="'Nowhere'"):
        demo(DemoSpec(map_name="Nowhere", out=tmp_path), lambda _: None)
    with pytest.raises(StreetError, match="use another map"):
        demo(DemoSpec(map_name="motorway", road="one_lane", out=tmp_path), lambda _: None)


def test_demo_invalid_driver_fails_before_any_run(tmp_path: Path):
    """A driver that does not exist is reported before any run."""
    with pytest.raises(SystemSpecError, match=r"examples\.own_driver"):
        demo(DemoSpec(driver="examples.own_driver:Missing", out=tmp_path), lambda _: None)


def test_a_drive_that_fails_is_told_with_its_reason(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    lines = ["class Quits:", "    def __init__(self, vehicle, carla_map): ...", "    def set_route(self, route): ..."]
    lines += ["    def run_step(self):", "        raise ValueError('my own mistake')"]
    (tmp_path / "agent_that_quits.py").write_text("\n".join(lines), encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(RunError, match="my own mistake"):
        demo(DemoSpec(driver="agent_that_quits:Quits", out=tmp_path / "out"), lambda _: None)
