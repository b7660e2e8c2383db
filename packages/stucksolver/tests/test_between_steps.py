"""A plan between two of its steps: people are told what it waits for, and it ends when waiting cannot succeed."""

from __future__ import annotations

import pytest

from stucksolver.guard import Guard, RejectCode, RejectReason, Verdict
from stucksolver.plan import RecoveryPlan
from stucksolver.plan.behaviors import BackUp, BorrowOncomingLane
from stucksolver.reasoners import ReasonerAnswer
from stucksolver.scene import ObjectKind
from stucksolver.solver import EventKind
from worlds import LANE_M, World, drive, noticed, straight_road, stubborn, thing

pytestmark = pytest.mark.integration
PLAN = (BackUp(distance_m=4.0, speed_mps=2.0), BorrowOncomingLane(past_object_id="lead", speed_mps=5.5))


class Stubborn:
    """Proposes the same plan again and again."""

    name = "stubborn"

    def __init__(self):
        self.attempts = ()

    def decide(self, request):
        self.attempts = request.scene.attempts or self.attempts
        decision = noticed(request.scene)
        analysis = decision.analysis.model_copy(update={"wait": None, "immobilized": True})
        changes = {"plan": RecoveryPlan(behaviors=PLAN), "analysis": analysis}
        return ReasonerAnswer(decision.model_copy(update=changes), self.name)


class Refuses(Guard):
    """Refuses every pass with one reason, as for oncoming traffic."""

    def __init__(self, object_id, code=RejectCode.ONCOMING_GAP):
        super().__init__()
        self.reason = RejectReason(code=code, object_id=object_id, detail=f"{object_id}: gap 1.0 m, required 3.0 m")

    def accept(self, behaviors, *arguments):
        if any(b.name == "borrow_oncoming_lane" for b in behaviors):
            return Verdict(rejects=(self.reason,)), None
        return super().accept(behaviors, *arguments)


def driven(objects, seconds=60.0, reasoner=None, **options):
    world = World(straight_road(), [thing("lead", 60.0, hazard=True), *objects], cruise_mps=0.0)
    seen = drive(world, seconds, reasoner=reasoner or Stubborn(), ladder=stubborn(repair_rounds=0), **options)
    backed_s = next(e.time_s for e in seen.events if e.kind is EventKind.STARTED) + 4.0  # 4 m back take 3.8 s
    return seen, backed_s


def stream():
    return [thing(f"c{k}", 70.0 + 25.0 * k, LANE_M, speed=-8.0) for k in range(60)]


@pytest.mark.parametrize(
    "other",
    [
        thing("bin", 85.0, LANE_M, kind=ObjectKind.BARRIER, length=0.6, width=0.6),
        thing("parked", 85.0, LANE_M, yaw=3.14, stationary_s=60.0),
    ],
    ids=lambda o: o.id,
)
def test_step_refused_for_object_that_stays_ends_at_once(other):
    seen, backed_s = driven([other], guard=Refuses(other.id))
    ended = next(e for e in seen.events if e.kind is EventKind.ABORTED)
    assert ended.time_s - backed_s <= 2.0
    assert other.id in ended.text


@pytest.mark.parametrize("code", [RejectCode.OFF_ROAD, RejectCode.SOLID_LINE, RejectCode.ONCOMING_SIGHT])
def test_step_refused_for_static_reason_ends_at_once(code):
    seen, backed_s = driven([], guard=Refuses(None, code))
    assert next(e.time_s for e in seen.events if e.kind is EventKind.ABORTED) - backed_s <= 2.0


def test_step_refused_for_static_reason_is_among_attempts():
    reasoner = Stubborn()
    driven([thing("parked", 85.0, LANE_M, yaw=3.14, stationary_s=60.0)], 12.0, reasoner, guard=Refuses("parked"))
    assert reasoner.attempts[0].blocker == "parked"
    assert reasoner.attempts[0].codes == (RejectCode.ONCOMING_GAP,)


def test_step_without_gap_in_traffic_ends_after_half_a_minute():
    seen, backed_s = driven(stream(), 45.0)
    ended = next(e for e in seen.events if e.kind is EventKind.ABORTED)
    assert 28.0 <= ended.time_s - backed_s <= 32.0
    assert "no gap within 30 s" in ended.text


def test_step_without_gap_is_told_within_10_s():
    seen, backed_s = driven(stream(), 30.0)
    told = next(e for e in seen.events if e.kind is EventKind.WAITING and e.notice.to == "passenger")
    assert told.time_s - backed_s <= 10.0
    assert told.notice.reason.reject.object_id.startswith("c")


def test_plan_that_found_no_gap_is_not_begun_again_with_its_back_up():
    seen, _ = driven(stream(), 80.0)
    assert seen.kinds().count(EventKind.STARTED) == 1


def test_just_stopped_vehicle_counts_as_traffic():
    """An oncoming car that has just stopped may drive on at any moment."""
    car = thing("car", 85.0, LANE_M, yaw=3.14, stationary_s=0.0)
    seen, _ = driven([car], 9.0, guard=Refuses("car"))
    assert EventKind.ABORTED not in seen.kinds()
