"""One HTML file about runs: a table, synchronized replays, and every decision with its reasons."""

from pathlib import Path

from stucksolver_eval.report.write import ReportError, write_report

ASSETS = Path(__file__).parent / "assets"
"""Scripts and styles of a replay, which the passenger's page uses too."""

__all__ = ["ASSETS", "ReportError", "write_report"]
