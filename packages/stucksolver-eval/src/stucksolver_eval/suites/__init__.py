"""The shipped suites: routes in the leaderboard's XML format, by name."""

from stucksolver_eval.suites.suites import (
    DATA,
    Suite,
    SuiteError,
    load_routes,
    route_ids,
    shipped_guidance,
    suite,
    suite_names,
)

__all__ = ["DATA", "Suite", "SuiteError", "load_routes", "route_ids", "shipped_guidance", "suite", "suite_names"]
