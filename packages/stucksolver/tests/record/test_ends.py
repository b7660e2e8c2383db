"""How a record ends: with its last line where the run ended, without one where it broke off."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from stucksolver.commands import main
from stucksolver.record import Recorder, RecordError, record_file, replay
from stucksolver.record.recorder import RUN_ENDED
from worlds import World, drive, straight_road, thing

UNDER_WAY_S = 8.0
"""Long enough for a plan to have begun, too short for it to be over."""


def in_front_of_a_parked_car() -> World:
    return World(straight_road(), [thing("lead", 75.0)], x=66.0)


def last_line(file):
    return json.loads(file.read_bytes().splitlines()[-1])


@pytest.fixture(scope="module")
def broken(tmp_path_factory):
    """A record whose run died under way."""
    recorder = Recorder(tmp_path_factory.mktemp("broken"))
    with pytest.raises(ZeroDivisionError), recorder:
        drive(in_front_of_a_parked_car(), UNDER_WAY_S, record=recorder)
        raise ZeroDivisionError
    (file,) = recorder.files
    return file


@pytest.mark.integration
def test_record_run_ends_in_intervention_is_complete(tmp_path):
    """A run that ends during an intervention writes the end of its record."""
    with Recorder(tmp_path) as recorder:
        drive(in_front_of_a_parked_car(), UNDER_WAY_S, record=recorder)
    (file,) = recorder.files
    assert last_line(file)["kind"] == "end"
    report = replay(file)
    assert report.matches and report.ended == RUN_ENDED
    assert main(["replay", str(file)]) == 0


@pytest.mark.integration
def test_record_run_dies_keeps_steps_without_end(broken):
    """A run that dies leaves a record without an end, but with every step before."""
    assert last_line(broken)["kind"] == "step"
    report = replay(broken)
    assert report.matches and report.ended is None and report.ticks > 20


def test_a_record_that_breaks_off_is_no_success(broken, capsys):
    assert main(["replay", str(broken)]) == 1
    assert "incomplete: the run failed" in capsys.readouterr().out


@pytest.mark.integration
def test_a_script_gets_each_replay_as_json(broken, tmp_path, capsys):
    with Recorder(tmp_path) as recorder:
        drive(in_front_of_a_parked_car(), 30.0, record=recorder)
    (file,) = recorder.files
    assert main(["replay", str(broken), str(file), "--json"]) == 1
    first, second = json.loads(capsys.readouterr().out)
    assert (first["file"], first["ended"], first["matches"]) == (str(broken), None, True)
    assert (second["file"], second["ended"], second["findings"]) == (str(file), last_line(file)["how"], [])
    assert second["lines"] == len(file.read_text(encoding="utf-8").splitlines()) and second["ticks"] > 0
    heads = tmp_path / "heads.txt"
    assert main(["replay", str(file), "--save-heads", str(heads), "--json"]) == 0
    [saved] = json.loads(capsys.readouterr().out)
    assert main(["replay", "--anchors", str(heads), "--json"]) == 0
    [checked] = json.loads(capsys.readouterr().out)
    assert (saved["anchored_line"], checked["anchored_line"]) == (None, second["lines"])


@pytest.mark.integration
def test_replay_truncated_among_complete_records_fails(broken, tmp_path):
    """One truncated record among complete ones makes the exit code 1."""
    with Recorder(tmp_path) as recorder:
        drive(in_front_of_a_parked_car(), 30.0, record=recorder)
    assert main(["replay", *map(str, recorder.files)]) == 0
    assert main(["replay", str(broken), *map(str, recorder.files)]) == 1


@pytest.mark.integration
def test_an_intervention_that_was_over_keeps_its_own_end(tmp_path):
    with Recorder(tmp_path) as recorder:
        drive(in_front_of_a_parked_car(), 30.0, record=recorder)
    assert [last_line(file)["how"] for file in recorder.files] == ["the vehicle is on its way"]


def test_the_end_of_a_run_without_interventions_leaves_no_file(tmp_path):
    with Recorder(tmp_path) as recorder:
        drive(World(straight_road()), 5.0, record=recorder)
    assert list(tmp_path.iterdir()) == []


def test_record_end_not_writable_is_kept_as_error(tmp_path, monkeypatch):
    """If the last line cannot be written, the recorder has the error afterwards."""

    def full(self, how):
        raise RecordError("cannot write it: No space left on device; make room")

    monkeypatch.setattr(record_file.RecordFile, "end", full)
    with Recorder(tmp_path) as recorder:
        drive(in_front_of_a_parked_car(), UNDER_WAY_S, record=recorder)
    assert "No space left" in str(recorder.error)


class Seat:
    """A stack as an evaluation's arm has it, in a world without a simulator."""

    def __init__(self) -> None:
        self.world = in_front_of_a_parked_car()
        self.status, self.surroundings, self.perform = self.world.status, self.world.surroundings, self.world.drive

    def in_map_frame(self, directive):
        return directive


def drive_an_arm(recorder):
    """Until the route is over, which is before the plan is."""
    pytest.importorskip("carla")
    from stucksolver.solver import StuckSolver
    from stucksolver_eval.systems.solver_system import SolverSystem
    from stucksolver_eval.systems.system_under_test import TickInfo

    seat = Seat()

    def make(listener):
        return StuckSolver(seat.world.scene, clock="lockstep", on_event=listener, record=recorder)

    arm = SolverSystem(seat, [], make, recorder)
    while seat.world.time_s < UNDER_WAY_S:
        arm.step(TickInfo(seat.world.time_s, seat.world.speed, seat.world.x))
    arm.close(seat.world.time_s)


@pytest.mark.integration
def test_record_route_ends_in_intervention_is_complete(tmp_path):
    """A route that ends during an intervention writes the end of its record."""
    recorder = Recorder(tmp_path)
    drive_an_arm(recorder)
    (file,) = recorder.files
    assert replay(file).ended == RUN_ENDED


def test_route_record_not_writable_raises_record_error():
    """A route whose record could not be written is not reported as driven."""
    with pytest.raises(RecordError, match="cannot write"):
        drive_an_arm(Recorder(Path("/dev/full/nowhere")))
