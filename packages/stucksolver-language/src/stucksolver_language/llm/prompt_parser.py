"""Parses the scene from a prompt: the inverse of `scene_text`, for a local model behind a chat server.

The prompt rounds to one decimal and omits numbers. In a parsed scene, objects have a heading along the road, and the
time of their last motion is unknown. The middle objects of a work zone and the values of failed plans are missing.
"""

from __future__ import annotations

import json
import math
import re
from typing import Any

from pydantic import ValidationError

from stucksolver.plan.behaviors import REGISTRY, describe
from stucksolver.scene import IMMOBILIZED_BELOW_MPS, AttemptOutcome, LaneRelation, Scene
from stucksolver.scene.base_model import first_problem
from stucksolver_language.llm.attempt_text import FAILED
from stucksolver_language.llm.menu_text import MENU, NO_MENU
from stucksolver_language.llm.scene_prompt import SAYS, SIGNALS

CONTROLS = "controls:"
ZONES = "zones:"
PASSENGER = re.compile(r'passenger says (-?\d+) s ago: (".*")$')
EGO = re.compile(
    r"ego: (?P<speed>\S+) m/s, below (?P<slow>\S+) km/h for (?P<stopped>\S+) s, progress in 20 s (?P<progress>\S+) m, "
    r"lane (?P<lane>.+) offset (?P<offset>\S+), (?:(?P<left>\S+) m to destination|at destination), "
    r"size (?P<length>[\d.]+)x(?P<width>[\d.]+), limit (?P<limit>\S+) m/s(?:, route: (?P<route>.*))?$"
)
LANE = re.compile(
    r"(?P<id>.+) (?P<relation>\S+) (?P<kind>\S+) (?P<width>\S+) (?P<line>\S+) (?P<ahead>\S+)/(?P<behind>\S+) "
    r"(?P<sight>\S+?)(?P<closed> no-entry-by-markings)?$"
)
OBJECT = re.compile(
    r"(?P<id>.+) (?P<kind>\S+) (?P<lane>\S+) (?P<gap>\S+) (?P<right>[-\d.]+?)\.\.(?P<left>[-\d.]+) "
    r"(?P<speed>[-\d.?]+)/(?P<across>[-\d.?]+) "
    r"(?P<stood>\S+) (?P<length>[\d.]+)\*(?P<width>[\d.]+)\*(?P<height>[\d.]+)(?P<marks>(?: [a-z-]+)*)$"
)
CONTROL = re.compile(
    r"(?P<kind>traffic_light|stop_sign)(?: (?P<state>[a-z]+))? (?P<gap>\S+) m (?P<applies>applies\??|not for us)$"
)
SIGN = re.compile(rf"sign {SAYS}(?P<word>[a-z-]+) (?P<gap>\S+) m at (?P<bearing>\S+) deg$")
ZONE = re.compile(r"(?P<kind>[a-z_]+) from (?P<start_m>\S+) to (?P<end_m>\S+) m(?:, roads off the route: .*)?$")
ATTEMPT = re.compile(r"(?P<plan>.+?): (?P<ended>[a-z_]+) (?P<ago>\d+) s ago(?:, (?P<missing>[^;]*))?; (?P<outcome>.*)$")
APPLIES = {"applies": True, "not for us": False, "applies?": None}


class PromptError(ValueError):
    """The text is not the scene of a prompt. The message says which line is wrong."""


def read_prompt(text: str) -> Scene:
    """Return the scene of a user's turn as `stucksolver_language.llm.prompt.user_text` writes it.

    Raises:
        PromptError: The text is not such a turn.
    """
    found: dict[str, Any] = {"time_s": 0.0, "frame": 0, "objects": [], "controls": [], "lanes": [], "waypoints": []}
    found |= {"attempts": [], "behaviors": (), "signs": [], "zones": []}
    part = ""
    for number, line in enumerate(text.strip().splitlines(), 1):
        part = _taken(found, part, number, line)
    if "ego" not in found:
        raise PromptError("not a scene: the text has no line that begins with `ego:`")
    try:
        return Scene.model_validate(found)
    except ValidationError as error:
        raise PromptError(first_problem(error)) from error


