"""The record: one file for each intervention, unbroken, compact, and derived again to the last verdict."""

from __future__ import annotations

import base64
import json
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from stucksolver.commands import main
from stucksolver.guard import Guard, GuardPolicy
from stucksolver.guard.policy import PeoplePolicy, RssPolicy, StoppingPolicy
from stucksolver.plan import RecoveryPlan
from stucksolver.plan.behaviors import Wait
from stucksolver.reasoners import ReasonerAnswer, ReasonerTrace
from stucksolver.reasoners.faulty import make_faulty
from stucksolver.record import Recorder, RecordError, replay
from stucksolver.record.hash_chain import ChainWriter, read_chain
from stucksolver.record.surroundings_delta import DeltaDecoder, DeltaEncoder
from stucksolver.scene import CameraImage, LineKind, ObservedSign, SignWord
from stucksolver.solver import EventKind
from worlds import LANE_M, World, drive, red_light, straight_road, stubborn, thing

TWO_WAY = straight_road()


CLOSED = ObservedSign(word=SignWord.ROAD_CLOSED, object_id="lead")


def recorded(folder, world=None, seconds=30.0, **options):
    """Drives, and gives what was seen and the files."""
    world = world or World(TWO_WAY, [thing("lead", 75.0)], x=66.0)
    with Recorder(folder) as recorder:
        seen = drive(world, seconds, record=recorder, **options)
    assert recorder.error is None
    return seen, recorder.files


@pytest.fixture(scope="module")
def one(tmp_path_factory):
    """A record of a parked car that was passed."""
    _, (file,) = recorded(tmp_path_factory.mktemp("record"))
    return file


def lines(file):
    return [json.loads(line) for line in file.read_bytes().splitlines()]


def told(line, kind):
    """What a line tells of this kind: `event`, `judged` or `tick`."""
    return [item[kind] for item in line.get("told", ()) if kind in item]


@pytest.mark.integration
def test_a_recovery_leaves_one_file_that_matches(one):
    report = replay(one)
    assert report.matches
    assert report.ended == "the vehicle is on its way"
    assert report.decisions == report.plans == 1
    assert report.ticks > 100
    assert report.underivable == 0


@pytest.mark.integration
def test_record_sign_words_are_kept_and_replay_matches(tmp_path):
    """Words on signs are stored in the record and change nothing in the replay."""

    class Signed(World):
        def scene(self, surroundings=None):
            return super().scene(surroundings).model_copy(update={"signs": (CLOSED,)})

    _, (file,) = recorded(tmp_path, Signed(TWO_WAY, [thing("lead", 75.0)], x=66.0))
    assert CLOSED.model_dump_json() in file.read_text(encoding="utf-8")
    assert replay(file).matches


def test_it_begins_with_all_that_decides_how_it_goes(one):
    first, last = lines(one)[0], lines(one)[-1]
    assert first["kind"] == "begin" and last["kind"] == "end"
    assert first["versions"].keys() >= {"stucksolver", "python", "numpy"}
    assert first["clock"] == "lockstep"
    assert first["reasoners"] == {"reasoner": "search"}
    assert first["ladder"]["name"] == "default"
    assert first["policy"] == GuardPolicy().model_dump(mode="json")
    assert first["policy"]["clearance"]["standing_gap_m"] == 0.3


OWN = GuardPolicy(people=PeoplePolicy(step_mps=1.1), rss=RssPolicy(reaction_s=0.8), stopping=StoppingPolicy(lag_s=0.5))


def rewritten(file, folder, change):
    """The same record with another first line, in an unbroken chain."""
    for number, data in read_chain(file):
        if number == 1:
            copy = ChainWriter(folder / "intervention-0001.jsonl")
            change(data["policy"])
        copy.write(data)
    copy.close()
    return copy.path


@pytest.mark.integration
def test_a_record_is_judged_by_its_own_policy(tmp_path):
    _, (file,) = recorded(tmp_path / "own", guard=Guard(OWN))
    assert GuardPolicy.model_validate(lines(file)[0]["policy"]) == OWN
    assert replay(file).findings == []


def test_with_other_numbers_the_verdicts_come_out_otherwise(one, tmp_path):
    def stricter(policy):
        policy["clearance"]["standing_gap_m"] = 3.0

    findings = replay(rewritten(one, tmp_path, stricter)).findings
    assert findings and findings[0].what.startswith("verdict")
    assert findings[0].recorded == "accepted" and "gap" in findings[0].derived


