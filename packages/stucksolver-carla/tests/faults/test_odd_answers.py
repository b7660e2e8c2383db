"""Whatever a reasoner answers: `step` raises nothing, does bounded work, and refuses what is no plan with a code."""

from __future__ import annotations

import math
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stucksolver import CONTINUE, StuckSolver
from stucksolver.guard import RejectCode
from stucksolver.plan import Analysis, CauseCode, Decision, Observation, RecoveryPlan
from stucksolver.plan.behaviors import BorrowOncomingLane, KeepLane, Wait
from stucksolver.reasoners import ReasonerAnswer, ReasonerTrace, SearchReasoner
from stucksolver.record import Recorder, replay
from stucksolver.scene.bounded_values import DEEPEST, MalformedError, read_again
from stucksolver.solver import EventKind
from worlds import World, drive, ladder, straight_road, thing

BRIEF = ladder(rungs={"reasoner": {"tries": 3}, "passenger": None, "remote": None})
HUGE = 1_000_000
WAIT = Wait(duration_s=1.0)
PASS = BorrowOncomingLane(past_object_id="lead", speed_mps=5.0)


class Raises:
    """Raises at whatever it is asked."""

    def __getattribute__(self, name):
        raise RuntimeError("never read me")

    def __eq__(self, other):
        raise RuntimeError("never compare me")

    __hash__ = None

    def __repr__(self):
        raise RuntimeError("never show me")


class Endless(tuple):
    """A tuple that says it is empty, and whose entries never end."""

    def __iter__(self):
        while True:
            yield WAIT

    def __len__(self):
        return 0


class Blind(KeepLane):
    """A behavior that would be checked for nothing."""

    checks = ()


class Text(str):
    """A text whose methods raise."""

    def encode(self, *_):
        raise RuntimeError("never encode me")


def plan(behaviors, **more):
    return RecoveryPlan.model_construct(behaviors=behaviors, **{"replan_route": False, "route_start": None, **more})


def decision(what, **more):
    fields = {
        "version": 1,
        "observation": Observation(controls=(), participants=(), summary="all is clear"),
        "analysis": Analysis(steps=(), immobilized=True, cause=CauseCode.UNKNOWN, reason="sure"),
        "plan": what,
        "rationale": "because",
    }
    return Decision.model_construct(**{**fields, **more})


def constructed(**more):
    return KeepLane.model_construct(**{"name": "keep_lane", "distance_m": 40.0, "speed_mps": 5.0, **more})


def nested(depth):
    found: list = []
    for _ in range(depth):
        found = [found]
    return found


CYCLE: list = [WAIT]
CYCLE.append(CYCLE)
WIDE: list = []
WIDE.extend([WIDE] * 50)
LOOP = plan(())
LOOP.__dict__["behaviors"] = (LOOP,)

PLANS = {
    "a string": "overtake",
    "empty text": "",
    "a number": 7,
    "nothing but an object": object(),
    "one that raises": Raises(),
    "a class": RecoveryPlan,
    "a dictionary": {"behaviors": [{"name": "wait", "duration_s": 1.0}]},
    "no behaviours": plan(()),
    "behaviours that are a text": plan("wait"),
    "behaviours that are a generator": plan(WAIT for _ in iter(int, 1)),
    "a million waits": plan((WAIT,) * HUGE),
    "a million in a list": plan([WAIT] * HUGE),
    "a million that raise": plan((Raises(),) * HUGE),
    "seven": plan((WAIT,) * 7),
    "endless": plan(Endless()),
    "texts": plan(("wait", "keep_lane")),
    "a subclass": plan((Blind(distance_m=40.0, speed_mps=5.0),)),
    "behaviours that raise": plan((Raises(),)),
    "a cycle": plan(CYCLE),
    "a wide cycle": plan(WIDE),
    "a plan in itself": LOOP,
    "deep": plan(nested(100_000)),
    "without its fields": RecoveryPlan.model_construct(),
    "no number": plan((constructed(speed_mps=math.nan),)),
    "infinite": plan((constructed(distance_m=math.inf),)),
    "beyond its bounds": plan((constructed(distance_m=1e9),)),
    "below its bounds": plan((constructed(speed_mps=-5.0),)),
    "far too large": plan((constructed(distance_m=10**400),)),
    "true for a number": plan((constructed(distance_m=Raises()),)),
    "a text for a number": plan((constructed(distance_m="far"),)),
    "another name": plan((constructed(name="fly"),)),
    "a name that raises": plan((constructed(name=Text("keep_lane")),)),
    "a long name of an object": plan(
        (
            BorrowOncomingLane.model_construct(
                name="borrow_oncoming_lane", past_object_id="x" * 100_000_000, speed_mps=5.0
            ),
        )
    ),
    "a start that is none": plan((WAIT,), route_start=7),
    "a start that raises": plan((WAIT,), route_start=Raises()),
    "perhaps": plan((WAIT,), replan_route="perhaps"),
}

