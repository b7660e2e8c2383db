"""`stucksolver replay`: derives a record again and says whether it matches."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from stucksolver.cli.errors import UsageError
from stucksolver.plotting import can_plot
from stucksolver.record import Anchor, RecordError, Report, check_anchor, read_heads, replay, write_heads
from stucksolver.record.picture import draw_record

SHOWN = 20


def add_options(parser: argparse.ArgumentParser) -> None:
    """What the command is told."""
    parser.add_argument("records", nargs="*", type=Path, metavar="FILE", help="a record, intervention-….jsonl")
    parser.add_argument(
        "--save-heads", type=Path, metavar="FILE", help="write line and hash of each record's end, to be kept elsewhere"
    )
    parser.add_argument(
        "--anchors", type=Path, metavar="FILE", help="heads saved before: the records must agree with them"
    )
    parser.add_argument("--picture", type=Path, metavar="PNG", help="draw it from above (one record; needs matplotlib)")
    parser.add_argument(
        "--at", type=float, nargs="+", default=(), metavar="S", help="moments to draw, by the stack's clock"
    )


def run(options: argparse.Namespace) -> int:
    """0 when all are whole and match, else 1. Raises `UsageError` for a record that was changed."""
    try:
        anchors = {} if options.anchors is None else read_heads(options.anchors)
        records = options.records or list(anchors)
        if not records:
            raise UsageError("name a record, intervention-….jsonl, or --anchors FILE")
        if options.anchors is not None and (unknown := [path for path in records if path not in anchors]):
            raise UsageError(f"{options.anchors} has no anchor of {unknown[0]}; name it as it was named there")
        if options.picture is not None:
            _picture(options, records)
        elif options.at:
            raise UsageError("--at chooses moments of a picture: add --picture PNG")
        reports = [_replayed(path, anchors) for path in records]
        if options.save_heads is not None:
            write_heads(options.save_heads, records)
            print(f"heads: {options.save_heads}; sign it, or keep it where nobody can change it")
    except RecordError as error:
        raise UsageError(str(error)) from error
    return 0 if all(report.matches and report.ended is not None for report in reports) else 1


def _replayed(path: Path, anchors: dict[Path, Anchor]) -> Report:
    report = replay(path)
    _print(report)
    if path in anchors:
        check_anchor(path, anchors[path])
        print(f"  as anchored at line {anchors[path].line}")
    return report


def _picture(options: argparse.Namespace, records: Sequence[Path]) -> None:
    if len(records) > 1:
        raise UsageError("--picture draws one record; name one FILE")
    if not can_plot():
        raise UsageError("--picture needs matplotlib: pip install 'stucksolver[report]'")
    try:
        print(f"picture: {draw_record(records[0], options.picture, options.at)}")
    except OSError as error:
        raise UsageError(f"cannot write {options.picture}: {error.strerror}; name another place") from error


def _print(report: Report) -> None:
    told = [
        f"{report.decisions - report.underivable} of {report.decisions} decisions",
        f"{report.plans} verdicts at acceptance",
        f"{report.ticks} ticks",
    ]
    print(f"{report.path}: {report.lines} lines, unbroken chain; derived again: {', '.join(told)}")
    if report.underivable:
        print(f"  {report.underivable} decisions came from a reasoner that leaves no trace")
    broken = "it is incomplete: the run failed, its process was killed, or the disk was full"
    print(f"  ended: {report.ended}" if report.ended else f"  {broken}")
    for finding in report.findings[:SHOWN]:
        print(f"  line {finding.line}, {finding.what}: recorded {finding.recorded!r}, derived {finding.derived!r}")
    if len(report.findings) > SHOWN:
        print(f"  and {len(report.findings) - SHOWN} more")
    whole = "everything matches" if report.ended else "everything up to there matches"
    print(f"  {whole}" if report.matches else f"  {len(report.findings)} do not match; see `versions`:")
    if not report.matches:
        print(f"  written by {', '.join(f'{name} {version}' for name, version in report.versions.items())}")
