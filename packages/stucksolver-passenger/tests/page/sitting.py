"""A seat in a toy world: the real solver, guard and reader, with people who press and say things."""

from __future__ import annotations

from itertools import count

from stucksolver import StuckSolver
from stucksolver.interpreter import find_reader
from stucksolver.ladder.ladder import Approval
from stucksolver_passenger.api_types import CommandKind, PersonCommand
from stucksolver_passenger.conversation import Conversation
from stucksolver_passenger.vehicle_session import VehicleSession
from worlds import World, ladder, straight_road, thing

PASSENGER_ASKED = ladder(approval=Approval(behaviors={"borrow_oncoming_lane": "passenger"}))
"""The passenger is asked before the oncoming lane is used."""


def parked(**more) -> World:
    """A car stands in our lane of a road with one lane each way."""
    return World(straight_road(), [thing("parked", 75.0)], **more)


class Sitting:
    """A world, its solver and a seat. `policy`: the ladder; `options` go to the solver."""

    def __init__(self, world: World, policy=PASSENGER_ASKED, **options) -> None:
        self.world, self.told, self.now_s = world, [], 0.0
        conversation = Conversation(lambda: self.solver.state)
        settings = {"clock": "lockstep", "ladder": policy, "on_event": conversation.hear, **options}
        settings.setdefault("reader", find_reader())
        self.solver = StuckSolver(world.scene, **settings)
        self.seat = VehicleSession(self.solver, conversation, self.told.append, wall_s=lambda: self.world.time_s)
        self._numbers = count(1)
        self.directives = []

    def press(self, kind, *, by="passenger", client="one", **more):
        """What came of it."""
        return self.seat.take(
            PersonCommand(number=next(self._numbers), kind=CommandKind(kind), by=by, client=client, **more)
        )

    def say(self, text, **more):
        return self.press("say", text=text, **more)

    def answer(self, yes, **more):
        return self.press("yes" if yes else "no", question_id=self.now.question.id, **more)

    def tick(self):
        directive = self.solver.step(self.world.status(), self.world.surroundings)
        self.directives.append(directive)
        self.seat.tick(self.world.status(), self.world.scene)
        self.world.drive(directive)

    def until(self, wanted, limit_s=60.0):
        """Drive until it is so; fails after too long."""
        end_s = self.world.time_s + limit_s
        while self.world.time_s < end_s:
            self.tick()
            if self.told and wanted(self.now):
                return self.now
        raise AssertionError(f"not within {limit_s} s; the last was {self.now}")

    def drive(self, seconds):
        end_s = self.world.time_s + seconds
        while self.world.time_s < end_s:
            self.tick()

    @property
    def now(self):
        return self.told[-1]

    def car(self):
        """What the car has said so far."""
        return [line.text for line in self.now.lines if line.speaker.value == "car"]
