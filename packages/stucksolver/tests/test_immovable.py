"""A vehicle that does not move although it drives: people are told exactly that, and no object is blamed."""

from __future__ import annotations

from dataclasses import dataclass

import pytest

from stucksolver.guard import RejectCode
from stucksolver.plan import CONTINUE
from stucksolver.reasoners import ReasonerError
from stucksolver.scene import ObjectKind
from stucksolver.solver import EventKind, QuestionKind
from worlds import LANE_M, World, drive, ladder, straight_road, stubborn, thing

pytestmark = pytest.mark.integration
SAYS = "does not move although it drives"


@dataclass
class Held(World):
    """A world that holds the vehicle, whatever the pedals do. `reports`: the stack says when the driver drives."""

    free_s: float = 1e9
    reports: bool = False
    drives: bool = False

    def drive(self, directive):
        x, y = self.x, self.y
        self.drives = directive == CONTINUE or bool(getattr(directive, "path", ()))
        super().drive(directive)
        if self.time_s < self.free_s:
            self.x, self.y, self.speed = x, y, 0.0

    def status(self):
        return super().status().model_copy(update={"drives": self.drives} if self.reports else {})


class Silent:
    """Never has an idea, so that the vehicle is left to its driver."""

    name = "silent"

    def decide(self, request):
        raise ReasonerError("no idea")


FAR = (thing("far", 113.0), thing("comes", 250.0, LANE_M, speed=-8.0))


def calls(seen):
    return [e for e in seen.events if e.kind is EventKind.ASKED and e.question.kind is QuestionKind.ASSISTANCE]


@pytest.mark.parametrize("reports", [False, True], ids=["plan alone", "driver reports"])
@pytest.mark.parametrize("name", ["default", "evaluation"])
def test_held_vehicle_asks_for_assistance_within_15_s(name, reports):
    seen = drive(Held(straight_road(), list(FAR), reports=reports), 40.0, ladder=ladder(name))
    asked = calls(seen)
    assert asked[0].time_s <= 15.0
    assert SAYS in asked[0].text
    assert not any("far" in e.text for e in seen.events if e.kind in (EventKind.ASKED, EventKind.STOPPED))


def test_vehicle_waiting_behind_does_not_hide_an_immovable_one():
    seen = drive(Held(straight_road(), [thing("follower", 42.0)], reports=True), 20.0)
    assert calls(seen)[0].time_s <= 15.0


def test_held_vehicle_tells_passenger_and_keeps_calling_once():
    seen = drive(Held(straight_road(), list(FAR)), 60.0, ladder=ladder(rungs={"model": None, "passenger": None}))
    told = [e for e in seen.events if e.kind is EventKind.WAITING and e.notice.to == "passenger"]
    assert told[-1].time_s <= 15.0 and SAYS in told[-1].text and told[-1].notice.reason.immovable
    assert len(calls(seen)) == 1


def test_call_is_withdrawn_when_vehicle_comes_free():
    seen = drive(Held(straight_road(), list(FAR), free_s=25.0), 45.0)
    ended = [e for e in seen.events if e.kind is EventKind.CANCELLED and e.question == calls(seen)[0].question]
    assert ended and 25.0 < ended[0].time_s < 35.0
    assert EventKind.WAITING_ENDED in seen.kinds()


def test_vehicle_held_by_its_driver_is_not_immovable():
    """The driver brakes: it has not been commanded to move in vain."""

    @dataclass
    class Brakes(Held):
        def status(self):
            return World.status(self).model_copy(update={"drives": False})

    seen = drive(Brakes(straight_road(), list(FAR)), 30.0)
    assert not any(SAYS in e.text for e in seen.events)


@pytest.mark.parametrize(
    "near",
    [
        thing("bollard", 53.2, kind=ObjectKind.CONE),
        thing("car", 58.0, stationary_s=1.0),
        thing("beside", 50.0, 2.0, kind=ObjectKind.PROP, length=1.0, width=1.0),
    ],
    ids=lambda o: o.id,
)
def test_object_close_by_is_no_proof_of_an_immovable_vehicle(near):
    seen = drive(Held(straight_road(), [near], reports=True), 20.0, ladder=stubborn(), reasoner=Silent())
    assert not any(SAYS in e.text for e in seen.events)


def test_plan_that_moves_vehicle_is_no_call():
    world = World(straight_road(), [thing("lead", 62.0, hazard=True)])
    seen = drive(world, 30.0)
    assert not calls(seen)
    assert RejectCode.TIMEOUT not in [c for e in seen.events if e.verdict for c in e.verdict.codes]
