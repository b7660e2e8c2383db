"""One stack on one connection, from `hello` to `bye`."""

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
    """Serves one stack. If it disconnects without `bye`, it has died, and its record is left incomplete."""

    def __init__(self, wire: Wire) -> None:
        self._wire = wire
        self._events: list[dict[str, Any]] = []
        self._directive: Directive | None = None
        self._number = 0
        """Number of the tick that is being answered."""

    def run(self) -> None:
        """Serve until `bye`.

        Raises `WireError` if the stack disconnects without it, `RecordError` if the record is incomplete at the end.
        """
        hello = self._wire.receive().get("hello")
        if not isinstance(hello, dict) or hello.get("version") != VERSION:
            theirs = str(hello.get("version") if isinstance(hello, dict) else None)[:20]
            differ = f"the bridge speaks version {theirs} of the link's protocol, this solver version {VERSION}"
            self._wire.send({"error": f"{differ}; install both from the same release"})
            return
        try:
            settings = SessionSettings.model_validate(hello.get("settings", {}))
            side = self._side(hello, settings)
            recorder = settings.recorder()
            solver = settings.solver(side.scene, self._hear, recorder) if settings.helps else None
        except (ValidationError, LadderError, ReasonerNameError, ValueError, UnusableError) as error:
            self._wire.send({"error": f"the solver's settings cannot be used: {error}"})
            return
        self._wire.send({"ready": VERSION})
        with recorder or contextlib.nullcontext(), solver or contextlib.nullcontext(), contextlib.closing(side):
            try:
                while "bye" not in (told := self._wire.receive()):
                    tick = self._begin(told)
                    self._wire.send({**self._step(solver, side, tick), "number": self._number})
            except UnusableError as error:
                self._wire.send({"error": str(error)})
                return
        if recorder is not None and recorder.error is not None:
            raise recorder.error

    def _side(self, hello: dict[str, Any], settings: SessionSettings) -> RemoteStack:
        """Return the stack's part of this process. Raises `UnusableError` or `ValueError`."""
        if hello.get("sensed"):
            return _sensed(hello["sensed"], settings, self._ask)
        return _Carla(hello["carla"], self._ask) if hello.get("carla") else _Forms(self._ask)

    def _begin(self, told: dict[str, Any]) -> dict[str, Any]:
        """Return the tick in a message, and note its number. Raises `UnusableError`."""
        tick, number = told.get("tick"), told.get("number")
        if not isinstance(tick, dict) or type(number) is not int:
            raise UnusableError("a message is no tick with a number; install bridge and solver from the same release")
        self._number = number
        return tick

    def _step(self, solver: StuckSolver | None, side: RemoteStack, tick: dict[str, Any]) -> dict[str, Any]:
        if "say" in tick and solver is not None:
            solver.guide(str(tick["say"]))
        if tick.get("again"):
            self._directive = None
            side.forget()
        try:
            if not side.begin(tick):
                return {"orders": side.waiting(), "events": side.events()}
            status = side.status(tick)
        except (LookupError, TypeError, ValueError, ArithmeticError) as error:
            raise UnusableError(f"a tick cannot be used: {in_one_line(error)}") from error
        directive = CONTINUE if solver is None else solver.step(status, side.surroundings)
        orders = side.perform(directive)
        answer: dict[str, Any] = {}
        self._events += side.events()
        # Compare by identity: an equal directive that starts again is sent with its orders.
        if directive is not self._directive:
            answer["directive"] = directive_adapter.dump_python(directive, mode="json")
            self._directive = directive
        if orders:
            answer["orders"] = orders
        if self._events:
            answer["events"], self._events = self._events, []
        return answer

    def _ask(self, what: str) -> Any:
        self._wire.send({"need": what, "number": self._number})
        given = self._wire.receive()
        if given.get("number") != self._number:
            raise UnusableError(f"{what} of another tick were given; install bridge and solver from the same release")
        return given.get("given")

    def _hear(self, event: Event) -> None:
        verdict = None if event.verdict is None else str(event.verdict)
        told = {"time_s": event.time_s, "kind": event.kind.value, "text": event.text, "verdict": verdict}
        self._events.append(told)


def _sensed(opening: dict[str, Any], settings: SessionSettings, ask: Any) -> RemoteStack:
    uses_image = sees(settings.recovery) or sees(settings.reasoner or "")
    try:
        return sensor_perception().remote_stack(opening, settings, ask, uses_image=uses_image)
    except (SensorError, PluginError) as error:
        raise UnusableError(str(error)) from error


class _Forms(RemoteStack):
    """A stack that builds its surroundings and scenes itself."""

    def __init__(self, ask: Any) -> None:
        self._ask = ask

    def status(self, tick: dict[str, Any]) -> Status:
        """Return the status as it came. The solver names what is wrong in it, and leaves the vehicle to its driver."""
        form = tick["status"]
        try:
            return Status.model_validate(form, strict=True)
        except ValidationError as error:
            if not isinstance(form, dict) or not form.keys() <= Status.model_fields.keys():
                raise UnusableError(f"a status cannot be used: {first_problem(error)}") from error
            return Status.model_construct(**form)

    def surroundings(self) -> Surroundings:
        return Surroundings.model_validate(self._ask("surroundings"))

    def scene(self, seen: Surroundings) -> Scene | None:
        """The stack makes its own of what it sees; nothing else can be added to a form."""
        given = self._ask("scene")
        return None if given is None else Scene.model_validate(given)

    def perform(self, directive: Directive) -> list[Any]:
        """Return no orders: the stack performs the directive itself."""
        return []

    def forget(self) -> None:
        """Do nothing: there is nothing to repeat."""


class _Carla(RemoteStack):
    """A CARLA world reported as raw facts: `CarlaStack` on its mirror."""

    def __init__(self, opening: dict[str, Any], ask: Any) -> None:
        # The carla package is needed only here.
        from stucksolver_carla.sidecar.mirrored_world import MirrorDriver, MirrorVehicle, MirrorWorld
        from stucksolver_carla.stack import CarlaStack

        self._orders: list[Any] = []
        self._world = MirrorWorld(opening, ask)
        self._world.turn_to(opening["tick"])
        self._ego = MirrorVehicle(self._world, opening, ask, self._orders)
        driver = MirrorDriver(self._world, self._ego, opening, self._orders)
        self._stack = CarlaStack(self._ego, driver, self._world.map)

    def status(self, tick: dict[str, Any]) -> Status:
        self._world.turn_to(tick)
        return self._stack.status()

    def surroundings(self) -> Surroundings:
        # First, because a late request is answered for a later tick, and then the ego must be of that tick, too.
        self._world.look()
        return self._stack.surroundings()

    def scene(self, seen: Surroundings) -> Scene | None:
        return self._stack.scene(seen)

    def forget(self) -> None:
        """Repeat all orders: the driver's side is not performing the last ones."""
        self._stack.forget()

    def perform(self, directive: Directive) -> list[Any]:
        self._stack.perform(directive)
        orders, self._orders[:] = list(self._orders), []
        return orders