ANSWERS = {
    "nothing": None,
    "a text": "overtake",
    "one that raises": Raises(),
    "a class": ReasonerAnswer,
    "a decision alone": decision(RecoveryPlan(behaviors=(WAIT,))),
    "no decision": ReasonerAnswer(None, "odd"),
    "a decision that raises": ReasonerAnswer(Raises(), "odd"),
    "a name that is none": ReasonerAnswer(decision(None), 7),
    "a name that raises": ReasonerAnswer(decision(None), Raises()),
    "a name without end": ReasonerAnswer(decision(None), "x" * HUGE),
    "a trace that is none": ReasonerAnswer(decision(None), "odd", "trace"),
    "a trace of a million": ReasonerAnswer(decision(None), "odd", ReasonerTrace.model_construct(answers=("x",) * HUGE)),
    "a cost that is no number": ReasonerAnswer(decision(None), "odd", ReasonerTrace.model_construct(usd=math.nan)),
    "no observation": ReasonerAnswer(decision(None, observation=None), "odd"),
    "a million participants": ReasonerAnswer(
        decision(None, observation=Observation.model_construct(controls=(), participants=(1,) * HUGE, summary="")),
        "odd",
    ),
    "a reason that raises": ReasonerAnswer(decision(None, rationale=Raises()), "odd"),
    "a reason that no record holds": ReasonerAnswer(decision(None, rationale="\ud800"), "odd"),
    "a cause that is none": ReasonerAnswer(
        decision(None, analysis=Analysis.model_construct(steps=(), immobilized="yes", cause="a", reason="")), "odd"
    ),
    **{f"a plan: {name}": ReasonerAnswer(decision(item), "odd") for name, item in PLANS.items()},
}


class Odd:
    """Answers the same to everything."""

    name = "odd"

    def __init__(self, answer):
        self.answer = answer

    def decide(self, request):
        return self.answer


@contextmanager
def counted() -> Iterator[list[int]]:
    """Counts the calls of functions in this thread and in those that it starts."""
    calls = [0]

    def count(frame, event, argument):
        calls[0] += event in ("call", "c_call")

    threading.setprofile(count)
    sys.setprofile(count)
    try:
        yield calls
    finally:
        sys.setprofile(None)
        threading.setprofile(None)


def asked(answer, seconds=6.0, **options):
    world = World(straight_road(), [thing("lead", 60.0)])
    return drive(world, seconds, reasoner=Odd(answer), ladder=BRIEF, **options)


@pytest.mark.parametrize("what", ANSWERS)
def test_step_odd_answer_is_refused_with_a_code(what):
    seen = asked(ANSWERS[what])
    failed = [event for event in seen.events if event.kind is EventKind.FAILED]
    assert failed and all(event.verdict.codes == (RejectCode.IMPLAUSIBLE,) for event in failed)
    assert all(len(event.text) < 500 and "\n" not in event.text for event in failed)
    assert set(seen.directives) == {CONTINUE}
    assert EventKind.DECIDED not in seen.kinds()


@pytest.mark.parametrize("what", ["a million waits", "a million in a list", "deep", "a wide cycle", "a cycle"])
def test_step_huge_plan_takes_bounded_work(what):
    """A huge plan takes as little work as a small one."""
    with counted() as small:
        asked(ANSWERS["a plan: seven"], 2.0)
    with counted() as huge:
        asked(ANSWERS[f"a plan: {what}"], 2.0)
    assert huge[0] < small[0] + 50_000


