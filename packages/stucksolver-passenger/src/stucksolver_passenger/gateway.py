"""The desk: connects the vehicles of a process to the people who talk to them. This is what an engineer embeds."""

from __future__ import annotations

from collections.abc import Mapping
from json import dumps
from pathlib import Path
from types import TracebackType
from typing import Any

from stucksolver.solver import StuckSolver
from stucksolver.solver.events import Listener
from stucksolver.solver.state_machine.state import State
from stucksolver_passenger.api_types import VEHICLE_ID, PersonCommand, VehicleReport
from stucksolver_passenger.conversation import Conversation
from stucksolver_passenger.link import Link
from stucksolver_passenger.socket_frames import SocketMessage, Topic
from stucksolver_passenger.vehicle_session import VehicleSession, VehicleSessions


class PassengerGateway:
    """Connects vehicles to a passenger server. It never makes a control loop wait.

    ```python desk = Desk(server.address) solver = StuckSolver(stack.scene, on_event=desk.ear("car-1")) seat =
    desk.add("car-1", solver, name="Car 1") ... directive = solver.step(status, stack.surroundings)  # on every tick
    seat.tick(status, stack.scene) ```

    Several processes may each have a desk at the same server.

    Args:
        address: Address of a `PassengerServer`.

    Raises:
        LinkError: The server cannot be reached.
    """

    def __init__(self, address: Path) -> None:
        self._conversations: dict[str, Conversation] = {}
        self._solvers: dict[str, StuckSolver] = {}
        self._seats = VehicleSessions()
        self._link = Link(address, self._receive)

    def ear(self, vehicle_id: str) -> Listener:
        """Return the listener for a vehicle's solver (`on_event`). Get it before the solver is made."""
        return self._conversation(vehicle_id).hear

    def add(self, vehicle_id: str, solver: StuckSolver, name: str = "") -> VehicleSession:
        """Add a vehicle.

        Args:
            vehicle_id: Up to 40 letters, digits, - and _.
            solver: The vehicle's solver.
            name: What people call the vehicle.

        Raises:
            ValueError: The id is invalid or already used.
        """
        if not VEHICLE_ID.fullmatch(vehicle_id):
            raise ValueError(f"{vehicle_id!r} is not a valid vehicle id; use up to 40 letters, digits, - and _")
        conversation = self._conversation(vehicle_id)
        seat = VehicleSession(solver, conversation, lambda now: self._publish(vehicle_id, now))
        self._seats.add(vehicle_id, seat)
        self._solvers[vehicle_id] = solver
        self._link.send(SocketMessage(Topic.HELLO, vehicle_id, (name or vehicle_id).encode()))
        return seat

    def show_scenery(self, vehicle_id: str, scenery: Mapping[str, Any]) -> None:
        """Send the static part of the view from above, at the start and whenever the route changes."""
        self._link.send(SocketMessage(Topic.SCENERY, vehicle_id, _json(scenery)))

    def show_view(self, vehicle_id: str, view: Mapping[str, Any]) -> None:
        """Send the moving part of the view from above."""
        self._link.send(SocketMessage(Topic.VIEW, vehicle_id, _json(view)))

    def show_picture(self, vehicle_id: str, jpeg: bytes) -> None:
        """Send the front camera's image."""
        self._link.send(SocketMessage(Topic.PICTURE, vehicle_id, jpeg))

    def leave(self, vehicle_id: str) -> None:
        """End the vehicle's ride. Its page says so and stays."""
        self._link.send(SocketMessage(Topic.BYE, vehicle_id))

    def close(self) -> None:
        """Send what is left and disconnect from the server."""
        self._link.close()

    def __enter__(self) -> PassengerGateway:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _conversation(self, vehicle_id: str) -> Conversation:
        if vehicle_id not in self._conversations:
            self._conversations[vehicle_id] = Conversation(lambda: self._state(vehicle_id))
        return self._conversations[vehicle_id]

    def _state(self, vehicle_id: str) -> State | None:
        solver = self._solvers.get(vehicle_id)
        return None if solver is None else solver.state

    def _publish(self, vehicle_id: str, now: VehicleReport) -> None:
        self._link.send(SocketMessage(Topic.NOW, vehicle_id, now.model_dump_json().encode()))

    def _receive(self, frame: SocketMessage) -> None:
        """Handle a command from the server, on the link's own thread; the solver accepts it from any thread."""
        if frame.topic is Topic.COMMAND:
            outcome = self._seats.take(frame.vehicle, PersonCommand.model_validate_json(frame.payload))
            self._link.send(SocketMessage(Topic.OUTCOME, frame.vehicle, outcome.model_dump_json().encode()))


def _json(data: Mapping[str, Any]) -> bytes:
    return dumps(data, separators=(",", ":"), allow_nan=False).encode()
