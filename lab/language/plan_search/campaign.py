"""A campaign: finds the standstills of a suite, searches for plans, drives the best ones, and stores the outcomes.

The folder of a campaign:

```
campaign.json            the campaign's options
reference/ROUTE-SEED/    the drive with the rules, and all its queries
standstills/NAME.json    the standstills that require a plan
searches/NAME.json       the plans that the guard accepts there, best first, and the work of the search
drives/NAME/NUMBER/      one exact drive each
labels.jsonl             one line for each exact drive
best.json                the best plans, for `--recovery teacher:DIR`
moments/                 the same as samples for the student, for `python -m lab distill train --data DIR`
report.html              comparison of the best plans with the rules
```

Completed steps are skipped, so the same command continues an interrupted campaign. Steps in progress are finished
first: exact drives before searches, and searches before drives with the rules. Therefore an interrupted campaign has
complete standstills.
"""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import BrokenExecutor, Executor, ProcessPoolExecutor
from dataclasses import dataclass, field
from functools import partial
from multiprocessing import get_context
from pathlib import Path

from stucksolver.reasoners.playback import BOOK, PlanTable

from lab.language.plan_search.beam_search import Candidate, Search, SearchedPlan, SearchSettings, kinds, varied
from lab.language.plan_search.campaign_samples import write_lessons
from lab.language.plan_search.counterfactual_run import DriveSpec, PlanTrial, drive_task, label_of, questions_of
from lab.language.plan_search.labels import Label, LabelFile, best, by_standstill
from lab.language.plan_search.lookahead import LookAhead
from lab.language.plan_search.quick_value import QuickValue
from lab.language.plan_search.standstill import Standstill, digest_of, moments
from lab.language.plan_search.step_scheduler import Step, StepStage, run_steps
from stucksolver.atomic_files import write_text
from stucksolver.guard import Guard
from stucksolver.ladder import find_ladder
from stucksolver.plan import RecoveryPlan
from stucksolver.scene.base_model import FrozenModel
from stucksolver_eval.results.outcome import RouteOutcome
from stucksolver_eval.results.store import ResultStore
from stucksolver_eval.routes import Route
from stucksolver_eval.runner.job import RouteJob
from stucksolver_eval.runner.route_process import RouteTask, run_task
from stucksolver_eval.systems.spec import SystemSpec

MANIFEST, LABELS = "campaign.json", "labels.jsonl"
STANDSTILLS, SEARCHES = "standstills", "searches"
Say = Callable[[str], None]


class PlanSearchError(RuntimeError):
    """A campaign cannot continue; the message has the reason and the remedy."""


class PlanSearchManifest(FrozenModel):
    """The options of a campaign. It continues only with the same ones."""

    version: int = 1
    """Version of the file."""
    suite: str
    suite_digest: str
    seed: int
    driver: str
    ladder: str
    limit_s: float | None
    best: int


class SearchRecord(FrozenModel):
    """The result of a search and its work.

    The work is the number of guard checks, of plans for which the simulator looked ahead, and of its forks, and the
    wall time (s).
    """

    accepted: int
    checked: int
    looked: int = 0
    """Number of plans for which the simulator looked ahead."""
    forks: int
    fork_s: float
    seconds: float
    chosen: tuple[Candidate, ...]


@dataclass(frozen=True)
class PlanSearchSpec:
    """The definition of a campaign.

    Attributes:
        suite: Name of the suite, or a file of routes.
        routes: The routes to drive.
        seed: Seed of the traffic.
        out: The campaign's folder.
        best: Number of plans driven exactly at each standstill, in addition to the rules' plan and waiting.
        jobs: Number of drives and searches in parallel.
        drives: Settings that all drives share.
        search: Limits of the search.
    """

    suite: str
    suite_digest: str
    routes: tuple[Route, ...]
    seed: int
    out: Path
    best: int = 10
    """Number of plans driven exactly at each standstill. Ours."""
    jobs: int = 2
    """Number of drives and searches in parallel. Ours."""
    drives: DriveSpec = field(default_factory=DriveSpec)
    search: SearchSettings = field(default_factory=SearchSettings)


