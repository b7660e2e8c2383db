"""A campaign: find the standstills of a suite, search plans for each, drive the best ones, and keep the outcomes.

The folder of a campaign:

campaign.json            what was asked for
reference/ROUTE-SEED/    the drive with the rules, with every question that was asked
standstills/NAME.json    the moments at which a plan is wanted
searches/NAME.json       the plans that the guard accepts there, best first, with the work that it took
drives/NAME/NUMBER/      one exact drive each
labels.jsonl             one line for each exact drive
best.json                the best plans, for `--recovery teacher:DIR`
report.html              what there is to win

Every step that is done already is skipped, so the same command goes on after it was killed.
"""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from stucksolver.decision import RecoveryPlan
from stucksolver.guard import Guard
from stucksolver.ladder import find_ladder
from stucksolver.reason.played import BOOK, PlanBook
from stucksolver.scene.model import Model
from stucksolver_distill.exact import DriveSpec, Trial, drive_task, label_of, questions_of
from stucksolver_distill.labels import Label, LabelFile, best, by_standstill
from stucksolver_distill.lookahead import LookAhead
from stucksolver_distill.search import Candidate, Search, SearchSettings, kinds, varied
from stucksolver_distill.standstill import Standstill, digest_of, moments
from stucksolver_eval.arms.spec import ArmSpec
from stucksolver_eval.files import write_text
from stucksolver_eval.results.outcome import RouteOutcome
from stucksolver_eval.results.store import Store
from stucksolver_eval.routes import Route
from stucksolver_eval.runner.job import RouteJob
from stucksolver_eval.runner.pool import run_tasks
from stucksolver_eval.runner.work import Task

MANIFEST, LABELS = "campaign.json", "labels.jsonl"
STANDSTILLS, SEARCHES = "standstills", "searches"
Say = Callable[[str], None]


class CampaignError(RuntimeError):
    """A campaign cannot go on; the message says why and what to do."""


class Manifest(Model):
    """What was asked for. A campaign goes on only with the same."""

    version: int = 1
    suite: str
    suite_digest: str
    seed: int
    driver: str
    ladder: str
    limit_s: float | None
    best: int


class KeptSearch(Model):
    """The result of a search and the work that it took: questions to the guard, forks, and wall time (s)."""

    accepted: int
    checked: int
    forks: int
    fork_s: float
    seconds: float
    chosen: tuple[Candidate, ...]


@dataclass(frozen=True)
class CampaignSpec:
    """What is asked for.

    Attributes:
        suite: Name of the suite, or a file of routes.
        routes: The routes to drive.
        seed: Seed of the traffic.
        out: The campaign's folder.
        best: Plans that are driven exactly at each standstill, beside the rules' and waiting.
        jobs: Drives at a time.
        drives: What all drives share.
        search: How far to search.
    """

    suite: str
    suite_digest: str
    routes: tuple[Route, ...]
    seed: int
    out: Path
    best: int = 10
    jobs: int = 2
    drives: DriveSpec = field(default_factory=DriveSpec)
    search: SearchSettings = field(default_factory=SearchSettings)


def collect(spec: CampaignSpec, say: Say) -> LabelFile:
    """Run everything that is not done yet, and return the labels.

    Args:
        spec: What is asked for.
        say: Takes a line of progress.

    Raises:
        CampaignError: The folder holds another campaign, or a line of it cannot be read.
        OutputError: Something cannot be written.
    """
    _begin(spec)
    try:
        labels = LabelFile(spec.out / LABELS)
    except ValueError as error:
        raise CampaignError(f"{error}; remove that line, or choose another folder") from error
    found = list(_standstills(spec, say))
    say(f"{len(found)} standstills on {len(spec.routes)} routes")
    trials = [trial for still in found for trial in _trials(spec, still, say)]
    _drive(spec, trials, labels, say)
    write_text(spec.out / BOOK, book_of(labels.labels).model_dump_json(indent=1) + "\n")
    return labels


def _begin(spec: CampaignSpec) -> None:
    manifest = Manifest(
        suite=spec.suite,
        suite_digest=spec.suite_digest,
        seed=spec.seed,
        driver=spec.drives.driver,
        ladder="" if spec.drives.ladder is None else spec.drives.ladder.name,
        limit_s=spec.drives.limit_s,
        best=spec.best,
    )
    path = spec.out / MANIFEST
    if not path.exists():
        write_text(path, manifest.model_dump_json(indent=1) + "\n")
    elif Manifest.model_validate_json(path.read_text(encoding="utf-8")) != manifest:
        raise CampaignError(f"{path} is of another campaign; choose another --out, or give the same options again")


# ---- the standstills


def _standstills(spec: CampaignSpec, say: Say) -> Iterator[Standstill]:
    """Drive each route with the rules, and yield its standstills."""
    tasks = [
        drive_task(spec.drives, route, spec.seed, PlanBook(), _reference(spec, route))
        for route in spec.routes
        if not Store(_reference(spec, route)).is_done(route, spec.seed)
    ]
    for task, outcome in _ended(tasks, spec.jobs):
        say(f"route {task.job.route.id}, with the rules: {outcome.state} ({outcome.wall_s:.0f} s)")
    for route in spec.routes:
        yield from _of_route(spec, route)


def _reference(spec: CampaignSpec, route: Route) -> Path:
    return spec.out / "reference" / f"{route.id}-{spec.seed}"


