"""Suites by name: those that ship with us, or a route file."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

from stucksolver.evaluate.routes import Route, read_routes

PACKAGE = "stucksolver.evaluate"


class SuiteError(ValueError):
    """No such suite; the message lists what there is."""


def suite_names() -> tuple[str, ...]:
    """Suites that ship with us."""
    folder = Path(str(files(PACKAGE))) / "suites"
    return tuple(sorted(path.stem for path in folder.glob("*.xml")))


def suite_path(name: str) -> Path:
    """The route file of a suite's name, or of a path. Raises `SuiteError`."""
    shipped = Path(str(files(PACKAGE))) / "suites" / f"{name}.xml"
    if shipped.is_file():
        return shipped
    path = Path(name)
    if path.suffix == ".xml" or path.exists():
        return path
    known = ", ".join(suite_names()) or "none"
    raise SuiteError(f"unknown suite {name!r}: there are {known}; or give a route file that ends in .xml")


def load_suite(name: str, only: tuple[str, ...] = ()) -> tuple[Route, ...]:
    """Its routes, or those of the ids given. Raises `SuiteError` and `RouteFileError`."""
    routes = read_routes(suite_path(name))
    if not only:
        return routes
    known = {route.id for route in routes}
    missing = [one for one in only if one not in known]
    if missing:
        raise SuiteError(f"no route {', '.join(missing)} in {name}; its ids are {min(known)} to {max(known)}")
    return tuple(route for route in routes if route.id in only)
