"""The demonstration: a parked car and two slow cyclists, on any map, each without and with what helps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Literal

from stucksolver_eval.files import require_writable
from stucksolver_eval.jobs import Job, make
from stucksolver_eval.report import write_report
from stucksolver_eval.runlog import RunLog
from stucksolver_eval.situation import Scenario

SAY_S = 8.0
"""When the passenger speaks, since the start."""
WORDS = "please overtake them"
ALONE, HELPED, GUIDED = "driver alone", "StuckSolver", "StuckSolver + passenger"
ARMS = (
    (Scenario.PARKED_CAR, ALONE),
    (Scenario.PARKED_CAR, HELPED),
    (Scenario.CYCLISTS, HELPED),
    (Scenario.CYCLISTS, GUIDED),
)
SPOKEN = ((Scenario.PARKED_CAR, GUIDED), (Scenario.CYCLISTS, GUIDED))


@dataclass(frozen=True)
class DemoSpec:
    """What to show. `host` and `port`: a running CARLA server instead of a carlette of our own."""

    map_name: str = "demo_town"
    maps: str | None = None
    seed: int = 1
    profile: str = "normal"
    road: Literal["one_lane", "multi_lane", "any"] = "any"
    oncoming: int = 3
    clock: str = "lockstep"
    out: Path = Path("out/demo")
    host: str | None = None
    port: int = 2000
    say: str | None = None
    """What a passenger says in place of the demonstration's own words; then both streets are driven with it alone."""

    @property
    def arms(self) -> tuple[tuple[Scenario, str], ...]:
        """What is driven, in this order."""
        return ARMS if self.say is None else SPOKEN


def demo(spec: DemoSpec, say: Callable[[str], None]) -> tuple[list[RunLog], Path]:
    """Run everything, keep each run's log as soon as it is there, and write the report last.

    Raises `RunError`, `OutputError` and `ReportError`; logs of runs already made stay in `out/runs`.
    """
    require_writable(spec.out / "runs")
    runs: list[RunLog] = []
    notes = _notes(spec)
    for k, (scenario, arm) in enumerate(spec.arms, 1):
        label = f"[{k}/{len(spec.arms)}] {scenario.value.replace('_', ' ')}: {arm}"
        log, repeated = make(_job(spec, scenario, arm, k), partial(_progress, say, label))
        runs.append(log)
        say(f"{label}: {log.result.status} after {log.result.duration_s:.0f} s\n")
        if repeated:
            notes.append(f"Run {k} was repeated: the process of its first attempt was killed by a signal.")
    report = spec.out / "report.html"
    write_report(runs, report, f"StuckSolver on {Path(spec.map_name).stem}", notes)
    return runs, report


def _progress(say: Callable[[str], None], label: str, elapsed_s: float) -> None:
    say(f"{label} … {elapsed_s:.0f} s")


def _job(spec: DemoSpec, scenario: Scenario, arm: str, number: int) -> Job:
    return Job(
        scenario=scenario,
        arm=arm,
        with_solver=arm != ALONE,
        guidance=((SAY_S, spec.say or WORDS),) if arm == GUIDED else (),
        map_name=spec.map_name,
        maps=spec.maps,
        road=spec.road,
        oncoming=spec.oncoming,
        seed=spec.seed,
        profile=spec.profile,
        clock=spec.clock,
        log=spec.out / "runs" / f"{number}-{scenario.value}.json",
        host=spec.host,
        port=spec.port,
    )


def _notes(spec: DemoSpec) -> list[str]:
    simulator = f"{spec.host}:{spec.port}" if spec.host else "carlette, the embedded simulator"
    return [
        f"Seed {spec.seed}, driver behavior:{spec.profile}, clock {spec.clock}, simulator: {simulator}.",
        "perception: privileged – scenes are built from the simulator's ground truth, not from sensors.",
        "A solid line may be crossed past a stationary obstruction without asking (the evaluation profile).",
    ]
