"""Drives one street in real time, with StuckSolver and a passenger."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from random import Random
from typing import TYPE_CHECKING

from stucksolver.interpreter import find_reader
from stucksolver.ladder import Ladder, find_ladder
from stucksolver.solver import StuckSolver
from stucksolver_carla.client_connection import SimulatorServer, connect
from stucksolver_carla.drivers.behavior import DriverOptions
from stucksolver_carla.stack import CarlaStack
from stucksolver_eval.background_traffic import Background
from stucksolver_eval.drivers import make_driver
from stucksolver_eval.passenger import LiveView, Pictures, RealTimePacer
from stucksolver_eval.ride.situations import RIDES
from stucksolver_eval.routes import Route
from stucksolver_eval.routes.route_line import RouteLine
from stucksolver_eval.scenario_context import ScenarioContext
from stucksolver_eval.scenarios.player import ScenarioPlayer
from stucksolver_eval.simulator_server import CLIENT_TIMEOUT_S, open_server, set_synchronous
from stucksolver_eval.streets.routes import SimulatorTarget, street_route, with_map
from stucksolver_passenger.gateway import PassengerGateway
from stucksolver_passenger.memory import Memory

if TYPE_CHECKING:
    import carla

DT_S = 0.05
"""Length of a tick (s)."""
HERO = "vehicle.lincoln.mkz_2020"
LIFT_M = 0.3
"""Height above the road at which the ego spawns (m). Ours."""
SETTLE_TICKS = 10
"""Number of ticks for the ego to settle on its wheels. Ours."""
STANDS_MPS = 0.3
"""Speed below which the ego counts as stopped at its destination (m/s). Ours."""
VEHICLE = "car-1"
"""Id of the car on the passenger server."""


class RideError(RuntimeError):
    """The ride cannot start. The message states the reason."""


@dataclass(frozen=True)
class RideSpec:
    """Options of a ride.

    Attributes:
        case: One of `RIDES`.
        asks: Ask the passenger before the car uses the oncoming lane, unless their own guidance requested it.
        memory: File of the memory; None for no memory.
        clock: Clock of the solver; `wall` uses the real time of answers.
        host: Address of a running CARLA server, which replaces carlette.
        port: Its port.
    """

    case: str = "parked_car"
    map_name: str | None = None
    maps: str | None = None
    seed: int = 1
    driver: str = "behavior:normal"
    ladder: Path | None = None
    memory: Path | None = None
    asks: bool = True
    clock: str = "wall"
    host: str | None = None
    port: int = 2000
    tempo: float = 1.0
    """Factor on real time, if the machine is fast enough."""
    limit_s: float | None = None
    """Simulated time after which the ride ends in any case."""

    @property
    def town(self) -> str:
        """Name of the map."""
        return self.map_name or RIDES[self.case].map_name

    def policy(self) -> Ladder:
        """Return the ladder. Raises `LadderError`."""
        ladder = find_ladder(self.ladder)
        if not self.asks or self.ladder is not None:
            return ladder
        asked = {**ladder.approval.model_dump(mode="json"), "behaviors": {"borrow_oncoming_lane": "passenger"}}
        return ladder.model_copy(update={"approval": type(ladder.approval).model_validate(asked)})


@dataclass(frozen=True)
class RideOutcome:
    """End of the ride, and its pacing: number of ticks, number of late ones, and the longest delay (s)."""

    arrived: bool
    duration_s: float
    ticks: int
    late: int
    worst_s: float
    behind_s: tuple[float, ...] = ()


def find_ride(spec: RideSpec) -> Route:
    """Find a route with the case's situation. Raises `StreetError`, `CaseError` and `ServerError`."""
    case = RIDES[spec.case]
    where = SimulatorTarget(spec.town, spec.maps, spec.seed, spec.host, spec.port)
    place = with_map(where, lambda world, carla_map: case.find(world, carla_map, spec.seed))
    return street_route("1", spec.town, place.waypoints, case.type, place.parameters)


def drive_ride(
    spec: RideSpec,
    route: Route,
    desk: PassengerGateway,
    *,
    begun: Callable[[], None] = lambda: None,
    wanted: Callable[[], bool] = lambda: True,
) -> RideOutcome:
    """Drive the route in a separate simulator.

    `begun` is called when the page has content. The ride ends early if `wanted` returns False. Raises `ServerError`,
    `RideError`, `MemoryFileError`, `ScenarioError`, `RouteError`, `LadderError`, and errors of the client.
    """
    with open_server(spec.town, spec.maps, spec.seed, spec.host, spec.port, scenery=True) as server:
        return _in_world(spec, route, desk, server, begun, wanted)


