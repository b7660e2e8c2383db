"""Drives one route from start to end and applies the criteria."""

from __future__ import annotations

import time
from collections.abc import Callable
from pkgutil import resolve_name
from random import Random
from typing import TYPE_CHECKING

from stucksolver.solver import Event
from stucksolver_carla.client_connection import SimulatorServer, connect
from stucksolver_carla.drivers.behavior import DriverOptions, RoutePoint
from stucksolver_eval.background_traffic import Background
from stucksolver_eval.coarse_positions import coarse_positions
from stucksolver_eval.criteria import EgoTick
from stucksolver_eval.criteria.monitor import CriteriaMonitor
from stucksolver_eval.criteria.route_timeout import TIMED_OUT
from stucksolver_eval.drivers import make_driver
from stucksolver_eval.drivers.user_agent_driver import UserAgentDriver
from stucksolver_eval.guidance.script_player import ScriptPlayer
from stucksolver_eval.near_miss import NearMissWatch
from stucksolver_eval.passenger import PassengerPage
from stucksolver_eval.results.checkpoint import make_record
from stucksolver_eval.results.metric_info import MetricInfo
from stucksolver_eval.results.outcome import RouteOutcome, SpokenGuidance, TimedInfraction
from stucksolver_eval.results.route_result import RouteResult
from stucksolver_eval.routes.route_line import RouteLine
from stucksolver_eval.runner.immobilization_watch import ImmobilizationWatch, TrafficSpeeds
from stucksolver_eval.runner.isolated_process import PROGRESS_EVERY_S
from stucksolver_eval.runner.job import RouteJob
from stucksolver_eval.runner.perception_source import PerceptionSource, knowledge_of
from stucksolver_eval.runner.recording_spec import Recording, TickPart
from stucksolver_eval.runner.run_log_collector import ReplayKeeper
from stucksolver_eval.runner.weather import Weather
from stucksolver_eval.scenario_context import ScenarioContext
from stucksolver_eval.scenarios.player import ScenarioPlayer
from stucksolver_eval.simulator_server import CLIENT_TIMEOUT_S, set_synchronous
from stucksolver_eval.systems import make_arm
from stucksolver_eval.systems.factory import NONE, TIMERS
from stucksolver_eval.systems.solver_system import SolverSystem
from stucksolver_eval.systems.system_under_test import SystemUnderTest, TickInfo

if TYPE_CHECKING:
    import carla


DT_S = 0.05
"""Length of a tick (s)."""
HERO = "vehicle.lincoln.mkz_2020"
LIFT_M = 0.3
"""Height above the road at which the ego spawns (m). Ours."""
SETTLE_TICKS = 10
"""Number of ticks for the ego to settle on its wheels. Ours."""
BEYOND_END_M = 20
"""Length of the driver's route beyond the destination (m), so that the driver does not brake for it. Ours."""


class DriveError(RuntimeError):
    """A route cannot be driven as specified. The message states the problem and its position."""


def drive_route(job: RouteJob, server: SimulatorServer, progress: Callable[[float], None]) -> RouteResult:
    """Drive one route in a fresh world. Raises `RouteError`, `ScenarioError`, `DriveError`, and the client's errors."""
    client = connect(server, CLIENT_TIMEOUT_S)
    world = client.get_world() if job.host is None else client.load_world(job.route.town)
    set_synchronous(world, DT_S)
    if job.host is not None:
        # Carlette waits from its start on. On another server the lights have been running.
        world.reset_all_traffic_lights()
    world.tick()  # a world without a tick has no snapshot yet
    try:
        return _drive(job, client, world, progress)
    finally:
        if job.host is not None:
            set_synchronous(world, None)


def _drive(job: RouteJob, client: carla.Client, world: carla.World, progress: Callable[[float], None]) -> RouteResult:
    carla_map = world.get_map()
    line = RouteLine.trace(carla_map, job.route.waypoints)
    if job.arm.recovery not in (NONE, TIMERS) and (coarse := coarse_positions(line.waypoints)):
        raise DriveError(f"route {job.route.id} has {coarse}")
    hero = _hero(world, line)
    knows = knowledge_of(job, hero, carla_map)
    for _ in range(SETTLE_TICKS):
        world.tick()
        knows.tick()
    setting = ScenarioContext(client, world, carla_map, hero, line, Random(f"{job.seed}:{job.route.id}"), dt_s=DT_S)
    play = ScenarioPlayer(job.route.scenarios, setting, Background(setting, empty=not job.background))
    try:
        world.tick()
        return _Drive(job, setting, play, knows).go(progress)
    finally:
        knows.close()
        play.close()


def _hero(world: carla.World, line: RouteLine) -> carla.Vehicle:
    blueprint = world.get_blueprint_library().find(HERO)
    blueprint.set_attribute("role_name", "hero")
    start = line.waypoints[0].transform
    start.location.z += LIFT_M
    hero: carla.Vehicle | None = world.try_spawn_actor(blueprint, start)
    if hero is None:
        place = start.location
        raise DriveError(f"cannot place the ego at the route's start: ({place.x:.1f}, {place.y:.1f}). Move the start")
    return hero


