"""What is recorded comes back; a file that cannot be used is named."""

from __future__ import annotations

import logging
from pathlib import Path

import numpy as np
import pytest

from carlette.blueprints import AttributeType
from carlette.errors import RequestError
from carlette.geometry import Pose, Vector
from carlette.recorder import LogRecorder, Replay, ReplayOptions, read_tape, report
from carlette.recorder.log_file import MAGIC
from carlette.world.spawn import spawn
from carlette.world.traffic_lights import Color
from carlette.world.world import World
from straight import add, launch, straight_world

TICKS = 40


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[tuple[Vector, Vector]], tuple[int, int]]:
    """A car that runs into a standing one, and a walker who leaves: the log, the cars' ways, their ids."""
    world = straight_world()
    hero = {"role_name": (AttributeType.STRING, "hero")}
    car, other = spawn(world, "vehicle.tesla.model3", hero, Pose(Vector(50.0, 1.75))), add(world, x=62.0)
    walker = add(world, "walker.pedestrian.0001", x=80.0, z=1.0)
    recorder = LogRecorder(tmp_path_factory.mktemp("logs") / "run.log", world)
    launch(world, car, 12.0)
    ways = []
    for tick in range(TICKS):
        if tick == 10:
            world.remove(walker.id)
        world.tick()
        recorder.note(world)
        ways.append((world.pose(car).location, world.pose(other).location))
    recorder.stop()
    return recorder.path, ways, (car.id, other.id)


def test_a_log_holds_every_tick_and_every_actor(recorded) -> None:
    path, ways, (car, other) = recorded
    tape = read_tape(path)
    assert len(tape.frames) == TICKS + 1
    assert tape.duration_s == pytest.approx(TICKS * 0.05, abs=1e-6)
    assert tape.entries[car].role == "hero"
    last = tape.frames[-1]
    for number, place in zip((car, other), ways[-1], strict=True):
        motion = last.motion[np.flatnonzero(last.ids == number)[0]]
        assert motion[:3] == pytest.approx(place, abs=1e-4)


def test_a_replay_leads_new_actors_along_the_recorded_ways(recorded) -> None:
    path, ways, _ = recorded
    world = straight_world()
    replay = Replay(read_tape(path), world)
    replay.step(world)
    found = []
    while not replay.is_over:
        world.tick()
        replay.step(world)
        cars = [actor for actor in world.actors.values() if actor.type_id == "vehicle.tesla.model3"]
        found.append(tuple(world.pose(car).location for car in cars))
    assert np.array(found) == pytest.approx(np.array(ways), abs=0.02)
    assert not any(actor.type_id.startswith("walker.") for actor in world.actors.values())
    replay.stop(world, keep_actors=False)
    assert not any(actor.type_id.startswith("vehicle.") for actor in world.actors.values())


def test_replay_takes_over_existing_actors_and_returns_them(recorded) -> None:
    """A replay moves actors that still exist, without physics, and returns them when it stops."""
    path, _, (car, other) = recorded
    world = straight_world()
    mine = [add(world, x=x) for x in (200.0, 220.0)]
    assert [item.id for item in mine] == [car, other]
    replay = Replay(read_tape(path), world, start_s=1.0)
    replay.step(world)
    assert world.pose(mine[0]).location.x < 70.0 and not world.bodies.simulated[mine[0].row]
    replay.stop(world, keep_actors=False)
    assert mine[0].id in world.actors and world.bodies.simulated[mine[0].row]


def test_the_hero_can_be_left_out_and_time_run_faster(recorded) -> None:
    path, _, (car, _) = recorded
    world = straight_world()
    replay = Replay(read_tape(path), world, options=ReplayOptions(time_factor=4.0, ignores_hero=True))
    steps = 0
    while not replay.is_over:
        replay.step(world)
        steps += 1
    assert steps == pytest.approx(TICKS / 4 + 1, abs=1)
    assert sum(actor.type_id == "vehicle.tesla.model3" for actor in world.actors.values()) == 1
    assert read_tape(path).entries[car].role == "hero"


def test_replay_plays_part_counted_from_either_end(recorded) -> None:
    """A part of a log can be replayed, with a start that counts from the beginning or from the end."""
    tape, world = read_tape(recorded[0]), straight_world()
    part = Replay(tape, world, start_s=0.5, duration_s=0.5)
    assert (part.time_s, part.end_s) == (0.5, 1.0)
    assert Replay(tape, world, start_s=-0.5).time_s == pytest.approx(tape.duration_s - 0.5)


