"""Parses a model's answer: tolerant of text around the JSON, strict about the JSON itself."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import partial
from types import MappingProxyType
from typing import Any

from pydantic import Field, ValidationError

from stucksolver.plan import Decision, RecoveryPlan
from stucksolver.plan.behaviors import Behavior
from stucksolver.plan.behaviors.registry import AnyBehavior
from stucksolver.plan.mirror import mirrored_decision, mirrored_plan
from stucksolver.reasoners.reasoner import PARSERS, Menu, ReasonerError
from stucksolver.scene import Scene
from stucksolver.scene.base_model import FrozenModel
from stucksolver_language.llm import long_answer, short_answer
from stucksolver_language.llm.answer_form import NONE
from stucksolver_language.llm.chain_consistency import wrong_chain
from stucksolver_language.llm.json_extraction import NoJsonError, extract_json
from stucksolver_language.llm.long_answer import LongAnalysis, LongAnswer
from stucksolver_language.llm.offered_behaviors import available
from stucksolver_language.llm.short_answer import CodeError, ShortAnswer
from stucksolver_language.llm.tool_schema import MOST_BEHAVIORS, steps_of

FORMAT = "llm-decide-3"
"""Version of recorded answers. It increases when an answer that was valid before can no longer be parsed, or when one
that was invalid can be parsed: 3 has letters of a menu and the short form.
"""
FORMAT_2 = "llm-decide-2"
"""The version before menus."""
FORMAT_1 = "llm-decide-1"
"""The version before the parser compared the answers to the chain's questions with its conclusion."""
MOST_ERRORS = 3
"""Maximum number of errors in the message for the model. Ours."""
NO_MENU: Menu = MappingProxyType({})


class AnswerError(ReasonerError):
    """The answer is not a decision about this scene. The message can be quoted to the model."""


class _PlanQuestion(FrozenModel):
    behaviors: tuple[AnyBehavior, ...] = Field(min_length=1, max_length=MOST_BEHAVIORS)


def parse_answer(text: str, scene: Scene, menu: Menu = NO_MENU, *, chain: bool = True) -> Decision:
    """Parse the decision in an answer of the short or the long form.

    Args:
        text: The model's answer.
        scene: The scene to which the answer belongs.
        menu: Plans by letter that the query offered, in the solver's frame.
        chain: Compare the answers to the questions S2.1 to S2.5 with the conclusion.

    Raises:
        AnswerError: The answer is not a decision about this scene. The message lists the first errors, for the model.
    """
    data = _extracted(text)
    fields = json.loads(data)
    short = isinstance(fields, dict) and "choice" in fields and "decision" not in fields
    decision, letter = _short(fields, scene, menu) if short else _long(data, scene, menu, chain)
    if scene.mirrored:
        # The model got the scene as it is in the image.
        decision = mirrored_decision(decision)
    return decision if letter is None else decision.model_copy(update={"plan": menu[letter]})


def parse_plan(text: str, scene: Scene) -> RecoveryPlan:
    """Parse the plan in a query to the guard.

    Raises:
        AnswerError: The text contains no plan for this scene.
    """
    behaviors = _validated(_PlanQuestion, _extracted(text)).behaviors
    _raise_if(_wrong_behaviors(behaviors, scene))
    plan = RecoveryPlan(behaviors=behaviors)
    return mirrored_plan(plan) if scene.mirrored else plan


def _without_menu(text: str, scene: Scene, menu: Menu, *, chain: bool = True) -> Decision:
    return parse_answer(text, scene, chain=chain)


PARSERS[FORMAT] = parse_answer
PARSERS[FORMAT_2] = _without_menu
PARSERS[FORMAT_1] = partial(_without_menu, chain=False)


def _short(data: dict[str, Any], scene: Scene, menu: Menu) -> tuple[Decision, str | None]:
    """Return the decision of the short form, and the letter of its plan. Raises `AnswerError`."""
    answer = _validated(ShortAnswer, json.dumps(short_answer.fields_of(data)))
    letter = None if answer.choice == NONE else answer.choice
    wrong = _wrong_letter(letter, menu, answer.behaviors is not None)
    if answer.choice == NONE and answer.behaviors is not None:
        wrong.append("choice is none, so there must be no behaviors")
    if answer.choice is None and answer.behaviors is None:
        wrong.append("choice must be a letter, none, or a list of behaviors")
    wrong += _wrong_behaviors(answer.behaviors or (), scene)
    try:
        observation, analysis = short_answer.observation_of(answer, scene), short_answer.analysis_of(answer, scene)
    except CodeError as error:
        raise AnswerError("; ".join([*wrong, str(error)][:MOST_ERRORS])) from error
    behaviors = _chosen(letter, menu, answer.behaviors)
    if behaviors is not None and not analysis.immobilized and scene.guidance is None:
        wrong.append(f"a plan is chosen although S2 is {answer.S2}: choice must be none, or S2 a code of S2.5")
    _raise_if(
        wrong
        or wrong_chain(
            {step.id: step.answer for step in analysis.steps},
            immobilized=analysis.immobilized,
            wait=analysis.wait,
            intent=analysis.guidance_intent,
            moves=_moves(behaviors),
        )
    )
    plan = None if answer.behaviors is None else RecoveryPlan(behaviors=answer.behaviors)
    return Decision(observation=observation, analysis=analysis, plan=plan, rationale=answer.why), letter


