"""The server's state of all vehicles: the newest update of each topic, and the operators' queue."""

from __future__ import annotations

import asyncio
import base64
import time
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, field

from stucksolver_passenger.api_types import CommandResult, OperatorCall, PersonCommand, VehicleReport
from stucksolver_passenger.socket_frames import SocketMessage, Topic

OUTCOME_S = 3.0
"""Time for a vehicle to report the result of a command (s). Ours."""
HELP_CALLS = 50
"""Maximum number of stored calls for help. Ours."""
VEHICLES = 500
"""Maximum number of vehicles. A vehicle that has left is removed first. Ours."""
UNREACHABLE = "The car does not answer at the moment. Please try again."
SHOWN = (Topic.SCENERY, Topic.NOW, Topic.VIEW, Topic.PICTURE)


@dataclass
class Vehicle:
    """One vehicle. `shown` has the newest payload of each topic, a picture in base64, with an increasing number."""

    id: str
    name: str
    write: Callable[[bytes], None] | None
    """Sends to the vehicle's process; None after the process has left."""
    shown: dict[Topic, tuple[int, str]] = field(default_factory=dict)
    asked: tuple[str, float] | None = None
    """Id of the open question to the operator, and its time."""
    noticed: tuple[str, float] | None = None
    """Id of the notice to the operator, and its time."""

    @property
    def now(self) -> VehicleReport | None:
        """Current state of the vehicle; None before its first report."""
        report = self.shown.get(Topic.NOW)
        return None if report is None else VehicleReport.model_validate_json(report[1])


