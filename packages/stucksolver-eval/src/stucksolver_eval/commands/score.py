"""`stucksolver score` and `stucksolver compare`: compute figures from result files alone."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from stucksolver.commands.arguments import add_json, print_json
from stucksolver.commands.errors import UsageError

SCORES = '[{"folder": path, "warnings": [text], ...}] with all fields of the folder\'s summary.json'
"""Form of the output of `--json` for each evaluation."""

if TYPE_CHECKING:
    from stucksolver_eval.metrics.comparison import Compared
    from stucksolver_eval.metrics.summary import Summary
    from stucksolver_eval.results.store import ResultStore


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of `score`."""
    parser.add_argument("folders", nargs="+", type=Path, metavar="DIR", help="output of `evaluate --out`")
    parser.add_argument("--alone", type=Path, metavar="DIR", help="the same suite and seeds with the driver alone")
    parser.add_argument("--plots", type=Path, metavar="DIR", help="write PNG plots that compare all of them")
    add_json(parser, SCORES)


def add_compare_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of `compare`."""
    parser.add_argument("first", type=Path, metavar="A", help="output of `evaluate --out`, the baseline")
    parser.add_argument(
        "others", nargs="+", type=Path, metavar="B", help="output of `evaluate --out` on the same routes; one or more"
    )
    parser.add_argument("--page", type=Path, metavar="HTML", help="write a page that compares all of them")
    add_json(
        parser,
        '[{figure: {"a", "b", "difference", "p", "pairs"}}], an object for each B; a, b and difference are '
        '{"mean", "low", "high"} with a 95 %% interval',
    )


def run(options: argparse.Namespace) -> int:
    """Print the scores of existing results; returns the exit code of `show_scores`.

    Raises:
        UsageError: Results cannot be read, or plots are requested without matplotlib.
    """
    from stucksolver.optional_dependencies import can_plot

    if options.plots is not None and not can_plot():
        raise UsageError("--plots needs matplotlib: add the extra [report] (README, Install)")
    return show_scores(options.folders, alone=options.alone, plots=options.plots, as_json=options.json)


def show_scores(
    folders: list[Path], alone: Path | None = None, plots: Path | None = None, *, as_json: bool = False
) -> int:
    """Print all tables, or JSON, and write each folder's report.

    Returns 1 if a route crashed or could not be driven as requested, or if most questions to a model had no usable
    answer; else 0. Raises `UsageError`.
    """
    from stucksolver.atomic_files import OutputError
    from stucksolver.record import RecordError
    from stucksolver_eval.report import ReportError
    from stucksolver_eval.report.evaluation import write_evaluation
    from stucksolver_eval.report.plots import write_plots
    from stucksolver_eval.report.tables import banners, summary_text
    from stucksolver_eval.results.store import ResultStore, StoreError
    from stucksolver_eval.routes import RouteFileError

    try:
        pair = _pair(folders, alone)
        summaries = []
        for folder in folders:
            summaries.append(_summarized(folder, pair))
            write_evaluation(ResultStore(folder), summaries[-1])
        if plots is not None:
            write_plots(summaries, plots)
    except (StoreError, RouteFileError, OutputError, ReportError, RecordError, OSError) as error:
        raise UsageError(str(error)) from error
    if as_json:
        _print_scores(zip(folders, summaries, strict=True))
    else:
        print(summary_text(summaries))
        print("\n" + "\n".join(f"report: {folder / 'report.html'}" for folder in folders))
    return int(any(s.crashed or s.invalid or banners(s) for s in summaries))


def _print_scores(evaluations: Iterable[tuple[Path, Summary]]) -> None:
    from stucksolver_eval.report.tables import banners, summary_data

    print_json([{"folder": folder, "warnings": banners(s), **summary_data(s)} for folder, s in evaluations])


def _pair(folders: list[Path], alone: Path | None) -> ResultStore | None:
    """Return the evaluation of the driver alone: `alone`, or one of the folders, or None."""
    from stucksolver_eval.results.store import ResultStore

    if alone is not None:
        return ResultStore(alone)
    return next((s for s in map(ResultStore, folders) if s.manifest().recovery == "none"), None)


def _summarized(folder: Path, alone: ResultStore | None) -> Summary:
    """Return the metrics of one evaluation, paired with the driver alone unless it is that evaluation."""
    from stucksolver_eval.metrics.summary import summarize
    from stucksolver_eval.results.store import ResultStore

    return summarize(ResultStore(folder), None if alone is None or folder == alone.folder else alone)


def show_sweep(summaries: dict[str, Summary], out: Path, *, as_json: bool = False) -> int:
    """Print the trade-off, or JSON, and write a report for each combination; returns as `show_scores` does."""
    from stucksolver_eval.report.evaluation import write_evaluation
    from stucksolver_eval.report.tables import banners
    from stucksolver_eval.report.tradeoff import write_tradeoff
    from stucksolver_eval.results.store import ResultStore

    for label, summary in summaries.items():
        write_evaluation(ResultStore(out / label), summary)
    table = write_tradeoff(summaries, out)
    warned = [f"{label}: {text}" for label, summary in summaries.items() for text in banners(summary)]
    if as_json:
        _print_scores((out / label, summary) for label, summary in summaries.items())
    else:
        print("\n".join([table, *warned]))
    return int(bool(warned) or any(s.crashed or s.invalid for s in summaries.values()))


def run_compare(options: argparse.Namespace) -> int:
    """Print the comparison of each B with A.

    Returns 1 if most questions to a model had no usable answer, else 0. Raises `UsageError`.
    """
    from stucksolver.atomic_files import OutputError
    from stucksolver.commands.terminal_text import filled
    from stucksolver_eval.metrics.comparison import ComparisonError, comparison, comparison_text
    from stucksolver_eval.report import ReportError
    from stucksolver_eval.report.comparison import write_comparison
    from stucksolver_eval.report.tables import banners
    from stucksolver_eval.results.store import StoreError
    from stucksolver_eval.routes import RouteFileError

    try:
        # Only the driver alone shows where waiting would have sufficed, and A may be another reasoner.
        alone = _pair([options.first, *options.others], None)
        first, *others = [_summarized(other, alone) for other in (options.first, *options.others)]
        compared = [comparison(first, other) for other in others]
        if options.json:
            print_json([_figures(item) for item in compared])
        else:
            print("\n\n".join(comparison_text(first, *pair) for pair in zip(others, compared, strict=True)))
        if options.page is not None:
            write_comparison([options.first, *options.others], [first, *others], options.page)
            print(f"\npage: {options.page}", file=sys.stderr if options.json else sys.stdout)
    except (StoreError, RouteFileError, ComparisonError, OutputError, ReportError) as error:
        raise UsageError(str(error)) from error
    warned = [text for other in (first, *others) for text in banners(other)]
    if warned:
        print("\n" + "\n".join(map(filled, warned)), file=sys.stderr if options.json else sys.stdout)
    return int(bool(warned))


def _figures(compared: Compared) -> dict[str, dict[str, object]]:
    """Return each metric of A and B, and their difference over the pairs, with 95 % intervals."""
    return {
        name: {"a": asdict(a), "b": asdict(b), "difference": asdict(d.difference), "p": d.p, "pairs": d.pairs}
        for name, (a, b, d) in compared.items()
    }
