"""Checks once, on entry, whether the surroundings are plausible, so that later code can rely on every value.

Each field that can be reached from `Surroundings` is checked: its type by its annotation, each number by its range in
`RANGES`, each text and each list by its length. A number without a range raises an error when this module is imported.
"""

from __future__ import annotations

import types
from collections.abc import Callable, Iterator
from enum import Enum
from functools import cache
from itertools import pairwise
from typing import Any, Union, get_args, get_origin

from stucksolver.scene.base_model import FrozenModel
from stucksolver.scene.objects import TrackedObject
from stucksolver.scene.road import LaneStrip, RoadGeometry, Zone, ZoneKind
from stucksolver.scene.status import Status
from stucksolver.scene.surroundings import EgoState, LaneSight, Surroundings, TrafficControl, VehicleLimits

FURTHEST_M = 1e6
"""Upper bound for positions in a local frame (m): a map is a few kilometers wide."""
LONGEST_ROUTE_M = 1e7
"""Upper bound for arc lengths along a route (m): a quarter of the equator."""
LONGEST_M = 60.0
"""Upper bound for lengths of objects (m): the longest road train has 53.5 m."""
SMALLEST_M = 1e-6
"""Lower bound for lengths of objects (m): they are above 0."""
QUICKEST_MPS = 120.0
"""Upper bound for speeds and speed limits (m/s): 432 km/h."""
ROLLS_BACK_MPS = 0.5
"""Lower bound for the speed in a status, times -1 (m/s): a speed has no sign, but a stopped vehicle has noise. Ours."""
OLDEST_S = 1e6
"""Upper bound for ages (s): eleven days."""
LATEST_S = 1e12
"""Upper bound for times (s): far more than the seconds since 1970."""
LAST_FRAME = 2**63
"""Upper bound for frame numbers."""
LEAST_LIMIT = 0.05
"""Lower bound for each of the vehicle's limits (m, m/s²). Ours."""
MOST_LIMIT = 100.0
"""Upper bound for each of the vehicle's limits (m, m/s²). Ours."""
WIDEST_M = 100.0
"""Upper bound for the width of a lane (m). Ours."""
FURTHEST_ASIDE_M = 1000.0
"""Upper bound for the offset of a lane from the route (m). Ours."""
FINEST_M = 1e-3
"""Lower bound for the spacing of a road's stations (m). Ours."""
COARSEST_M = 100.0
"""Upper bound for the spacing of a road's stations (m). Ours."""
MOST_ENTRIES = 2000
"""Upper bound for the number of objects, of controls, of lanes and of zones. Ours."""
MOST_STATIONS = 100_000
"""Upper bound for the number of a road's stations. Ours."""
LONGEST_TEXT = 500
"""Upper bound for the length of an id, a key or a fault (characters). Ours."""

_METERS = (-FURTHEST_M, FURTHEST_M)
_SIZE = (SMALLEST_M, LONGEST_M)
_SPREAD = (0.0, LONGEST_M)
_AGE = (0.0, OLDEST_S)
_SPEED = (-QUICKEST_MPS, QUICKEST_MPS)
_ALONG_ROUTE = (-LONGEST_ROUTE_M, LONGEST_ROUTE_M)

RANGES: dict[type[FrozenModel], dict[str, tuple[float, float]]] = {
    Status: {"time_s": (-LATEST_S, LATEST_S), "speed_mps": (-ROLLS_BACK_MPS, QUICKEST_MPS), "progress_m": _ALONG_ROUTE},
    Surroundings: {"frame": (-LAST_FRAME, LAST_FRAME), "time_s": (-LATEST_S, LATEST_S), "age_s": _AGE},
    EgoState: {
        "x_m": _METERS,
        "y_m": _METERS,
        "yaw_rad": _METERS,
        "speed_mps": _SPEED,
        "length_m": _SIZE,
        "width_m": _SIZE,
        "position_sd_m": _SPREAD,
    },
    VehicleLimits: dict.fromkeys(VehicleLimits.model_fields, (LEAST_LIMIT, MOST_LIMIT)),
    TrackedObject: {
        "x_m": _METERS,
        "y_m": _METERS,
        "yaw_rad": _METERS,
        "vx_mps": _SPEED,
        "vy_mps": _SPEED,
        "length_m": _SIZE,
        "width_m": _SIZE,
        "height_m": _SIZE,
        "stationary_s": _AGE,
        "moved_s_ago": _AGE,
        "seen_for_s": _AGE,
        "kind_confidence": (0.0, 1.0),
        "position_sd_m": _SPREAD,
        "across_sd_m": _SPREAD,
    },
    TrafficControl: {"distance_m": _METERS},
    LaneSight: {"ahead_m": (0.0, FURTHEST_M), "behind_m": (0.0, FURTHEST_M)},
    LaneStrip: {
        "start": (0, MOST_STATIONS),
        "offset_m": (-FURTHEST_ASIDE_M, FURTHEST_ASIDE_M),
        "width_m": (0.0, WIDEST_M),
        "speed_limit_mps": (0.0, QUICKEST_MPS),
    },
    Zone: {"start_m": _ALONG_ROUTE, "end_m": _ALONG_ROUTE},
    RoadGeometry: {
        "spacing_m": (FINEST_M, COARSEST_M),
        "reference": _METERS,
        "route_start_m": _ALONG_ROUTE,
        "destination_m": _ALONG_ROUTE,
    },
}
"""Least and greatest plausible value of each number, by model and field."""
_STATIONS = frozenset({"reference", "offset_m", "width_m", "line"})
"""Names of lists with an entry for each station."""
_MISSING = object()
_KEPT_ROADS = 8
"""Number of checked roads that are cached. Ours."""