@pytest.mark.parametrize("part", ["clearance", "waits"])
def test_replay_incomplete_policy_is_rejected(part, one, tmp_path):
    """An incomplete guard policy is rejected and never completed with defaults."""
    with pytest.raises(RecordError, match=rf"intervention-0001.jsonl: the guard's policy is .*{part}"):
        replay(rewritten(one, tmp_path, lambda policy: policy[part].popitem()))


@pytest.mark.parametrize("part", ["clearance", "waits"])
def test_a_number_that_nobody_here_knows_is_refused(part, one, tmp_path):
    with pytest.raises(RecordError, match=rf"policy .*{part}.unheard_of_m"):
        replay(rewritten(one, tmp_path, lambda policy: policy[part].update(unheard_of_m=1.0)))


def test_trigger_scene_decision_verdict_and_outcome_are_there(one):
    steps = [line for line in lines(one) if line["kind"] == "step"]
    events = [e for step in steps for e in told(step, "event")]
    assert [e["kind"] for e in events][:3] == ["triggered", "decided", "started"]
    assert steps[0]["asked"]["scene"]["objects"][0]["id"] == "lead"
    assert steps[1]["in"]["answer"]["decision"]["plan"]["behaviors"][-1]["name"] == "borrow_oncoming_lane"
    assert events[1]["reasoner"] == "search"
    assert events[-1]["kind"] == "closed"


def test_legitimate_waits_leave_no_file(tmp_path):
    world = World(TWO_WAY, controls=(red_light(8.0),), cruise_mps=0.0)
    _, files = recorded(tmp_path, world, 20.0)
    assert files == [] and list(tmp_path.iterdir()) == []


@pytest.mark.integration
def test_each_intervention_has_a_file_and_none_is_written_over(tmp_path):
    world = World(TWO_WAY, [thing("lead", 75.0), thing("second", 150.0)], x=66.0, sight_m=500.0)
    _, files = recorded(tmp_path, world, 45.0)
    assert len(files) == 2
    recorded(tmp_path)
    assert len(list(tmp_path.glob("intervention-*.jsonl"))) == 3
    assert all(replay(file).matches for file in tmp_path.glob("*.jsonl"))


HARD = {
    "refused for the oncoming traffic": {
        "world": lambda: World(
            TWO_WAY,
            [thing("lead", 75.0), *(thing(f"c{k}", 140.0 + 50 * k, LANE_M, speed=-9.0) for k in range(3))],
            x=66.0,
        )
    },
    "aborted before the commit point": {"world": lambda: World(TWO_WAY, [thing("lead", 75.0)], x=66.0, cruise_mps=0.0)},
    "denied a solid line": {
        "world": lambda: World(straight_road(oncoming=LineKind.SOLID), [thing("lead", 75.0)], x=60.0, cruise_mps=0.0)
    },
}


@pytest.mark.integration
@pytest.mark.parametrize("case", HARD.values(), ids=HARD)
def test_refusals_aborts_and_repairs_are_derived_again(case, tmp_path):
    world = case["world"]()
    if world.cruise_mps == 0.0 and world.x == 66.0:
        world._along = lambda directive: None
    _, files = recorded(tmp_path, world, 25.0, ladder=stubborn())
    report = replay(files[0])
    assert report.findings == []
    assert report.plans >= 1


@pytest.mark.integration
@pytest.mark.parametrize("name", ["random", "always_left", "contradictory", "late"])
def test_the_answers_of_other_reasoners_are_parsed_again(name, tmp_path):
    _, files = recorded(tmp_path, seconds=12.0, reasoner=make_faulty(name, seed=3))
    report = replay(files[0])
    assert report.findings == []
    assert report.underivable == 0 and report.decisions >= 1


@pytest.mark.integration
def test_a_plan_that_is_not_repeated_is_derived_again(tmp_path):
    """Waiting is done once; the same again is refused, and so it is offline."""

    class Waits:
        name = "rules"

        def decide(self, request):
            decision = make_faulty("contradictory").decide(request).decision
            plan = RecoveryPlan(behaviors=(Wait(duration_s=1.0),))
            decision = decision.model_copy(update={"plan": plan})
            return ReasonerAnswer(decision, self.name, ReasonerTrace(answers=(decision.model_dump_json(),)))

    seen, files = recorded(tmp_path, seconds=15.0, reasoner=Waits())
    assert EventKind.INEFFECTIVE in seen.kinds()
    report = replay(files[0])
    assert report.findings == [] and report.plans > 1


