"""The shipped suites: routes in the leaderboard's XML format, by name."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path

from stucksolver_eval.routes import Route, read_routes

DATA = Path(__file__).with_name("data")


class SuiteError(ValueError):
    """There is no such suite, no guidance or no map for it. The message names the remedy."""


@dataclass(frozen=True)
class Suite:
    """Routes with a digest that identifies their version."""

    name: str
    routes: tuple[Route, ...]
    digest: str
    """The first 12 hexadecimal digits of the file's SHA-256."""

    @property
    def maps(self) -> tuple[str, ...]:
        """The towns of the suite, in alphabetical order."""
        return tuple(sorted({route.town for route in self.routes}))


def suite_names() -> tuple[str, ...]:
    """Return the names of the shipped suites."""
    return tuple(sorted(path.stem for path in DATA.glob("*.xml")))


def suite(name: str) -> Suite:
    """Return a shipped suite, such as `immobilized`, or a route file if the name ends in `.xml`.

    Raises `SuiteError` for an unknown name and `RouteFileError` for an invalid file.
    """
    path = Path(name) if name.endswith(".xml") else DATA / f"{name}.xml"
    if path.parent == DATA and name not in suite_names():
        known = ", ".join(suite_names())
        raise SuiteError(f"no such shipped suite: '{name}'. Choose from {known}, or give a route file (.xml)")
    routes = read_routes(path)
    return Suite(path.stem, routes, hashlib.sha256(path.read_bytes()).hexdigest()[:12])


def shipped_guidance(name: str) -> Path:
    """Return the path of a suite's shipped guidance script. Raises `SuiteError` if there is none."""
    path = DATA / f"guidance-{name}.json"
    if not path.is_file():
        known = ", ".join(suite_names())
        raise SuiteError(f"no shipped guidance for suite: '{name}', only for {known}. Give a script")
    return path


def load_routes(name: str, only: tuple[str, ...] = ()) -> tuple[Route, ...]:
    """Return the routes of a suite or file, or those with the ids `only`. Raises `SuiteError` and `RouteFileError`."""
    routes = suite(name).routes
    known = {route.id for route in routes}
    missing = [route_id for route_id in only if route_id not in known]
    if missing:
        raise SuiteError(f"no such route in {name}: {', '.join(missing)}. Its ids are {', '.join(sorted(known))}")
    return tuple(route for route in routes if not only or route.id in only)


def route_ids(name: str) -> frozenset[str]:
    """Return the ids of all routes of a suite or file. Raises `SuiteError` and `RouteFileError`."""
    return frozenset(route.id for route in suite(name).routes)