class Board:
    """State of all vehicles. Only one event loop may use it."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._vehicles: OrderedDict[str, Vehicle] = OrderedDict()
        self._numbers = 0
        self._outcomes: dict[int, asyncio.Future[CommandResult]] = {}
        self._help: OrderedDict[str, tuple[str, str, float]] = OrderedDict()
        """By the call's id: vehicle, text, and its time."""
        self._changed = asyncio.Event()

    # ---- for vehicles

    def take(self, frame: SocketMessage, write: Callable[[bytes], None]) -> None:
        """Accept a frame from a vehicle's process. `write` sends to the process."""
        if frame.topic is Topic.HELLO:
            self._join(frame, write)
            return
        vehicle = self._vehicles.get(frame.vehicle)
        if vehicle is None:
            return
        if frame.topic is Topic.OUTCOME:
            outcome = CommandResult.model_validate_json(frame.payload)
            waiting = self._outcomes.pop(outcome.number, None)
            if waiting is not None and not waiting.done():
                waiting.set_result(outcome)
        elif frame.topic is Topic.BYE:
            vehicle.write = None
        elif frame.topic in SHOWN:
            image = frame.topic is Topic.PICTURE
            self._show(vehicle, frame.topic, (base64.b64encode(frame.payload) if image else frame.payload).decode())

    def lost(self, write: Callable[[bytes], None]) -> None:
        """Record that a process has disconnected, so that its vehicles cannot be reached."""
        for vehicle in self._vehicles.values():
            if vehicle.write is write:
                vehicle.write = None

    def _join(self, frame: SocketMessage, write: Callable[[bytes], None]) -> None:
        self._vehicles.pop(frame.vehicle, None)
        self._vehicles[frame.vehicle] = Vehicle(frame.vehicle, frame.payload.decode("utf-8", "replace")[:80], write)
        gone = [vehicle.id for vehicle in self._vehicles.values() if vehicle.write is None]
        for name in gone[: max(len(self._vehicles) - VEHICLES, 0)]:
            del self._vehicles[name]

    def _show(self, vehicle: Vehicle, topic: Topic, payload: str) -> None:
        self._numbers += 1
        vehicle.shown[topic] = (self._numbers, payload)
        if topic is Topic.NOW:
            now = vehicle.now
            question = None if now is None else now.question
            if question is None or question.to != "operator":
                vehicle.asked = None
            elif vehicle.asked is None or vehicle.asked[0] != question.id:
                vehicle.asked = (question.id, self._clock())
            notice = None if now is None else now.notice
            if notice is None:
                vehicle.noticed = None
            elif vehicle.noticed is None or vehicle.noticed[0] != notice.id:
                vehicle.noticed = (notice.id, self._clock())
        changed, self._changed = self._changed, asyncio.Event()
        changed.set()

    # ---- for people

    def vehicle(self, vehicle_id: str) -> Vehicle | None:
        """Return a vehicle that is or was connected; None otherwise."""
        return self._vehicles.get(vehicle_id)

    @property
    def vehicles(self) -> tuple[Vehicle, ...]:
        """All vehicles, in the order of their arrival."""
        return tuple(self._vehicles.values())

    async def change(self) -> None:
        """Wait until any vehicle has an update."""
        await self._changed.wait()

    def number(self) -> int:
        """Return a number for the next command."""
        self._numbers += 1
        return self._numbers

    async def command(self, vehicle: Vehicle, command: PersonCommand) -> CommandResult:
        """Pass a command to its vehicle, and wait briefly for its result."""
        if vehicle.write is None:
            return CommandResult(number=command.number, taken=False, told="This ride is over.")
        waiting: asyncio.Future[CommandResult] = asyncio.get_running_loop().create_future()
        self._outcomes[command.number] = waiting
        vehicle.write(SocketMessage(Topic.COMMAND, vehicle.id, command.model_dump_json().encode()).packed())
        try:
            return await asyncio.wait_for(waiting, OUTCOME_S)
        except asyncio.TimeoutError:
            # The sender gets a sentence instead of an error of the server.
            return CommandResult(number=command.number, taken=False, told=UNREACHABLE)
        finally:
            self._outcomes.pop(command.number, None)

    # ---- the operators' queue

    def call_for_help(self, vehicle: Vehicle, text: str) -> None:
        """Add a passenger's call. A vehicle has at most one call."""
        if all(other != vehicle.id for other, _, _ in self._help.values()):
            self._help[f"h{self.number()}"] = (vehicle.id, text, self._clock())
        while len(self._help) > HELP_CALLS:
            self._help.popitem(last=False)

    def close_call(self, call_id: str) -> bool:
        """Close a call for help. Returns False if there is none with this id."""
        return self._help.pop(call_id, None) is not None

    def queue(self) -> tuple[OperatorCall, ...]:
        """Return the entries that wait for an operator, the longest waiting first, and after them the notices."""
        now_s = self._clock()
        calls = [
            OperatorCall(
                id=key,
                vehicle=vehicle_id,
                name=self._name(vehicle_id),
                kind="help",
                text=text,
                waiting_s=round(now_s - since_s, 1),
            )
            for key, (vehicle_id, text, since_s) in self._help.items()
        ]
        for vehicle in self._vehicles.values():
            now = vehicle.now if vehicle.asked is not None and vehicle.write is not None else None
            if now is None or now.question is None or vehicle.asked is None:
                continue
            calls.append(
                OperatorCall(
                    id=f"{vehicle.id}:{now.question.id}",
                    vehicle=vehicle.id,
                    name=vehicle.name,
                    kind="question",
                    text=f"{now.thought} {now.question.text}",
                    waiting_s=round(now_s - vehicle.asked[1], 1),
                    question_id=now.question.id,
                )
            )
        return (*sorted(calls, key=lambda call: -call.waiting_s), *self._notices(now_s))

    def _notices(self, now_s: float) -> list[OperatorCall]:
        """Return the notices of vehicles that ask nothing, the longest standing first."""
        calls = [
            OperatorCall(
                id=f"{vehicle.id}:{now.notice.id}",
                vehicle=vehicle.id,
                name=vehicle.name,
                kind="notice",
                text=now.notice.text,
                waiting_s=round(now_s - vehicle.noticed[1], 1),
            )
            for vehicle in self._vehicles.values()
            if vehicle.noticed is not None
            and vehicle.asked is None
            and vehicle.write is not None
            and (now := vehicle.now) is not None
            and now.notice is not None
        ]
        return sorted(calls, key=lambda call: -call.waiting_s)

    def _name(self, vehicle_id: str) -> str:
        vehicle = self._vehicles.get(vehicle_id)
        return vehicle_id if vehicle is None else vehicle.name
