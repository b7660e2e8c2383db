"""Serves one stack on one connection, from `hello` to `bye`."""

from __future__ import annotations

import contextlib
from typing import Any

from pydantic import ValidationError

from stucksolver.ladder import LadderError
from stucksolver.plan import CONTINUE
from stucksolver.plan.directive import Directive, directive_adapter
from stucksolver.plugins import PluginError
from stucksolver.reasoners.factory import sees
from stucksolver.reasoners.registry import ReasonerNameError
from stucksolver.scene import Scene, Status, Surroundings
from stucksolver.scene.base_model import first_problem
from stucksolver.scene.wording import in_one_line
from stucksolver.solver import Event, StuckSolver
from stucksolver_bridge.message_socket import VERSION, Wire
from stucksolver_carla.perception_interface import SensorError, sensor_perception
from stucksolver_carla.remote_stack import RemoteStack, UnusableError
from stucksolver_carla.session_settings import SessionSettings


class SidecarSession:
    """The session of one stack. If the stack disconnects without `bye`, its record stays incomplete."""

    def __init__(self, wire: Wire) -> None:
        self._wire = wire
        self._events: list[dict[str, Any]] = []
        self._directive: Directive | None = None
        self._number = 0
        """Number of the tick that is being answered."""

    def run(self) -> None:
        """Serve until `bye`.

        Raises `WireError` if the stack disconnects before that, `RecordError` if the record is incomplete at the end.
        """
        hello = self._wire.receive().get("hello")
        if not isinstance(hello, dict) or hello.get("version") != VERSION:
            bridge_version = str(hello.get("version") if isinstance(hello, dict) else None)[:20]
            reason = f"the bridge uses protocol version {bridge_version}, this solver uses version {VERSION}"
            self._wire.send({"error": f"{reason}; install both from the same release"})
            return
        try:
            settings = SessionSettings.model_validate(hello.get("settings", {}))
            stack = self._make_stack(hello, settings)
            recorder = settings.recorder()
            solver = settings.solver(stack.scene, self._store_event, recorder) if settings.helps else None
        except (ValidationError, LadderError, ReasonerNameError, ValueError, UnusableError) as error:
            self._wire.send({"error": f"the solver's settings are invalid: {error}"})
            return
        self._wire.send({"ready": VERSION})
        with recorder or contextlib.nullcontext(), solver or contextlib.nullcontext(), contextlib.closing(stack):
            try:
                while "bye" not in (message := self._wire.receive()):
                    tick = self._tick_of(message)
                    self._wire.send({**self._step(solver, stack, tick), "number": self._number})
            except UnusableError as error:
                self._wire.send({"error": str(error)})
                return
        if recorder is not None and recorder.error is not None:
            raise recorder.error

    def _make_stack(self, hello: dict[str, Any], settings: SessionSettings) -> RemoteStack:
        """Return the counterpart of the stack in this process. Raises `UnusableError` or `ValueError`."""
        if hello.get("sensed"):
            return _sensor_stack(hello["sensed"], settings, self._ask)
        return _MirroredStack(hello["carla"], self._ask) if hello.get("carla") else _JsonStack(self._ask)

    def _tick_of(self, message: dict[str, Any]) -> dict[str, Any]:
        """Return the tick in a message, and store its number. Raises `UnusableError`."""
        tick, number = message.get("tick"), message.get("number")
        if not isinstance(tick, dict) or type(number) is not int:
            raise UnusableError("expected a tick with a number; install bridge and solver from the same release")
        self._number = number
        return tick

    def _step(self, solver: StuckSolver | None, stack: RemoteStack, tick: dict[str, Any]) -> dict[str, Any]:
        if "say" in tick and solver is not None:
            solver.guide(str(tick["say"]))
        if tick.get("again"):
            self._directive = None
            stack.forget()
        try:
            if not stack.begin(tick):
                return {"orders": stack.waiting(), "events": stack.events()}
            status = stack.status(tick)
        except (LookupError, TypeError, ValueError, ArithmeticError) as error:
            raise UnusableError(f"invalid tick: {in_one_line(error)}") from error
        directive = CONTINUE if solver is None else solver.step(status, stack.surroundings)
        orders = stack.perform(directive)
        answer: dict[str, Any] = {}
        self._events += stack.events()
        # The comparison is by identity, because an equal directive that starts again is sent with its orders.
        if directive is not self._directive:
            answer["directive"] = directive_adapter.dump_python(stack.in_map_frame(directive), mode="json")
            self._directive = directive
        if orders:
            answer["orders"] = orders
        if self._events:
            answer["events"], self._events = self._events, []
        return answer

    def _ask(self, name: str) -> Any:
        self._wire.send({"need": name, "number": self._number})
        reply = self._wire.receive()
        if reply.get("number") != self._number:
            raise UnusableError(f"{name} belong to another tick; install bridge and solver from the same release")
        return reply.get("given")

    def _store_event(self, event: Event) -> None:
        verdict = None if event.verdict is None else str(event.verdict)
        message = {"time_s": event.time_s, "kind": event.kind.value, "text": event.text, "verdict": verdict}
        self._events.append(message)


