"""A behavior is one file and its registration: this file defines one, and everything outside follows."""

from __future__ import annotations

import ast
from pathlib import Path
from typing import ClassVar, Literal

import pytest
from pydantic import Field, ValidationError

import stucksolver
from stucksolver.guard import Guard, RejectCode
from stucksolver.plan import (
    Analysis,
    Decision,
    Execute,
    Observation,
    RecoveryPlan,
    apply_guidance_limits,
    plan_matches_intent,
)
from stucksolver.plan.behaviors import (
    REGISTRY,
    Behavior,
    BehaviorStart,
    Check,
    PlanPhrase,
    describe,
    names_with,
    parse_behavior,
    register,
    unregister,
)
from stucksolver.plan.behaviors.behavior import MOVING_CHECKS
from stucksolver.plan.behaviors.keep_lane import own_lane
from stucksolver.plan.frenet_path import FrenetPath, along_lane
from stucksolver.plan.json_schemas import schemas
from stucksolver.reasoners import ReasonerAnswer, ReasonerTrace
from stucksolver.record import Recorder, RecordError, replay
from stucksolver.scene import GuidanceIntent, Interpretation, Scene
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.interpretation import GuidanceLimits
from stucksolver.solver import EventKind
from stucksolver_language.llm.answer_parser import parse_plan
from stucksolver_language.llm.prompt import system_text, user_text
from stucksolver_language.llm.tool_schema import decide_tool
from stucksolver_passenger.memory.solution import solution_of
from stucksolver_passenger.sentences import future_phrase, needed, present_phrase
from worlds import NAMES, World, drive, straight_road, thing

NAME = "edge_forward"
PACKAGES = Path(__file__).parents[2]
PROPOSERS = {
    "plan/lease.py",
    "reasoners/faulty.py",
    "reasoners/duties",
    "reasoners/search",
    "solver/state_machine/execution.py",
    "solver/state_machine/execution_steps.py",
    "solver/state_machine/minimal_risk.py",
    "solver/state_machine/path_points.py",
}
"""Modules of the core that create concrete behaviors: each of them proposes what the vehicle does."""


class EdgeForward(Behavior):
    """Edge forward in the ego's lane to see past the vehicle ahead, and stop."""

    summary: ClassVar[str] = "Edge distance_m metres forward to see past the vehicle ahead, then stop."
    phrase: ClassVar[PlanPhrase] = PlanPhrase("edge forward to see more", "edging forward to see more")
    approval_note: ClassVar[str | None] = "I would come close to the vehicle ahead."
    checks: ClassVar[tuple[Check, ...]] = (*MOVING_CHECKS, Check.CREEP_SPEED, Check.STOPPING_PLACE)
    intents: ClassVar[tuple[GuidanceIntent, ...]] = (GuidanceIntent.GO,)
    solution_rank: ClassVar[int | None] = 75

    name: Literal["edge_forward"] = "edge_forward"
    distance_m: float = Field(ge=1.0, le=3.0)

    @classmethod
    def fits_scene(cls, scene: Scene) -> bool:
        return bool(scene.objects)

    def maneuver(self, view: FrenetScene, start: BehaviorStart) -> FrenetPath:
        return along_lane(own_lane(view, start), start.s_m, start.d_m, self.distance_m, 1.0).stopping()


class EdgingReasoner:
    """Proposes the new behavior, once."""

    name = "edging"

    def __init__(self) -> None:
        self._plan: RecoveryPlan | None = RecoveryPlan(behaviors=(EdgeForward(distance_m=2.0),))

    def decide(self, request):
        plan, self._plan = self._plan, None
        decision = Decision(
            observation=Observation(controls=(), participants=(), summary=""),
            analysis=Analysis(steps=(), immobilized=True, reason="a test"),
            plan=plan,
            rationale="a test",
        )
        return ReasonerAnswer(decision, self.name, ReasonerTrace(answers=(decision.model_dump_json(),)))


@pytest.fixture
def registered():
    register(EdgeForward)
    yield
    if NAME in REGISTRY:
        unregister(NAME)


def blocked_world(x: float = 66.0, *names: str) -> World:
    """A parked car ahead, whose rear is at 72.7 m; the ego's front is 2.45 m ahead of `x`."""
    return World(straight_road(), [thing("lead", 75.0)], x=x, offers=(*NAMES, *names))


def recorded_drive(folder):
    """Drive with the reasoner above; return the world, the drive and the record."""
    world = blocked_world(66.0, NAME)
    with Recorder(folder) as recorder:
        seen = drive(world, 8.0, reasoner=EdgingReasoner(), record=recorder)
    assert recorder.error is None
    return world, seen, recorder.files[0]


def test_registered_behavior_is_in_descriptions_and_schemas(registered):
    (offer,) = describe((NAME,))
    assert offer.parameters["properties"]["distance_m"]["maximum"] == 3.0
    for form in ("decision", "directive"):
        assert schemas()[form]["$defs"]["EdgeForward"]["properties"]["name"]["const"] == NAME
    plan = RecoveryPlan(behaviors=(EdgeForward(distance_m=2.0),))
    again = RecoveryPlan.model_validate_json(plan.model_dump_json())
    assert again == plan and type(again.behaviors[0]) is EdgeForward


def test_registered_behavior_is_in_the_prompt_and_in_answers(registered):
    scene, empty = blocked_world(66.0, NAME).scene(), World(straight_road(), offers=(*NAMES, NAME)).scene()
    assert f"{NAME}(distance_m 1..3): {EdgeForward.summary}" in system_text(scene)
    assert NAME in user_text(scene).splitlines()[-2] and NAME not in user_text(empty).splitlines()[-2]
    assert decide_tool(scene).parameters["$defs"][NAME]["properties"]["distance_m"]["maximum"] == 3.0
    plan = parse_plan('{"behaviors": [{"name": "edge_forward", "distance_m": 2}]}', scene)
    assert plan.behaviors == (EdgeForward(distance_m=2.0),)


