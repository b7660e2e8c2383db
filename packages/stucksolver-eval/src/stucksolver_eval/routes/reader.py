"""Reads the leaderboard's route XML, of format 2.0 (Bench2Drive) or 1.0 (Longest6, LAV, LMDrive).

In format 1.0 a route holds its waypoints itself. Its scenarios are in another file, which is not read. Errors name the
file, the line and the remedy.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

from stucksolver_eval.routes.route import Position, Route, RoutePose, ScenarioSpec, WeatherKey

_NOT_PARAMETERS = ("trigger_point",)
_NOT_WEATHER = ("id", "name")
"""Attributes of a weather in format 1.0 that are labels."""


class RouteFileError(ValueError):
    """A route file is invalid. The message names the file, the line, the problem and the remedy."""


def read_routes(path: Path) -> tuple[Route, ...]:
    """Return all routes of a file, in its order. Raises `RouteFileError`."""
    try:
        root = _parse(path)
    except OSError as error:
        raise RouteFileError(f"cannot read file: {path}: {error.strerror}. Give a route XML file") from error
    reader = _RouteFileReader(path)
    if root.tag != "routes":
        raise reader.error(
            root, f"the outermost element is <{root.tag}>, not <routes>", "give a leaderboard route file"
        )
    routes = tuple(reader.route(element) for element in root.all("route"))
    if not routes:
        raise reader.error(root, "there is no <route> in it", "add at least one")
    reader.refuse_twins(routes, root)
    return routes


@dataclass
class _Element:
    tag: str
    attributes: Mapping[str, str]
    line: int
    children: list[_Element] = field(default_factory=list)

    def all(self, tag: str) -> Iterator[_Element]:
        return (child for child in self.children if child.tag == tag)

    def inside(self, holders: str, tag: str, old: str = "") -> Iterator[_Element]:
        """Yield the children `tag` of all `holders`, then the own children `old` of format 1.0."""
        for holder in self.all(holders):
            yield from holder.all(tag)
        yield from self.all(old)


def _parse(path: Path) -> _Element:
    """Parse the element tree with line numbers. Raises `OSError` and `RouteFileError`."""
    parser = expat.ParserCreate()
    outside = _Element("", {}, 0)
    stack = [outside]

    def begin(tag: str, attributes: dict[str, str]) -> None:
        element = _Element(tag, attributes, parser.CurrentLineNumber)
        stack[-1].children.append(element)
        stack.append(element)

    def refuse(*_: object) -> None:
        raise RouteFileError(
            f"{path}, line {parser.CurrentLineNumber}: a document type is not allowed; remove the DOCTYPE"
        )

    parser.StartElementHandler = begin
    parser.EndElementHandler = lambda tag: stack.pop()
    # Entities could expand a small file to any size.
    parser.StartDoctypeDeclHandler = refuse
    try:
        parser.Parse(path.read_bytes(), True)
    except expat.ExpatError as error:
        reason = expat.ErrorString(error.code)
        raise RouteFileError(f"{path}, line {error.lineno}: not well-formed XML: {reason}; fix it there") from error
    return outside.children[0]


class _RouteFileReader:
    """Turns elements of one file into routes."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def error(self, element: _Element, wrong: str, remedy: str) -> RouteFileError:
        return RouteFileError(f"{self._path}, line {element.line}: {wrong}; {remedy}")

    def route(self, element: _Element) -> Route:
        name = self._text(element, "id")
        waypoints = tuple(self._position(p) for p in element.inside("waypoints", "position", old="waypoint"))
        if len(waypoints) < 2:
            raise self.error(
                element,
                f"route {name} has {len(waypoints)} waypoints",
                "give it at least two <position> in <waypoints>, or <waypoint> in format 1.0",
            )
        weathers = element.inside("weathers", "weather", old="weather")
        scenarios = element.inside("scenarios", "scenario")
        return Route(
            id=name,
            town=self._text(element, "town"),
            waypoints=waypoints,
            weathers=tuple(sorted((self._weather(w) for w in weathers), key=lambda w: w.route_percentage)),
            scenarios=tuple(self._scenario(s) for s in scenarios),
        )

    def refuse_twins(self, routes: tuple[Route, ...], root: _Element) -> None:
        known_ids: set[str] = set()
        for route, element in zip(routes, root.all("route"), strict=True):
            if route.id in known_ids:
                raise self.error(element, f"route id {route.id} occurs twice", "give each route its own id")
            known_ids.add(route.id)

    def _scenario(self, element: _Element) -> ScenarioSpec:
        name = self._text(element, "name")
        points = list(element.all("trigger_point"))
        if len(points) != 1:
            raise self.error(
                element, f"scenario {name} has {len(points)} trigger points", "give it one <trigger_point>"
            )
        yaw_deg = self._number(points[0], "yaw") if "yaw" in points[0].attributes else 0.0
        return ScenarioSpec(
            name=name,
            type=self._text(element, "type"),
            trigger=RoutePose(self._position(points[0]), yaw_deg),
            parameters={c.tag: dict(c.attributes) for c in element.children if c.tag not in _NOT_PARAMETERS},
        )

    def _weather(self, element: _Element) -> WeatherKey:
        values = {name: self._number(element, name) for name in element.attributes if name not in _NOT_WEATHER}
        return WeatherKey(values.pop("route_percentage", 0.0), values)

    def _position(self, element: _Element) -> Position:
        z_m = self._number(element, "z") if "z" in element.attributes else 0.0
        return Position(self._number(element, "x"), self._number(element, "y"), z_m)

    def _text(self, element: _Element, name: str) -> str:
        value = element.attributes.get(name, "").strip()
        if not value:
            raise self.error(element, f"<{element.tag}> has no {name}", f'write {name}="..."')
        return value

    def _number(self, element: _Element, name: str) -> float:
        text = self._text(element, name)
        try:
            value = float(text)
        except ValueError:
            # The check below reports the element with its line.
            value = math.nan
        if not math.isfinite(value):
            raise self.error(element, f'{name}="{text}" of <{element.tag}> is not a number', "write a finite number")
        return value
