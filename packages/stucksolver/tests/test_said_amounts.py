"""What a passenger said about how far, how fast and how long is done, within the bounds of each behavior."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stucksolver.plan import Execute, RecoveryPlan, apply_guidance_limits
from stucksolver.plan.behaviors import (
    BackUp,
    BorrowOncomingLane,
    ChangeLane,
    KeepLane,
    Nudge,
    PullOver,
    RejoinRoute,
    Wait,
)
from stucksolver.record import Recorder, replay
from stucksolver.scene import DirectedSide, GuidanceIntent, GuidanceLimits, Interpretation, LineKind
from stucksolver.solver import EventKind
from worlds import World, drive, straight_road, thing

TWO_WAY = straight_road()
ASIDE = Nudge(side="left", offset_m=0.5, distance_m=9.0)
CHANGE = ChangeLane(side="left", distance_m=30.0, speed_mps=8.0)


def reading(intent, side=None, **limits):
    return Interpretation(
        intent=GuidanceIntent(intent), likely=GuidanceIntent(intent), side=side, confidence=1.0, reader="test",
        limits=GuidanceLimits(**limits),
    )  # fmt: skip


def changed(behavior, heard):
    return apply_guidance_limits(RecoveryPlan(behaviors=(behavior,)), heard).behaviors[0]


def begun(result):
    return [d.behavior for d in result.directives if isinstance(d, Execute)]


@pytest.mark.parametrize(
    ("behavior", "heard", "name", "value"),
    [
        (BackUp(distance_m=3.0), reading("back_up", distance_m=5.0), "distance_m", 5.0),
        (BackUp(distance_m=3.0), reading("back_up", distance_m=50.0), "distance_m", 40.0),
        (BackUp(distance_m=3.0), reading("back_up", distance_m=0.3), "distance_m", 1.0),
        (KeepLane(distance_m=20.0, speed_mps=2.0), reading("go", distance_m=5.0), "distance_m", 5.0),
        (PullOver(), reading("let_me_out", distance_m=40.0), "distance_m", 40.0),
        (ASIDE, reading("overtake", DirectedSide.LEFT, distance_m=1.0), "offset_m", 1.0),
        (CHANGE, reading("overtake", speed_mps=3.0), "speed_mps", 3.0),
        (CHANGE, reading("overtake", distance_m=50.0), "distance_m", 30.0),
        (CHANGE, reading("go", speed_mps=0.1), "speed_mps", 0.6),
        (Wait(duration_s=30.0), reading("let_me_out", wait_s=50.0), "duration_s", 50.0),
        (Wait(duration_s=30.0), reading("pull_over", wait_s=50.0), "duration_s", 30.0),
    ],
)  # fmt: skip
def test_a_parameter_is_what_was_said_within_its_bounds(behavior, heard, name, value):
    assert getattr(changed(behavior, heard), name) == pytest.approx(value)


@pytest.mark.integration
@given(st.floats(0.05, 40.0), st.sampled_from(list(GuidanceIntent)))
def test_words_never_make_a_plan_faster(speed_mps, intent):
    plan = RecoveryPlan(
        behaviors=(
            BackUp(distance_m=3.0),
            BorrowOncomingLane(past_object_id="car", speed_mps=5.0),
            RejoinRoute(speed_mps=4.0),
        )
    )
    slowed = apply_guidance_limits(plan, reading(intent, speed_mps=speed_mps))
    assert all(
        behavior.speed_mps <= was.speed_mps for behavior, was in zip(slowed.behaviors, plan.behaviors, strict=True)
    )


def test_without_amounts_the_plan_is_the_same():
    plan = RecoveryPlan(behaviors=(BackUp(distance_m=3.0),))
    assert apply_guidance_limits(plan, None) is plan
    assert apply_guidance_limits(plan, reading("back_up")) is plan


@pytest.mark.integration
@pytest.mark.parametrize(("words", "far_m"), [("back up two metres", 2.0), ("reverse 5 m please", 5.0)])
def test_it_backs_up_as_far_as_it_was_told(words, far_m, tmp_path):
    world = World(TWO_WAY, [thing("car", 52.0)], x=40.0)
    with Recorder(tmp_path) as recorder:
        seen = drive(world, 12.0, words={1.0: words}, record=recorder)
    assert next(b for b in begun(seen) if isinstance(b, BackUp)).distance_m == far_m
    assert EventKind.FINISHED in seen.kinds()
    (file,) = recorder.files
    report = replay(file)
    assert report.findings == [] and report.underivable == 0


@pytest.mark.integration
def test_guidance_speed_limits_fastest_behavior():
    """A requested speed is the highest one of the plan."""

    def fastest_mps(words):
        riders = [thing(name, x, speed=1.0) for name, x in (("near", 75.0), ("far", 81.0))]
        road = straight_road(left=LineKind.BROKEN)
        seen = drive(World(road, riders, x=40.0, sight_m=400.0), 15.0, words={5.0: words})
        return max((b.speed_mps for b in begun(seen) if not isinstance(b, Wait)), default=None)

    assert fastest_mps("please overtake them") > 5.0
    assert fastest_mps("overtake them, but not faster than 12 km/h") == pytest.approx(3.33)


@pytest.mark.integration
def test_a_named_time_is_waited_instead_of_the_usual_one():
    def begins_s(words):
        seen = drive(World(TWO_WAY, [thing("lead", 75.0)], x=66.0), 75.0, words={0.5: words})
        return next(e.time_s for e in seen.events if e.kind is EventKind.STARTED)

    usual_s, named_s = begins_s("wait"), begins_s("wait for fifty seconds")
    assert usual_s < 45.0
    assert named_s == pytest.approx(usual_s + 20.0, abs=1.0)