class _Drive:
    """One run. The constructor prepares it."""

    def __init__(self, job: RouteJob, setting: ScenarioContext, play: ScenarioPlayer, knows: PerceptionSource) -> None:
        self._job, self._setting, self._play, self._knows = job, setting, play, knows
        self._world, self._hero, self._line = setting.world, setting.hero, setting.route
        options = DriverOptions(heeds_on_path=not job.arm.heedless)
        route = self._line.points + _beyond(self._line)
        knows.tick()
        # Driver and solver may use the ego's sensors. The criteria use the ground truth.
        ego = play.perceived(knows.vehicle)
        driver = make_driver(job.arm.driver, setting.client, self._hero, setting.map, route, options, ego)
        self._driver, self._driven_route = driver, driver.route
        self._arm: SystemUnderTest = make_arm(job.arm, ego, driver, setting.map, self._line, job.seed, job.records)
        self._jury = CriteriaMonitor(self._world, setting.map, self._hero, self._line, play)
        self._speaker = ScriptPlayer(job.lines, Random(f"{job.seed}:{job.route.id}:guidance"))
        self._weather = Weather(self._world, job.route.weathers)
        self._spells, self._near = ImmobilizationWatch(), NearMissWatch(self._world, self._hero)
        self._speeds = TrafficSpeeds(self._world)
        self._metric = MetricInfo()
        self._track: list[tuple[float, float]] = []
        self._start_s = float(self._world.get_snapshot().timestamp.elapsed_seconds)
        self._replay = _replay(job, setting, self._arm)
        self._crowd = _scattered(job, setting)
        self._recorder = _recorder(job, setting)
        self._passenger_page = _make_passenger_page(job, setting, self._arm)
        self._events: list[Event] = []
        if job.events and isinstance(self._arm, SolverSystem):
            self._arm.listen(self._hear)
        self._ticks = 0
        self._time_s = 0.0
        self._released = False
        """True if an operator has approved the crossing of a broken light."""

    def go(self, progress: Callable[[float], None]) -> RouteResult:
        """Drive until the route ends. Returns the results."""
        began, next_progress_s = time.monotonic(), 0.0
        try:
            while (failure := self._tick()) is None:
                self._world.tick()
                self._knows.tick()
                if self._recorder is not None:
                    self._recorder.tick()
                if self._time_s >= next_progress_s:
                    next_progress_s += PROGRESS_EVERY_S
                    progress(self._time_s)
            self._arm.close(self._time_s)
            self._spells.finish(self._time_s)
            self._jury.finish()
            return self._driven(failure or None, time.monotonic() - began)
        finally:
            self._jury.close()
            if self._passenger_page is not None:
                self._passenger_page.close()
            if self._recorder is not None:
                self._recorder.close()
            if isinstance(self._driver, UserAgentDriver):
                self._driver.close()

    def _tick(self) -> str | None:
        """Run the steps between two ticks of the world. Returns the end of the route, or None if it continues."""
        snapshot = self._world.get_snapshot()
        self._time_s = time_s = float(snapshot.timestamp.elapsed_seconds) - self._start_s
        transform, velocity = self._hero.get_transform(), self._hero.get_velocity()
        place_m = self._jury.completion.s_m
        if self._crowd is not None:
            self._crowd.tick(time_s)
        self._play.tick(time_s, place_m)
        moment = EgoTick(
            frame=int(snapshot.frame),
            time_s=time_s,
            transform=transform,
            velocity=velocity,
            suspended=self._play.suspended | ({"red_light"} if self._released else set()),
            background_mps=self._speeds.read(snapshot),
        )
        if self._driver.route is not self._driven_route:
            self._take_new_route(moment)
        failure = self._jury.update(moment)
        self._metric.add(self._hero, transform)
        self._measure(moment)
        if failure is None and self._job.limit_s is not None and time_s > self._job.limit_s:
            failure = TIMED_OUT
        if failure is not None:
            return failure
        self._ticks += 1
        now = TickInfo(time_s, moment.speed_mps, self._jury.completion.s_m)
        self._play_guidance(now)
        control = self._arm.step(now)
        self._hero.apply_control(self._play.noise(self._knows.checked(control)))
        if self._replay is not None:
            self._replay.tick(now, self._arm.directive)
        if self._passenger_page is not None:
            self._passenger_page.tick(time_s, self._arm.directive)
        return None

    def _play_guidance(self, now: TickInfo) -> None:
        """Forward the utterances and replies of the guidance script for this tick."""
        arm = self._arm
        question = arm.solver.pending_question if isinstance(arm, SolverSystem) else None
        for line, text in self._speaker.due(now.time_s, now.place_m, now.speed_mps, question):
            if line.answer is None:
                arm.say(text)
            elif isinstance(arm, SolverSystem):
                answered = arm.answer(line.answer == "yes", line.by)
                if answered is not None and line.answer == "yes" and "red_light" in answered.needs:
                    self._released = (
                        self._play.expected == "ask"
                    )  # only at a broken light; at any other, an approval changes nothing
            when_s = round(now.time_s, 2)
            guidance = SpokenGuidance(kind=line.kind, time_s=when_s, text=text, help=line.help, by=line.by)
            arm.log.guidance.append(guidance)

    def _hear(self, event: Event) -> None:
        self._events.append(event.model_copy(update={"time_s": event.time_s - self._start_s}))

    def _take_new_route(self, moment: EgoTick) -> None:
        """Adopt the driver's new route, if the scenario allows leaving the original one."""
        self._driven_route = self._driver.route
        if "route_deviation" in moment.suspended:
            self._jury.reroute(RouteLine.along(self._driven_route))

    def _measure(self, moment: EgoTick) -> None:
        place_m = self._jury.completion.s_m
        new_m = float(self._jury.line.new_ground_m[self._jury.completion.index])
        self._spells.update(moment.time_s, moment.speed_mps, new_m)
        self._near.update(moment.time_s, moment.transform, moment.velocity)
        self._weather.update(self._jury.completion.percentage)
        if moment.time_s >= len(self._track) - 1e-6:
            self._track.append((round(moment.time_s, 2), round(place_m, 1)))

    def _driven(self, failure: str | None, wall_s: float) -> RouteResult:
        job, jury, log = self._job, self._jury, self._arm.log
        record = make_record(
            route_id=job.route.id,
            scenario=job.scenario,
            town=job.route.town,
            length_m=jury.line.length_m,
            game_s=self._time_s,
            wall_s=wall_s,
            completion_pct=jury.completion.percentage,
            failure=failure,
            infractions=jury.infractions,
        )
        inside = [bool(w.is_junction) for w in jury.line.waypoints]
        outcome = RouteOutcome(
            route_id=job.route.id,
            scenario=job.scenario,
            town=job.route.town,
            seed=job.seed,
            arm=job.arm.name,
            expected=self._play.expected,
            within_s=self._play.within_s,
            marks={mark: round(time_s, 2) for mark, time_s in self._play.marks.items()},
            asked_s=log.asked_s,
            notices=tuple(log.notices),
            ticks=self._ticks,
            wall_s=round(wall_s, 3),
            length_m=round(jury.line.length_m, 3),
            points=len(inside),
            first_junction=inside.index(True) + 1 if any(inside) else None,
            stuck_end_pct=jury.min_speed.stuck_end,
            infractions=tuple(
                TimedInfraction(kind=i.kind, time_s=round(i.time_s, 2), text=i.text) for i in jury.infractions
            ),
            near_misses=tuple(self._near.found),
            spells=tuple(self._spells.spells),
            stopped_s=round(self._spells.stopped_s, 3),
            interventions=tuple(log.interventions),
            queries=tuple(log.queries),
            reliability=tuple(log.reliability),
            guidance=tuple(log.guidance),
            track=tuple(self._track),
        )
        replay = None if self._replay is None else self._replay.log(record, outcome)
        return RouteResult(record, outcome, self._metric, replay, tuple(self._events))


