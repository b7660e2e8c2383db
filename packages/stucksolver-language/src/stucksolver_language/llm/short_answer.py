"""The short form of an answer: the choice first, then the three steps as codes and one sentence."""

from __future__ import annotations

import re
from typing import Any

from pydantic import Field

from stucksolver.plan import (
    QUESTIONS,
    Analysis,
    AnalysisStep,
    CauseCode,
    GuidanceIntent,
    Intent,
    Observation,
    ObservedControl,
    Participant,
    PictureObject,
    ReportedSign,
    ReportedWorkZone,
    WaitReason,
)
from stucksolver.plan.behaviors.registry import AnyBehavior
from stucksolver.scene import ControlKind, LightState, ObjectKind, Scene, SignWord
from stucksolver.scene.base_model import FrozenModel
from stucksolver_language.llm.answer_form import AT_DESTINATION, CAN, CANNOT, CONCLUSIONS, HELD, IMMOBILIZED
from stucksolver_language.llm.tool_schema import MOST_BEHAVIORS, MOST_CODES, steps_of
from stucksolver_language.llm.work_zones import work_zone_of

LIGHT = "light:"
"""Prefix of a traffic light, before its state."""
SIGN = "sign:"
"""Prefix of a sign, before its words."""
STOP_SIGN = "stop_sign"
WORK_ZONE = "work_zone"
SEEN = re.compile(r"seen:(?P<kind>[a-z_]+)@(?P<bearing>-?\d{1,3})~(?P<distance>\d{1,3})$")
"""Object that only the image shows: kind, bearing (deg, left positive) and rough distance (m)."""
SIGN_WORDS = {word.value.replace("_", "-"): word for word in SignWord}


class ShortAnswer(FrozenModel):
    """Answer in the short form. The names of the fields are those of the schema.

    The schema has `choice` alone: a letter or `none`, or the list of behaviors, which `fields_of` moves to `behaviors`.
    """

    choice: str | None
    behaviors: tuple[AnyBehavior, ...] | None = Field(default=None, min_length=1, max_length=MOST_BEHAVIORS)
    S1: tuple[str, ...] = Field(max_length=MOST_CODES)
    S2: str
    why: str


def fields_of(data: dict[str, Any]) -> dict[str, Any]:
    """Return the fields of a `ShortAnswer` for an answer as the schema has it."""
    own = isinstance(data.get("choice"), list) and "behaviors" not in data
    return {**data, "choice": None, "behaviors": data["choice"]} if own else data


class CodeError(ValueError):
    """A code is not one of the short form. The message can be quoted to the model."""


def observation_of(answer: ShortAnswer, scene: Scene) -> Observation:
    """Return the first step. Numbers and lanes are the measured ones.

    Raises:
        CodeError: A code of `S1` is unknown.
    """
    found = [_observed(code, scene) for code in answer.S1]
    told = any(isinstance(item, ReportedWorkZone) for item in found)
    return Observation(
        controls=tuple(item for item in found if isinstance(item, ObservedControl)),
        participants=tuple(item for item in found if isinstance(item, Participant)),
        summary=answer.why,
        signs=tuple(item for item in found if isinstance(item, ReportedSign)),
        work_zone=work_zone_of(scene) if told else None,
        picture_only=tuple(item for item in found if isinstance(item, PictureObject)),
    )


def analysis_of(answer: ShortAnswer, scene: Scene) -> Analysis:
    """Return the second step: the question that `S2` names is answered with yes, the others with no.

    Raises:
        CodeError: `S2` is no code, or belongs to a question that was not asked.
    """
    code = answer.S2
    name = code.partition(":")[0]
    if code not in CONCLUSIONS or name not in steps_of(scene):
        raise CodeError(f"S2: {code!r} is no code for {', '.join(steps_of(scene))}")
    steps = tuple(
        AnalysisStep(
            id=step,
            question=QUESTIONS[step],
            answer=step == name and not code.startswith(CANNOT),
            evidence=answer.why if step == name else "",
        )
        for step in steps_of(scene)
    )
    return Analysis(
        steps=steps,
        immobilized=code.startswith(IMMOBILIZED),
        cause=CauseCode(code.removeprefix(IMMOBILIZED)) if code.startswith(IMMOBILIZED) else None,
        wait=_wait(answer),
        guidance_intent=_intent(code),
        reason=answer.why,
    )


def _wait(answer: ShortAnswer) -> WaitReason | None:
    if answer.S2 == AT_DESTINATION:
        return WaitReason.AT_DESTINATION
    return WaitReason(answer.S2.removeprefix(HELD)) if answer.S2.startswith(HELD) else None


def _intent(code: str) -> GuidanceIntent | None:
    if not code.startswith(CAN):
        return None
    return GuidanceIntent(code.removeprefix(CANNOT if code.startswith(CANNOT) else CAN))


def _observed(
    code: str, scene: Scene
) -> ObservedControl | Participant | ReportedSign | ReportedWorkZone | PictureObject:
    """Return what a code of `S1` names. Raises `CodeError`."""
    participant = _participant(code, scene)
    if participant is not None:
        return participant
    if code == WORK_ZONE:
        return ReportedWorkZone()
    if code == STOP_SIGN:
        return _control(ControlKind.STOP_SIGN, None, scene)
    if code.startswith(LIGHT) and code.removeprefix(LIGHT) in {state.value for state in LightState}:
        return _control(ControlKind.TRAFFIC_LIGHT, LightState(code.removeprefix(LIGHT)), scene)
    word = SIGN_WORDS.get(code.removeprefix(SIGN).replace("_", "-")) if code.startswith(SIGN) else None
    if word is not None:
        carrier = next((sign.object_id for sign in scene.signs if sign.word is word), None)
        return ReportedSign(content=word.value, object_id=carrier)
    seen = SEEN.match(code)
    if seen is not None and seen["kind"] in {kind.value for kind in ObjectKind} and abs(int(seen["bearing"])) <= 180:
        return PictureObject(
            kind=ObjectKind(seen["kind"]), bearing_deg=float(seen["bearing"]), distance_m=float(seen["distance"])
        )
    raise CodeError(f"S1: {code!r} is no object of this scene and no code")


def _participant(code: str, scene: Scene) -> Participant | None:
    """Return the object with this id, or None. A kind after the id is what the image shows."""
    by_id = {o.id: o for o in scene.objects}
    name, _, kind = (code, "", "") if code in by_id else code.rpartition(":")
    obj = by_id.get(name)
    if obj is None or (kind and kind not in {known.value for known in ObjectKind}):
        return None
    shown = ObjectKind(kind) if kind else obj.kind
    return Participant(object_id=name, kind=shown, lane=obj.lane, distance_m=obj.gap_m, intent=Intent.UNKNOWN)


def _control(kind: ControlKind, state: LightState | None, scene: Scene) -> ObservedControl:
    """Return a control with the measured distance and validity of the first one of its kind, if there is one."""
    known = next((control for control in scene.controls if control.kind is kind), None)
    if known is None:
        return ObservedControl(kind=kind, state=state, applies=None, distance_m=None)
    return ObservedControl(kind=kind, state=state, applies=known.applies, distance_m=known.distance_m)
