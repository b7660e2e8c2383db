"""Validates an answer of the solver before any part of it is performed, so that nothing fails halfway.

Numbers must be finite and within bounds, lists must not be too long, and names must be in the tables below. Python 3.7,
standard library only.
"""

from __future__ import annotations

from typing import Any, Callable, Sequence

from stucksolver_bridge.path_line import PathLine

FURTHEST_M = 1e6
"""Maximum coordinate of a position, from the map's origin (m). Ours; larger than any map."""
QUICKEST_MPS = 120.0
"""Maximum speed on a path (m/s). Ours; faster than any vehicle in CARLA."""
HARDEST_MPS2 = 100.0
"""Maximum deceleration of a stop (m/s²). Ours; above what any tire can transmit."""
MOST_POINTS = 10_000
"""Maximum number of points of a path. Ours; a recovery is at most 200 m long, with a point every half meter."""
MOST_PLACES = 20_000
"""Maximum number of points of a route. Ours; a route has about one point per meter."""
MOST_IDS = 1000
"""Maximum number of actors that a directive excludes from the agent's obstacles. Ours."""
MOST_ORDERS = 16
"""Maximum number of orders in one answer. Ours."""
MOST_EVENTS = 1000
"""Maximum number of events in one answer. Ours."""
LONGEST_TICKS = 200
"""Longest validity of a directive (ticks), as in `Execute.expires_ticks`."""
MOST_LIGHTS = 0xFFFFFFFF
"""`carla.VehicleLightState.All`."""
LARGEST_ID = 2**31 - 1
"""Largest id of an actor, a road or a lane: a signed integer of 32 bits."""
KINDS = ("continue", "execute", "replan", "safe_stop")


class InvalidDirectiveError(ValueError):
    """A part of an answer is invalid; the message names the part and the reason."""


def malformed_reason(answer: Any) -> str | None:
    """Return the reason to reject the solver's answer to a tick, in a few words; None if all of it is valid."""
    return _reject_reason(_check_answer, answer)


def directive_reject_reason(form: Any) -> str | None:
    """Return the reason to reject a directive in its JSON form; None if all of it is valid."""
    return _reject_reason(_check_directive, form)


def _reject_reason(check: Callable[[Any], None], value: Any) -> str | None:
    try:
        check(value)
    except InvalidDirectiveError as error:
        return str(error)
    return None


def _check_answer(answer: Any) -> None:
    _check_type(dict, answer, "the answer")
    if "directive" in answer:
        _check_directive(answer["directive"])
    for order in _checked_list(answer.get("orders", []), MOST_ORDERS, "orders"):
        is_pair = isinstance(order, (list, tuple)) and len(order) == 2 and isinstance(order[0], str)
        if not is_pair or order[0] not in _ORDERS:
            raise InvalidDirectiveError(f"an order must be one of {', '.join(_ORDERS)}")
        if order[0] in _NEEDS_DIRECTIVE and "directive" not in answer:
            raise InvalidDirectiveError(f"{order[0]} requires a directive in the same answer")
        _ORDERS[order[0]](order[1])
    for event in _checked_list(answer.get("events", []), MOST_EVENTS, "events"):
        _check_type(dict, event, "an event")


def _check_directive(form: Any) -> None:
    _check_type(dict, form, "a directive")
    if form.get("kind") not in KINDS:
        raise InvalidDirectiveError(f"a directive must be one of {', '.join(KINDS)}")
    if form["kind"] != "execute":
        return
    for point in _checked_list(form.get("path", []), MOST_POINTS, "the path"):
        _check_type(dict, point, "a point of the path")
        _check_point((point.get("x_m"), point.get("y_m"), point.get("speed_mps")))
        _check_type(bool, point.get("no_stop", False), "no_stop")
    _check_number(form.get("expires_ticks", 1), 1, LONGEST_TICKS, "expires_ticks", whole=True)
    _check_hold(form.get("brake_mps2"))


def _check_follow(order: Any) -> None:
    _check_type(dict, order, "follow")
    path = _checked_list(order.get("path"), MOST_POINTS, "the path")
    for point in path:
        if not isinstance(point, (list, tuple)) or len(point) != 3:
            raise InvalidDirectiveError("a point of the path must be three numbers")
        _check_point(point)
    try:
        PathLine(path)
    except ValueError as error:
        raise InvalidDirectiveError(str(error)) from error
    _check_type(bool, order.get("reverse"), "reverse")
    for item in _checked_list(order.get("ignore"), MOST_IDS, "ignore"):
        _check_number(item, -LARGEST_ID, LARGEST_ID, "an id", whole=True)


def _check_point(point: Sequence[Any]) -> None:
    for value in point[:2]:
        _check_number(value, -FURTHEST_M, FURTHEST_M, "a position on the path")
    _check_number(point[2], 0.0, QUICKEST_MPS, "a speed on the path")


def _check_hold(brake_mps2: Any) -> None:
    if brake_mps2 is not None:
        _check_number(brake_mps2, 1e-3, HARDEST_MPS2, "the braking deceleration")


def _check_route(places: Any) -> None:
    for point in _checked_list(places, MOST_PLACES, "the route"):
        if not isinstance(point, (list, tuple)) or len(point) != 4 or not isinstance(point[3], str):
            raise InvalidDirectiveError("a point of the route must be a road, lane, arc length and command")
        for value in point[:2]:
            _check_number(value, -LARGEST_ID, LARGEST_ID, "a road or lane", whole=True)
        _check_number(point[2], -FURTHEST_M, FURTHEST_M, "an arc length")


def _check_lights(state: Any) -> None:
    _check_number(state, 0, MOST_LIGHTS, "the lights", whole=True)


def _check_control(order: Any) -> None:
    if not isinstance(order, (list, tuple)) or len(order) != 5:
        raise InvalidDirectiveError("the control must be throttle, steering, brake, reverse and hand brake")
    throttle, steer, brake, reverse, hand_brake = order
    _check_number(throttle, 0.0, 1.0, "the throttle")
    _check_number(steer, -1.0, 1.0, "the steering")
    _check_number(brake, 0.0, 1.0, "the brake")
    _check_type(bool, reverse, "reverse")
    _check_type(bool, hand_brake, "the hand brake")


def _check_nothing(value: Any) -> None:
    """Accept any value, because the order uses none."""


_ORDERS: dict[str, Callable[[Any], None]] = {
    "follow": _check_follow,
    "hold": _check_hold,
    "release": _check_nothing,
    "route": _check_route,
    "lights": _check_lights,
    "control": _check_control,
}
"""Check of each order's value, by the order's name."""


_NEEDS_DIRECTIVE = ("follow", "hold", "release")
"""Orders that are valid only together with their directive, because the lease is renewed with that directive."""


def _check_type(kind: type, value: Any, what: str) -> None:
    if not isinstance(value, kind):
        raise InvalidDirectiveError(f"{what} must be a {kind.__name__}")


def _checked_list(value: Any, most: int, what: str) -> Sequence[Any]:
    if not isinstance(value, (list, tuple)):
        raise InvalidDirectiveError(f"{what} must be a list")
    if len(value) > most:
        raise InvalidDirectiveError(f"{what} has {len(value)} entries; at most {most} are allowed")
    return value


def _check_number(value: Any, least: float, most: float, what: str, whole: bool = False) -> None:
    # No call of `isfinite`, because it raises for integers too large for a float. A comparison with NaN is false.
    fits = isinstance(value, int if whole else (int, float)) and not isinstance(value, bool) and least <= value <= most
    if not fits:
        raise InvalidDirectiveError(f"{what} must be a {'whole ' if whole else ''}number from {least:g} to {most:g}")