def _long(data: str, scene: Scene, menu: Menu, chain: bool) -> tuple[Decision, str | None]:
    """Return the decision of the long form, and the letter of its plan. Raises `AnswerError`."""
    answer = _validated(LongAnswer, data)
    decided = answer.decision
    letter = decided.choice
    wrong = [
        *_wrong_steps(answer.analysis, scene),
        *_wrong_letter(letter, menu, decided.behaviors is not None or decided.replan_route),
        *_wrong_ids(answer, scene),
        *_contradictions(answer, scene),
    ]
    behaviors = _chosen(letter, menu, decided.behaviors)
    if chain and not wrong:
        wrong = wrong_chain(
            {name: step.answer for name, step in answer.analysis.steps.items()},
            immobilized=answer.analysis.immobilized,
            wait=answer.analysis.wait,
            intent=answer.analysis.guidance_intent,
            moves=_moves(behaviors),
        )
    _raise_if(wrong)
    plan = None
    if decided.behaviors is not None:
        plan = RecoveryPlan(
            behaviors=decided.behaviors, replan_route=decided.replan_route, route_start=decided.route_start
        )
    observation, analysis = long_answer.observation_of(answer, scene), long_answer.analysis_of(answer, scene)
    return Decision(observation=observation, analysis=analysis, plan=plan, rationale=decided.rationale), letter


# ---- from text to a typed answer


def _extracted(text: str) -> str:
    try:
        return extract_json(text)
    except NoJsonError as error:
        raise AnswerError(str(error)) from error


def _validated(kind: type[Any], data: str) -> Any:
    try:
        return kind.model_validate_json(data, strict=True)
    except ValidationError as error:
        raise AnswerError("; ".join(_worded(e) for e in error.errors()[:MOST_ERRORS])) from error


def _worded(error: Any) -> str:
    where = ".".join(str(part) for part in error["loc"])
    return f"{where}: {error['msg']}" if where else str(error["msg"])


def _raise_if(wrong: list[str]) -> None:
    if wrong:
        raise AnswerError("; ".join(wrong[:MOST_ERRORS]))


# ---- comparison with the scene and the menu


def _wrong_letter(letter: str | None, menu: Mapping[str, RecoveryPlan], has_own: bool) -> list[str]:
    if letter is None:
        return []
    if letter not in menu:
        known = f"the plans that are listed are {', '.join(menu)}" if menu else "no plan is listed"
        return [f"choice: there is no plan {letter!r}; {known}"]
    return [f"choice is {letter}, so behaviors must be null"] if has_own else []


def _chosen(letter: str | None, menu: Menu, own: tuple[Behavior, ...] | None) -> tuple[Behavior, ...] | None:
    """Return the behaviors of the plan with this letter, or the model's own if the menu has no such letter."""
    plan = None if letter is None else menu.get(letter)
    return own if plan is None else plan.behaviors


def _moves(behaviors: tuple[Behavior, ...] | None) -> bool:
    return any(not b.stands_still for b in behaviors or ())


def _wrong_steps(analysis: LongAnalysis, scene: Scene) -> list[str]:
    asked = steps_of(scene)
    return [] if set(analysis.steps) == set(asked) else [f"analysis.steps must be exactly {', '.join(asked)}"]


def _wrong_ids(answer: LongAnswer, scene: Scene) -> list[str]:
    objects = {o.id for o in scene.objects}
    starts = {w.id for w in scene.waypoints}
    wrong = [f"unknown object {p.object_id!r}" for p in answer.observation.participants if p.object_id not in objects]
    if answer.decision.route_start is not None and answer.decision.route_start not in starts:
        wrong.append(f"unknown waypoint {answer.decision.route_start!r}")
    carriers = (sign.object_id for sign in answer.observation.signs if sign.object_id is not None)
    wrong += [f"unknown object {name!r}" for name in carriers if name not in objects]
    return wrong + _wrong_behaviors(answer.decision.behaviors or (), scene)


def _wrong_behaviors(behaviors: tuple[Behavior, ...], scene: Scene) -> list[str]:
    objects, starts = {o.id for o in scene.objects}, {w.id for w in scene.waypoints}
    offered = {b.name for b in available(scene)}
    wrong = [f"behavior {b.name} is not available here" for b in behaviors if b.name not in offered]
    for behavior in behaviors:
        for key, value in behavior.model_dump().items():
            if key == "route_start" and value is not None and value not in starts:
                wrong.append(f"{behavior.name}: unknown waypoint {value!r}")
            elif key.endswith("_id") and value is not None and value not in objects:
                wrong.append(f"{behavior.name}: unknown object {value!r}")
    return wrong


def _contradictions(answer: LongAnswer, scene: Scene) -> list[str]:
    """Return the contradictions in the chain."""
    decided, analysis = answer.decision, answer.analysis
    plan = decided.behaviors is not None or decided.choice is not None
    wrong = []
    if plan and not analysis.immobilized and scene.guidance is None:
        wrong.append("behaviors are given although the vehicle is not immobilized and nobody spoke")
    if scene.guidance is not None and analysis.guidance_intent is None:
        wrong.append("the passenger spoke: analysis.guidance_intent must say what is asked")
    if answer.decision.route_start is not None and not answer.decision.replan_route:
        wrong.append("route_start is given although replan_route is false")
    return wrong
