"""A model that reads nothing but the prompt: it finds its way through the scene's text and answers the call.

So whatever it can decide, any model that can read could decide: all that is needed stands in the prompt.
"""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from typing import Any

NUMBER = r"-?\d+(?:\.\d+)?"
OBJECT = re.compile(
    rf"^(?P<id>\S+) (?P<kind>[a-z_]+) (?P<lane>[a-z_]+) (?P<gap>{NUMBER}|\?) (?P<right>{NUMBER})\.\.(?P<left>{NUMBER}) "
    rf"(?P<speed>{NUMBER})/(?P<across>{NUMBER}) (?P<stood>{NUMBER}|\?) \S+\*\S+\*\S+(?P<marks>.*)$",
    re.MULTILINE,
)
LANE = re.compile(r"^(?P<id>\S+) (?P<relation>left|right|oncoming|ego) .*$", re.MULTILINE)
CONTROL = re.compile(
    r"^(?P<kind>traffic_light|stop_sign)(?: (?P<state>\w+))? (?P<distance>\S+) m (?P<applies>.*)$",
    re.M,
)
LIGHT_M = 25.0
ITEM = re.compile(r"^(?P<letter>[A-F]) [a-z_]+\(.*?: accepted: ", re.M)
SPOKEN = re.compile(r"^passenger says \S+ s ago: (?P<words>\".*\")$", re.MULTILINE)


@dataclass(frozen=True)
class Read:
    """What the text says."""

    objects: list[dict[str, str]]
    lanes: list[dict[str, str]]
    controls: list[dict[str, str]]
    words: str | None
    ego: str
    """The first line."""

    @property
    def stopped(self) -> bool:
        return re.match(r"ego: (?:0|0\.\d+|1\.[0-3]) m/s", self.ego) is not None

    def told(self, pattern: str) -> str:
        """What the first line says of something."""
        found = re.search(pattern, self.ego)
        return found.group() if found else "not told"


def read(text: str) -> Read:
    spoken = SPOKEN.search(text)
    return Read(
        [m.groupdict() for m in OBJECT.finditer(text)],
        [{**m.groupdict(), "line": m.group()} for m in LANE.finditer(text)],
        [m.groupdict() for m in CONTROL.finditer(text)],
        json.loads(spoken["words"]) if spoken else None,
        text.partition("\n")[0],
    )


def answer(text: str, behaviors: list[str]) -> dict[str, Any]:
    """The arguments of `decide` for a scene's text, with the behaviors that the schema offers."""
    seen = read(text)
    wait = _wait(seen)
    plan = None if wait else _plan(seen, behaviors)
    stuck = seen.stopped and wait is None
    return {
        "observation": {
            "controls": [
                {"kind": c["kind"], "state": c["state"], "applies": c["applies"] == "applies"} for c in seen.controls
            ],
            "participants": [
                {"object_id": o["id"], "kind": o["kind"], "lane": o["lane"], "intent": _intent(o)}
                for o in seen.objects[:4]
            ],
            "summary": f"objects: {len(seen.objects)}, traffic controls: {len(seen.controls)}",
        },
        "analysis": {
            "steps": _steps(seen, wait, stuck),
            "immobilized": stuck,
            "cause": "static_obstacle" if stuck else None,
            "wait": wait,
            "guidance_intent": _wish(seen.words) if seen.words is not None else None,
            "reason": f"waiting is right: {wait}" if wait else _nearest(seen),
        },
        "decision": {
            "rationale": "wait" if plan is None else f"get past with {plan[0]['name']}",
            "behaviors": plan,
            "replan_route": False,
            "route_start": None,
        },
    }


def short_answer(text: str, behaviors: list[str]) -> dict[str, Any]:
    """The same decision in the short form: the first accepted plan of the menu, if there is one, or its own."""
    long = answer(text, behaviors)
    plan, seen = long["decision"]["behaviors"], read(text)
    listed = ITEM.search(text)
    letter = listed["letter"] if listed and plan else None
    return {
        "choice": letter or plan or "none",
        "S1": [o["id"] for o in seen.objects[:4]] + [f"light:{c['state']}" for c in seen.controls if c["state"]][:1],
        "S2": _conclusion(long["analysis"], seen),
        "why": long["analysis"]["reason"][:120],
    }


