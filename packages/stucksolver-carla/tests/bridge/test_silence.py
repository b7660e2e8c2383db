"""In silence the driver is told what was proven to be safe without the solver; at nonsense it is told to stand."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scripted import scripted
from test_orders import ANYTHING, FOLLOW, GOOD, spoilt

from stucksolver.plan.directive import EXPIRES_TICKS
from stucksolver_bridge import SolverError, recovery_client

LIVE, LOCKSTEP = {"clock": "wall"}, {"clock": "lockstep"}
GO = {"directive": {"kind": "continue"}, "orders": [["release", None]]}
DRIVE = GOOD[1]
COMMITTED = {
    "directive": {
        **DRIVE["directive"],
        "path": [{**point, "no_stop": True} for point in DRIVE["directive"]["path"]],
    },
    "orders": DRIVE["orders"],
}
CARLA = SimpleNamespace(VehicleLightState=int)


class Car:
    """Moves along its lane as fast as it is let."""

    def __init__(self):
        self.x, self.speed, self.lights = 0.0, 4.0, 0

    def get_location(self):
        return SimpleNamespace(x=self.x, y=-0.5)

    def get_velocity(self):
        return SimpleNamespace(x=self.speed, y=0.0)

    def get_light_state(self):
        return self.lights

    def set_light_state(self, state):
        self.lights = state


class Driver:
    """Does what it is told, and writes it down."""

    route, acceleration_mps2 = (), 3.0

    def __init__(self):
        self.vehicle, self.told, self.path_left_m = Car(), [], 30.0

    def follow(self, path, reverse, ignore):
        assert path == FOLLOW["path"] and ignore == frozenset(FOLLOW["ignore"])
        self.told.append("follow")

    def hold(self, brake_mps2=None):
        self.told.append(("hold", brake_mps2))

    def release(self):
        self.told.append("release")

    def run_step(self):
        stops = bool(self.told) and self.told[-1] not in ("follow", "release")
        self.vehicle.speed = max(self.vehicle.speed - 0.15, 0.0) if stops else 4.0
        self.vehicle.x += 0.05 * self.vehicle.speed
        self.path_left_m = max(29.0 - self.vehicle.x, 0.0)
        return "control"


@pytest.fixture
def made(tmp_path, monkeypatch):
    facts = SimpleNamespace(opening=lambda *_: {}, tick=lambda: {"time": 1.0}, give=None)
    monkeypatch.setattr(recovery_client, "WorldData", lambda *_: facts)
    started = []

    def make(clock, answers, end, **options):
        python, told = scripted(tmp_path, answers, end), []
        one = recovery_client.RecoveryClient(Driver(), None, CARLA, clock, python, on_event=told.append, **options)
        one.told = told
        started.append(one)
        return one

    yield make
    for item in started:
        item.solver.process.kill()
        item.close()


def steps(agent, count):
    """Runs the control loop; a live one has the time to hear an answer."""
    for _ in range(count):
        assert agent.run_step() == "control"
        if agent.solver.live:
            agent.solver.process.poll()


@pytest.mark.parametrize("end", ["silent", "trickles"])
def test_silence_stops_on_path_then_driver_takes_over(made, end):
    """Without answers, the ego stops on its path; then the driver drives by itself."""
    one = made(LIVE, [DRIVE], end, tick_s=20.0)
    steps(one, 1)
    assert one._driver.told == ["follow"]
    one.solver._exchange._wait_s = 0.001
    steps(one, EXPIRES_TICKS - 1)
    assert one._driver.told == ["follow"], "good for so long"
    steps(one, 1)
    assert one._driver.told == ["follow", ("hold", None)]
    steps(one, 60)
    assert one._driver.told == ["follow", ("hold", None), "release"]
    assert one.directive == {"kind": "continue"}
    assert [event["kind"] for event in one.told].count("order_expired") == 1
    assert one.solver.alive, "it may come back"


@pytest.mark.parametrize("end", ["floods", "floods old", "floods any", "trickles old", "reorders"])
def test_run_step_answers_to_other_ticks_renew_no_lease(made, end, capfd):
    """A process whose solver sleeps goes on sending: it stops, hands back, and the fault is one line."""
    one = made(LIVE, [DRIVE], end, tick_s=20.0)
    steps(one, 1)
    assert one._driver.told == ["follow"]
    one.solver._exchange._wait_s = 0.01
    steps(one, EXPIRES_TICKS)
    assert one._driver.told == ["follow", ("hold", None)], "at the latest when the order has expired"
    steps(one, 60)
    assert one._driver.told == ["follow", ("hold", None), "release"]
    assert capfd.readouterr().err.count("an answer to another tick was dropped") <= 1


@pytest.mark.parametrize("end", ["floods", "floods old", "floods any"])
def test_run_step_flood_of_other_answers_ends_the_solver(made, end, capfd):
    one = made(LOCKSTEP, [DRIVE], end)
    steps(one, 70)
    assert not one.solver.alive and "belong to no tick" in one.solver.fault
    assert one._driver.told == ["follow", ("hold", None), "release"]
    assert capfd.readouterr().err.count("the solver has stopped") == 1


def test_run_step_doubled_answers_are_used_once_and_silence_expires(made):
    """Each answer comes three times for thirty ticks; the spare ones do not bridge the silence after them."""
    one = made(LIVE, [DRIVE], "doubles", tick_s=20.0)
    steps(one, 31)
    assert one._driver.told == ["follow"] and one.solver.alive
    one.solver._exchange._wait_s = 0.01
    steps(one, EXPIRES_TICKS + 1)
    assert one._driver.told == ["follow", ("hold", None)]


@pytest.mark.parametrize("version", [None, 0, 1, 2, 4, "3", True, [3], 10**400, "x" * 1000])
def test_solver_process_other_version_is_one_line(made, version):
    with pytest.raises(SolverError) as error:
        made(LIVE, [], [version])
    assert "version" in str(error.value) and "install both from the same release" in str(error.value)
    assert "\n" not in str(error.value) and len(str(error.value)) < 200


@pytest.mark.parametrize("clock", [LIVE, LOCKSTEP])
@pytest.mark.parametrize("end", ["dies", "babbles"])
def test_a_solver_that_is_gone_is_not_waited_for(made, clock, end, capfd):
    one = made(clock, [DRIVE], end, tick_s=20.0)
    steps(one, 2)
    assert not one.solver.alive
    assert one._driver.told == ["follow", ("hold", None)]
    steps(one, 60)
    assert one._driver.told[-1] == "release"
    assert capfd.readouterr().err.count("drives by itself") == 1


@pytest.mark.parametrize("end", ["dies", "silent"])
def test_past_the_commit_point_the_path_is_finished(made, end):
    one = made(LIVE, [COMMITTED], end, tick_s=20.0)
    steps(one, 1)
    one.solver._exchange._wait_s = 0.001 if end == "silent" else 10.0
    while one._driver.path_left_m > 5.0:
        steps(one, 1)
        assert one._driver.told == ["follow"]
    steps(one, 20)
    assert one._driver.told == ["follow", "release"]


def test_silence_restores_lights_before_intervention(made):
    """The lights are restored when the solver is gone and cannot switch them off."""
    hazards = {"directive": {"kind": "execute", "behavior": {"name": "hazard_lights"}}}
    one = made(LOCKSTEP, [{**hazards, "orders": [["lights", 48], ["hold", 3.0]]}], "dies")
    steps(one, 1)
    assert one._vehicle.lights == 48 and one._driver.told == [("hold", 3.0)]
    steps(one, 60)
    assert one._vehicle.lights == 0 and one._driver.told == [("hold", 3.0), "release"]


def test_a_safe_stop_is_kept_when_the_solver_is_gone(made):
    stop = {"directive": {"kind": "safe_stop", "reason": "blocked"}, "orders": [["lights", 48], ["hold", None]]}
    one = made(LOCKSTEP, [stop], "dies")
    steps(one, 100)
    assert one._driver.told == [("hold", None)] and one._vehicle.lights == 48


@pytest.mark.parametrize("end", ["silent", "trickles"])
def test_silence_in_lockstep_ends_run_with_one_error(made, end):
    """Where the world waits, a time limit ends the run with one error."""
    one = made(LOCKSTEP, [DRIVE], end)
    steps(one, 1)
    one.solver._exchange._limit_s = 0.3  # from here on: a busy machine may need longer for a good answer
    with pytest.raises(SolverError, match=r"kept the world waiting: no answer within 0\.3 s.*answer_limit_s"):
        one.run_step()
    assert not one.solver.alive and one.fault


def test_renewed_directive_is_driven_without_limit(made):
    """A directive that is renewed is driven for as long as it takes."""
    one = made(LOCKSTEP, [DRIVE], "goes on")
    steps(one, 100)
    assert one._driver.told == ["follow"]


def test_a_late_order_is_good_for_so_much_less(told_by):
    one = told_by(DRIVE)
    one.solver.late_ticks = 4
    one.run_step()
    one.solver.step = lambda *_: None
    steps(one, EXPIRES_TICKS - 5)
    assert one._driver.told == ["follow"]
    steps(one, 1)
    assert one._driver.told == ["follow", ("hold", None)]


def test_what_a_listener_raises_is_its_own_and_no_order(told_by):
    def full(event):
        raise OSError("no space left on the device")

    one = told_by({**DRIVE, "events": [{"kind": "started"}]})
    one._on_event = full
    with pytest.raises(OSError, match="no space"):
        one.run_step()
    steps(one, 1)
    assert one._driver.told == ["follow"]


# ---- nonsense


class Says:
    """A solver in this process that says one thing after the other."""

    alive, fault, live, late_ticks = True, None, False, 0

    def __init__(self, *_, **__):
        self.answers, self.ticks = [], []

    def step(self, tick, give):
        self.ticks.append(tick)
        return self.answers.pop(0) if self.answers else {}


@pytest.fixture
def told_by(monkeypatch):
    facts = SimpleNamespace(opening=lambda *_: {}, tick=lambda: {"time": 1.0}, give=None)
    monkeypatch.setattr(recovery_client, "WorldData", lambda *_: facts)
    monkeypatch.setattr(recovery_client, "SolverProcess", Says)

    def make(*answers):
        one = recovery_client.RecoveryClient(Driver(), None, CARLA, {}, "python")
        one.solver.answers += answers
        return one

    return make


@pytest.mark.parametrize("answer", list(spoilt()))
def test_nonsense_is_stood_still_at_and_said_once(told_by, answer, capsys):
    one = told_by(DRIVE, answer, answer, answer)
    steps(one, 4)
    assert one._driver.told == ["follow", ("hold", None)]
    assert capsys.readouterr().err.count("the vehicle stops") == 1
    steps(one, 100)
    assert one._driver.told[-1] == ("hold", None) and one._vehicle.speed == 0.0, "for as long as nothing else is said"
    assert one.solver.ticks[-1]["again"], "it is asked to say it again"
    one.solver.answers.append(GO)
    steps(one, 2)
    assert one._driver.told[-1] == "release"
    assert "again" not in one.solver.ticks[-1]


def test_malformed_answer_past_commit_point_finishes_path(told_by):
    """After a malformed answer past the commit point, the path is finished first."""
    one = told_by(COMMITTED, {"orders": "none"})
    steps(one, 60)
    assert one._driver.told == ["follow"]


def test_nonsense_while_nothing_is_performed_is_stood_still_at(told_by):
    one = told_by(GO, {"directive": 7})
    steps(one, 40)
    assert one._driver.told == ["release", ("hold", None)]


def test_what_fails_all_the_same_is_stood_still_at(told_by, capsys):
    one = told_by(DRIVE)
    one._driver.follow = lambda *_: 1 / 0
    steps(one, 3)
    assert one._driver.told == [("hold", None)]
    assert "ZeroDivisionError" in capsys.readouterr().err


@pytest.mark.integration
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.lists(ANYTHING | st.sampled_from([*GOOD[:4], GO]), max_size=6))
def test_whatever_is_said_the_agents_loop_goes_on(told_by, answers):
    one = told_by(*answers)
    steps(one, len(answers) + 20)
    for brake in (told[1] for told in one._driver.told if isinstance(told, tuple)):
        assert brake is None or math.isfinite(brake)