@pytest.mark.integration
def test_words_that_take_a_plan_back_are_derived_again(tmp_path):
    world = World(TWO_WAY, [thing("lead", 100.0)], x=80.0)
    seen, files = recorded(tmp_path, world, 25.0, words={6.0: "no, stop, wait"})
    assert EventKind.GUIDANCE in seen.kinds()
    assert all(replay(file).findings == [] for file in files)


@pytest.mark.integration
def test_replay_different_verdict_is_reported_with_line(one, tmp_path):
    """A verdict that the replay does not reproduce is reported with its line.

    The whole hash chain is written anew, as a forger would do.
    """
    forged = tmp_path / "forged.jsonl"
    writer = ChainWriter(forged)
    for _, data in read_chain(one):
        for judged in told(data, "judged"):
            judged["verdict"] = {"rejects": [{"code": "collision", "detail": "forged"}]}
        writer.write(data)
    writer.close()
    report = replay(forged)
    assert [f.what for f in report.findings] == ["verdict at acceptance"]
    assert told(lines(forged)[report.findings[0].line - 1], "judged")
    assert "forged" in report.findings[0].recorded


@settings(max_examples=60)
@given(data=st.data())
def test_any_changed_byte_is_found_in_its_line(one, data, tmp_path_factory):
    content = bytearray(one.read_bytes())
    at = data.draw(st.integers(0, len(content) - 1))
    content[at] ^= data.draw(st.integers(1, 255))
    changed = tmp_path_factory.mktemp("x") / "changed.jsonl"
    changed.write_bytes(content)
    line = one.read_bytes()[:at].count(b"\n") + 1
    with pytest.raises(RecordError, match=rf"line {line}: .*changed") as found:
        list(read_chain(changed))
    assert str(changed) in str(found.value)


@pytest.mark.parametrize("number", [0, 3, 40])
def test_a_line_taken_out_is_found(one, number, tmp_path):
    kept = one.read_bytes().splitlines(keepends=True)
    del kept[number]
    (tmp_path / "short.jsonl").write_bytes(b"".join(kept))
    with pytest.raises(RecordError, match=f"line {number + 1}: changed"):
        list(read_chain(tmp_path / "short.jsonl"))


@pytest.mark.integration
@pytest.mark.parametrize("share", [0.3, 0.6, 0.95])
def test_replay_truncated_record_matches_to_last_line(one, share, tmp_path):
    """A truncated record is valid up to its last whole line."""
    content = one.read_bytes()
    (tmp_path / "broken.jsonl").write_bytes(content[: int(len(content) * share)])
    report = replay(tmp_path / "broken.jsonl")
    assert report.ended is None
    assert report.matches and report.lines >= 3


@pytest.mark.integration
def test_record_image_file_is_verified_by_digest(tmp_path):
    """The image is a file beside the record; replay rejects a changed or missing image."""
    world = World(TWO_WAY, [thing("lead", 75.0)], x=66.0)
    scene, picture = world.scene, os.urandom(4000)
    image = CameraImage(width=320, height=180, jpeg=base64.b64encode(picture))
    world.scene = lambda surroundings=None: scene(surroundings).model_copy(update={"image": image})
    _, (file,) = recorded(tmp_path, world, 20.0)
    (stored,) = (tmp_path / "images").iterdir()
    assert stored.read_bytes() == picture
    assert [path.stat().st_mode & 0o777 for path in (stored, file)] == [0o600, 0o600]
    assert base64.b64encode(picture) not in file.read_bytes()
    assert replay(file).matches
    stored.write_bytes(picture[:-1])
    with pytest.raises(RecordError, match="was changed after writing"):
        replay(file)
    stored.unlink()
    with pytest.raises(RecordError, match="is missing: keep the folder"):
        replay(file)


def test_surroundings_come_back_to_the_last_bit():
    world = World(TWO_WAY, [thing("lead", 75.0), thing("car", 120.0, LANE_M, speed=-9.1 / 3)], speed=7.7 / 3)
    packer, unpacker = DeltaEncoder(), DeltaDecoder()
    for k in range(40):
        if k == 20:
            world.objects.append(thing("new", 90.1, 1 / 3))
        if k == 30:
            del world.objects[0]
        seen = world.surroundings()
        road = packer.new_road(seen)
        if road is not None:
            unpacker.add_road(road.model_dump(mode="json"))
        assert unpacker.unpack(json.loads(json.dumps(packer.pack(seen)))) == seen
        world.drive(None)


