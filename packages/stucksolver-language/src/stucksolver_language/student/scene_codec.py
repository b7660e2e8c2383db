"""The student's scene text: a scene as compact rows that can be parsed again. It is stable and has a version.

The first line is the version. One JSON list per row follows: a letter, then the values of that row's fields in the
order of `FIELDS`. Numbers have at most three decimals. The camera's image is omitted, and so are the schemas of the
behaviors, which follow from their names.
"""

from __future__ import annotations

import json
from typing import Any

from pydantic import ValidationError

from stucksolver.plan.behaviors import REGISTRY, describe
from stucksolver.scene import (
    CandidateWaypoint,
    FailedAttempt,
    Guidance,
    Scene,
    SceneEgo,
    SceneLane,
    SceneObject,
    TrafficControl,
)
from stucksolver.scene.base_model import FrozenModel, first_problem

VERSION = 1
"""Version of the text. It increases with every change of `FIELDS`. A text of another version is rejected."""
HEAD = "stucksolver-scene/"

ROWS: dict[str, tuple[str, type[FrozenModel]]] = {
    "e": ("ego", SceneEgo),
    "o": ("objects", SceneObject),
    "c": ("controls", TrafficControl),
    "l": ("lanes", SceneLane),
    "w": ("waypoints", CandidateWaypoint),
    "a": ("attempts", FailedAttempt),
    "g": ("guidance", Guidance),
}
"""Rows by letter: the field of the scene that they fill, and the type of one row."""
SINGLE = ("ego", "guidance")
FIELDS: dict[str, tuple[str, ...]] = {
    "s": ("time_s", "frame", "route_command", "speed_limit_mps", "claims"),
    "e": (
        "speed_mps",
        "lane_id",
        "lateral_offset_m",
        "stopped_for_s",
        "progress_20s_m",
        "distance_to_destination_m",
        "at_destination",
        "length_m",
        "width_m",
    ),
    "o": (
        "id",
        "kind",
        "lane",
        "lane_id",
        "gap_m",
        "left_edge_m",
        "right_edge_m",
        "speed_along_mps",
        "speed_across_mps",
        "in_path",
        "x_m",
        "y_m",
        "yaw_rad",
        "vx_mps",
        "vy_mps",
        "length_m",
        "width_m",
        "height_m",
        "stationary_s",
        "moved_s_ago",
        "pushed",
        "seen_for_s",
        "kind_confidence",
        "position_sd_m",
        "hazard_lights",
        "emergency_lights",
        "brake_lights",
    ),
    "c": ("kind", "distance_m", "applies", "state"),
    "l": (
        "id",
        "relation",
        "direction",
        "kind",
        "width_m",
        "line",
        "may_enter",
        "free_ahead_m",
        "free_behind_m",
        "sight_ahead_m",
        "speed_limit_mps",
    ),
    "w": ("id", "lane_id", "x_m", "y_m", "distance_m", "reaches_destination", "route_length_m"),
    "a": ("time_s", "behaviors", "ended", "codes", "failures", "outcome"),
    "g": ("text", "time_s", "reading"),
}
MOST_CHARACTERS = 200_000
"""Longest text that is parsed (characters): several hundred objects."""


class SceneTextError(ValueError):
    """The text is not a scene of this version. The message says which line is wrong, and why."""


def write_scene(scene: Scene) -> str:
    """Return a scene as text. The same scene always gives the same text.

    Args:
        scene: The scene, with all numbers in the units and frames of `Scene`.
    """
    lines = [f"{HEAD}{VERSION}", _row("s", scene)]
    for letter, (name, _) in ROWS.items():
        value = getattr(scene, name)
        rows = () if value is None else (value,) if name in SINGLE else value
        lines += [_row(letter, row) for row in rows]
    lines.append(json.dumps(["b", *(behavior.name for behavior in scene.behaviors)], separators=(",", ":")))
    return "\n".join(lines) + "\n"


def read_scene(text: str) -> Scene:
    """Return the scene of a text: `write_scene(read_scene(text)) == text`.

    Raises:
        SceneTextError: The text has another version, or a line is wrong.
    """
    if len(text) > MOST_CHARACTERS:
        raise SceneTextError(f"the text is longer than {MOST_CHARACTERS} characters")
    lines = text.splitlines()
    if not lines or lines[0] != f"{HEAD}{VERSION}":
        begins = lines[0][:40] if lines else ""
        raise SceneTextError(f"the text begins with {begins!r}, not with {HEAD}{VERSION}: it has another version")
    found: dict[str, Any] = {name: [] for name, _ in ROWS.values() if name not in SINGLE}
    for number, line in enumerate(lines[1:], 2):
        _take(found, number, line)
    try:
        return Scene.model_validate(found)
    except ValidationError as error:
        raise SceneTextError(first_problem(error)) from error


def _take(found: dict[str, Any], number: int, line: str) -> None:
    """Add one line to the fields of the scene. Raises `SceneTextError`."""
    try:
        _add(found, line)
    except (ValueError, TypeError, LookupError) as error:
        problem = first_problem(error) if isinstance(error, ValidationError) else str(error)
        raise SceneTextError(f"line {number}: {problem}") from error


def _add(found: dict[str, Any], line: str) -> None:
    letter, *values = json.loads(line)
    if letter == "b":
        found["behaviors"] = describe(tuple(name for name in values if name in REGISTRY))
        return
    if letter not in FIELDS:
        raise ValueError(f"unknown row {letter!r}")
    row = dict(zip(FIELDS[letter], values, strict=True))
    if letter == "s":
        found.update(row)
        return
    name, kind = ROWS[letter]
    item = kind.model_validate(row)
    if name in SINGLE:
        found[name] = item
    else:
        found[name].append(item)


def _row(letter: str, model: FrozenModel) -> str:
    fields = FIELDS[letter]
    data = model.model_dump(mode="json", include=set(fields))
    return json.dumps([letter, *(_short(data[name]) for name in fields)], separators=(",", ":"), allow_nan=False)


def _short(value: Any) -> Any:
    """Return a value with its numbers rounded to three decimals, or to two digits if nothing would be left."""
    if isinstance(value, float):
        short = round(value, 3) or float(f"{value:.2g}")
        return int(short) if short == int(short) else short
    if isinstance(value, dict):
        return {key: _short(item) for key, item in value.items()}
    return value
