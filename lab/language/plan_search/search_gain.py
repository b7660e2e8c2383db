"""The gain over the rules that a search has found: a lower bound of the possible gain, with the work for it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from lab.language.plan_search.campaign import LABELS, MANIFEST, SEARCHES, PlanSearchManifest, SearchRecord
from lab.language.plan_search.grade import Grade
from lab.language.plan_search.labels import Label, LabelFile, best, by_standstill
from stucksolver.atomic_files import write_text
from stucksolver_eval.report.markup import document, note, section, table

REPORT = "report.html"
ALL = "all"
HEAD = (
    "Standstills of",
    "Count",
    "Recovered: rules",
    "waiting",
    "best",
    "DS: rules",
    "waiting",
    "best",
    "Harm: rules",
    "waiting",
    "best",
    "Seconds: rules",
    "best",
    "Won",
    "Exact drives",
)


@dataclass(frozen=True)
class GainRow:
    """The grades at one standstill. `best` is the best of all drives, including those of the rules and of waiting."""

    name: str
    scenario: str
    rules: Grade
    wait: Grade
    best: Label
    drives: int

    @property
    def top(self) -> Grade:
        """Grade of the best drive."""
        assert self.best.grade is not None
        return self.best.grade

    @property
    def won(self) -> bool:
        """True if a driven plan ended better than the rules' plan did."""
        return self.top.rank > self.rules.rank


def rows_of(labels: Sequence[Label]) -> list[GainRow]:
    """Return a row for each standstill at which the rules and waiting were driven."""
    rows = []
    for name, group in by_standstill(labels).items():
        rules, wait, top = best(group, "rules"), best(group, "wait"), best(group)
        if rules is None or wait is None or top is None or rules.grade is None or wait.grade is None:
            continue
        drives = sum(item.counts for item in group)
        rows.append(GainRow(name, rules.scenario, rules.grade, wait.grade, top, drives))
    return rows


def write_report(folder: Path) -> Path:
    """Write the page of a campaign, and return its path.

    Raises:
        OutputError: It cannot be written.
    """
    labels = LabelFile(folder / LABELS).labels
    manifest = PlanSearchManifest.model_validate_json((folder / MANIFEST).read_text(encoding="utf-8"))
    searches = [
        SearchRecord.model_validate_json(path.read_text(encoding="utf-8"))
        for path in sorted((folder / SEARCHES).glob("*.json"))
    ]
    path = folder / REPORT
    write_text(path, page(manifest, labels, searches))
    return path


def page(manifest: PlanSearchManifest, labels: Sequence[Label], searches: Sequence[SearchRecord]) -> str:
    """Return the HTML page of a campaign."""
    rows = rows_of(labels)
    head = [
        note(
            f"Suite {manifest.suite}, seed {manifest.seed}, driver {manifest.driver}. Every figure comes from exact "
            f"drives: the route is driven again up to the very same moment. “Best” is the best of the rules’ plan, "
            f"waiting and up to {manifest.best} plans of the search, so its gain over the rules is a lower bound of "
            "the possible gain: more drives can only raise it."
        ),
        note(budget(labels, searches)),
    ]
    sections = [
        section("Gain by scenario type", table("gain by type", HEAD, _by_type(rows))),
        section("Each standstill", table("standstills", ("Standstill", "Scenario", *DETAIL), _details(rows))),
    ]
    return document("Possible gain over the rules", head, sections)


def budget(labels: Sequence[Label], searches: Sequence[SearchRecord]) -> str:
    """Return a sentence about the work."""
    failed = sum(label.grade is None for label in labels)
    missed = sum(label.grade is not None and not label.reached for label in labels)
    forks, fork_s = sum(search.forks for search in searches), sum(search.fork_s for search in searches)
    return (
        f"Work: {len(labels)} exact drives, {sum(label.drive_s for label in labels):.0f} s of wall time, one core and "
        f"one simulator each; {failed} failed and {missed} did not reach the same moment, and are left out. The "
        f"searches made {sum(search.checked for search in searches)} guard checks and {forks} forks ({fork_s:.0f} s), "
        f"and took {sum(search.seconds for search in searches):.0f} s in total."
    )


DETAIL = ("Rules", "Waiting", "Best", "Whose plan", "Plan")


def _details(rows: Sequence[GainRow]) -> list[tuple[str, ...]]:
    return [
        (
            row.name,
            row.scenario,
            _summary(row.rules),
            _summary(row.wait),
            _summary(row.top),
            row.best.source,
            _plan(row.best),
        )
        for row in rows
    ]


def _summary(grade: Grade) -> str:
    after = "not recovered" if grade.recovered_after_s is None else f"{grade.recovered_after_s:.0f} s"
    harm = grade.collisions + grade.infractions + grade.near_misses
    return f"{after}, DS {grade.driving_score:.1f}" + (f", harm {harm}" if harm else "")


def _plan(label: Label) -> str:
    if label.plan is None:
        return "wait"
    parts = []
    for behavior in label.plan.behaviors:
        parameters = behavior.model_dump(exclude={"name"}, exclude_none=True)
        parts.append(f"{behavior.name}({', '.join(f'{name}={value}' for name, value in parameters.items())})")
    return " > ".join(parts)


def _by_type(rows: Sequence[GainRow]) -> list[tuple[str, ...]]:
    types = sorted({row.scenario for row in rows})
    groups = [(text, [row for row in rows if row.scenario == text]) for text in types]
    return [_sums(name, group) for name, group in [*groups, (ALL, list(rows))] if group]


def _sums(name: str, rows: Sequence[GainRow]) -> tuple[str, ...]:
    arms = [[row.rules for row in rows], [row.wait for row in rows], [row.top for row in rows]]
    recovered = [str(sum(grade.recovers for grade in arm)) for arm in arms]
    scores = [f"{sum(grade.driving_score for grade in arm) / len(arm):.1f}" for arm in arms]
    harm = [str(sum(g.collisions + g.infractions + g.near_misses for g in arm)) for arm in arms]
    won, drives = sum(row.won for row in rows), sum(row.drives for row in rows)
    seconds = _seconds(rows)
    return (name, str(len(rows)), *recovered, *scores, *harm, *seconds, str(won), str(drives))


def _seconds(rows: Sequence[GainRow]) -> tuple[str, str]:
    """Return the mean time to recover of the rules and of the best, over the standstills at which both recovered."""
    pairs = [
        (row.rules.recovered_after_s, row.top.recovered_after_s)
        for row in rows
        if row.rules.recovered_after_s is not None and row.top.recovered_after_s is not None
    ]
    if not pairs:
        return "–", "–"
    return f"{sum(a for a, _ in pairs) / len(pairs):.1f}", f"{sum(b for _, b in pairs) / len(pairs):.1f}"
