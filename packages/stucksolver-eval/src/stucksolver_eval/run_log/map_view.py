"""Extracts the part of a map for a run's replay: lanes as areas, painted lines as polylines.

CARLA's world is left-handed; the result is in the right-handed frame of `run_log` (y = -carla y).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import Literal, NamedTuple

import carla
import numpy as np
import shapely
from numpy.typing import NDArray

from stucksolver_eval.results.run_log import LaneArea, MapView, Marking, Polyline
from stucksolver_eval.run_log.lane_spans import LaneSpan, lane_spans

_STEP_M = 2.0
"""Distance between samples of a lane (m). Ours."""
_INSIDE_M = 1e-3
"""Distance from the ends of a lane (m). At the ends CARLA may already return the next lane."""
_TOLERANCES_M = (0.02, 0.06, 0.2, 0.6, 1.5)
"""Tolerances of the simplification (m), tried in this order until the size fits. Ours."""
_MAX_BYTES = 190_000
"""Largest size of the JSON form (bytes). Ours."""
_DOUBLE_LINE_M = 0.12
"""Distance between the centers of a double line (m). Ours."""
_Points = NDArray[np.float64]
_Paint = tuple[str, str]


def map_view(carla_map: carla.Map, points: Sequence[tuple[float, float]], margin_m: float = 60.0) -> MapView:
    """Return lanes and markings within `margin_m` of a line of points (right-handed frame, m).

    The map's name is stored without folders. Curves are simplified only as much as needed to keep the JSON form under
    200 kB. Raises `ValueError` without points.
    """
    if not points:
        raise ValueError("map_view needs at least one point, such as those of a route")
    line = shapely.LineString(points) if len(points) > 1 else shapely.Point(points[0])
    region = line.buffer(margin_m)
    shapely.prepare(region)
    pieces = [piece for span in lane_spans(carla_map, region) for piece in _pieces(_sampled(carla_map, span), region)]
    for tolerance_m in _TOLERANCES_M:
        view = _view(carla_map.name.rsplit("/", 1)[-1], pieces, tolerance_m)
        if len(view.model_dump_json()) < _MAX_BYTES:
            break
    return view


class _Samples(NamedTuple):
    """One lane, sampled in driving direction."""

    span: LaneSpan
    left: _Points
    right: _Points
    paint: list[tuple[_Paint, _Paint]]
    """Type and color of the lines on the left and on the right."""


def _sampled(carla_map: carla.Map, span: LaneSpan) -> _Samples:
    count = max(2, int(np.ceil((span.end_s - span.start_s) / _STEP_M)) + 1)
    stations = np.linspace(span.start_s + _INSIDE_M, span.end_s - _INSIDE_M, count)
    if span.lane_id > 0:
        stations = stations[::-1]
    waypoints = [carla_map.get_waypoint_xodr(span.road_id, span.lane_id, float(s)) for s in stations]
    found = [waypoint for waypoint in waypoints if waypoint is not None]
    center, to_left = np.empty((len(found), 2)), np.empty((len(found), 2))
    for index, waypoint in enumerate(found):
        transform = waypoint.transform
        yaw_rad = -np.radians(transform.rotation.yaw)
        center[index] = transform.location.x, -transform.location.y
        to_left[index] = -np.sin(yaw_rad), np.cos(yaw_rad)
        to_left[index] *= waypoint.lane_width / 2
    paint = [(_paint(waypoint.left_lane_marking), _paint(waypoint.right_lane_marking)) for waypoint in found]
    return _Samples(span, center + to_left, center - to_left, paint)


def _paint(marking: carla.LaneMarking | None) -> _Paint:
    if marking is None:
        return "none", "white"
    color = str(marking.color).lower()
    return str(marking.type).lower(), "white" if color in ("standard", "other") else color


def _pieces(lane: _Samples, region: shapely.Polygon) -> Iterator[_Samples]:
    """Yield the runs of samples inside the region. Single samples have no area and are dropped."""
    if len(lane.left) == 0:
        return
    middle = (lane.left + lane.right) / 2
    inside = shapely.contains_xy(region, middle[:, 0], middle[:, 1])
    for is_inside, group in groupby(range(len(inside)), key=lambda index: bool(inside[index])):
        places = list(group)
        if is_inside and len(places) > 1:
            cut = slice(places[0], places[-1] + 1)
            yield _Samples(lane.span, lane.left[cut], lane.right[cut], lane.paint[cut])


def _view(name: str, pieces: Sequence[_Samples], tolerance_m: float) -> MapView:
    lanes = [
        LaneArea(
            kind=piece.span.kind,
            left=_polyline(piece.left, tolerance_m),
            right=_polyline(piece.right, tolerance_m),
        )
        for piece in pieces
        if piece.span.kind != "none" and np.abs(piece.left - piece.right).max() > tolerance_m
    ]
    markings = [marking for piece in pieces for marking in _markings(piece, tolerance_m)]
    return MapView(name=name, lanes=tuple(lanes), markings=tuple(markings))


def _markings(piece: _Samples, tolerance_m: float) -> Iterator[Marking]:
    """Yield the line on the outer side of a lane, and the center line if it is drawn with this lane."""
    yield from _line(piece, [paint[1] for paint in piece.paint], piece.right, tolerance_m)
    if piece.span.draws_center:
        yield from _line(piece, [paint[0] for paint in piece.paint], piece.left, tolerance_m)


def _line(piece: _Samples, paints: list[_Paint], points: _Points, tolerance_m: float) -> Iterator[Marking]:
    """Yield one line, split at changes of its paint. Double lines become two."""
    across = piece.right - piece.left
    across /= np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-6)
    for (kind, color), group in groupby(range(len(points)), key=lambda index: paints[index]):
        places = list(group)
        cut = slice(places[0], min(places[-1] + 2, len(points)))
        if len(points[cut]) < 2:
            continue
        strokes = _strokes(kind)
        for number, stroke in enumerate(strokes):
            offset_m = _DOUBLE_LINE_M * (2 * number - len(strokes) + 1)
            shifted = points[cut] + across[cut] * offset_m
            yield Marking(points=_polyline(shifted, tolerance_m), kind=stroke, color=color)


def _strokes(kind: str) -> list[Literal["broken", "solid", "other"]]:
    """Return the single lines of a line: `solidbroken` is a solid line and a broken one."""
    if kind == "none":
        return []
    strokes: list[Literal["broken", "solid", "other"]] = []
    rest = kind
    while rest.startswith(("broken", "solid")):
        stroke: Literal["broken", "solid"] = "broken" if rest.startswith("broken") else "solid"
        strokes.append(stroke)
        rest = rest[len(stroke) :]
    return strokes or ["other"]


def _polyline(points: _Points, tolerance_m: float) -> Polyline:
    simple = shapely.simplify(shapely.LineString(points), tolerance_m)
    return tuple((round(float(x), 2), round(float(y), 2)) for x, y in shapely.get_coordinates(simple))