def test_lights_show_what_they_showed(tmp_path: Path, town01: Path) -> None:
    from carlette.opendrive.map_file import load_map
    from carlette.opendrive.road_network import RoadNetwork

    roads = RoadNetwork(load_map(town01))
    world, again = World(roads), World(roads)
    light = next(actor for actor in world.actors.values() if actor.type_id == "traffic.traffic_light")
    recorder = LogRecorder(tmp_path / "lights.log", world)
    world.signals.set_color(light.index, Color.OFF)
    world.tick()
    recorder.note(world)
    recorder.stop()
    replay = Replay(read_tape(recorder.path), again, start_s=-0.0001)
    replay.step(again)
    replay.step(again)
    assert again.signals.lights.color[light.index] == Color.OFF


def test_the_texts_tell_map_length_collisions_and_who_stood(recorded) -> None:
    path, _, (car, other) = recorded
    tape = read_tape(path)
    info = report.file_info(tape, show_all=True)
    assert "Map: straight" in info and f"Frames: {TICKS + 1}" in info and "Duration: 2 seconds" in info
    assert f"Create {car}: vehicle.tesla.model3" in info and "Destroy" in info
    hits = report.collisions(tape, "h", "v").splitlines()[5:-3]
    assert len(hits) >= 1 and all(f"{car} vehicle" in hit and f"{other} vehicle" in hit for hit in hits)
    assert len(report.collisions(tape, "w", "a").splitlines()) == len(report.collisions(tape, "w", "w").splitlines())
    assert f"{other} vehicle.tesla.model3" in report.blocked(tape, 0.3, 0.5)


def test_recorder_full_disk_ends_recording_with_one_log_line(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """A full disk ends the recording with one line in the log, and the simulation continues."""
    world = straight_world()
    add(world)
    recorder = LogRecorder(tmp_path / "full.log", world)
    recorder._file = Path("/dev/full").open("wb")  # noqa: SIM115
    with caplog.at_level(logging.ERROR):
        for _ in range(3):
            world.tick()
            recorder.note(world)
    recorder.stop()
    assert [record.getMessage() for record in caplog.records] == [
        f"recording to '{recorder.path}' ends here: No space left on device; the simulation goes on"
    ]


def test_recorder_truncated_log_is_read_up_to_the_cut(recorded, tmp_path: Path) -> None:
    """A truncated log is read up to the last complete frame."""
    cut = tmp_path / "cut.log"
    cut.write_bytes(recorded[0].read_bytes()[:-50])
    assert len(read_tape(cut).frames) == TICKS


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (None, "not found on server"),
        (b"CARLA_RECORDER", "is not a carlette log"),
        (MAGIC + b"\xc1\xc1", "is damaged"),
        (MAGIC + b"\x93\xa5frame\x01\x02", "is damaged"),
    ],
)
def test_recorder_invalid_file_is_rejected_with_its_problem(
    tmp_path: Path, content: bytes | None, problem: str
) -> None:
    """A file that is not a log is rejected, and the error names the file and the problem."""
    path = tmp_path / "other.log"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(RequestError, match=rf"other\.log.*{problem}"):
        read_tape(path)


@pytest.mark.parametrize("text", ["years of work", ""])
def test_a_file_of_somebody_else_is_never_overwritten(tmp_path: Path, text: str) -> None:
    theirs = tmp_path / "thesis.tex"
    theirs.write_text(text, encoding="utf-8")
    with pytest.raises(RequestError, match=r"thesis\.tex' exists and is not a carlette log"):
        LogRecorder(theirs, straight_world())
    assert theirs.read_text(encoding="utf-8") == text


def test_recorder_missing_folder_and_wrong_map_are_rejected(recorded, tmp_path: Path) -> None:
    """A recording into a missing folder and a replay of a log of another map are rejected."""
    with pytest.raises(RequestError, match="cannot record to"):
        LogRecorder(tmp_path / "no" / "folder.log", straight_world())
    tape = read_tape(recorded[0])
    tape.map_name = "Town99"
    with pytest.raises(RequestError, match=r"of map Town99, but straight is loaded; call load_world"):
        Replay(tape, straight_world())