def _of_route(spec: CampaignSpec, route: Route) -> Iterator[Standstill]:
    outcome = Store(_reference(spec, route)).outcome(route, spec.seed)
    if outcome is None or outcome.state != "driven":
        return
    for asked in moments(questions_of(_reference(spec, route))):
        assert asked.surroundings is not None
        still = Standstill(
            suite=spec.suite,
            route_id=route.id,
            seed=spec.seed,
            driver=spec.drives.driver,
            tick=asked.scene.frame,
            digest=digest_of(asked),
            scenario=outcome.scenario,
            town=route.town,
            at_s=round(outcome.queries[asked.number - 1].asked_s, 2),
            scene=asked.scene,
            surroundings=asked.surroundings,
            rules=asked.decision,
        )
        path = spec.out / STANDSTILLS / f"{still.name}.json"
        if not path.exists():
            write_text(path, still.model_dump_json() + "\n")
        yield still


# ---- the plans to drive


def _trials(spec: CampaignSpec, still: Standstill, say: Say) -> list[Trial]:
    """Return what is driven at a standstill: the rules' plan, waiting, and the best plans of the search."""
    path = spec.out / SEARCHES / f"{still.name}.json"
    if not path.exists():
        found = search(spec, still)
        write_text(path, found.model_dump_json(indent=1) + "\n")
        say(
            f"{still.name} ({still.scenario}): {found.accepted} plans of {found.checked} questions to the guard, "
            f"{found.forks} forks, {found.seconds:.0f} s"
        )
    kept = KeptSearch.model_validate_json(path.read_text(encoding="utf-8"))
    taught = [Trial(still, "teacher", one.plan, one.value) for one in kept.chosen]
    return [Trial(still, "rules", still.rules.plan), Trial(still, "wait", None), *taught]


def search(spec: CampaignSpec, still: Standstill) -> KeptSearch:
    """Search one standstill, and keep the best plans by turns of their kinds."""
    began = time.perf_counter()
    ahead = LookAhead(still.town, still.surroundings, (spec.drives.maps,) if spec.drives.maps else ())
    guard = Guard(find_ladder(spec.drives.ladder or "evaluation").guard_policy())
    work = Search(guard, still.scene, still.surroundings, ahead.value, spec.search)
    accepted = [one for one in work.run() if one.plan != still.rules.plan]
    chosen = varied(accepted, lambda one: (kinds(one.plan.behaviors), one.value), spec.best)
    return KeptSearch(
        accepted=len(accepted),
        checked=work.checked,
        forks=ahead.spent.forks,
        fork_s=round(ahead.spent.seconds, 2),
        seconds=round(time.perf_counter() - began, 2),
        chosen=tuple(chosen),
    )


# ---- the exact drives


def _drive(spec: CampaignSpec, trials: list[Trial], labels: LabelFile, say: Say) -> None:
    """Drive what has no label yet; the drive with the rules is there already."""
    done = {_key(one.standstill, one.source, one.plan) for one in labels.labels}
    left = [one for one in trials if _key(one.standstill.name, one.source, one.plan) not in done]
    routes = {route.id: route for route in spec.routes}
    tasks: dict[Path, tuple[Task, Trial]] = {}
    for trial in left:
        route = routes[trial.standstill.route_id]
        if trial.source == "rules":
            labels.add(_of_the_rules(spec, trial, route))
            continue
        folder = spec.out / "drives" / trial.standstill.name / plan_digest(trial.plan)
        waits = trial.source == "wait"
        tasks[folder] = (drive_task(spec.drives, route, spec.seed, trial.book, folder, waits=waits), trial)
    for count, (task, outcome) in enumerate(_ended([task for task, _ in tasks.values()], spec.jobs), 1):
        label = label_of(tasks[task.folder][1], task, outcome)
        labels.add(label)
        say(f"[{count}/{len(tasks)}] {said_of(label)}")


def _of_the_rules(spec: CampaignSpec, trial: Trial, route: Route) -> Label:
    folder = _reference(spec, route)
    outcome = Store(folder).outcome(route, spec.seed)
    assert outcome is not None, "the standstill comes from this drive"
    return label_of(trial, Task(RouteJob(route, spec.seed, ArmSpec(recovery="rules")), folder), outcome)


def _ended(tasks: list[Task], jobs: int) -> Iterator[tuple[Task, RouteOutcome]]:
    """Drive them, and yield each as it ends. Raises `OutputError`."""
    for news in run_tasks(tasks, jobs):
        if news.outcome is not None:
            yield news.task, news.outcome


def _key(standstill: str, source: str, plan: RecoveryPlan | None) -> tuple[str, str, str]:
    return standstill, source, plan_digest(plan)


def plan_digest(plan: RecoveryPlan | None) -> str:
    """Return a short name of a plan for files: `wait` for none."""
    return "wait" if plan is None else hashlib.sha256(plan.model_dump_json().encode()).hexdigest()[:12]


def said_of(label: Label) -> str:
    """Return one line about a label."""
    plan = "wait" if label.plan is None else " > ".join(kinds(label.plan.behaviors))
    if label.grade is None:
        return f"{label.standstill} {plan}: not driven: {label.error}"
    if not label.reached:
        return f"{label.standstill} {plan}: did not come to the same moment"
    got = label.grade.recovered_after_s
    on = "no recovery" if got is None else f"recovered after {got:.0f} s"
    harm = label.grade.collisions + label.grade.infractions
    return f"{label.standstill} {plan}: {on}, harm {harm}, DS {label.grade.driving_score:.0f} ({label.drive_s:.0f} s)"


def book_of(labels: Iterable[Label]) -> PlanBook:
    """Return the best plan of each standstill.

    Where the rules wait, and nothing that was driven is better, nothing is written: the teacher waits anyway.
    """
    plans: dict[str, RecoveryPlan | None] = {}
    for name, group in by_standstill(labels).items():
        found = best(group)
        if found is not None and not (found.source == "rules" and found.plan is None):
            plans[name.rpartition("-")[2]] = found.plan
    return PlanBook(plans=plans)
