"""The page of an evaluation: scores, abilities, recovery, scenarios, and routes with their replays."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from stucksolver.atomic_files import write_text
from stucksolver_eval.metrics.columns import run_name
from stucksolver_eval.metrics.multi_ability import ABILITIES
from stucksolver_eval.metrics.recovery import RecoveryMetrics
from stucksolver_eval.metrics.right_reaction import HEAD as REACTION_HEAD
from stucksolver_eval.metrics.run_result import immobilizations, run_result
from stucksolver_eval.metrics.summary import RouteRow, Summary
from stucksolver_eval.report import markup
from stucksolver_eval.report.decisions import write_decisions
from stucksolver_eval.report.markup import bar_cell
from stucksolver_eval.report.metric_tables import published_table, recovery_table, scores_table
from stucksolver_eval.report.tables import (
    banners,
    guidance_text,
    infraction_text,
    per_scenario,
    reactions,
    routes_csv,
    summary_json,
)
from stucksolver_eval.report.write import write_report
from stucksolver_eval.results.checkpoint import status_text
from stucksolver_eval.results.run_log import RunLog
from stucksolver_eval.results.store import ResultStore

Links = Mapping[tuple[str, int], str]
"""Paths relative to the evaluation's folder, by route id and seed."""


def write_evaluation(store: ResultStore, summary: Summary) -> Path:
    """Write `summary.json`, `routes.csv`, `report.html`, and a page for each replay or each record's decisions.

    Returns the report's path. Raises `OutputError`, `ReportError` and `RecordError`.
    """
    folder = store.folder
    write_text(folder / "summary.json", summary_json(summary))
    write_text(folder / "routes.csv", routes_csv(summary))
    links = replay_pages(store, summary)
    decisions = write_decisions(store, summary, links)
    write_text(folder / "report.html", evaluation_page(summary, links, decisions, _has_records(store, summary)))
    return folder / "report.html"


def evaluation_page(summary: Summary, links: Links, decisions: Links | None = None, recorded: bool = False) -> str:
    """Return the HTML page. `links` are pages with replay and decisions, `decisions` those with decisions only."""
    title = f"{Path(summary.manifest.suite).stem}: {run_name(summary)}"
    guidance = guidance_text(summary) or "nothing was said"
    run = {run_name(summary): summary}
    head = [*map(markup.warning, banners(summary)), markup.note(_about(summary)), _command(summary)]
    sections = [
        markup.section("Scores", scores_table(run), published_table()),
        markup.section("Abilities", _abilities(summary)),
        markup.section(
            "Recovery",
            recovery_table(run),
            markup.note(_alone(summary.recovery)),
            f"<p>Guidance: {markup.text(guidance)}.</p>",
        ),
        markup.section("Scenarios", _scenarios(summary), _reactions(summary)),
        markup.section(
            "Routes",
            _routes(summary.rows, links, decisions or {}),
            RECORDS if recorded else "",
        ),
    ]
    return markup.document(title, head, sections)


RECORDS = (
    '<p class="note">Hash-chained records of the interventions are in '
    f"{markup.code('seed-*/interventions')}; {markup.code('stucksolver replay FILE')} checks one and recomputes its "
    "decisions and verdicts.</p>"
)


def _about(summary: Summary) -> str:
    m = summary.manifest
    seeds = ", ".join(map(str, m.seeds))
    guided = f", guidance {m.guidance}" if m.guidance else ""
    asked = f", prompt {m.prompt}" if m.prompt else ""
    return (
        f"Suite {m.suite} (digest {m.suite_digest[:12]}), {m.routes} routes, seeds {seeds}; driver {m.driver}, "
        f"recovery {m.recovery}{guided}{asked}, clock {m.clock}, perception {m.perception}, simulator {m.simulator}."
    )


def _command(summary: Summary) -> str:
    command = summary.manifest.command
    return f'<p class="note">Command: {markup.code(command)}</p>' if command else ""


def _alone(f: RecoveryMetrics) -> str:
    if f.harm_alone is None:
        return "Driver alone: unknown; score this run with --alone DIR to pair it with the driver alone."
    return f"Infractions on whole routes: {f.infractions}, and {f.infractions_alone} with the driver alone."


def _abilities(summary: Summary) -> str:
    rows = [
        [markup.text(name.replace("_", " ").capitalize()), bar_cell(summary.abilities[name])]
        for name in (*ABILITIES, "mean")
    ]
    return markup.raw_table("Abilities", ("Ability", "Success rate, %"), rows)


def _scenarios(summary: Summary) -> str:
    rows = [
        [
            markup.text(name),
            markup.cell(f"{item['routes']:.0f}"),
            bar_cell(item["driving_score"]),
            bar_cell(item["success_rate"]),
        ]
        for name, item in per_scenario(summary).items()
    ]
    return markup.raw_table("Scenarios", ("Scenario", "Drives", "Driving score", "Success rate, %"), rows)


def _reactions(summary: Summary) -> str:
    rows = [row.cells for row in reactions(summary)]
    return markup.table("Right reactions", REACTION_HEAD, rows) if rows else ""


def _routes(rows: tuple[RouteRow, ...], links: Links, decisions: Links) -> str:
    head = ("Route", "Scenario", "Seed", "Status", "DS", "Infractions", "Plans", "Pages")
    cells = []
    for row in rows:
        key = row.route.id, row.seed
        pages = [
            markup.link(links[key], "replay and decisions") if key in links else "",
            markup.link(decisions[key], "decisions") if key in decisions else "",
        ]
        cells.append(
            [
                markup.text(row.route.id),
                *map(markup.cell, (row.scenario, str(row.seed))),
                f'<td class="status {"good" if row.success else "bad"}">{markup.text(status_of(row))}</td>',
                *map(markup.cell, (f"{row.score:.1f}", infraction_text(row))),
                markup.cell(str(len(row.outcome.interventions)) if row.outcome else ""),
                f"<td>{' '.join(filter(None, pages))}</td>",
            ]
        )
    return markup.raw_table("Routes", head, cells)


def status_of(row: RouteRow) -> str:
    """Return the end of a run, with the reason if the route was not driven."""
    status = status_text(row.record.status) if row.record else row.outcome.state if row.outcome else "missing"
    why = row.outcome.reason.splitlines()[-1] if row.outcome and row.outcome.reason else ""
    return f"{status} {why}".strip()


def _has_records(store: ResultStore, summary: Summary) -> bool:
    return any(store.interventions(row.route, row.seed).is_dir() for row in summary.rows)


def _with_figures(log: RunLog, row: RouteRow) -> RunLog:
    """Return a replay with the metrics of the summary. An older replay contains others."""
    if row.record is None or row.outcome is None:
        return log
    spans = tuple((immobilization.onset_s, immobilization.ended_s) for immobilization in immobilizations(row.outcome))
    result = run_result(row.record, row.outcome, len(log.decisions))
    return log.model_copy(update={"result": result, "stuck": spans})


def replay_pages(store: ResultStore, summary: Summary) -> Links:
    """Write a page for each stored replay without one. Returns the paths relative to the store's folder."""
    links = {}
    for row in summary.rows:
        packed = store.replay(row.route, row.seed)
        if not packed.exists():
            continue
        page = packed.with_name(packed.name.removesuffix(".json.gz") + ".html")
        if not page.exists() or page.stat().st_mtime < packed.stat().st_mtime:
            log = _with_figures(store.run_log(row.route, row.seed), row)
            write_report([log], page, f"{row.scenario}, route {row.route.id}", [summary.manifest.title])
        links[row.route.id, row.seed] = str(page.relative_to(store.folder))
    return links
