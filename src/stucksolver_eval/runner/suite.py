"""Loads the requested routes: a whole suite, or some of it."""

from __future__ import annotations

from stucksolver_eval.routes import Route
from stucksolver_eval.suites import SuiteError, suite


def load_routes(name: str, only: tuple[str, ...] = ()) -> tuple[Route, ...]:
    """Return the routes of a suite or file, or those with the given ids. Raises `SuiteError` and `RouteFileError`."""
    routes = suite(name).routes
    known = {route.id for route in routes}
    missing = [one for one in only if one not in known]
    if missing:
        raise SuiteError(f"no route {', '.join(missing)} in {name}; its ids are {', '.join(sorted(known))}")
    return tuple(route for route in routes if not only or route.id in only)


def route_ids(name: str) -> frozenset[str]:
    """Return the ids of all routes of a suite or file. Raises `SuiteError` and `RouteFileError`."""
    return frozenset(route.id for route in suite(name).routes)
