"""Makes the pages of `results/` from the data kept there: `python -m stucksolver_eval.pages.NAME`, in a checkout."""

from __future__ import annotations

from pathlib import Path

RESULTS = Path(__file__).parents[3] / "results"