def _conclusion(analysis: dict[str, Any], seen: Read) -> str:
    if seen.words is not None:
        wish = _wish(seen.words)
        return f"S2.1:{'no:' if wish == 'unclear' else ''}{wish}"
    if analysis["wait"]:
        return f"S2.4:{analysis['wait']}"
    return f"S2.5:{analysis['cause']}" if analysis["immobilized"] else "S2.3"


def _wish(words: str) -> str:
    return "overtake" if re.search(r"overtake|pass|around", words.lower()) else "unclear"


def _steps(seen: Read, wait: str | None, stuck: bool) -> dict[str, Any]:
    if seen.words is not None:
        return {"S2.1": {"answer": _wish(seen.words) != "unclear", "evidence": seen.words}}
    speed = seen.told(r"[\d.]+ m/s, below 5 km/h for [\d.]+ s")
    return {
        "S2.2": {"answer": False, "evidence": seen.told(r"[\d.?]+ m to destination")},
        "S2.3": {"answer": not seen.stopped, "evidence": speed},
        "S2.4": {"answer": wait is not None, "evidence": wait or "no light, no people, no queue"},
        "S2.5": {"answer": stuck, "evidence": _nearest(seen)},
    }


def _nearest(seen: Read) -> str:
    """The nearest thing in the path, as it is told."""
    ahead = [o for o in seen.objects if "in-path" in o["marks"]]
    if not ahead:
        return "nothing stands in the way"
    o = ahead[0]
    return f"{o['kind']} {o['id']} {o['gap']} m ahead, {o['speed']} m/s, has stood for {o['stood']} s"


def _wait(seen: Read) -> str | None:
    lights = (c for c in seen.controls if c["kind"] == "traffic_light" and c["applies"] == "applies")
    if any(c["state"] in ("red", "yellow") and float(c["distance"]) < LIGHT_M for c in lights):
        return "light"
    near = [o for o in seen.objects if o["gap"] != "?" and -2 < float(o["gap"]) < 15]
    if any(o["kind"] == "pedestrian" and (o["lane"] == "crossing" or "in-path" in o["marks"]) for o in near):
        return "people"
    return None


def _plan(seen: Read, behaviors: list[str]) -> list[dict[str, Any]] | None:
    ahead = [o for o in seen.objects if "in-path" in o["marks"] and o["gap"] != "?" and float(o["gap"]) > 0]
    if not ahead or not ((seen.words is not None and _wish(seen.words) == "overtake") or seen.stopped):
        return None
    first = min(ahead, key=lambda o: float(o["gap"]))
    if first["kind"] in ("bag", "litter") and "drive_over" in behaviors:
        return [{"name": "drive_over", "object_id": first["id"], "speed_mps": 1.5}]
    left = [lane for lane in seen.lanes if lane["relation"] == "left"]
    if left and "change_lane" in behaviors and "no-entry" not in left[0]["line"]:
        slow = [o for o in ahead if float(o["speed"]) < 3.0 or o is first]
        end, gone = max(float(o["gap"]) for o in slow), max(float(o["speed"]) for o in slow)
        way = (end + 20.0) * 5.0 / max(5.0 - max(gone, 0.0), 1.0)
        out = {"name": "change_lane", "side": "left", "distance_m": round(min(way, 120.0), 1), "speed_mps": 5.0}
        return [out, {"name": "change_lane", "side": "right", "distance_m": 20.0, "speed_mps": 5.0}]
    if "borrow_oncoming_lane" in behaviors:
        return [{"name": "borrow_oncoming_lane", "past_object_id": first["id"], "speed_mps": 5.0}]
    return None


def _intent(o: dict[str, str]) -> str:
    if o["lane"] == "crossing":
        return "crossing"
    speed = float(o["speed"])
    return "oncoming" if speed < -0.5 else "following_lane" if speed > 0.5 else "stopped"
