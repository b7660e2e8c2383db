"""The page of an evaluation: tables, bars by ability and by scenario, and the routes with their replays."""

from __future__ import annotations

import html
from pathlib import Path

from stucksolver_eval.files import write_text
from stucksolver_eval.report.charts import bars
from stucksolver_eval.report.page import block_digest
from stucksolver_eval.report.tables import (
    banners,
    guidance_text,
    infraction_text,
    per_scenario,
    routes_csv,
    summary_json,
)
from stucksolver_eval.report.write import write_report
from stucksolver_eval.results.record import status_text
from stucksolver_eval.results.store import Store
from stucksolver_eval.scores.ability import ABILITIES
from stucksolver_eval.scores.columns import (
    ABILITY_HEAD,
    HEAD,
    NOT_COMPARABLE,
    PUBLISHED,
    RECOVERY_HEAD,
    SOURCE,
    ability_row,
    corrected_row,
    main_row,
    published_ability_rows,
    published_row,
    recovery_row,
    run_name,
)
from stucksolver_eval.scores.recovery import RecoveryFigures
from stucksolver_eval.scores.summary import RouteRow, Summary
from stucksolver_eval.terminal import Row

COLUMNS_AT_MOST = 9
Links = dict[tuple[str, int], str]
STYLE = """
body{font:15px/1.45 system-ui,sans-serif;margin:2rem auto;max-width:76rem;padding:0 1rem;color:#1d2430;background:#fff}
.warning{background:#fde8d7;border-left:.3rem solid #c2410c;padding:.6rem .9rem;font-weight:600}
h1{font-size:1.5rem}h2{font-size:1.15rem;margin-top:2rem}
table{border-collapse:collapse;font-variant-numeric:tabular-nums;margin:.6rem 0;display:block;overflow-x:auto}
th,td{padding:.25rem .6rem;border-bottom:1px solid #dfe4ec;text-align:left;white-space:nowrap}
th{color:#4a5568;font-weight:600}.other td{color:#8a94a6}.note{color:#5b6576;font-size:.9rem}
.ok{color:#1a7f4b}.bad{color:#b3352c}svg{max-width:100%;height:auto}
"""


def write_evaluation(store: Store, summary: Summary) -> Path:
    """`summary.json`, `routes.csv`, `report.html`, and a page for each replay. Raises `OutputError`, `ReportError`."""
    folder = store.folder
    write_text(folder / "summary.json", summary_json(summary))
    write_text(folder / "routes.csv", routes_csv(summary))
    links = _replays(store, summary)
    write_text(folder / "report.html", evaluation_page(summary, links, _records(store, summary)))
    return folder / "report.html"


def evaluation_page(summary: Summary, links: Links, records: Links | None = None) -> str:
    """The whole HTML text. `links`: replay pages by route id and seed; `records`: folders of decision records."""
    m = summary.manifest
    title = f"{Path(m.suite).stem}: {run_name(summary)}"
    abilities = [(name.replace("_", " "), summary.abilities[name]) for name in ABILITIES]
    types = per_scenario(summary)
    parts = [
        f"<h1>{html.escape(title)}</h1>",
        *(f'<p class="warning">{html.escape(text)}</p>' for text in banners(summary)),
        f'<p class="note">{html.escape(_about(summary))}</p>',
        "<h2>Scores</h2>",
        _table(HEAD, [main_row(summary), corrected_row(summary)], [published_row(row) for row in PUBLISHED]),
        f'<p class="note">Rows in grey: {NOT_COMPARABLE} ({SOURCE}). “Corrected”: efficiency that counts the stretch '
        "on which a route got stuck, comfort in the units its bounds are meant for.</p>",
        "<h2>Abilities</h2>",
        _table(ABILITY_HEAD, [ability_row(summary)], published_ability_rows()),
        bars(abilities, "success rate %"),
        "<h2>Recovery</h2>",
        *_folded(RECOVERY_HEAD, recovery_row(summary)),
        f'<p class="note">{html.escape(_recovery_note(summary.recovery))}</p>',
        f"<p>Guidance: {html.escape(guidance_text(summary) or 'nothing was said')}.</p>",
        "<h2>Scenarios</h2>",
        bars([(name, one["driving_score"]) for name, one in types.items()], "driving score"),
        bars([(name, one["success_rate"]) for name, one in types.items()], "success rate %"),
        "<h2>Routes</h2>",
        _route_table(summary.rows, links, records or {}),
    ]
    policy = f"default-src 'none'; style-src '{block_digest(STYLE)}'"
    head = f'<meta charset="utf-8"><meta http-equiv="Content-Security-Policy" content="{policy}">'
    body = "\n".join(parts)
    head += f"<title>{html.escape(title)}</title><style>{STYLE}</style>"
    return f"<!doctype html><html lang=en><head>{head}</head><body>\n{body}\n</body></html>\n"


