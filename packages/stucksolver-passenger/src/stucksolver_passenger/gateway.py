"""The gateway that connects the vehicles of a process to people. It is the interface for embedding."""

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
    """Connects vehicles to a passenger server. It never blocks a control loop.

    ```python
    gateway = PassengerGateway(server.address)
    solver = StuckSolver(stack.scene, on_event=gateway.ear("car-1"))
    session = gateway.add("car-1", solver, name="Car 1")
    ...
    directive = solver.step(status, stack.surroundings)  # on every tick
    session.tick(status, stack.scene)
    ```

    Several processes may each have a gateway to the same server.

    Args:
        address: Address of a `PassengerServer`.

    Raises:
        LinkError: The server cannot be reached.
    """

    def __init__(self, address: Path) -> None:
        self._conversations: dict[str, Conversation] = {}
        self._solvers: dict[str, StuckSolver] = {}
        self._sessions = VehicleSessions()
        self._link = Link(address, self._receive)

    def ear(self, vehicle_id: str) -> Listener:
        """Return the listener for a vehicle's solver (`on_event`). Call this before creating the solver."""
        return self._conversation(vehicle_id).hear

    def add(self, vehicle_id: str, solver: StuckSolver, name: str = "") -> VehicleSession:
        """Add a vehicle.

        Args:
            vehicle_id: Up to 40 letters, digits, - and _.
            solver: The vehicle's solver.
            name: Name of the vehicle for people.

        Raises:
            ValueError: The id is invalid or already used.
        """
        if not VEHICLE_ID.fullmatch(vehicle_id):
            raise ValueError(f"invalid vehicle id: {vehicle_id!r}. Use up to 40 letters, digits, - and _")
        conversation = self._conversation(vehicle_id)
        session = VehicleSession(solver, conversation, lambda now: self._publish(vehicle_id, now))
        self._sessions.add(vehicle_id, session)
        self._solvers[vehicle_id] = solver
        self._link.send(SocketMessage(Topic.HELLO, vehicle_id, (name or vehicle_id).encode()))
        return session

    def show_scenery(self, vehicle_id: str, scenery: Mapping[str, Any]) -> None:
        """Send the static part of the view from above, at the start and after every change of the route."""
        self._link.send(SocketMessage(Topic.SCENERY, vehicle_id, _json(scenery)))

    def show_view(self, vehicle_id: str, view: Mapping[str, Any]) -> None:
        """Send the moving part of the view from above."""
        self._link.send(SocketMessage(Topic.VIEW, vehicle_id, _json(view)))

    def show_picture(self, vehicle_id: str, jpeg: bytes) -> None:
        """Send the front camera's image."""
        self._link.send(SocketMessage(Topic.PICTURE, vehicle_id, jpeg))

    def leave(self, vehicle_id: str) -> None:
        """End the vehicle's ride. Its page stays open and displays the end."""
        self._link.send(SocketMessage(Topic.BYE, vehicle_id))

    def close(self) -> None:
        """Send the queued frames and disconnect from the server."""
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
        """Handle a command from the server, on the link's own thread. The solver accepts it from any thread."""
        if frame.topic is Topic.COMMAND:
            outcome = self._sessions.take(frame.vehicle, PersonCommand.model_validate_json(frame.payload))
            self._link.send(SocketMessage(Topic.OUTCOME, frame.vehicle, outcome.model_dump_json().encode()))


def _json(data: Mapping[str, Any]) -> bytes:
    return dumps(data, separators=(",", ":"), allow_nan=False).encode()