STATUS_REMEDIES = {
    "time_s": "give the time of this tick in seconds",
    "speed_mps": "give the speed in meters per second, without a sign",
    "progress_m": "give the arc length reached along the route in meters",
    "pushes": "give True or False",
    "at_destination": "give True or False",
}
Check = Callable[[Any], str | None]
"""Returns what is wrong with a value, as `.field is …`, or None."""


def implausibility(surroundings: Surroundings) -> str | None:
    """Return the first implausible field of the surroundings and the fault in it, or None.

    The models reject most of this when they are created. This check also covers copies and objects that were created
    without validation. It never raises, whatever a field holds.
    """
    try:
        wrong = _checked(Surroundings)(surroundings)
        return wrong.removeprefix(".") if wrong else next(_contradictions(surroundings), None)
    except Exception as error:  # noqa: BLE001 - a subclass or a proxy may raise anything when it is read
        return f"they cannot be read ({type(error).__name__})"


def status_implausibility(status: Status) -> str | None:
    """Return the first implausible field of a status, the fault in it and the correction, or None.

    It never raises, whatever a field holds.
    """
    try:
        wrong = _checked(Status)(status)
    except Exception as error:  # noqa: BLE001 - a subclass or a proxy may raise anything when it is read
        wrong = f" cannot be read ({type(error).__name__})"
    if wrong is None:
        return None
    name = wrong.removeprefix(".").split(" ")[0]
    return f"status{wrong}; {STATUS_REMEDIES.get(name, 'give a Status')}"


def plausible_time_s(status: Status) -> float | None:
    """Return the time of a status (s), even if other fields are implausible; None if the time is implausible."""
    try:
        time_s: Any = status.__dict__.get("time_s")
    except Exception:  # noqa: BLE001 - as above
        return None
    return None if _number(*RANGES[Status]["time_s"], whole=False)(time_s) else time_s


def _contradictions(surroundings: Surroundings) -> Iterator[str]:
    """Yield contradictions between fields that are plausible one by one."""
    names: set[str] = set()
    for index, obj in enumerate(surroundings.objects):
        if obj.id in names:
            yield f"objects[{index}].id is {_shown(obj.id)}, like another object's: ids must be unique"
        names.add(obj.id)
    lanes = {lane.id for lane in surroundings.road.lanes}
    for index, sight in enumerate(surroundings.sight):
        if sight.lane_id not in lanes:
            yield f"sight[{index}].lane_id is {_shown(sight.lane_id)}, which is no lane of the road"


def _road_contradictions(road: RoadGeometry) -> Iterator[str]:
    """Yield contradictions between the fields of a road."""
    names: set[str] = set()
    for index, lane in enumerate(road.lanes):
        here = f".lanes[{index}]"
        if lane.id in names:
            yield f"{here}.id is {_shown(lane.id)}, like another lane's: ids must be unique"
        names.add(lane.id)
        if not len(lane.offset_m) == len(lane.width_m) == len(lane.line):
            yield f"{here}.offset_m, width_m and line do not have one value for each station"
        if lane.start + len(lane.offset_m) > len(road.reference):
            yield f"{here}.offset_m has stations beyond the reference line"
    for index, zone in enumerate(road.zones):
        if zone.end_m < zone.start_m:
            yield f".zones[{index}].end_m is {zone.end_m:g}, before start_m {zone.start_m:g}"
    # Crosswalks and level crossings may overlap, because each counts for itself. A junction counts as a whole, because
    # the guard measures the turn of the route in it. The order of zones does not matter.
    junctions = sorted((z.start_m, z.end_m, k) for k, z in enumerate(road.zones) if z.kind is ZoneKind.JUNCTION)
    for (_, end_m, _), (start_m, _, index) in pairwise(junctions):
        if start_m < end_m:
            yield f".zones[{index}].start_m is {start_m:g}, within another junction: give them as one zone"
    if len(road.reference) < 2:
        yield ".reference has fewer than two points"