def _sensor_stack(opening: dict[str, Any], settings: SessionSettings, ask: Any) -> RemoteStack:
    uses_image = sees(settings.recovery) or sees(settings.reasoner or "")
    try:
        return sensor_perception().remote_stack(opening, settings, ask, uses_image=uses_image)
    except (SensorError, PluginError) as error:
        raise UnusableError(str(error)) from error


class _JsonStack(RemoteStack):
    """A stack that builds its surroundings and scenes itself."""

    def __init__(self, ask: Any) -> None:
        self._ask = ask

    def status(self, tick: dict[str, Any]) -> Status:
        """Return the status, also with invalid values: the solver reports them and does not act."""
        form = tick["status"]
        try:
            return Status.model_validate(form, strict=True)
        except ValidationError as error:
            if not isinstance(form, dict) or not form.keys() <= Status.model_fields.keys():
                raise UnusableError(f"invalid status: {first_problem(error)}") from error
            # Created without validation, so that the solver's own check reports the fault as an event.
            return Status.model_construct(**form)

    def surroundings(self) -> Surroundings:
        return Surroundings.model_validate(self._ask("surroundings"))

    def scene(self, surroundings: Surroundings) -> Scene | None:
        """Return the scene of the stack, which builds it from its own surroundings."""
        reply = self._ask("scene")
        return None if reply is None else Scene.model_validate(reply)

    def perform(self, directive: Directive) -> list[Any]:
        """Return no orders, because the stack performs the directive itself."""
        return []

    def forget(self) -> None:
        """Do nothing, because there are no orders."""


class _MirroredStack(RemoteStack):
    """A CARLA world that sends raw data: `CarlaStack` on a mirror of it."""

    def __init__(self, opening: dict[str, Any], ask: Any) -> None:
        # A late import, because only this kind of stack requires the carla package.
        from stucksolver_carla.sidecar.mirrored_world import MirrorDriver, MirrorVehicle, MirrorWorld
        from stucksolver_carla.stack import CarlaStack

        self._orders: list[Any] = []
        self._world = MirrorWorld(opening, ask)
        self._world.start_tick(opening["tick"])
        self._ego = MirrorVehicle(self._world, opening, ask, self._orders)
        driver = MirrorDriver(self._world, self._ego, opening, self._orders)
        self._stack = CarlaStack(self._ego, driver, self._world.map)

    def status(self, tick: dict[str, Any]) -> Status:
        self._world.start_tick(tick)
        return self._stack.status()

    def surroundings(self) -> Surroundings:
        # The request comes first: if its answer is from a later tick, it sets the ego to that tick as well.
        self._world.request_actors()
        return self._stack.surroundings()

    def scene(self, surroundings: Surroundings) -> Scene | None:
        return self._stack.scene(surroundings)

    def forget(self) -> None:
        """Send all orders again, because the stack has rejected or lost the last ones."""
        self._stack.forget()

    def in_map_frame(self, directive: Directive) -> Directive:
        return self._stack.in_map_frame(directive)

    def perform(self, directive: Directive) -> list[Any]:
        self._stack.perform(directive)
        orders, self._orders[:] = list(self._orders), []
        return orders