def _about(summary: Summary) -> str:
    m = summary.manifest
    seeds = ", ".join(map(str, m.seeds))
    guided = f", guidance {m.guidance}" if m.guidance else ""
    asked = f", prompt {m.prompt}" if m.prompt else ""
    return (
        f"Suite {m.suite} (digest {m.suite_digest[:12]}), {m.routes} routes, seeds {seeds}; driver {m.driver}, "
        f"recovery {m.recovery}{guided}{asked}, clock {m.clock}, perception {m.perception}, "
        f"simulator {m.simulator}. {m.command}"
    )


def _recovery_note(f: RecoveryFigures) -> str:
    note = (
        "Met: stood or crept for 10 s or more, or a plan was begun. Left: 15 m of progress followed. Recovered: within "
        "60 s of a plan, without an infraction. Harm: infractions and near misses from a plan to 10 s after its end."
    )
    if f.harm_alone is None:
        return note + " Alone: not known; score with --alone DIR to pair this run with the driver alone."
    return f"{note} Over whole routes: {f.infractions}, and {f.infractions_alone} with the driver alone."


def _table(head: Row, rows: list[Row], others: list[Row]) -> str:
    lines = ["<tr>" + "".join(f"<th>{html.escape(cell)}</th>" for cell in head) + "</tr>"]
    lines += ["<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in rows]
    lines += [
        '<tr class="other">' + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in others
    ]
    return "<table>" + "".join(lines) + "</table>"


def _folded(head: Row, row: Row) -> list[str]:
    """One row under the other: too many columns for a page's width."""
    starts = range(1, len(head), COLUMNS_AT_MOST)
    return [_table(head[k : k + COLUMNS_AT_MOST], [row[k : k + COLUMNS_AT_MOST]], []) for k in starts]


def _route_table(rows: tuple[RouteRow, ...], links: Links, records: Links) -> str:
    head = ("Route", "Scenario", "Seed", "Status", "DS", "Infractions", "Plans", "Replay", "Record")
    lines = ["<tr>" + "".join(f"<th>{cell}</th>" for cell in head) + "</tr>"]
    for row in rows:
        status = status_text(row.record.status) if row.record else row.outcome.state if row.outcome else "missing"
        why = row.outcome.reason.splitlines()[-1] if row.outcome and row.outcome.reason else ""
        key = row.route.id, row.seed
        cells = [
            html.escape(row.route.id),
            html.escape(row.scenario),
            str(row.seed),
            f'<span class="{"ok" if row.success else "bad"}">{html.escape(f"{status} {why}".strip())}</span>',
            f"{row.score:.1f}",
            html.escape(infraction_text(row)),
            str(len(row.outcome.interventions)) if row.outcome else "",
            _link(links.get(key), "replay"),
            _link(records.get(key), "decisions"),
        ]
        lines.append("<tr>" + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>")
    return "<table>" + "".join(lines) + "</table>"


def _link(target: str | None, text: str) -> str:
    return f'<a href="{html.escape(target)}">{text}</a>' if target else ""


def _records(store: Store, summary: Summary) -> Links:
    """The folders of decision records that there are, relative to the evaluation's."""
    folders = {(row.route.id, row.seed): store.interventions(row.route, row.seed) for row in summary.rows}
    return {key: f"{path.relative_to(store.folder)}/" for key, path in folders.items() if path.is_dir()}


def _replays(store: Store, summary: Summary) -> Links:
    """A page for each kept replay that has none yet; links relative to the folder."""
    links = {}
    for row in summary.rows:
        packed = store.replay(row.route, row.seed)
        if not packed.exists():
            continue
        page = packed.with_name(packed.name.removesuffix(".json.gz") + ".html")
        if not page.exists() or page.stat().st_mtime < packed.stat().st_mtime:
            log = store.run_log(row.route, row.seed)
            write_report([log], page, f"{row.scenario}, route {row.route.id}", [summary.manifest.title])
        links[row.route.id, row.seed] = str(page.relative_to(store.folder))
    return links
