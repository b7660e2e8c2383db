"""Generates the pages of `results/` from the data stored there: `python -m stucksolver_eval.result_pages.NAME`."""

from __future__ import annotations

from pathlib import Path

RESULTS = Path(__file__).parents[5] / "results"
