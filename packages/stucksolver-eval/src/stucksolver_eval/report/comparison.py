"""A page that compares several evaluations of the same routes, with one column each."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path

from stucksolver.atomic_files import write_text
from stucksolver_eval.metrics.columns import number, run_name
from stucksolver_eval.metrics.comparison import comparison
from stucksolver_eval.metrics.paired_statistics import Interval
from stucksolver_eval.metrics.summary import RouteRow, Summary
from stucksolver_eval.report import markup
from stucksolver_eval.report.evaluation import Links, replay_pages, status_of
from stucksolver_eval.report.markup import bar_cell
from stucksolver_eval.report.metric_tables import published_table, recovery_table, scores_table
from stucksolver_eval.report.tables import banners, per_scenario
from stucksolver_eval.results.store import ResultStore

Arms = Mapping[str, Summary]
"""Summaries by column name; the others are compared with the first."""


def write_comparison(folders: Sequence[Path], summaries: Sequence[Summary], path: Path) -> None:
    """Write the page to `path`, with links to the reports and replays of the evaluations.

    Raises `ComparisonError` for evaluations of different routes, `OutputError` and `ReportError`.
    """
    arms = dict(zip(column_names(summaries, folders), summaries, strict=True))
    near = path.resolve().parent
    links, pages = {}, {}
    for (name, arm), folder in zip(arms.items(), folders, strict=True):
        replays = replay_pages(ResultStore(folder), arm)
        links[name] = {key: os.path.relpath(folder.resolve() / page, near) for key, page in replays.items()}
        if (folder / "report.html").is_file():
            pages[name] = os.path.relpath(folder.resolve() / "report.html", near)
    write_text(path, comparison_page(arms, pages, links))


def column_names(summaries: Sequence[Summary], folders: Sequence[Path]) -> list[str]:
    """Return a name for each run. Equal names get the folder's name in addition."""
    names = [run_name(summary) for summary in summaries]
    alike = {name for name in names if names.count(name) > 1}
    named = [f"{name} ({folder.name})" if name in alike else name for name, folder in zip(names, folders, strict=True)]
    return named if len(set(named)) == len(named) else [f"{name} {k}" for k, name in enumerate(names, 1)]


def comparison_page(arms: Arms, pages: Mapping[str, str], links: Mapping[str, Links]) -> str:
    """Return the HTML page. `pages` and `links` are each system's report and replays. Raises `ComparisonError`."""
    first, *others = arms
    m = arms[first].manifest
    about = f"Suite {m.suite} (digest {m.suite_digest[:12]}), {m.routes} routes."
    reports = " · ".join(markup.link(page, f"{name}: report") for name, page in pages.items())
    warned = [f"{name}: {banner}" for name, summary in arms.items() for banner in banners(summary)]
    head = [*map(markup.warning, warned), markup.note(about), f"<p>{reports}</p>" if reports else ""]
    sections = [
        markup.section("Scores", scores_table(arms), published_table()),
        markup.section(f"Differences to {first}", _differences(arms, first, others), markup.note(HOW_SURE)),
        markup.section("Recovery", recovery_table(arms)),
        markup.section("Driving score by scenario", _scenarios(arms)),
        markup.section("Drives that ended differently", _drives(arms, links), markup.note(SUCCESS)),
    ]
    return markup.document(f"{Path(m.suite).stem}: {len(arms)} runs compared", head, sections)


HOW_SURE = (
    "Over the routes and seeds that both drove. Brackets show the 95 % interval of a bootstrap over routes; p is that "
    "of a paired permutation test: how often chance alone would cause a difference this large."
)
SUCCESS = "Success or failure as Bench2Drive counts it, with the driving score of each drive."


def _differences(arms: Arms, first: str, others: Sequence[str]) -> str:
    rows = []
    for name in others:
        for figure, (_, _, found) in comparison(arms[first], arms[name]).items():
            cells = (_between(found.difference), f"{found.p:.4f}")
            rows.append([markup.text(f"{name}: {figure}"), *map(markup.cell, cells)])
    return markup.raw_table("Differences", ("Figure", "Difference [95 %]", "p"), rows)


def _between(interval: Interval) -> str:
    return f"{number(interval.mean)} [{number(interval.low)}, {number(interval.high)}]"


def _scenarios(arms: Arms) -> str:
    groups = {name: per_scenario(arm) for name, arm in arms.items()}
    rows = []
    for kind in sorted(set().union(*groups.values())):
        values = (found[kind]["driving_score"] if kind in found else None for found in groups.values())
        rows.append([markup.text(kind), *map(bar_cell, values)])
    return markup.raw_table("Driving score by scenario", ("Scenario", *arms), rows)


def _drives(arms: Arms, links: Mapping[str, Links]) -> str:
    drives = {name: {(row.route.id, row.seed): row for row in arm.rows} for name, arm in arms.items()}
    rows = []
    for key, row in next(iter(drives.values())).items():
        found = {name: rows_of.get(key) for name, rows_of in drives.items()}
        if len({item.success for item in found.values() if item is not None}) < 2:
            continue
        label = f"{row.route.id} {row.scenario}, seed {row.seed}"
        rows.append([markup.text(label), *(_drive(item, links[name].get(key)) for name, item in found.items())])
    if not rows:
        return "<p>None: every drive succeeded with all runs, or failed with all of them.</p>"
    return markup.raw_table("Drives that ended differently", ("Drive", *arms), rows)


def _drive(row: RouteRow | None, page: str | None) -> str:
    if row is None:
        return "<td>not driven</td>"
    outcome_text = f"{'success' if row.success else status_of(row)}, {row.score:.1f}"
    shown = f" {markup.link(page, 'replay')}" if page else ""
    return f'<td class="status {"good" if row.success else "bad"}">{markup.text(outcome_text)}{shown}</td>'
