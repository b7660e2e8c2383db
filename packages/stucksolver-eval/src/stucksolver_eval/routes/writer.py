"""Writes routes in the leaderboard's XML format. Reading them again gives the same routes."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from xml.etree import ElementTree as Xml

from stucksolver.atomic_files import write_text
from stucksolver_eval.routes.route import Position, Route, ScenarioSpec


def write_routes(path: Path, routes: Iterable[Route]) -> None:
    """Write the routes to one file, atomically. Raises `OutputError`."""
    write_text(path, routes_text(routes))


def routes_text(routes: Iterable[Route]) -> str:
    """Return the XML of the routes."""
    root = Xml.Element("routes")
    for route in routes:
        _route(root, route)
    Xml.indent(root, "   ")
    return Xml.tostring(root, encoding="unicode") + "\n"


def _route(root: Xml.Element, route: Route) -> None:
    element = Xml.SubElement(root, "route", id=route.id, town=route.town)
    weathers = Xml.SubElement(element, "weathers")
    for weather in route.weathers:
        values = {"route_percentage": weather.route_percentage, **weather.values}
        Xml.SubElement(weathers, "weather", {name: _number(value) for name, value in values.items()})
    waypoints = Xml.SubElement(element, "waypoints")
    for position in route.waypoints:
        Xml.SubElement(waypoints, "position", _position(position))
    scenarios = Xml.SubElement(element, "scenarios")
    for spec in route.scenarios:
        _scenario(scenarios, spec)


def _scenario(parent: Xml.Element, spec: ScenarioSpec) -> None:
    element = Xml.SubElement(parent, "scenario", name=spec.name, type=spec.type)
    trigger = {**_position(spec.trigger.position), "yaw": _number(spec.trigger.yaw_deg)}
    Xml.SubElement(element, "trigger_point", trigger)
    for name, attributes in spec.parameters.items():
        Xml.SubElement(element, name, dict(attributes))


def _position(position: Position) -> dict[str, str]:
    return {"x": _number(position.x_m), "y": _number(position.y_m), "z": _number(position.z_m)}


def _number(value: float) -> str:
    return repr(float(value)).removesuffix(".0")