def test_step_sound_answer_is_the_same_as_before():
    """What is validated again is what the reasoner said."""
    sound = ReasonerAnswer(decision(RecoveryPlan(behaviors=(PASS,))), "odd", ReasonerTrace(answers=("yes",), usd=0.1))
    seen = asked(sound, 20.0)
    decided = next(event for event in seen.events if event.kind is EventKind.DECIDED)
    assert (decided.decision, decided.reasoner, decided.trace) == (sound.decision, "odd", sound.trace)
    assert EventKind.STARTED in seen.kinds()


def test_record_odd_answers_are_replayed(tmp_path):
    with Recorder(tmp_path) as recorder:
        asked(ANSWERS["a plan: a million waits"], record=recorder)
    reports = [replay(path) for path in recorder.files]
    assert reports and all(report.matches for report in reports)


class Asks(Odd):
    """Has the guard check an odd plan, and then answers as the search does."""

    def decide(self, request):
        self.verdict = request.check(self.answer)
        return SearchReasoner().decide(request)


@pytest.mark.parametrize("what", PLANS)
def test_check_odd_plan_is_refused_and_raises_nothing(what):
    world, asks = World(straight_road(), [thing("lead", 60.0)]), Asks(PLANS[what])
    with counted() as calls:
        drive(world, 2.0, reasoner=asks, ladder=BRIEF)
    assert asks.verdict.startswith(f"{RejectCode.IMPLAUSIBLE.value}:")
    assert calls[0] < 2_000_000


class Shy:
    """A reasoner whose name can be read once, and which raises in every other way."""

    def __init__(self, error):
        self._names, self._error = ["shy", "shy"], error

    @property
    def name(self):
        return self._names.pop()

    @property
    def cancel(self):
        raise self._error

    def decide(self, request):
        raise self._error


class Unspeakable(Exception):
    """An error whose own text raises."""

    def __str__(self):
        raise ValueError("not even this")

    __repr__ = __str__


@pytest.mark.parametrize(
    "error",
    [Unspeakable(), SystemExit(3), KeyboardInterrupt(), ValueError("a\nb" * 1000)],
    ids=lambda item: type(item).__name__,
)
def test_step_reasoner_that_raises_is_one_line(error):
    world, told = World(straight_road(), [thing("lead", 60.0)]), []
    with StuckSolver(world.scene, reasoner=Shy(error), ladder=BRIEF, clock="lockstep", on_event=told.append) as solver:
        for _ in range(100):
            assert solver.step(world.status(), world.surroundings) is CONTINUE
            world.drive(CONTINUE)
    failed = [event.text for event in told if event.kind is EventKind.FAILED]
    assert failed and all(type(error).__name__ in text and len(text) < 500 and "\n" not in text for text in failed)


ANYTHING = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(max_size=5)
    | st.binary(max_size=5)
    | st.sampled_from([WAIT, PASS, Raises, CauseCode.LOOP]),
    lambda inner: (
        st.lists(inner, max_size=4) | st.tuples(inner, inner) | st.dictionaries(st.text(max_size=5), inner, max_size=3)
    ),
    max_leaves=12,
)


@pytest.mark.integration
@settings(max_examples=300)
@given(fields=st.fixed_dictionaries({"behaviors": ANYTHING, "replan_route": ANYTHING, "route_start": ANYTHING}))
def test_read_again_any_fields_give_valid_plan_or_error(fields):
    """Any fields give a valid plan or an error of one line."""
    try:
        read = read_again(RecoveryPlan.model_construct(**fields), RecoveryPlan, 1000)
    except MalformedError as error:
        assert "\n" not in str(error) and len(str(error)) < 1000
    else:
        assert read == RecoveryPlan.model_validate(read.model_dump())


@pytest.mark.parametrize("depth", [DEEPEST - 4, DEEPEST + 1, 100_000])
def test_read_again_depth_is_bounded(depth):
    with pytest.raises(MalformedError):
        read_again(plan(nested(depth)), RecoveryPlan, 1000)