def _taken(found: dict[str, Any], part: str, number: int, line: str) -> str:
    """Parse one line as `_line` does. Raises `PromptError`."""
    try:
        return _line(found, part, line)
    except (ValueError, TypeError, LookupError, StopIteration) as error:
        raise PromptError(f"line {number} is not part of a scene: {line[:80]!r}") from error


def _line(found: dict[str, Any], part: str, line: str) -> str:
    """Parse one line, and return the section of the text that the next lines belong to."""
    says = PASSENGER.match(line)
    if line.startswith("ego: "):
        found["ego"], found["route_command"], found["speed_limit_mps"] = _ego(_matched(EGO, line))
        return ""
    if says is not None:
        found["guidance"] = {"text": json.loads(says[2]), "time_s": -float(says[1])}
        return ""
    if line.startswith("behaviors available now: "):
        names = line.partition(": ")[2].split(", ")
        found["behaviors"] = describe(tuple(name for name in names if name in REGISTRY))
        return ""
    if line.startswith("questions: "):
        # They follow from the guidance.
        return ""
    if line.startswith("route starts ("):
        found["waypoints"] = [start for group in line.partition("): ")[2].split("; ") for start in _starts(group)]
        return ""
    for name in ("lanes", "objects"):
        if line.startswith((f"{name} (", f"{name}: none")):
            return name
    if line in (CONTROLS, FAILED, ZONES, MENU, NO_MENU):
        return line
    if part == MENU:
        # The plans of the menu follow from the scene and the guard.
        return part
    if part == "lanes":
        found["lanes"].append(_lane(_matched(LANE, line)))
    elif part == "objects":
        if not re.fullmatch(r"and \d+ more, farther", line):
            fields = _matched(OBJECT, line)
            found["objects"].append(_object(fields, found["ego"]))
            found["signs"] += [{"word": _word(word), "object_id": fields["id"]} for word in _marked(fields, SAYS)]
    elif part == CONTROLS and line.startswith("sign "):
        found["signs"].append(_sign(_matched(SIGN, line)))
    elif part == CONTROLS:
        found["controls"].append(_control(_matched(CONTROL, line)))
    elif part == ZONES:
        # A work zone follows from its objects.
        found["zones"] += [_matched(ZONE, line)] if not line.startswith("work_zone ") else []
    elif part == FAILED:
        found["attempts"].append(_attempt(_matched(ATTEMPT, line)))
    else:
        raise ValueError(line)
    return part


def _matched(form: re.Pattern[str], line: str) -> dict[str, str | None]:
    match = form.match(line)
    if match is None:
        raise ValueError(line)
    return match.groupdict()


def _threshold_mps(kmh: str | None) -> float:
    """Return the detector's threshold (m/s). The prompt rounds it; the default comes back exactly."""
    return IMMOBILIZED_BELOW_MPS if kmh == "5" else float(str(kmh)) / 3.6


def _ego(fields: dict[str, str | None]) -> tuple[dict[str, Any], str | None, float | None]:
    ego = {
        "speed_mps": _number(fields["speed"]),
        "lane_id": None if fields["lane"] == "none" else fields["lane"],
        "lateral_offset_m": _number(fields["offset"]),
        "stopped_for_s": _number(fields["stopped"]),
        "immobilized_below_mps": _threshold_mps(fields["slow"]),
        "progress_20s_m": _number(fields["progress"]),
        "distance_to_destination_m": 0.0 if fields["left"] is None else _number(fields["left"]),
        "at_destination": fields["left"] is None,
        "length_m": _number(fields["length"]),
        "width_m": _number(fields["width"]),
    }
    return ego, fields["route"], _number(fields["limit"])


def _lane(fields: dict[str, str | None]) -> dict[str, Any]:
    return {
        "id": fields["id"],
        "relation": fields["relation"],
        "direction": "opposite" if fields["relation"] == LaneRelation.ONCOMING.value else "same",
        "kind": fields["kind"],
        "width_m": _number(fields["width"]),
        "line": fields["line"],
        "may_enter": fields["closed"] is None and fields["relation"] != LaneRelation.EGO.value,
        "free_ahead_m": _number(fields["ahead"]),
        "free_behind_m": _number(fields["behind"]),
        "sight_ahead_m": _number(fields["sight"]),
        "speed_limit_mps": None,
    }


