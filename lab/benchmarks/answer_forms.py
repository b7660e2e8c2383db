"""Size of prompts and answers of a language model: with a menu or in free form, with a short or a long chain.

The scenes are those of `search_latency` with 1 to 30 objects. No model is asked: the answer is the decision of the
search, written in each form as a model would write it, and the parser must read the same plan from all four. `chars_*`
are medians in characters. With the address of a llama.cpp server in `TOKENIZE_URL` (`http://HOST:PORT`), `tokens_*` are
medians and maxima in the encoding of its model. `ms_menu_*` is the time to make a menu (ms).
"""

from __future__ import annotations

import json
import os
import statistics
import time
import urllib.request
from typing import Any

from lab.benchmarks.search_latency import NEARER_M, SIGHT_M
from lab.benchmarks.solver_overhead import parked_car
from stucksolver.guard import Guard
from stucksolver.plan import Decision, RecoveryPlan
from stucksolver.plan.behaviors import REGISTRY, describe
from stucksolver.reasoners import ReasonerRequest, SearchReasoner
from stucksolver.reasoners.search.menu import MenuItem, plan_menu
from stucksolver.scene import LaneSight, Scene, Status, Surroundings
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.scene_builder import build_scene
from stucksolver.solver.state_machine.plan_preview import PlanPreview
from stucksolver_language.llm import parse_answer
from stucksolver_language.llm.answer_form import HELD, IMMOBILIZED, NONE, AnswerForm
from stucksolver_language.llm.prompt import messages
from stucksolver_language.llm.tool_schema import MOST_CODES, MOST_PARTICIPANTS, SHORT_TEXT, decide_tool

FORMS = {
    "menu_short": AnswerForm(),
    "free_short": AnswerForm(menu=False),
    "menu_long": AnswerForm(chain="long"),
    "free_long": AnswerForm(menu=False, chain="long"),
}
COUNTS = (1, 10, 20, 30)
"""Numbers of objects in the scenes."""


def run(smoke: bool) -> dict[str, float]:
    """Return the metrics of this module's docstring."""
    address = os.environ.get("TOKENIZE_URL")
    sizes: dict[str, list[float]] = {}
    times: list[float] = []
    for surroundings in _situations(COUNTS[:1] if smoke else COUNTS):
        scene, preview = _scene(surroundings)
        began = time.perf_counter()
        menu = plan_menu(scene, preview.assess)
        times.append((time.perf_counter() - began) * 1e3)
        decision = SearchReasoner().decide(ReasonerRequest(scene, assess=preview.assess)).decision
        for name, form in FORMS.items():
            listed = menu if form.menu else None
            answer = written_answer(scene, decision, form, menu)
            plans = {item.letter: item.plan for item in listed or ()}
            if parse_answer(answer, scene, plans).plan != decision.plan:
                raise ValueError(f"the parser reads another plan from the form {name}")
            turns = messages(scene, form, listed)
            schema = json.dumps(decide_tool(scene, form).parameters)
            texts = {"fixed": turns[0].text, "scene": turns[1].text, "schema": schema, "answer": answer}
            for part, text in texts.items():
                sizes.setdefault(f"chars_{name}_{part}", []).append(len(text))
                if address is not None:
                    sizes.setdefault(f"tokens_{name}_{part}", []).append(_tokens(address, text))
    figures: dict[str, float] = {key: statistics.median(values) for key, values in sizes.items()}
    figures |= {f"{key}_most": max(values) for key, values in sizes.items() if key.startswith("tokens_")}
    return figures | {"ms_menu_p50": statistics.median(times), "ms_menu_most": max(times)}