def collect(spec: PlanSearchSpec, say: Say) -> LabelFile:
    """Run all remaining steps, and return the labels.

    Args:
        spec: The definition of the campaign.
        say: Called with each line of progress.

    Raises:
        PlanSearchError: The folder contains another campaign, or a line of its labels cannot be read.
        OutputError: Something cannot be written.
    """
    _begin(spec)
    try:
        labels = LabelFile(spec.out / LABELS)
    except ValueError as error:
        raise PlanSearchError(f"{error}. Remove that line, or choose another folder") from error
    # Searches have their own pool: they need the processor, and drives have processes of their own.
    with ProcessPoolExecutor(spec.jobs, get_context("spawn")) as searchers:
        work = _Campaign(spec, labels, say, searchers)
        run_steps([work.reference(route) for route in spec.routes], spec.jobs)
    say(f"{work.standstills} standstills on {len(spec.routes)} routes, {work.drives} exact drives in this run")
    guard = Guard(find_ladder(spec.drives.ladder or "evaluation").guard_policy())
    write_lessons(spec.out, spec.out / STANDSTILLS, labels.labels, guard)
    write_text(spec.out / BOOK, book_of(labels.labels).model_dump_json(indent=1) + "\n")
    return labels


def _begin(spec: PlanSearchSpec) -> None:
    manifest = PlanSearchManifest(
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
    elif PlanSearchManifest.model_validate_json(path.read_text(encoding="utf-8")) != manifest:
        raise PlanSearchError(
            f"the folder belongs to another campaign: {path}. Choose another --out, or use the same options"
        )


class _Campaign:
    """The steps of a campaign: a drive with the rules, then a search for each standstill, then the exact drives."""

    def __init__(self, spec: PlanSearchSpec, labels: LabelFile, say: Say, searchers: Executor) -> None:
        self._spec, self._labels, self._say, self._searchers = spec, labels, say, searchers
        self._done = {_key(label.standstill, label.source, label.plan) for label in labels.labels}
        self._planned = 0
        self.standstills = self.drives = 0

    def reference(self, route: Route) -> Step:
        """Return the drive of a route with the rules."""
        spec, folder = self._spec, _reference(self._spec, route)
        if ResultStore(folder).is_done(route, spec.seed):
            return Step(StepStage.REFERENCE, lambda wanted: None, lambda _: self._searches(route))
        task = drive_task(spec.drives, route, spec.seed, PlanTable(), folder)

        def next_steps(outcome: RouteOutcome) -> Iterator[Step]:
            self._say(f"route {route.id}, with the rules: {outcome.state} ({outcome.wall_s:.0f} s)")
            return self._searches(route)

        return Step(StepStage.REFERENCE, partial(_run, task), next_steps)

    def _searches(self, route: Route) -> Iterator[Step]:
        for still in _of_route(self._spec, route):
            self.standstills += 1
            yield self._search(route, still)

    def _search(self, route: Route, still: Standstill) -> Step:
        path = self._spec.out / SEARCHES / f"{still.name}.json"
        if path.exists():
            record = SearchRecord.model_validate_json(path.read_text(encoding="utf-8"))
            return Step(StepStage.SEARCH, lambda wanted: record, lambda found: self._drives(route, still, found))

        def next_steps(found: SearchRecord) -> Iterator[Step]:
            write_text(path, found.model_dump_json(indent=1) + "\n")
            self._say(
                f"{still.name} ({still.scenario}): {found.accepted} plans accepted, {found.checked} guard checks, "
                f"{found.forks} forks, {found.seconds:.0f} s"
            )
            return self._drives(route, still, found)

        return Step(StepStage.SEARCH, lambda wanted: self._searched(still), next_steps)

    def _searched(self, still: Standstill) -> SearchRecord:
        try:
            return self._searchers.submit(search, self._spec, still).result()
        except BrokenExecutor as error:
            raise PlanSearchError(
                f"the process of the search was killed (too little memory?): {still.name}. Run the same command again"
            ) from error

    def _drives(self, route: Route, still: Standstill, found: SearchRecord) -> Iterator[Step]:
        """Yield the drives: waiting, and the best plans of the search. The drive with the rules already exists."""
        taught = [PlanTrial(still, "teacher", candidate.plan, candidate.value) for candidate in found.chosen]
        for trial in (PlanTrial(still, "rules", still.rules.plan), PlanTrial(still, "wait", None), *taught):
            if _key(still.name, trial.source, trial.plan) in self._done:
                continue
            if trial.source == "rules":
                self._labels.add(_of_the_rules(self._spec, trial, route))
                continue
            self._planned += 1
            yield self._exact(route, trial)

    def _exact(self, route: Route, trial: PlanTrial) -> Step:
        spec = self._spec
        folder = spec.out / "drives" / trial.standstill.name / plan_digest(trial.plan)
        task = drive_task(spec.drives, route, spec.seed, trial.book, folder, waits=trial.source == "wait")

        def next_steps(outcome: RouteOutcome) -> Iterator[Step]:
            label = label_of(trial, task, outcome)
            self._labels.add(label)
            self.drives += 1
            self._say(f"[{self.drives} of {self._planned} drives so far] {said_of(label)}")
            return iter(())

        return Step(StepStage.EXACT, partial(_run, task), next_steps)


def _run(task: RouteTask, wanted: Callable[[], bool]) -> RouteOutcome:
    return run_task(task, wanted=wanted)


def _reference(spec: PlanSearchSpec, route: Route) -> Path:
    return spec.out / "reference" / f"{route.id}-{spec.seed}"


def _of_route(spec: PlanSearchSpec, route: Route) -> Iterator[Standstill]:
    outcome = ResultStore(_reference(spec, route)).outcome(route, spec.seed)
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


def search(spec: PlanSearchSpec, still: Standstill) -> SearchRecord:
    """Search for plans at one standstill, and return the best of each kind in turn.

    The simulator looks ahead for the most promising ones.
    """
    began = time.perf_counter()
    guard = Guard(find_ladder(spec.drives.ladder or "evaluation").guard_policy())
    work = Search(guard, still.scene, still.surroundings, QuickValue(still.surroundings).value, spec.search)
    accepted = [item for item in work.run() if item.plan != still.rules.plan]
    ahead = LookAhead(still.town, still.surroundings, (spec.drives.maps,) if spec.drives.maps else ())
    looked = [
        Candidate(plan=item.plan, value=round(ahead.value(item.trail), 2))
        for item in varied(accepted, _kind_and_value, spec.search.looked)
    ]
    return SearchRecord(
        accepted=len(accepted),
        checked=work.checked,
        looked=len(looked),
        forks=ahead.spent.forks,
        fork_s=round(ahead.spent.seconds, 2),
        seconds=round(time.perf_counter() - began, 2),
        chosen=tuple(varied(looked, _kind_and_value, spec.best)),
    )


def _kind_and_value(candidate: Candidate | SearchedPlan) -> tuple[tuple[str, ...], float]:
    return kinds(candidate.plan.behaviors), candidate.value


def _of_the_rules(spec: PlanSearchSpec, trial: PlanTrial, route: Route) -> Label:
    folder = _reference(spec, route)
    outcome = ResultStore(folder).outcome(route, spec.seed)
    assert outcome is not None, "the standstill comes from this drive"
    return label_of(trial, RouteTask(RouteJob(route, spec.seed, SystemSpec(recovery="rules")), folder), outcome)


def _key(standstill: str, source: str, plan: RecoveryPlan | None) -> tuple[str, str, str]:
    return standstill, source, plan_digest(plan)


def plan_digest(plan: RecoveryPlan | None) -> str:
    """Return a short name for a plan's files; `wait` if there is no plan."""
    return "wait" if plan is None else hashlib.sha256(plan.model_dump_json().encode()).hexdigest()[:12]


def said_of(label: Label) -> str:
    """Return one line about a label."""
    plan = "wait" if label.plan is None else " > ".join(kinds(label.plan.behaviors))
    if label.grade is None:
        return f"{label.standstill} {plan}: not driven: {label.error}"
    if not label.reached:
        return f"{label.standstill} {plan}: did not reach the same moment"
    got = label.grade.recovered_after_s
    on = "no recovery" if got is None else f"recovered after {got:.0f} s"
    harm = label.grade.collisions + label.grade.infractions
    return f"{label.standstill} {plan}: {on}, harm {harm}, DS {label.grade.driving_score:.0f} ({label.drive_s:.0f} s)"


def book_of(labels: Iterable[Label]) -> PlanTable:
    """Return the best plan of each standstill.

    A standstill is left out if the rules wait there and no driven plan is better: the teacher waits there anyway.
    """
    plans: dict[str, RecoveryPlan | None] = {}
    for name, group in by_standstill(labels).items():
        found = best(group)
        if found is not None and not (found.source == "rules" and found.plan is None):
            plans[name.rpartition("-")[2]] = found.plan
    return PlanTable(plans=plans)