def test_record_writes_road_once_and_short_ticks(one):
    """The road is written once, and the median tick takes less than 500 bytes."""
    kinds = [line["kind"] for line in lines(one)]
    assert kinds.count("road") == 1
    ticks = [len(raw) for raw in one.read_bytes().splitlines() if b'"told":[{"tick":' in raw]
    assert len(ticks) > 100 and sorted(ticks)[len(ticks) // 2] < 500


# ---- failing


@pytest.mark.integration
def test_a_full_disk_ends_the_record_and_nothing_else():
    """/dev/full takes nothing: the system's own full disk."""
    full = Recorder(Path("/dev/full/nowhere"))
    world = World(TWO_WAY, [thing("lead", 75.0)], x=66.0)
    seen = drive(world, 25.0, record=full, every_tick=lambda world: time.sleep(0.0005))
    full.close()
    faults = seen.texts(EventKind.FAULT)
    assert len(faults) == 1 and "the record ends here: cannot write" in faults[0]
    assert EventKind.RECOVERED in seen.kinds()


@pytest.mark.integration
def test_what_was_written_before_the_disk_was_full_stays_whole(tmp_path):
    """A limit on the size of files stands for the disk: the system refuses to write on, in the middle of a line."""
    code = """
import resource, signal, sys
sys.path.insert(0, sys.argv[1])
from pathlib import Path
from worlds import World, drive, straight_road, thing
from stucksolver.record import Recorder
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (60_000, 60_000))
recorder = Recorder(Path(sys.argv[2]))
seen = drive(World(straight_road(), [thing("lead", 75.0)], x=66.0), 25.0, record=recorder)
recorder.close()
print([e.kind.value for e in seen.events if e.kind.value in ("fault", "recovered")], recorder.error)
"""
    core = Path(__file__).parents[1]
    done = subprocess.run(
        [sys.executable, "-c", code, str(core), str(tmp_path)], capture_output=True, text=True, timeout=60, check=True
    )
    assert "recovered" in done.stdout
    assert "cannot write" in done.stdout
    (file,) = tmp_path.glob("*.jsonl")
    assert file.read_bytes().endswith(b"\n")
    report = replay(file)
    assert report.matches and report.ended is None and report.ticks > 5


@pytest.mark.integration
def test_replay_command_reports_match_or_changed_line(one, tmp_path, capsys):
    """The command reports that everything matches, or names the changed line."""
    assert main(["replay", str(one)]) == 0
    assert "everything matches" in capsys.readouterr().out
    changed = tmp_path / "changed.jsonl"
    changed.write_bytes(one.read_bytes().replace(b'"lead"', b'"laed"', 1))
    assert main(["replay", str(changed)]) == 2
    assert f"{changed}, line" in capsys.readouterr().err
    assert main(["replay", str(tmp_path / "none.jsonl")]) == 2
    assert "cannot read" in capsys.readouterr().err


@pytest.mark.integration
def test_the_picture_shows_the_moments_asked_for(one, tmp_path, capsys):
    pytest.importorskip("matplotlib")
    few, many = tmp_path / "few.png", tmp_path / "new" / "many.png"
    assert main(["replay", str(one), "--picture", str(few), "--at", "10", "11"]) == 0
    assert main(["replay", str(one), "--picture", str(many)]) == 0
    sizes = [Image.open(file).size for file in (few, many)]
    assert sizes[0][0] == sizes[1][0]
    assert sizes[0][1] < sizes[1][1]
    assert len(Image.open(few).convert("RGB").getcolors(1_000_000)) > 100
    assert str(few) in capsys.readouterr().out


def test_a_picture_of_two_records_is_refused(one, tmp_path, capsys):
    assert main(["replay", str(one), str(one), "--picture", str(tmp_path / "two.png")]) == 2
    assert "give one FILE" in capsys.readouterr().err


@pytest.mark.parametrize("at", ["9999", "-3", "nan", "inf"])
def test_replay_picture_time_not_recorded_is_rejected(one, tmp_path, capsys, at):
    """A time that was not recorded is rejected in one line that lists the recorded times."""
    pytest.importorskip("matplotlib")
    assert main(["replay", str(one), "--picture", str(tmp_path / "no.png"), f"--at={at}"]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert f"nothing was recorded at {at} s; choose from 1" in error
    assert not (tmp_path / "no.png").exists()


def test_a_moment_without_a_picture_is_refused(one, capsys):
    assert main(["replay", str(one), "--at", "12"]) == 2
    assert "--picture" in capsys.readouterr().err
