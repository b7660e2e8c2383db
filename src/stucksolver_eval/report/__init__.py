"""One HTML file that shows runs: a table, synchronised replays, and every decision with its reasons."""

from stucksolver_eval.report.write import ReportError, write_report

__all__ = ["ReportError", "write_report"]
