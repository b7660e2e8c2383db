"""`stucksolver replay`: recomputes the decisions of a record and reports whether they match."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from stucksolver.commands.arguments import add_json, print_json
from stucksolver.commands.errors import UsageError
from stucksolver.optional_dependencies import can_plot
from stucksolver.record import Anchor, RecordError, Report, check_anchor, read_heads, replay, write_heads
from stucksolver.record.drawing import draw_record

SHOWN = 20
"""Maximum number of mismatches that are printed for a record."""


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    parser.add_argument("records", nargs="*", type=Path, metavar="FILE", help="a record, intervention-….jsonl")
    parser.add_argument(
        "--save-heads", type=Path, metavar="FILE", help="write the last line number and hash of each record to FILE"
    )
    parser.add_argument(
        "--anchors", type=Path, metavar="FILE", help="heads that were saved earlier; the records must match them"
    )
    parser.add_argument("--picture", type=Path, metavar="PNG", help="draw one record from above (needs matplotlib)")
    parser.add_argument(
        "--at", type=float, nargs="+", default=(), metavar="S", help="times to draw, on the stack's clock"
    )
    add_json(
        parser,
        '[{"file", "lines", "ended" (null if incomplete), "matches", "decisions", "underivable", "plans", "ticks", '
        '"versions", "findings": [{"line", "what", "recorded", "derived"}], "anchored_line" (or null)}]',
    )


def run(options: argparse.Namespace) -> int:
    """Replay the records. Returns 0 if all are complete and match, else 1. Raises `UsageError`."""
    try:
        anchors = {} if options.anchors is None else read_heads(options.anchors)
        records = options.records or list(anchors)
        if not records:
            raise UsageError("give a record, intervention-….jsonl, or --anchors FILE")
        if options.anchors is not None and (unknown := [path for path in records if path not in anchors]):
            raise UsageError(f"{options.anchors} has no entry for {unknown[0]}; give the path exactly as written there")
        if options.picture is not None:
            _picture(options, records)
        elif options.at:
            raise UsageError("--at selects times for a picture: add --picture PNG")
        reports = [_replayed(path, anchors, quiet=options.json) for path in records]
        if options.json:
            print_json([_data(report, anchors) for report in reports])
        if options.save_heads is not None:
            write_heads(options.save_heads, records)
            note = f"heads: {options.save_heads}; sign the file, or store it where it cannot be changed"
            print(note, file=sys.stderr if options.json else sys.stdout)
    except RecordError as error:
        raise UsageError(str(error)) from error
    return 0 if all(report.matches and report.ended is not None for report in reports) else 1


def _replayed(path: Path, anchors: dict[Path, Anchor], *, quiet: bool) -> Report:
    report = replay(path)
    if not quiet:
        _print(report)
    if path in anchors:
        check_anchor(path, anchors[path])
        if not quiet:
            print(f"  agrees with the anchor at line {anchors[path].line}")
    return report


def _data(report: Report, anchors: dict[Path, Anchor]) -> dict[str, object]:
    fields = asdict(report)
    anchor = anchors.get(fields.pop("path"))
    return {
        "file": report.path,
        **fields,
        "matches": report.matches,
        "anchored_line": None if anchor is None else anchor.line,
    }


def _picture(options: argparse.Namespace, records: Sequence[Path]) -> None:
    if len(records) > 1:
        raise UsageError("--picture draws one record; give one FILE")
    if not can_plot():
        raise UsageError("--picture needs matplotlib: add the extra [report] (README, Install)")
    try:
        note = f"picture: {draw_record(records[0], options.picture, options.at)}"
        print(note, file=sys.stderr if options.json else sys.stdout)
    except OSError as error:
        raise UsageError(f"{options.picture} cannot be written: {error.strerror}; choose another path") from error


def _print(report: Report) -> None:
    counts = [
        f"{report.decisions - report.underivable} of {report.decisions} decisions",
        f"{report.plans} verdicts at acceptance",
        f"{report.ticks} ticks",
    ]
    print(f"{report.path}: {report.lines} lines, hash chain intact; recomputed: {', '.join(counts)}")
    if report.underivable:
        print(f"  {report.underivable} decisions came from a reasoner without a trace and cannot be recomputed")
    broken = "incomplete: the run failed, its process was killed, or the disk was full"
    print(f"  ended: {report.ended}" if report.ended else f"  {broken}")
    for finding in report.findings[:SHOWN]:
        print(f"  line {finding.line}, {finding.what}: recorded {finding.recorded!r}, recomputed {finding.derived!r}")
    if len(report.findings) > SHOWN:
        print(f"  and {len(report.findings) - SHOWN} more")
    whole = "everything matches" if report.ended else "everything up to that point matches"
    print(f"  {whole}" if report.matches else f"  {len(report.findings)} do not match; see `versions`:")
    if not report.matches:
        print(f"  written by {', '.join(f'{name} {version}' for name, version in report.versions.items())}")
