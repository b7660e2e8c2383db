"""The functions that a model may call, derived from the decision's types and the behaviors of the stack.

They are the same in every query of a drive, because providers compile a schema when it comes first, which takes up to
10 s, and caches match it as a whole. So ids of objects and waypoints are texts, and behaviors that have nothing to act
on can be expressed: the parser checks both. The functions use the subset of JSON Schema for strict structured output
(every field required, no others, no defaults), except for limits, which are removed for servers that reject them. Lists
and texts are bounded, since a small model may repeat one item until its tokens are used up.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum
from typing import Any

from stucksolver.plan import CauseCode, GuidanceIntent, Intent, WaitReason
from stucksolver.plan.behaviors import REGISTRY
from stucksolver.plan.behaviors.registry import describe
from stucksolver.scene import AvailableBehavior, ControlKind, LaneRelation, LightState, ObjectKind, Scene
from stucksolver_language.llm.answer_form import CONCLUSIONS, NONE, USUAL_FORM, AnswerForm
from stucksolver_language.llm.chat import Tool
from stucksolver_language.llm.offered_behaviors import known_behaviors

DECIDE = "decide"
CHECK_PLAN = "check_plan"
MOST_BEHAVIORS = 6
"""Maximum number of behaviors in a plan. Ours."""
MOST_CONTROLS = 6
"""Maximum number of traffic controls in an observation. Ours."""
MOST_PARTICIPANTS = 8
"""Maximum number of participants in an observation. Ours."""
MOST_SIGNS = 4
"""Maximum number of signs, and of objects that only the image shows, in an observation. Ours."""
MOST_SIGN_TEXT = 120
"""Longest content of a sign (characters), as in `ReportedSign`."""
MOST_TEXT = 240
"""Longest text (characters): one or two sentences."""
MOST_CODES, MOST_CODE = 6, 64
"""Maximum number of codes in the short form, and longest code (characters): an id with a kind. Ours."""
SHORT_TEXT = 160
"""Longest sentence of the short form (characters): about 40 of its 120 tokens. Ours."""
SHORT_ID, LONG_ID = 16, 64
"""Longest id of an object or a waypoint in an answer (characters).

The short bound applies as long as the ids of the scene fit: CARLA's are shorter, a UUID has 36. A small model that
repeats itself fills each id to its bound. Ours.
"""
GUIDED, UNGUIDED = ("S2.1",), ("S2.2", "S2.3", "S2.4", "S2.5")
"""Questions of the chain with and without a passenger's guidance."""

Schema = dict[str, Any]


def decide_tool(scene: Scene, form: AnswerForm = USUAL_FORM) -> Tool:
    """Return the function for the final answer in a form."""
    return _decide_tool(known_behaviors(scene), _id_length(scene), form)


def full_decide_tool(form: AnswerForm = USUAL_FORM) -> Tool:
    """Return the same function for a stack that offers every behavior, for queries without a scene."""
    return _decide_tool(describe(tuple(REGISTRY)), SHORT_ID, form)


def check_tool(scene: Scene) -> Tool:
    """Return the function that queries the guard about a plan before the model commits to it."""
    parameters = _object({"behaviors": _plan()})
    parameters["$defs"] = _plan_definitions(known_behaviors(scene), _id_length(scene))
    return Tool(CHECK_PLAN, "Ask whether the safety guard would accept these behaviors now.", parameters)


def steps_of(scene: Scene) -> tuple[str, ...]:
    """Return the questions of the chain that apply."""
    return GUIDED if scene.guidance is not None else UNGUIDED


def _id_length(scene: Scene) -> int:
    ids = [*(obj.id for obj in scene.objects), *(waypoint.id for waypoint in scene.waypoints)]
    return SHORT_ID if all(len(name) <= SHORT_ID for name in ids) else LONG_ID


def _decide_tool(behaviors: Sequence[AvailableBehavior], id_length: int, form: AnswerForm) -> Tool:
    plans = _plan_definitions(behaviors, id_length)
    if form.chain == "short":
        parameters = _short(form)
        parameters["$defs"] = plans
        return Tool(DECIDE, "Answer with your choice first, then the reasons as codes and one sentence.", parameters)
    parameters = _object(
        {"observation": _observation(), "analysis": _analysis(), "decision": _decision(form)},
    )
    steps = [_object({name: {"$ref": "#/$defs/step"} for name in names}) for names in (UNGUIDED, GUIDED)]
    parameters["$defs"] = {
        "step": _object({"answer": {"type": ["boolean", "null"]}, "evidence": _text()}),
        "steps": {"anyOf": steps},
        **plans,
    }
    return Tool(DECIDE, "Answer with what you observe, analyse and decide, in this order.", parameters)