def _beyond(line: RouteLine) -> tuple[RoutePoint, ...]:
    """Return points of the lane beyond the destination, if there is one."""
    here, found = line.waypoints[-1], []
    for _ in range(BEYOND_END_M):
        following = here.next(1.0)
        if not following:
            break
        here = following[0]
        found.append(RoutePoint(here, "lane_follow"))
    return tuple(found)


def _make_passenger_page(job: RouteJob, setting: ScenarioContext, arm: SystemUnderTest) -> PassengerPage | None:
    if job.passenger is None or not isinstance(arm, SolverSystem):
        return None
    return PassengerPage(job.passenger, setting, arm)


def _replay(job: RouteJob, setting: ScenarioContext, arm: SystemUnderTest) -> ReplayKeeper | None:
    if job.replays == "none":
        return None
    return ReplayKeeper(job, setting, arm if isinstance(arm, SolverSystem) else None)


def _scattered(job: RouteJob, setting: ScenarioContext) -> TickPart | None:
    """Return the part that scatters objects along the route of a recording; None if the job names none."""
    if job.recording is None or not job.recording.crowd:
        return None
    crowd: TickPart = resolve_name(job.recording.crowd)(setting, job.seed)
    return crowd


def _recorder(job: RouteJob, setting: ScenarioContext) -> Recording | None:
    if job.recording is None:
        return None
    facts = {"route": job.route.id, "scenario": job.scenario, "seed": job.seed, "driver": job.arm.driver}
    recorder: Recording = resolve_name(job.recording.factory)(
        job.recording, setting, job.seed, {**facts, "weather": job.recording.weather}
    )
    return recorder