def _in_world(
    spec: RideSpec,
    route: Route,
    desk: PassengerGateway,
    server: SimulatorServer,
    begun: Callable[[], None],
    wanted: Callable[[], bool],
) -> RideOutcome:
    client = connect(server, CLIENT_TIMEOUT_S)
    world = client.get_world() if spec.host is None else client.load_world(spec.town)
    set_synchronous(world, DT_S)
    line = RouteLine.trace(world.get_map(), route.waypoints)
    hero = _hero(world, line)
    for _ in range(SETTLE_TICKS):
        world.tick()
    setting = ScenarioContext(client, world, world.get_map(), hero, line, Random(f"{spec.seed}:ride"), dt_s=DT_S)
    play = ScenarioPlayer(route.scenarios, setting, Background(setting, empty=True))
    try:
        world.tick()
        ride = _Ride(spec, setting, play, desk)
        begun()
        return ride.go(wanted)
    finally:
        play.close()
        if spec.host is not None:
            set_synchronous(world, None)


def _hero(world: carla.World, line: RouteLine) -> carla.Vehicle:
    blueprint = world.get_blueprint_library().find(HERO)
    blueprint.set_attribute("role_name", "hero")
    start = line.waypoints[0].transform
    start.location.z += LIFT_M
    hero: carla.Vehicle | None = world.try_spawn_actor(blueprint, start)
    if hero is None:
        raise RideError(
            f"cannot place the car at the route's start: ({start.location.x:.1f}, {start.location.y:.1f}). "
            "Choose another seed"
        )
    return hero


class _Ride:
    """One ride. The constructor prepares it."""

    def __init__(self, spec: RideSpec, setting: ScenarioContext, play: ScenarioPlayer, desk: PassengerGateway) -> None:
        self._spec, self._setting, self._play, self._desk = spec, setting, play, desk
        hero, line = setting.hero, setting.route
        driver = make_driver(spec.driver, setting.client, hero, setting.map, line.points, DriverOptions())
        self._driver = driver
        self._stack = CarlaStack(hero, driver, setting.map)
        reader = find_reader()
        reader.read("hello", "")  # loads the interpreter now, because its first interpretation takes long
        policy, ear = spec.policy(), desk.ear(VEHICLE)
        self._memory = None if spec.memory is None else Memory(spec.memory)
        limits = policy.waits.limits()
        self._solver = StuckSolver(
            self._stack.scene,
            ladder=policy,
            reasoner=None if self._memory is None else self._memory.before(limits=limits),
            clock=spec.clock,
            on_event=ear if self._memory is None else self._memory.ear(VEHICLE, ear),
            reader=reader,
        )
        self._seat = desk.add(VEHICLE, self._solver, f"{spec.case.replace('_', ' ').capitalize()}, {spec.town}")
        self._view = LiveView(desk, VEHICLE, setting.world, hero)
        self._view.show_scenery(setting.map, line)
        self._pictures = Pictures(lambda jpeg: desk.show_picture(VEHICLE, jpeg), hero)
        self._place = 0
        self._start_s = float(setting.world.get_snapshot().timestamp.elapsed_seconds)
        self._arrived = False

    def go(self, wanted: Callable[[], bool]) -> RideOutcome:
        """Drive until the car has stopped at its destination, or the ride is no longer needed."""
        pace, time_s = RealTimePacer(DT_S / self._spec.tempo), 0.0
        try:
            while wanted() and not self._arrived and (self._spec.limit_s is None or time_s < self._spec.limit_s):
                pace.wait()
                time_s = self._tick()
                self._setting.world.tick()
        finally:
            self._pictures.close()
            self._solver.close()
            if self._memory is not None:
                self._memory.close()
                if self._memory.fault is not None:
                    print(
                        f"note: some entries of the memory were not stored: {self._memory.fault}",
                        file=sys.stderr,
                        flush=True,
                    )
            self._seat.end()
            self._desk.leave(VEHICLE)
        return RideOutcome(self._arrived, time_s, pace.ticks, pace.late, pace.worst_s, tuple(pace.behind_s))

    def _tick(self) -> float:
        """Run the steps between two ticks of the world. Returns the time since the start (s)."""
        setting = self._setting
        time_s = float(setting.world.get_snapshot().timestamp.elapsed_seconds) - self._start_s
        self._place = setting.route.project(setting.hero.get_location(), self._place)
        self._play.tick(time_s, float(setting.route.s_m[self._place]))
        status = self._stack.status()
        directive = self._solver.step(status, self._stack.surroundings)
        setting.hero.apply_control(self._play.noise(self._stack.perform(directive)))
        self._seat.tick(status, self._stack.scene)
        self._view.tick(time_s, status.speed_mps, self._stack.in_map_frame(directive))
        self._arrived = status.at_destination and status.speed_mps < STANDS_MPS
        return time_s
