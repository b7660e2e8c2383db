"""Creates systems from their names."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from stucksolver.immobilization import DetectorSettings
from stucksolver.ladder import find_ladder
from stucksolver.reasoners import Reasoner
from stucksolver.reasoners.factory import make_reasoner, preflight, sees
from stucksolver.reasoners.faulty import FAULTY, make_faulty
from stucksolver.reasoners.registry import ReasonerNameError
from stucksolver.record import Recorder
from stucksolver.solver import StuckSolver
from stucksolver_carla.stack import CarlaStack
from stucksolver_carla.stack.client_interface import EgoVehicle
from stucksolver_carla.stack.front_camera import FrontCamera, PictureSource
from stucksolver_eval.drivers import DriverNameError, RouteDriver, check_driver
from stucksolver_eval.routes.route_line import RouteLine
from stucksolver_eval.systems.solver_system import Listener, SolverSystem
from stucksolver_eval.systems.spec import SENSORS, SystemSpec
from stucksolver_eval.systems.system_under_test import DriverOnly, SystemUnderTest
from stucksolver_eval.systems.timed_reasoner import TimedReasoner
from stucksolver_eval.systems.timer_baseline import TimerSystem
from stucksolver_eval.systems.unguarded import PermissiveGuard
from stucksolver_passenger.memory import Memory, MemoryFileError, SolutionStore
from stucksolver_perception.camera.sign_reader import UNREAD, unavailable_reason

if TYPE_CHECKING:
    import carla

NONE = "none"
"""System without recovery."""
TIMERS = "timers"
"""System with recovery by timers."""
FAULTY_PREFIX = "faulty:"
"""Prefix of systems with a reasoner that fails by design. The kind of failure follows."""
VEHICLE = "car-1"
"""Name of the vehicle in a memory."""
EXCHANGES = "exchanges"
"""Folder next to the records: every request to a model, and its answer."""


class SystemSpecError(ValueError):
    """There is no such system. The message lists the existing ones."""


def check_arm(spec: SystemSpec) -> None:
    """Check a system.

    Raises:
        SystemSpecError: The driver, the recovery or the reasoner does not exist, or they do not fit together.
        LadderError: The ladder cannot be used.
    """
    try:
        check_driver(spec.driver)
    except DriverNameError as error:
        raise SystemSpecError(str(error)) from error
    _check_perception(spec)
    _check_memory(spec)
    if spec.recovery not in (NONE, TIMERS):
        _reasoner(spec.recovery, 0)
    elif not spec.guarded:
        raise SystemSpecError(
            f"--unguarded needs a recovery with a guard: {spec.recovery!r} has none. Choose another --recovery"
        )
    elif spec.reasoner:
        raise SystemSpecError(
            f"--reasoner {spec.reasoner} needs a recovery that uses it: {spec.recovery!r} does not. "
            "Choose another --recovery"
        )
    if spec.reasoner:
        _reasoner(spec.reasoner, 0)
    if spec.ladder is not None:
        # It is read once, so that errors appear before the drive.
        find_ladder(spec.ladder)


def _check_perception(spec: SystemSpec) -> None:
    if spec.perception == SENSORS:
        from stucksolver_perception.pipeline import unavailable_reason

        # This loads all weights once, so that errors appear before the drive.
        why = unavailable_reason()
        if why:
            raise SystemSpecError(f"--perception sensors: {why}")
    if spec.sensor_fault:
        from stucksolver_perception.carla.sensor_faults import FAULTS

        if spec.perception != SENSORS:
            raise SystemSpecError("--sensor-fault needs --perception sensors")
        if spec.sensor_fault not in FAULTS:
            raise SystemSpecError(f"unknown sensor fault: {spec.sensor_fault!r}. Choose from {', '.join(FAULTS)}")


def _check_memory(spec: SystemSpec) -> None:
    if spec.memory is None:
        return
    if spec.recovery in (NONE, TIMERS):
        raise SystemSpecError(
            f"--memory needs a recovery that proposes plans: {spec.recovery!r} does not. Choose another --recovery"
        )
    try:
        SolutionStore(spec.memory)
    except MemoryFileError as error:
        raise SystemSpecError(f"--memory: {error}") from error


def preflight_arm(spec: SystemSpec) -> tuple[str, ...]:
    """Check once that each reasoner responds, and whether signs are read. Returns notes for the user, one line each.

    Raises:
        SystemSpecError: A reasoner does not respond.
    """
    words = [item for item in (spec.recovery, spec.reasoner) if item not in ("", NONE, TIMERS)]
    unread = unavailable_reason() if spec.perception == SENSORS else None
    notes = () if unread is None else (f"{UNREAD}: {unread}",)
    try:
        return (*notes, *(note for word in words for note in preflight(_reasoner(word, 0), word)))
    except ReasonerNameError as error:
        raise SystemSpecError(str(error)) from error


def carries_camera(spec: SystemSpec) -> bool:
    """True if a reasoner uses images. The camera costs more than everything else in a tick."""
    return spec.camera or sees(spec.recovery) or sees(spec.reasoner)


def make_arm(
    spec: SystemSpec,
    ego: EgoVehicle,
    driver: RouteDriver,
    carla_map: carla.Map,
    line: RouteLine,
    seed: int,
    records: Path | None,
) -> SystemUnderTest:
    """Make a system for a driver with its route.

    Args:
        spec: The system.
        ego: The vehicle.
        driver: Its driver.
        carla_map: The map.
        line: The route's line.
        seed: Seed of random choices.
        records: Folder for a record of each intervention, if any.

    Raises:
        SystemSpecError: The system cannot be made.
        LadderError: The ladder cannot be used.
    """
    if spec.recovery == NONE:
        return DriverOnly(driver)
    if spec.recovery == TIMERS:
        return TimerSystem(ego, driver, line)
    exchanges = None if records is None else records / EXCHANGES
    ladder = find_ladder(spec.ladder or "evaluation")
    asked = _reasoner(spec.recovery, seed, exchanges)
    memory = None if spec.memory is None else Memory(spec.memory)
    first = TimedReasoner(asked if memory is None else memory.before(asked, ladder.waits.limits()))
    models = {"model": TimedReasoner(_reasoner(spec.reasoner, seed, exchanges))} if spec.reasoner else {}
    recorder = None if records is None else Recorder(records)
    camera = _camera(ego) if carries_camera(spec) else None
    stack = CarlaStack(ego, driver, carla_map, camera=camera)

    def make(listener: Listener) -> StuckSolver:
        """Return the system's solver, which emits its events to `listener`."""
        return StuckSolver(
            stack.scene,
            ladder=ladder,
            reasoner=first,
            guard=None if spec.guarded else PermissiveGuard(),
            models=models,
            detector=DetectorSettings(**spec.detector),
            clock=spec.clock,
            on_event=listener if memory is None else memory.ear(VEHICLE, listener),
            record=recorder,
        )

    return SolverSystem(stack, [first, *models.values()], make, recorder, camera, memory)


def _camera(ego: Any) -> PictureSource:
    """Return the vehicle's own camera if it uses its sensors, else a new one."""
    eyes = getattr(ego, "perceiver", None)
    found: PictureSource = FrontCamera(ego) if eyes is None else eyes.camera()
    return found


def _reasoner(words: str, seed: int, exchanges: Path | None = None) -> Reasoner:
    if words.startswith(FAULTY_PREFIX):
        name = words.removeprefix(FAULTY_PREFIX)
        if name not in FAULTY:
            raise SystemSpecError(f"unknown reasoner: {words!r}. Faulty ones are {', '.join(FAULTY)}")
        return make_faulty(name, seed)
    try:
        return make_reasoner(words, exchanges)
    except ReasonerNameError as error:
        raise SystemSpecError(f"{error}; a recovery may also be {NONE}, {TIMERS} or {FAULTY_PREFIX}NAME") from error