def _short(form: AnswerForm) -> Schema:
    named = {"type": "string", "enum": [*form.letters, NONE]}
    return _object(
        {
            "choice": {"anyOf": [named, _plan()]},
            "S1": _list({"type": "string", "maxLength": MOST_CODE}, MOST_CODES),
            "S2": {"type": "string", "enum": list(CONCLUSIONS)},
            "why": {"type": "string", "maxLength": SHORT_TEXT},
        }
    )


def _observation() -> Schema:
    control = _object(
        {"kind": _enum(ControlKind), "state": _or_null(_enum(LightState)), "applies": {"type": ["boolean", "null"]}}
    )
    participant = _object(
        {
            "object_id": {"$ref": "#/$defs/object_id"},
            "kind": _enum(ObjectKind),
            "lane": _enum(LaneRelation),
            "intent": _enum(Intent),
        }
    )
    sign = _object(
        {"content": {**_text(), "maxLength": MOST_SIGN_TEXT}, "object_id": _or_null({"$ref": "#/$defs/object_id"})}
    )
    bearing = {"type": "number", "minimum": -180, "maximum": 180}
    distance = {"type": "number", "minimum": 0, "maximum": 1000}
    seen = _object({"kind": _enum(ObjectKind), "bearing_deg": bearing, "distance_m": distance})
    return _object(
        {
            "controls": _list(control, MOST_CONTROLS),
            "signs": _list(sign, MOST_SIGNS),
            "work_zone": {"type": "boolean"},
            "participants": _list(participant, MOST_PARTICIPANTS),
            "picture_only": _list(seen, MOST_SIGNS),
            "summary": _text(),
        }
    )


def _analysis() -> Schema:
    return _object(
        {
            "steps": {"$ref": "#/$defs/steps"},
            "immobilized": {"type": "boolean"},
            "cause": _or_null(_enum(CauseCode)),
            "wait": _or_null(_enum(WaitReason)),
            "guidance_intent": _or_null(_enum(GuidanceIntent)),
            "reason": _text(),
        }
    )


def _decision(form: AnswerForm) -> Schema:
    choice = {"choice": _or_null({"type": "string", "enum": list(form.letters)})} if form.menu else {}
    return _object(
        {
            **choice,
            "rationale": _text(),
            "behaviors": _or_null(_plan()),
            "replan_route": {"type": "boolean"},
            "route_start": _or_null({"$ref": "#/$defs/waypoint_id"}),
        }
    )


def _plan() -> Schema:
    return {"type": "array", "minItems": 1, "maxItems": MOST_BEHAVIORS, "items": {"$ref": "#/$defs/behavior"}}


def _behavior(name: str, parameters: Schema) -> Schema:
    """Return a behavior's own schema without titles and defaults."""
    fields = {key: _field(key, value) for key, value in parameters["properties"].items() if key != "name"}
    return _object({"name": {"type": "string", "enum": [name]}, **fields})


def _field(key: str, value: Schema) -> Schema:
    if key == "route_start":
        return _or_null({"$ref": "#/$defs/waypoint_id"})
    if key.endswith("_id"):
        return {"$ref": "#/$defs/object_id"}
    return {k: v for k, v in value.items() if k not in ("title", "default", "description")}


def _plan_definitions(behaviors: Sequence[AvailableBehavior], id_length: int) -> Schema:
    return {
        **{b.name: _behavior(b.name, b.parameters) for b in behaviors},
        "behavior": {"anyOf": [{"$ref": f"#/$defs/{b.name}"} for b in behaviors]},
        "waypoint_id": {"type": "string", "maxLength": id_length},
        "object_id": {"type": "string", "maxLength": id_length},
    }


def _object(properties: Schema) -> Schema:
    return {
        "type": "object",
        "properties": properties,
        "required": list(properties),
        "additionalProperties": False,
    }


def _list(items: Schema, most: int) -> Schema:
    return {"type": "array", "maxItems": most, "items": items}


def _enum(kind: type[Enum]) -> Schema:
    return {"type": "string", "enum": [str(member.value) for member in kind]}


def _or_null(schema: Schema) -> Schema:
    if "enum" in schema:
        return {"type": ["string", "null"], "enum": [*schema["enum"], None]}
    return {"anyOf": [schema, {"type": "null"}]}


def _text() -> Schema:
    return {"type": "string", "maxLength": MOST_TEXT}