_known_roads: tuple[tuple[RoadGeometry, str | None], ...] = ()


def _why_road(road: Any) -> str | None:
    """Check a road once: it stays the same object during an intervention and has thousands of numbers."""
    global _known_roads
    for cached, wrong in _known_roads:
        if cached is road:
            return wrong
    wrong = _fields(RoadGeometry)(road) or next(_road_contradictions(road), None)
    # The tuple is replaced as a whole, because the threads of reasoners check plans, too.
    _known_roads = (*_known_roads[1 - _KEPT_ROADS :], (road, wrong))
    return wrong


# ---- checks by type


@cache
def _checked(model: type[FrozenModel]) -> Check:
    return _why_road if model is RoadGeometry else _fields(model)


@cache
def _fields(model: type[FrozenModel]) -> Check:
    """Return the check of all fields of a model."""
    checks = [(name, _check_of(model, name, info.annotation)) for name, info in model.model_fields.items()]

    def check(value: Any) -> str | None:
        if not isinstance(value, model):
            return f" is a {type(value).__name__}, not a {model.__name__}"
        values = value.__dict__
        for name, check_field in checks:
            wrong = check_field(values.get(name, _MISSING))
            if wrong is not None:
                return f".{name}{wrong}"
        return None

    return check


def _check_of(model: type[FrozenModel], name: str, annotation: Any) -> Check:
    """Return the check of a field with this annotation."""
    origin, inner = get_origin(annotation), get_args(annotation)
    if origin in (Union, types.UnionType):
        (kind,) = (item for item in inner if item is not type(None))
        return _optional(_check_of(model, name, kind))
    if origin is tuple and len(inner) == 2 and inner[1] is Ellipsis:
        most = MOST_STATIONS if name in _STATIONS else MOST_ENTRIES
        return _list(_check_of(model, name, inner[0]), most)
    if origin is tuple:
        return _list(_check_of(model, name, inner[0]), len(inner), least=len(inner))
    if annotation is bool:
        return _exactly(bool)
    if annotation in (int, float):
        return _number(*RANGES[model][name], whole=annotation is int)
    if annotation is str:
        return _text
    if issubclass(annotation, Enum):
        return _exactly(annotation)
    return _checked(annotation)


def _optional(check: Check) -> Check:
    return lambda value: None if value is None else check(value)


def _exactly(kind: type) -> Check:
    return lambda value: None if type(value) is kind else f" is {_shown(value)}, not a {kind.__name__}"


def _number(least: float, most: float, *, whole: bool) -> Check:
    kinds: tuple[type, ...] = (int,) if whole else (float, int)
    usual: type = kinds[0]
    expected = f"{'whole ' if whole else ''}number from {least:g} to {most:g}"

    def check(value: Any) -> str | None:
        # NaN is within no bounds. Most numbers are of the usual type, and comparing types is faster than `isinstance`.
        fits = type(value) is usual or (isinstance(value, kinds) and type(value) is not bool)
        return None if fits and least <= value <= most else f" is {_shown(value)}, not a {expected}"

    return check


def _text(value: Any) -> str | None:
    if type(value) is not str:
        return f" is {_shown(value)}, not a text"
    if len(value) > LONGEST_TEXT:
        return f" has {len(value)} characters; at most {LONGEST_TEXT} are allowed"
    if value.isascii():
        return None
    try:
        value.encode()
    except UnicodeEncodeError:
        return " has characters that no record can hold"
    return None


def _list(check: Check, most: int, least: int = 0) -> Check:
    def check_all(value: Any) -> str | None:
        if type(value) is not tuple:
            return f" is {_shown(value)}, not a tuple"
        if not least <= len(value) <= most:
            return f" has {len(value)} entries; {least or ''}{' to ' if least else 'at most '}{most} are allowed"
        for index, item in enumerate(value):
            wrong = check(item)
            if wrong is not None:
                return f"[{index}]{wrong}"
        return None

    return check_all


def _shown(value: Any) -> str:
    """Return a number or a text in a few characters; of any other value the type."""
    if value is _MISSING:
        return "missing"
    if type(value) is int and abs(value) > LAST_FRAME:
        return "a number beyond all bounds"
    if value is None or type(value) in (bool, int, float):
        return repr(value)
    return ascii(value[:40]) if type(value) is str else f"a {type(value).__name__}"


_checked(Status), _checked(Surroundings)