def test_registered_behavior_is_checked_by_the_guard(registered):
    edge = EdgeForward(distance_m=2.0)
    verdict, proven = Guard().accept([edge], blocked_world().view(), False)
    assert verdict.accepted and proven.path.end_s == pytest.approx(68.0, abs=0.51)
    assert not Guard().accept([edge], blocked_world(69.5).view(), False)[0].accepted
    beyond = EdgeForward.model_construct(distance_m=30.0)
    assert Guard().accept([beyond], blocked_world().view(), False)[0].codes == (RejectCode.IMPLAUSIBLE,)


def test_registered_behavior_answers_to_its_intent(registered):
    plan = RecoveryPlan(behaviors=(EdgeForward(distance_m=1.0),))
    reading = Interpretation(
        intent=GuidanceIntent.GO,
        likely=GuidanceIntent.GO,
        confidence=1.0,
        reader="a test",
        limits=GuidanceLimits(distance_m=20.0),
    )
    assert plan_matches_intent(reading, plan)
    assert apply_guidance_limits(plan, reading).behaviors == (EdgeForward(distance_m=3.0),)
    assert solution_of(plan).name == "go"


def test_registered_behavior_has_sentences_for_people(registered):
    edge = EdgeForward(distance_m=2.0)
    assert future_phrase(RecoveryPlan(behaviors=(edge,))) == "edge forward to see more"
    assert present_phrase(edge) == "I am edging forward to see more."
    assert needed((NAME,)) == ("I would come close to the vehicle ahead.",)


@pytest.mark.integration
def test_registered_behavior_is_executed_recorded_and_replayed(registered, tmp_path):
    world, seen, file = recorded_drive(tmp_path)
    assert seen.texts(EventKind.STARTED) == [NAME] and EventKind.FINISHED in seen.kinds()
    assert world.x == pytest.approx(68.0, abs=0.6) and seen.nearest_m > 1.5
    driven = [d for d in seen.directives if isinstance(d, Execute) and type(d.behavior) is EdgeForward]
    assert len(driven) > 20 and driven[0].path
    report = replay(file)
    assert report.matches and report.ticks > 20
    assert report.plans == 1 and report.underivable == 0


@pytest.mark.integration
def test_unregistered_behavior_is_gone_everywhere(registered, tmp_path):
    *_, file = recorded_drive(tmp_path)
    scene, edge = blocked_world(66.0, NAME).scene(), EdgeForward(distance_m=2.0)
    unregister(NAME)
    assert tuple(REGISTRY) == NAMES
    with pytest.raises(KeyError, match=NAME):
        describe((NAME,))
    with pytest.raises(ValidationError, match=NAME):
        parse_behavior({"name": NAME, "distance_m": 2.0})
    with pytest.raises(ValidationError):
        Execute(behavior=edge)
    assert all("EdgeForward" not in schema.get("$defs", {}) for schema in schemas().values())
    assert NAME not in system_text(scene)
    assert Guard().accept([edge], blocked_world().view(), False)[0].codes == (RejectCode.IMPLAUSIBLE,)
    with pytest.raises(KeyError, match=NAME):
        needed((NAME,))
    with pytest.raises(RecordError, match=NAME):
        replay(file)


def test_register_name_is_taken_is_refused(registered):
    with pytest.raises(ValueError, match="name is taken: 'edge_forward'"):
        register(EdgeForward)


def test_register_missing_facts_are_named():
    class Unsaid(Behavior):
        name: Literal["unsaid"] = "unsaid"
        solution_rank: ClassVar[int | None] = 1

        def maneuver(self, view, start):
            return None

    with pytest.raises(ValueError, match="does not state: summary, phrase, intents"):
        register(Unsaid)
    assert "unsaid" not in REGISTRY


def test_unregister_unknown_name_is_an_error():
    with pytest.raises(KeyError):
        unregister("fly")


def test_names_with_a_check_follow_the_registry(registered):
    assert names_with(Check.PASSABLE) == {"drive_over"}
    assert NAME in names_with(Check.STOPPING_PLACE)


def imports_of(file: Path) -> set[str]:
    """Return the names that a file imports from the folder of behaviors."""
    nodes = ast.walk(ast.parse(file.read_text(encoding="utf-8")))
    froms = [node for node in nodes if isinstance(node, ast.ImportFrom) and node.module]
    return {
        alias.name
        for node in froms
        if str(node.module).startswith("stucksolver.plan.behaviors")
        for alias in node.names
    }


def test_concrete_behaviors_are_imported_only_by_proposers():
    core, classes = Path(stucksolver.__file__).parent, {behavior.__name__ for behavior in REGISTRY.values()}
    files = [file for file in PACKAGES.glob("*/src/**/*.py") if not file.is_relative_to(core / "plan" / "behaviors")]
    found = {file for file in files if imports_of(file) & classes}
    assert all(file.is_relative_to(core) for file in found), found
    names = {file.relative_to(core).as_posix() for file in found}
    rooms = ("reasoners/duties", "reasoners/search")
    assert {next((room for room in rooms if name.startswith(f"{room}/")), name) for name in names} == PROPOSERS


def test_no_package_tells_behaviors_apart_by_class():
    classes = {behavior.__name__ for behavior in REGISTRY.values()}
    for file in PACKAGES.glob("*/src/**/*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "isinstance":
                named = {name.id for name in ast.walk(node.args[1]) if isinstance(name, ast.Name)}
                assert not named & classes, f"{file.relative_to(PACKAGES)}, line {node.lineno}"
