"""The demonstration: a parked car and two slow cyclists, on any map, each without and with StuckSolver."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from stucksolver.atomic_files import require_writable
from stucksolver_eval.guidance import ScriptLine, ScriptTrigger
from stucksolver_eval.passenger import PassengerSpec
from stucksolver_eval.report import write_report
from stucksolver_eval.results.run_log import RunLog
from stucksolver_eval.results.store import ResultStore
from stucksolver_eval.routes import Route
from stucksolver_eval.runner.job import RouteJob
from stucksolver_eval.runner.route_process import RouteTask, drive_task
from stucksolver_eval.streets.finder import choose_street
from stucksolver_eval.streets.routes import SimulatorTarget, street_route, with_map
from stucksolver_eval.systems.factory import check_arm
from stucksolver_eval.systems.spec import PRIVILEGED, SENSORS, SystemSpec

if TYPE_CHECKING:
    import carla

SAY_S = 8.0
"""Time of the passenger's utterance (s since the start). Ours."""
WORDS = "please overtake them"
VEHICLE = "car-1"
"""Name of the car for a passenger."""
ALONE, HELPED, GUIDED = "driver alone", "StuckSolver", "StuckSolver + passenger"
FRAME_EVERY_S = 0.1
"""Interval between frames of the replay (s). Ours."""
KINDS = {"one_lane": "one lane each way", "multi_lane": "several lanes"}


@dataclass(frozen=True)
class DemoSituation:
    """One of the two situations: the scenario type, a short description, and the required length of street (m)."""

    type: str
    name: str
    length_m: int


PARKED_CAR = DemoSituation("ParkedCarInLane", "parked car", 170)
CYCLISTS = DemoSituation("SlowCyclists", "two slow cyclists", 260)
SITUATIONS = (PARKED_CAR, CYCLISTS)
ARMS = ((PARKED_CAR, ALONE), (PARKED_CAR, HELPED), (CYCLISTS, HELPED), (CYCLISTS, GUIDED))
SPOKEN = ((PARKED_CAR, GUIDED), (CYCLISTS, GUIDED))

SEEN_BY = {
    PRIVILEGED: "perception: privileged – scenes are built from the simulator's ground truth, not from sensors.",
    SENSORS: "perception: sensors – driver and solver perceive only with camera, LiDAR, GNSS, IMU and wheel sensors.",
}


@dataclass(frozen=True)
class DemoSpec:
    """Options of the demonstration. `host` and `port` name a running CARLA server that replaces carlette."""

    map_name: str = "demo_town"
    maps: str | None = None
    seed: int = 1
    driver: str = "behavior:normal"
    recovery: str = "search"
    """The reasoner of the systems with StuckSolver."""
    road: Literal["one_lane", "multi_lane", "any"] = "any"
    oncoming: int = 3
    """Number of oncoming cars. Ours."""
    clock: str = "lockstep"
    out: Path = Path("out/demo")
    host: str | None = None
    port: int = 2000
    say: str | None = None
    """Utterance of the passenger instead of the demonstration's own. Then both streets are driven only with it."""
    pictures: bool = True
    """Store an image of the front camera with each decision."""
    memory: Path | None = None
    """File of the memory; None for no memory."""
    perception: str = PRIVILEGED
    """Source of perception for driver and solver: one of `systems.spec.PERCEPTIONS`."""

    passenger: Path | None = None
    """Address of a passenger server. People can talk to the car with StuckSolver."""

    @property
    def arms(self) -> tuple[tuple[DemoSituation, str], ...]:
        """The drives in order."""
        return ARMS if self.say is None else SPOKEN