def written_answer(scene: Scene, decision: Decision, form: AnswerForm, menu: tuple[MenuItem, ...]) -> str:
    """Return a decision in the JSON of a form. The letter is that of the same plan, if the menu has it."""
    plan = decision.plan
    letter = next((item.letter for item in menu if form.menu and item.plan == plan), None)
    behaviors = None if plan is None or letter is not None else _behaviors(plan)
    data = (_short if form.chain == "short" else _long)(decision, letter, behaviors)
    if form.chain == "long" and form.menu:
        data["decision"] = {"choice": letter, **data["decision"]}
    return json.dumps(data)


def _short(decision: Decision, letter: str | None, behaviors: list[Any] | None) -> dict[str, Any]:
    analysis = decision.analysis
    wait = analysis.wait.value if analysis.wait is not None else "queue"
    cause = analysis.cause.value if analysis.cause is not None else "unknown"
    return {
        "choice": letter or behaviors or NONE,
        "S1": [p.object_id for p in decision.observation.participants[:MOST_CODES]],
        "S2": IMMOBILIZED + cause if analysis.immobilized else HELD + wait,
        "why": analysis.reason[:SHORT_TEXT],
    }


def _long(decision: Decision, letter: str | None, behaviors: list[Any] | None) -> dict[str, Any]:
    observation, analysis = decision.observation, decision.analysis
    participants = [
        {"object_id": p.object_id, "kind": p.kind.value, "lane": p.lane.value, "intent": p.intent.value}
        for p in observation.participants[:MOST_PARTICIPANTS]
    ]
    seen: dict[str, Any] = {"controls": [], "signs": [], "work_zone": False, "participants": participants}
    return {
        "observation": {**seen, "picture_only": [], "summary": observation.summary},
        "analysis": {
            "steps": {
                step.id: {
                    "answer": step.answer if step.id != "S2.5" else analysis.immobilized,
                    "evidence": step.evidence,
                }
                for step in analysis.steps
            },
            "immobilized": analysis.immobilized,
            "cause": None if analysis.cause is None else analysis.cause.value,
            "wait": None if analysis.wait is None or analysis.immobilized else analysis.wait.value,
            "guidance_intent": None,
            "reason": analysis.reason,
        },
        "decision": {
            "rationale": decision.rationale,
            "behaviors": behaviors,
            "replan_route": False,
            "route_start": None,
        },
    }


def _behaviors(plan: RecoveryPlan) -> list[Any]:
    return [behavior.model_dump(mode="json") for behavior in plan.behaviors]


def _situations(counts: tuple[int, ...]) -> list[Surroundings]:
    """Return a pass, a pass without room to pull out, and a road on which the oncoming lane is not visible."""
    first = parked_car()
    lanes = tuple(LaneSight(lane_id=x.lane_id, ahead_m=SIGHT_M, behind_m=SIGHT_M) for x in first.sight)
    nearer = first.ego.model_copy(update={"x_m": first.ego.x_m + NEARER_M})
    found = []
    for count in counts:
        # The parked car is always among them.
        objects = tuple(sorted(first.objects, key=lambda o: o.id != "lead")[:count])
        some = first.model_copy(update={"objects": objects})
        found += [some, some.model_copy(update={"ego": nearer}), some.model_copy(update={"sight": lanes})]
    return found


def _scene(surroundings: Surroundings) -> tuple[Scene, PlanPreview]:
    view = FrenetScene(surroundings)
    status = Status(time_s=surroundings.time_s, speed_mps=0.0, progress_m=0.0)
    scene = build_scene(view, status, describe(tuple(REGISTRY)))
    scene = scene.model_copy(update={"ego": scene.ego.model_copy(update={"stopped_for_s": 30.0})})
    return scene, PlanPreview(Guard(), view, lambda plan: False)


def _tokens(address: str, text: str) -> int:
    """Return the number of tokens that a llama.cpp server counts."""
    body = json.dumps({"content": text}).encode()
    request = urllib.request.Request(f"{address}/tokenize", body, {"Content-Type": "application/json"})
    with urllib.request.urlopen(request, timeout=30) as response:
        return len(json.load(response)["tokens"])
