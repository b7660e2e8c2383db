"""The room that the ego needs to swing out: the guard measures it, and the rules back up for as much."""

from __future__ import annotations

from dataclasses import dataclass

import pytest

from grids import each_value, sample
from stucksolver.guard import Guard, RejectCode, RejectReason, Verdict
from stucksolver.plan import RecoveryPlan
from stucksolver.plan.behaviors import KeepLane
from stucksolver.scene import AttemptOutcome, LaneDirection, LineKind, ObjectKind, RoadGeometry
from stucksolver.solver import EventKind
from stucksolver.solver.state_machine.gap_wait import STAYS_WAIT_S, GapWait
from stucksolver.solver.state_machine.history import AttemptHistory, waits_for_nothing
from worlds import LANE_M, World, drive, straight_road, strip, thing

NOSE_M = 2.45
"""From the middle of the ego of `World` to its front bumper (m)."""
HALF_CAR_M = 2.3


def right_road() -> RoadGeometry:
    """A road with a second lane of the ego's direction on the right, and nothing else."""
    count = 401
    own = strip("own", 0.0, LaneDirection.SAME, LineKind.NONE, count)
    right = strip("right", -LANE_M, LaneDirection.SAME, LineKind.BROKEN, count)
    reference = tuple((float(x), 0.0) for x in range(count))
    return RoadGeometry(key="right", spacing_m=1.0, reference=reference, lanes=(own, right))


ROADS = {
    "oncoming lane": straight_road(),
    "lane on the left": straight_road(left=LineKind.BROKEN, oncoming=None),
    "lane on the right": right_road(),
}


def parked(gap_m: float, aside_m: float = 0.0, **more: object):
    return thing("lead", 50.0 + NOSE_M + gap_m + HALF_CAR_M, aside_m, **more)


def test_verdict_gap_names_the_object_that_is_too_near():
    """A refusal for a gap keeps the object's id, and so does the attempt that the reasoner gets."""
    world = World(ROADS["lane on the left"], [parked(4.5)])
    plan = RecoveryPlan(behaviors=(KeepLane(distance_m=30.0, speed_mps=5.5),))
    verdict = Guard().accept(plan.behaviors, world.view(), False)[0]
    assert verdict.too_near == ("lead",)
    (attempt,) = AttemptHistory(3).with_attempt(plan, AttemptOutcome.REJECTED, 0.0, verdict=verdict).attempts
    assert attempt.too_near == ("lead",)


@pytest.mark.integration
@pytest.mark.parametrize(("road", "gap_m", "aside_m"), each_value(ROADS, [4.5, 4.6, 5.0], [0.0, 0.25]))
def test_solver_stopped_close_behind_a_parked_car_passes_it(road, gap_m, aside_m):
    """The gap at which the guard needs more room than the rules assume: it was refused there for good."""
    world = World(ROADS[road], [parked(gap_m, aside_m)])
    seen = drive(world, 40.0, ladder="evaluation")
    assert world.x > 50.0 + gap_m + 15.0, seen.texts(EventKind.DECIDED)
    assert seen.nearest_m > 0.0


@pytest.mark.integration
@pytest.mark.parametrize(
    ("kind", "width_m"),
    each_value([ObjectKind.TRUCK, ObjectKind.VAN, ObjectKind.DEBRIS, ObjectKind.BARRIER], [1.9, 2.5]),
)
def test_solver_stopped_close_behind_other_obstacles_passes_them(kind, width_m):
    world = World(ROADS["lane on the right"], [parked(4.6, kind=kind, width=width_m)])
    seen = drive(world, 60.0, ladder="evaluation")
    assert world.x > 70.0, seen.texts(EventKind.DECIDED)


@dataclass
class Sluggish(World):
    """Its stack steers late: the ego drives beside its path, nearer to the obstacle, as weak controllers do."""

    late_m: float = 2.0

    def _along(self, directive):
        if directive.reverse:
            self._back(directive)
            return
        later = tuple(p.model_copy(update={"x_m": p.x_m + self.late_m}) for p in directive.path)
        super()._along(directive.model_copy(update={"path": later}))


@pytest.mark.integration
@pytest.mark.parametrize("late_m", sample([1.0, 1.5, 2.0], 1))
def test_plan_stopped_by_a_stationary_object_is_given_up_soon(late_m):
    """After the commit point the ego stands for what does not move. The plan stood for its whole time, 120 s."""
    world = Sluggish(ROADS["lane on the right"], [parked(5.2)], late_m=late_m)
    seen = drive(world, 60.0, ladder="evaluation")
    assert seen.nearest_m > 0.0
    assert world.x > 70.0, [(round(e.time_s, 1), e.kind.value, e.text, str(e.verdict or "")) for e in seen.events]


def test_waiting_for_a_vehicle_that_stops_counts_from_its_stop():
    """What has just stopped may go on: the time in which it moved does not count."""
    world = World(ROADS["lane on the right"], [parked(5.2)])
    refused = Verdict(rejects=(RejectReason(code=RejectCode.COLLISION, detail="", object_id="lead"),))
    waiting = None
    for tick in range(200):
        moves = tick < 100
        world.objects = [parked(5.2, speed=1.0 if moves else 0.0, stationary_s=0.0 if moves else 9.0)]
        waiting = GapWait.after(waiting, refused, world.view(), 0.05 * tick)
        waited_s = 0.05 * (tick - 100)
        assert waiting.has_timed_out(world.ego(), 0.05 * tick) == (waited_s > STAYS_WAIT_S + 1e-9), tick


@pytest.mark.parametrize("code", [RejectCode.LANE_ENTRY, RejectCode.ONCOMING_SIGHT, RejectCode.STALE])
def test_waiting_for_traffic_sight_or_data_is_not_in_vain(code):
    refused = Verdict(rejects=(RejectReason(code=code, detail="", object_id="lead"),))
    assert not waits_for_nothing(refused, frozenset())
