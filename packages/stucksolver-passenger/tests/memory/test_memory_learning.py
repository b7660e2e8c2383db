"""The real solver, guard and reader on a road that is blocked: what is learned, what is proposed, and what never is."""

from __future__ import annotations

import sqlite3

import pytest
from remembering import ASKING, LEFT, REROUTE, blocked_road, driven, episode, features

from stucksolver.ladder.ladder import Approval
from stucksolver.reasoners import ReasonerRequest
from stucksolver.reasoners.reasoner import ReasonerError
from stucksolver.record import Recorder, replay
from stucksolver.scene import ObjectKind
from stucksolver.solver import EventKind
from stucksolver_passenger.memory import Memory, SolutionOutcome, SolutionStore, features_of
from worlds import READER, World, ladder, red_light, straight_road, thing

LIMITS = ASKING.waits.limits()
pytest.importorskip("onnxruntime", reason="the extra `words` is not installed")


def one_drive(path, world, seconds=15.0, *, words=None, **options):
    """One drive with a memory; its events."""
    with Memory(path) as memory:
        inner = options.pop("inner", None)
        ear = memory.ear("car-1")
        drive = driven(
            world, seconds, words=words, reader=READER, reasoner=memory.before(inner, LIMITS), on_event=ear, **options
        )
    assert memory.fault is None
    return drive


def kinds(events):
    return [event.kind for event in events]


def recovered(events):
    return EventKind.RECOVERED in kinds(events)


def questions(events):
    return sum(e.kind is EventKind.ASKED and e.question.kind.value != "assistance" for e in events)


@pytest.fixture(scope="module")
def lessons(tmp_path_factory):
    """A memory after two guided recoveries."""
    path = tmp_path_factory.mktemp("taught") / "m.db"
    for k in range(2):
        assert recovered(one_drive(path, blocked_road(float(k)), 13.0, words="Please take another street."))
    return path


@pytest.fixture
def taught(lessons, tmp_path):
    """A copy of it."""
    with sqlite3.connect(lessons) as source, sqlite3.connect(tmp_path / "m.db") as copy:
        source.backup(copy)
    return tmp_path / "m.db"


@pytest.mark.integration
def test_memory_entry_contains_utterance_scene_and_outcome(taught):
    """What the passenger said is stored with the scene, the solution and its outcome."""
    told = SolutionStore(taught).episodes()[0].episode
    assert (told.text, told.solution, told.ending) == ("Please take another street.", REROUTE, SolutionOutcome.WORKED)
    assert told.scene.obstacle == "debris" and told.questions == 1 and told.guided


def test_after_guided_recoveries_the_vehicle_helps_itself_and_asks_less(taught):
    before = driven(blocked_road(5.0), 15.0, reader=READER)
    after = one_drive(taught, blocked_road(5.0))
    assert (recovered(before), questions(before)) == (False, 1)
    assert (recovered(after), questions(after)) == (True, 0)
    assert "memory: reroute worked 2 of 2 times" in next(e.text for e in after if e.reasoner == "memory")


def test_bad_advice_once_does_not_poison_it(taught):
    path = taught
    one_drive(path, blocked_road(), words="Back up a bit.")
    after = one_drive(path, blocked_road(9.0))
    assert recovered(after) and questions(after) == 0


def test_one_kind_of_obstacle_says_nothing_of_another(taught):
    after = one_drive(taught, blocked_road(kind=ObjectKind.UNKNOWN))
    assert not recovered(after) and questions(after) == 1


def test_memory_ineffective_solution_is_tried_once_and_recorded_as_failed(taught):
    """Same debris without a detour: the remembered solution is tried once in an intervention, and its rate falls."""
    path, dead_end = taught, blocked_road()
    dead_end.drive = lambda directive: World.drive(dead_end, directive)
    events = one_drive(path, dead_end)
    tried = [e for e in events if e.kind is EventKind.STARTED and e.rung != "remote"]
    assert len(tried) == 1 and questions(events) == 1
    last = SolutionStore(path).episodes()[-1].episode
    assert (last.solution, last.ending, last.proposer) == (REROUTE, SolutionOutcome.FAILED, "memory")