def demo(spec: DemoSpec, say: Callable[[str], None]) -> tuple[list[RunLog], Path]:
    """Run all drives, store each drive's files immediately, and write the report at the end.

    Drives that are finished stay in `out/runs` after an error.

    Raises:
        SystemSpecError: The driver, the recovery or the reasoner does not exist or does not respond.
        StreetError: The map has no suitable street.
        ServerError: The simulator did not start or ended.
        RunError: A drive failed.
        OutputError: A file cannot be written.
        ReportError: The report cannot be made.
    """
    check_arm(_arm(spec, HELPED))
    require_writable(spec.out / "runs")
    where = SimulatorTarget(spec.map_name, spec.maps, spec.seed, spec.host, spec.port)
    found = with_map(
        where, lambda world, carla_map: {situation: _found(spec, situation, carla_map) for situation in SITUATIONS}
    )
    runs: list[RunLog] = []
    for k, (situation, arm) in enumerate(spec.arms, 1):
        label = f"[{k}/{len(spec.arms)}] {situation.name}: {arm}"
        route, title = found[situation]
        log = _driven(RouteTask(_job(spec, route, arm), spec.out / "runs" / f"{k}"), partial(_progress, say, label))
        runs.append(log.model_copy(update={"scenario": title, "arm": arm}))
        say(f"{label}: {log.result.status} after {log.result.duration_s:.0f} s\n")
    report = spec.out / "report.html"
    write_report(runs, report, f"StuckSolver on {Path(spec.map_name).stem}", _notes(spec))
    return runs, report


def _found(spec: DemoSpec, situation: DemoSituation, carla_map: carla.Map) -> tuple[Route, str]:
    """Return the best street on the map for a situation, and its title."""
    street = choose_street(carla_map, spec.road, spec.seed, situation.length_m)
    oncoming = spec.oncoming if street.kind == "one_lane" else 0
    title = f"{situation.name}, {KINDS[street.kind]}" + (f", {oncoming} oncoming" if oncoming else "")
    parameters = {"oncoming": float(oncoming)}
    if situation is PARKED_CAR:
        parameters["distance"] = float(street.obstacle_index)
    route_id = str(SITUATIONS.index(situation) + 1)
    return street_route(route_id, spec.map_name, street.waypoints, situation.type, parameters), title


def _driven(task: RouteTask, progress: Callable[[float], None]) -> RunLog:
    """Return one drive's replay.

    Raises:
        RunError: The drive has no replay.
    """
    drive_task(task, progress)
    return ResultStore(task.folder).run_log(task.job.route, task.job.seed)


def _progress(say: Callable[[str], None], label: str, elapsed_s: float) -> None:
    say(f"{label} … {elapsed_s:.0f} s")


def _arm(spec: DemoSpec, arm: str) -> SystemSpec:
    recovery = "none" if arm == ALONE else spec.recovery
    return SystemSpec(
        driver=spec.driver,
        recovery=recovery,
        clock=spec.clock,
        perception=spec.perception,
        memory=None if arm == ALONE else spec.memory,
        camera=spec.pictures and arm != ALONE,
    )


def _job(spec: DemoSpec, route: Route, arm: str) -> RouteJob:
    words = ScriptLine(when=ScriptTrigger(time_s=SAY_S), say=(spec.say or WORDS,))
    return RouteJob(
        route=route,
        seed=spec.seed,
        arm=_arm(spec, arm),
        lines=(words,) if arm == GUIDED else (),
        maps=spec.maps,
        replays="all",
        background=False,
        frame_every_s=FRAME_EVERY_S,
        passenger=None if spec.passenger is None else PassengerSpec(spec.passenger, VEHICLE, f"Demonstration: {arm}"),
        host=spec.host,
        port=spec.port,
    )


def _notes(spec: DemoSpec) -> list[str]:
    simulator = f"{spec.host}:{spec.port}" if spec.host else "carlette, the embedded simulator"
    return [
        f"Seed {spec.seed}, driver {spec.driver}, clock {spec.clock}, simulator: {simulator}.",
        SEEN_BY[spec.perception],
        "A solid line may be crossed past a stationary obstruction without asking (the evaluation profile).",
    ]
