"""Checks that an answer of the solver can be performed, before any part of it is: nothing may fail halfway.

Numbers must be finite and within bounds, lists must not be too long, and names must be known. Python 3.7, standard
library only.
"""

from __future__ import annotations

from typing import Any, Callable, Sequence

from stucksolver_bridge.path_line import PathLine

FURTHEST_M = 1e6
"""No place on a map is farther from its origin."""
QUICKEST_MPS = 120.0
HARDEST_MPS2 = 100.0
MOST_POINTS = 10_000
"""Most points of a path. A recovery is at most 200 m long, with a point every half meter."""
MOST_PLACES = 20_000
"""Most points of a route, which has about one per meter."""
MOST_IDS = 1000
"""Most actors that an order may tell the agent to ignore."""
MOST_ORDERS = 16
"""Most orders in one answer."""
MOST_EVENTS = 1000
"""Most events in one answer."""
LONGEST_TICKS = 200
"""Longest validity of an order, as in `Execute.expires_ticks`."""
MOST_LIGHTS = 0xFFFFFFFF
"""`carla.VehicleLightState.All`."""
LARGEST_ID = 2**31 - 1
KINDS = ("continue", "execute", "replan", "safe_stop")


class InvalidDirectiveError(ValueError):
    """Something cannot be performed; the message says what and why."""


def malformed_reason(answer: Any) -> str | None:
    """Return why the solver's answer to a tick cannot be performed, in a few words; None if all of it can."""
    return _why(_check_answer, answer)


def why_unfit(form: Any) -> str | None:
    """Return why a directive in its JSON form cannot be performed; None if all of it can."""
    return _why(_check_directive, form)


def _why(check: Callable[[Any], None], value: Any) -> str | None:
    try:
        check(value)
    except InvalidDirectiveError as unfit:
        return str(unfit)
    return None


def _check_answer(answer: Any) -> None:
    _a(dict, answer, "the answer")
    if "directive" in answer:
        _check_directive(answer["directive"])
    for order in _list(answer.get("orders", []), MOST_ORDERS, "orders"):
        named = isinstance(order, (list, tuple)) and len(order) == 2 and isinstance(order[0], str)
        if not named or order[0] not in _ORDERS:
            raise InvalidDirectiveError(f"an order is not one of {', '.join(_ORDERS)}")
        if order[0] in _OF_A_DIRECTIVE and "directive" not in answer:
            raise InvalidDirectiveError(f"{order[0]} comes without the directive that it belongs to")
        _ORDERS[order[0]](order[1])
    for event in _list(answer.get("events", []), MOST_EVENTS, "events"):
        _a(dict, event, "an event")


def _check_directive(form: Any) -> None:
    _a(dict, form, "a directive")
    if form.get("kind") not in KINDS:
        raise InvalidDirectiveError(f"a directive is not one of {', '.join(KINDS)}")
    if form["kind"] != "execute":
        return
    for point in _list(form.get("path", []), MOST_POINTS, "the path"):
        _a(dict, point, "a point of the path")
        _check_point((point.get("x_m"), point.get("y_m"), point.get("speed_mps")))
        _a(bool, point.get("no_stop", False), "no_stop")
    _number(form.get("expires_ticks", 1), 1, LONGEST_TICKS, "expires_ticks", whole=True)
    _check_hold(form.get("brake_mps2"))


def _check_follow(order: Any) -> None:
    _a(dict, order, "follow")
    path = _list(order.get("path"), MOST_POINTS, "the path")
    for point in path:
        if not isinstance(point, (list, tuple)) or len(point) != 3:
            raise InvalidDirectiveError("a point of the path is not three numbers")
        _check_point(point)
    try:
        PathLine(path)
    except ValueError as error:
        raise InvalidDirectiveError(str(error)) from error
    _a(bool, order.get("reverse"), "reverse")
    for item in _list(order.get("ignore"), MOST_IDS, "ignore"):
        _number(item, -LARGEST_ID, LARGEST_ID, "an id", whole=True)


def _check_point(point: Sequence[Any]) -> None:
    for value in point[:2]:
        _number(value, -FURTHEST_M, FURTHEST_M, "a position on the path")
    _number(point[2], 0.0, QUICKEST_MPS, "a speed on the path")


def _check_hold(brake_mps2: Any) -> None:
    if brake_mps2 is not None:
        _number(brake_mps2, 1e-3, HARDEST_MPS2, "the braking deceleration")


def _check_route(places: Any) -> None:
    for spot in _list(places, MOST_PLACES, "the route"):
        if not isinstance(spot, (list, tuple)) or len(spot) != 4 or not isinstance(spot[3], str):
            raise InvalidDirectiveError("a point of the route is not a road, lane, arc length and command")
        for value in spot[:2]:
            _number(value, -LARGEST_ID, LARGEST_ID, "a road or lane", whole=True)
        _number(spot[2], -FURTHEST_M, FURTHEST_M, "an arc length")


def _check_lights(state: Any) -> None:
    _number(state, 0, MOST_LIGHTS, "the lights", whole=True)


def _check_control(order: Any) -> None:
    if not isinstance(order, (list, tuple)) or len(order) != 5:
        raise InvalidDirectiveError("the control is not throttle, steering, brake, reverse and hand brake")
    throttle, steer, brake, reverse, hand_brake = order
    _number(throttle, 0.0, 1.0, "the throttle")
    _number(steer, -1.0, 1.0, "the steering")
    _number(brake, 0.0, 1.0, "the brake")
    _a(bool, reverse, "reverse")
    _a(bool, hand_brake, "the hand brake")


def _check_nothing(value: Any) -> None:
    """Accept any value: the order needs none."""


_ORDERS: dict[str, Callable[[Any], None]] = {
    "follow": _check_follow,
    "hold": _check_hold,
    "release": _check_nothing,
    "route": _check_route,
    "lights": _check_lights,
    "control": _check_control,
}


_OF_A_DIRECTIVE = ("follow", "hold", "release")


def _a(kind: type, value: Any, what: str) -> None:
    if not isinstance(value, kind):
        raise InvalidDirectiveError(f"{what} is not a {kind.__name__}")


def _list(value: Any, most: int, what: str) -> Sequence[Any]:
    if not isinstance(value, (list, tuple)):
        raise InvalidDirectiveError(f"{what} is not a list")
    if len(value) > most:
        raise InvalidDirectiveError(f"{what} has {len(value)} entries; at most {most} are allowed")
    return value


def _number(value: Any, least: float, most: float, what: str, whole: bool = False) -> None:
    # Not `isfinite`: it fails for integers too large for a float. NaN is within no bounds.
    fits = isinstance(value, int if whole else (int, float)) and not isinstance(value, bool) and least <= value <= most
    if not fits:
        raise InvalidDirectiveError(f"{what} is not a {'whole ' if whole else ''}number from {least:g} to {most:g}")