def overtaking_kept(path, world):
    """Overtaking on the left has worked often in this world's scene, as a passenger's wish."""
    scene = features_of(world.scene())
    store = SolutionStore(path)
    for _ in range(8):
        store.add(episode(LEFT, scene=scene, text="go round it"))
    return path


def test_a_remembered_yes_is_no_standing_consent(tmp_path):
    policy = ladder(approval=Approval(behaviors={"borrow_oncoming_lane": "passenger"}))
    world = World(straight_road(), [thing("parked", 75.0)])
    path = overtaking_kept(tmp_path / "m.db", World(straight_road(), [thing("parked", 75.0)], x=67.0))
    events = one_drive(path, world, 12.0, ladder=policy)
    assert EventKind.ASKED in kinds(events)
    assert EventKind.STARTED not in kinds(events)


def test_what_was_remembered_gives_no_leave_that_only_words_give(tmp_path):
    """Somebody who drives slowly is passed when the passenger asks for it, and never because one once did."""
    slow = {"kind": ObjectKind.BICYCLE, "speed": 1.0}
    path = overtaking_kept(tmp_path / "m.db", World(straight_road(), [thing("slow", 62.0, **slow)]))
    events = one_drive(path, World(straight_road(), [thing("slow", 75.0, **slow)]), 15.0)
    assert EventKind.STARTED not in kinds(events)


def test_at_a_red_light_nothing_is_proposed(tmp_path):
    world = World(straight_road(), [], controls=(red_light(5.0),), cruise_mps=0.0)
    path = overtaking_kept(tmp_path / "m.db", world)
    events = one_drive(path, world, 8.0)
    assert EventKind.STARTED not in kinds(events)
    assert not [e for e in events if e.reasoner == "memory"]


def test_another_reasoner_is_not_asked_where_the_memory_knows(taught, tmp_path):
    class Silent:
        name = "silent"
        asked = 0

        def decide(self, request):
            self.asked += 1
            raise ReasonerError("nothing comes to mind")

    silent = Silent()
    events = one_drive(taught, blocked_road(), inner=silent)
    assert recovered(events) and silent.asked == 0
    assert not recovered(one_drive(tmp_path / "empty.db", blocked_road(), inner=silent)) and silent.asked > 0


def test_memory_file_lost_during_run_does_not_disturb_solver(taught, tmp_path):
    """When the file is lost during a run, the solver works as without a memory, and the memory reports the fault."""
    path = taught
    with Memory(path) as memory:
        for item in tmp_path.glob("m.db*"):
            item.unlink()
        path.mkdir()
        reasoner, ear = memory.before(limits=LIMITS), memory.ear("car-1")
        events = driven(blocked_road(), 20.0, reader=READER, reasoner=reasoner, on_event=ear)
    assert questions(events) == 1 and EventKind.FAULT not in kinds(events)
    assert memory.fault is not None and "is not writable" in str(memory.fault)


def test_a_record_replays_without_the_memory(taught, tmp_path):
    path = taught
    recorder = Recorder(tmp_path / "records")
    assert recovered(one_drive(path, blocked_road(), record=recorder))
    recorder.close()
    files = sorted((tmp_path / "records").glob("*.jsonl"))
    assert files
    for file in files:
        assert replay(file).matches


def test_the_memory_answers_the_same_whenever_it_is_asked(taught):
    with Memory(taught) as memory:
        scene = blocked_road(-8.0).scene()
        ego = scene.ego.model_copy(update={"stopped_for_s": 6.0})
        scene = scene.model_copy(update={"ego": ego})
        first, second = (memory.before(limits=LIMITS).decide(ReasonerRequest(scene)) for _ in range(2))
    assert first == second and first.reasoner == "memory"
    assert features_of(scene) == features()
