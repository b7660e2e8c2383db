"""Exact drives: a route is driven again up to the same tick, and another plan is executed there.

Runs of the embedded simulator are identical bit for bit, so two drives differ only from the plan on.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from stucksolver.reasoners.playback import BOOK, PlanTable

from lab.language.plan_search.grade import Grade, grade
from lab.language.plan_search.labels import Label, Source
from lab.language.plan_search.standstill import Standstill, digest_of
from stucksolver.atomic_files import write_text
from stucksolver.plan import RecoveryPlan
from stucksolver.record import LoggedQuery, read_questions
from stucksolver_eval.results.metric_info import read_metric_info
from stucksolver_eval.results.outcome import RouteOutcome
from stucksolver_eval.results.store import ResultStore
from stucksolver_eval.routes import Route
from stucksolver_eval.runner.job import RouteJob
from stucksolver_eval.runner.route_process import RouteTask
from stucksolver_eval.systems.spec import SystemSpec

QUESTIONS = "questions.jsonl"


@dataclass(frozen=True)
class DriveSpec:
    """Settings that all drives of a campaign share.

    Attributes:
        driver: Name of the driver.
        ladder: The ladder's file; None for the evaluation's own profile.
        maps: Additional folders of maps.
        limit_s: Time at which every route is ended (s); None if it should run to its own end.
    """

    driver: str = "behavior:normal"
    ladder: Path | None = None
    maps: str | None = None
    limit_s: float | None = None


def drive_task(
    spec: DriveSpec, route: Route, seed: int, book: PlanTable, folder: Path, *, waits: bool = False
) -> RouteTask:
    """Prepare a drive with a table of plans.

    Args:
        spec: Settings that all drives share.
        route: The route.
        seed: Seed of its traffic.
        book: The plans to execute.
        folder: Folder for all files of this drive.
        waits: If True, the vehicle waits at every standstill that is not in the table; if False, the rules
            decide there.

    Raises:
        OutputError: The folder cannot be written.
    """
    write_text(folder / BOOK, book.model_dump_json() + "\n")
    (folder / QUESTIONS).unlink(missing_ok=True)
    recovery = f"{'teacher' if waits else 'teacher-then-rules'}:{folder}"
    arm = SystemSpec(driver=spec.driver, recovery=recovery, ladder=spec.ladder, questions=folder / QUESTIONS)
    return RouteTask(RouteJob(route=route, seed=seed, arm=arm, maps=spec.maps, limit_s=spec.limit_s), folder)


def questions_of(folder: Path) -> tuple[LoggedQuery, ...]:
    """Return the queries of a drive.

    Raises:
        RecordError: The record cannot be read.
    """
    return read_questions(folder / QUESTIONS)


@dataclass(frozen=True)
class PlanTrial:
    """One answer to drive at a standstill."""

    standstill: Standstill
    source: Source
    plan: RecoveryPlan | None
    value: float | None = None

    @property
    def book(self) -> PlanTable:
        """A table with only this answer. It is empty for the rules, so that they decide."""
        return PlanTable() if self.source == "rules" else PlanTable(plans={self.standstill.digest: self.plan})


def label_of(trial: PlanTrial, task: RouteTask, outcome: RouteOutcome) -> Label:
    """Grade a drive that has ended, and check that it reached the standstill."""
    still = trial.standstill
    reached = any(digest_of(question) == still.digest for question in questions_of(task.folder))
    graded = _grade(task, outcome, still.at_s) if outcome.state == "driven" else None
    return Label(
        standstill=still.name,
        scenario=still.scenario,
        source=trial.source,
        plan=trial.plan,
        value=trial.value,
        reached=reached,
        grade=graded,
        error=outcome.reason.strip().splitlines()[-1] if outcome.reason.strip() else "",
        drive_s=outcome.wall_s,
    )


def _grade(task: RouteTask, outcome: RouteOutcome, at_s: float) -> Grade:
    store, job = ResultStore(task.folder), task.job
    record = store.record(job.route, job.seed)
    assert record is not None, "a driven route has a record"
    return grade(outcome, record, read_metric_info(store.metric_info(job.route, job.seed)), at_s)
