"""The compact form of runs inside the page; `assets/decode.js` reads it.

Lengths are whole centimeters, times milliseconds, speeds cm/s, angles tenths of a degree. A series of numbers is its
first value followed by differences, or a single number if it never changes.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import groupby, pairwise
from typing import Any

import shapely

from stucksolver_eval.results.checkpoint import status_text
from stucksolver_eval.results.run_log import MapView, Polyline, RunLog, RunLogFrame
from stucksolver_eval.run_table import recovered_text, stopped_text

_FULL_TURN = 3600
"""A full turn in tenths of a degree."""
_PATH_TOLERANCE_M = 0.05
"""Largest deviation of a simplified path (m). Ours."""

Series = int | list[int]


def pack(runs: Sequence[RunLog], title: str, notes: Sequence[str]) -> dict[str, Any]:
    """Return all data of the page. Maps that several runs share are stored once."""
    maps: dict[str, int] = {}
    packed_maps: list[dict[str, Any]] = []
    packed_runs = []
    for run in runs:
        key = run.map.model_dump_json()
        if key not in maps:
            maps[key] = len(packed_maps)
            packed_maps.append(_map(run.map))
        packed_runs.append(_run(run, maps[key]))
    return {"title": title, "notes": list(notes), "maps": packed_maps, "runs": packed_runs}


def series(values: Iterable[int]) -> Series:
    """Return the first value and differences, or the value if it never changes."""
    whole = list(values)
    if whole and whole.count(whole[0]) == len(whole):
        return whole[0]
    return whole[:1] + [after - before for before, after in pairwise(whole)]


def _run(run: RunLog, map_index: int) -> dict[str, Any]:
    shown = {"scenario", "arm", "seed", "driver", "reasoner", "clock", "perception"}
    frames = run.frames
    return {
        **run.model_dump(mode="json", include=shown | {"actors", "stuck", "decisions", "events", "result"}),
        "ended": status_text(run.result.status),
        "stopped": stopped_text(run.result),
        "recovered": recovered_text(run.result),
        "map": map_index,
        "route": _line(run.route),
        "frames": len(frames),
        "time": series(round(frame.time_s * 1000) for frame in frames),
        "speed": series(_hundredths(frame.speed_mps) for frame in frames),
        "tracks": _tracks(frames, len(run.actors)),
        "lights": _lights(frames),
        "paths": _paths(frames),
    }


def _map(view: MapView) -> dict[str, Any]:
    return {
        "name": view.name,
        "lanes": [{"kind": a.kind, "left": _line(a.left), "right": _line(a.right)} for a in view.lanes],
        "markings": [{"kind": m.kind, "color": m.color, "points": _line(m.points)} for m in view.markings],
    }


def _line(points: Polyline) -> list[Any]:
    """Return the number of points, their x and their y."""
    return [len(points), series(_hundredths(x) for x, _ in points), series(_hundredths(y) for _, y in points)]


def _tracks(frames: Sequence[RunLogFrame], actors: int) -> list[list[list[Any]]]:
    by_frame = [{pose[0]: pose[1:] for pose in frame.poses} for frame in frames]
    return [_track([poses.get(actor) for poses in by_frame]) for actor in range(actors)]


def _track(poses: Sequence[tuple[float, float, float] | None]) -> list[list[Any]]:
    """Return the spans in which an actor is present: first frame, number of frames, x, y, yaw."""
    spells: list[list[Any]] = []
    for present, group in groupby(enumerate(poses), key=lambda item: item[1] is not None):
        if present:
            spell = list(group)
            there = [pose for _, pose in spell if pose is not None]
            xs, ys = (series(_hundredths(pose[axis]) for pose in there) for axis in (0, 1))
            spells.append([spell[0][0], len(there), xs, ys, series(_unwrapped(pose[2] for pose in there))])
    return spells


def _unwrapped(angles_deg: Iterable[float]) -> Iterable[int]:
    """Yield tenths of a degree without jumps of a full turn, so that differences stay small."""
    last = 0
    for angle_deg in angles_deg:
        step = (round(angle_deg * 10) - last + _FULL_TURN // 2) % _FULL_TURN - _FULL_TURN // 2
        last += step
        yield last


def _lights(frames: Sequence[RunLogFrame]) -> list[list[Any]]:
    """Return each light's x and y, and the frames in which its state changes; null while it is not visible."""
    by_frame = [{(x, y): state for x, y, state in frame.lights} for frame in frames]
    places = sorted({place for states in by_frame for place in states})
    return [[_hundredths(x), _hundredths(y), _changes([states.get((x, y)) for states in by_frame])] for x, y in places]


def _paths(frames: Sequence[RunLogFrame]) -> list[list[Any]]:
    """Return the frames in which the driven recovery path changes, with the new one (null: none)."""
    changes = _changes([frame.path for frame in frames])
    return [[index, _line(_simplified(path)) if path else None] for index, path in changes]


def _changes(values: Sequence[Any]) -> list[list[Any]]:
    """Return the indices of a list at which its value changes, with the new value."""
    found: list[list[Any]] = []
    for index, value in enumerate(values):
        if not found or found[-1][1] != value:
            found.append([index, value])
    return found


def _simplified(path: Polyline) -> Polyline:
    if len(path) < 3:
        return path
    line = shapely.simplify(shapely.LineString(path), _PATH_TOLERANCE_M)
    return tuple((float(x), float(y)) for x, y in shapely.get_coordinates(line))


def _hundredths(value: float) -> int:
    return round(value * 100)
