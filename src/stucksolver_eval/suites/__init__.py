"""Suites that ship: routes as the leaderboard's XML, found by name."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path

from stucksolver_eval.routes import Route, read_routes

DATA = Path(__file__).with_name("data")


class SuiteError(ValueError):
    """There is no such suite, or no words for it; the message names those there are."""


@dataclass(frozen=True)
class Suite:
    """Routes with what tells one version of them from another."""

    name: str
    routes: tuple[Route, ...]
    digest: str
    """The first 12 hexadecimal digits of the file's SHA-256."""

    @property
    def maps(self) -> tuple[str, ...]:
        """The towns it needs, in alphabetical order."""
        return tuple(sorted({route.town for route in self.routes}))


def suite_names() -> tuple[str, ...]:
    """The suites that ship."""
    return tuple(sorted(path.stem for path in DATA.glob("*.xml")))


def suite(name: str) -> Suite:
    """A suite that ships (`bench220`, `dev`) or, where the name ends in `.xml`, a file of routes.

    Raises `SuiteError` for a name that is neither and `RouteFileError` for a file that is not right.
    """
    path = Path(name) if name.endswith(".xml") else DATA / f"{name}.xml"
    if path.parent == DATA and name not in suite_names():
        known = ", ".join(suite_names())
        raise SuiteError(f"no suite '{name}' ships (there are: {known}); name one of them or a route file (.xml)")
    routes = read_routes(path)
    return Suite(path.stem, routes, hashlib.sha256(path.read_bytes()).hexdigest()[:12])


def shipped_guidance(name: str) -> Path:
    """What a passenger says on some routes of a suite that ships. Raises `SuiteError` where no such script does."""
    path = DATA / f"guidance-{name}.json"
    if not path.is_file():
        known = ", ".join(suite_names())
        raise SuiteError(f"no words of a passenger ship for the suite '{name}' (but for {known}); give a script")
    return path