def _object(fields: dict[str, str | None], ego: dict[str, Any]) -> dict[str, Any]:
    gap, length, speed = _number(fields["gap"]), _number(fields["length"]) or 0.1, _number(fields["speed"]) or 0.0
    across = _number(fields["across"]) or 0.0
    left, right = _number(fields["left"]) or 0.0, _number(fields["right"]) or 0.0
    marks = (fields["marks"] or "").split()
    return {
        "id": fields["id"],
        "kind": fields["kind"],
        "lane": fields["lane"],
        "lane_id": None,
        "gap_m": gap,
        "left_edge_m": left,
        "right_edge_m": right,
        "speed_along_mps": speed,
        "in_path": "in-path" in marks,
        "x_m": (gap or 0.0) + (ego["length_m"] + length) / 2,
        "y_m": (left + right) / 2 - ego["lateral_offset_m"],
        "yaw_rad": 0.0,
        "speed_across_mps": across,
        "vx_mps": speed,
        "vy_mps": across,
        "length_m": length,
        "width_m": _number(fields["width"]) or 0.1,
        "height_m": _number(fields["height"]) or 0.05,
        "stationary_s": _number(fields["stood"]),
        "hazard_lights": "hazard-lights" in marks,
        "emergency_lights": "emergency-lights" in marks,
        "brake_lights": "brake-lights" in marks,
        "door_open": True if "door-open" in marks else None,
        "gesture": next(iter(_marked(fields, SIGNALS)), None),
    }


def _marked(fields: dict[str, str | None], prefix: str) -> list[str]:
    """Return the rest of each mark of an object that starts with `prefix`."""
    return [mark.removeprefix(prefix) for mark in (fields["marks"] or "").split() if mark.startswith(prefix)]


def _attempt(fields: dict[str, str | None]) -> dict[str, Any]:
    """Return a failed plan by the names of its behaviors. Its values are in the text of the reason."""
    names = re.sub(r"\([^)]*\)", "", fields["plan"] or "").split("+")
    missing = f"{fields['missing']}; " if fields["missing"] else ""
    ended = AttemptOutcome(fields["ended"])
    outcome = f"{missing}{fields['outcome']}"
    return {"time_s": -float(fields["ago"] or 0.0), "behaviors": names, "ended": ended, "outcome": outcome}


def _word(mark: str | None) -> str:
    return (mark or "").replace("-", "_")


def _sign(fields: dict[str, str | None]) -> dict[str, Any]:
    bearing = _number(fields["bearing"])
    radians = None if bearing is None else math.radians(bearing)
    return {"word": _word(fields["word"]), "distance_m": _number(fields["gap"]), "bearing_rad": radians}


def _control(fields: dict[str, str | None]) -> dict[str, Any]:
    applies = APPLIES[fields["applies"] or ""]
    return {"kind": fields["kind"], "state": fields["state"], "distance_m": _number(fields["gap"]), "applies": applies}


def _starts(group: str) -> list[dict[str, Any]]:
    """Return the route starts of one lane: `own@0 +20 +40 at 39 reaches destination 120 m`."""
    lane, *words = group.split(" ")
    found: list[dict[str, Any]] = []
    place = iter(words)
    for word in place:
        if not found and word in ("at", "reaches", "dead"):
            # A waypoint whose id equals its lane's id is listed without an id.
            found.append({"id": lane, "lane_id": lane, "x_m": 0.0, "y_m": 0.0, "distance_m": 0.0})
        if word == "at":
            found[-1]["distance_m"] = found[-1]["x_m"] = float(next(place))
        elif word in ("reaches", "dead"):
            next(place)
            found[-1]["reaches_destination"] = word == "reaches"
        elif word == "m":
            continue
        elif found and re.fullmatch(r"\d+(?:\.\d)?", word):
            found[-1]["route_length_m"] = float(word)
        else:
            ahead = float(word[1:]) if re.fullmatch(r"\+\d+(?:\.\d)?", word) else 0.0
            name = lane + word if word.startswith("+") else word
            found.append({"id": name, "lane_id": lane, "x_m": ahead, "y_m": 0.0, "distance_m": ahead})
    return found


def _number(text: str | None) -> float | None:
    return None if text is None or text == "?" else float(text)
