"""`stucksolver replay`: derives a record again and says whether it matches."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from stucksolver.cli.errors import UsageError
from stucksolver.record import RecordError, Report, replay

SHOWN = 20


def add_replay(commands: Any) -> argparse.ArgumentParser:
    """Register the command."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "replay", help="derive every decision and verdict of a record again, offline"
    )
    parser.add_argument("records", nargs="+", type=Path, metavar="FILE", help="a record, intervention-….jsonl")
    return parser


def run_replay(options: argparse.Namespace) -> int:
    """0 when everything matches, 1 when something does not. Raises `UsageError` for a record that was changed."""
    agree = True
    for path in options.records:
        try:
            report = replay(path)
        except RecordError as error:
            raise UsageError(str(error)) from error
        _print(report)
        agree = agree and report.matches
    return 0 if agree else 1


def _print(report: Report) -> None:
    told = [
        f"{report.decisions - report.underivable} of {report.decisions} decisions",
        f"{report.plans} verdicts at acceptance",
        f"{report.ticks} ticks",
    ]
    print(f"{report.path}: {report.lines} lines, unbroken chain; derived again: {', '.join(told)}")
    if report.underivable:
        print(f"  {report.underivable} decisions came from a reasoner that leaves no trace")
    print(f"  ended: {report.ended}" if report.ended else "  it breaks off: the process ended, or the disk was full")
    for finding in report.findings[:SHOWN]:
        print(f"  line {finding.line}, {finding.what}: recorded {finding.recorded!r}, derived {finding.derived!r}")
    if len(report.findings) > SHOWN:
        print(f"  and {len(report.findings) - SHOWN} more")
    print("  everything matches" if report.matches else f"  {len(report.findings)} do not match; see `versions`:")
    if not report.matches:
        print(f"  written by {', '.join(f'{name} {version}' for name, version in report.versions.items())}")
