"""Pages with the decisions of runs without a stored replay, read from their records."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

from stucksolver.record import read_decisions
from stucksolver_eval.metrics.columns import run_name
from stucksolver_eval.metrics.run_result import run_result
from stucksolver_eval.metrics.summary import RouteRow, Summary
from stucksolver_eval.report.write import write_report
from stucksolver_eval.results.outcome import came_to
from stucksolver_eval.results.run_log import DecisionMoment, MapView, RunLog
from stucksolver_eval.results.store import ResultStore
from stucksolver_eval.run_log.thumbnail import thumbnail

NOTE = "Times are those of the simulator. Only interventions are recorded; legitimate waits before them are not."


def write_decisions(
    store: ResultStore, summary: Summary, shown: Mapping[tuple[str, int], str]
) -> dict[tuple[str, int], str]:
    """Write a page for each run with records that is not in `shown`. Returns paths relative to the store's folder.

    Raises `RecordError` for a record that was changed, and `ReportError`.
    """
    links = {}
    for row in summary.rows:
        folder = store.interventions(row.route, row.seed)
        if (row.route.id, row.seed) in shown or not folder.is_dir() or row.record is None:
            continue
        page = folder / "decisions.html"
        log = _log(summary, row, tuple(moments_of(folder)))
        write_report([log], page, f"{row.scenario}, route {row.route.id}: decisions", [summary.manifest.title, NOTE])
        links[row.route.id, row.seed] = str(page.relative_to(store.folder))
    return links


def moments_of(folder: Path) -> Iterator[DecisionMoment]:
    """Yield the decisions of all records in a folder, with the camera's images. Raises `RecordError`."""
    for path in sorted(folder.glob("intervention-*.jsonl")):
        for decision in read_decisions(path):
            outcome, verdict = came_to(decision.event.verdict)
            yield DecisionMoment(
                time_s=round(decision.event.time_s, 2),
                trigger="guidance" if decision.event.trigger == "guidance" else "detector",
                decision=decision.decision.model_dump(mode="json"),
                outcome=outcome,
                codes=() if decision.event.verdict is None else decision.event.verdict.codes,
                verdict=verdict,
                picture=None if decision.image is None else thumbnail(decision.image),
            )


def _log(summary: Summary, row: RouteRow, moments: tuple[DecisionMoment, ...]) -> RunLog:
    """Return a run without frames, so that the page contains its decisions only."""
    m, record = summary.manifest, row.record
    assert record is not None
    return RunLog(
        scenario=f"{row.scenario}, route {row.route.id}",
        arm=run_name(summary),
        seed=row.seed,
        driver=m.driver,
        reasoner=m.recovery,
        clock=m.clock,
        perception=m.perception,
        map=MapView(name=row.route.town, lanes=(), markings=()),
        route=(),
        actors=(),
        frames=(),
        stuck=(),
        decisions=moments,
        events=(),
        result=run_result(record, row.outcome, len(moments)),
    )
