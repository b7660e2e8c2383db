"""Who is asked, what a yes releases, and the stop at the ladder's end."""

from __future__ import annotations

import pytest
from climbing import QUICK, SOLID, STANDING_STILL, TWO_WAY, stuck

from stucksolver import CONTINUE, SafeStop, StuckSolver
from stucksolver.ladder import Resume, profile
from stucksolver.plan import Execute
from stucksolver.reasoners import ReasonerError, SearchReasoner
from stucksolver.solver import EventKind, QuestionError, QuestionKind
from worlds import LANE_M, World, ladder, straight_road, thing

# ---- people


@pytest.mark.integration
@pytest.mark.parametrize("answer", ["please go around it", "Pass him."])
def test_the_passenger_is_asked_and_may_answer_in_words(answer):
    world = stuck()
    told = []

    class OnlyWhenAsked:
        name = "shy"

        def decide(self, request):
            if request.scene.guidance is None:
                raise ReasonerError("no idea")
            return SearchReasoner().decide(request)

    with StuckSolver(
        world.scene,
        reasoner=OnlyWhenAsked(),
        clock="lockstep",
        ladder=ladder(rungs=QUICK | {"passenger": {}}),
        on_event=told.append,
    ) as solver:
        for _ in range(round(30.0 / world.dt)):
            world.drive(solver.step(world.status(), world.surroundings))
            if EventKind.RECOVERED in kinds(told):
                break
            question = solver.pending_question
            if question is not None and question.kind is QuestionKind.ADVICE and world.time_s > 5.0:
                assert "car lead blocks the way" in question.text
                with pytest.raises(QuestionError, match="call guide"):
                    solver.approve()
                solver.guide(answer)
                world.time_s += 1e-3
    assert EventKind.RECOVERED in [e.kind for e in told]
    assert world.x > 80.0


def solid_line(seconds, answer, **options):
    """Stuck behind a parked car at a solid line; `answer` gets the solver whenever a question is open."""
    world = World(SOLID, [thing("lead", 75.0)], x=58.0, **STANDING_STILL)
    told = []
    with StuckSolver(world.scene, clock="lockstep", on_event=told.append, **options) as solver:
        for _ in range(round(seconds / world.dt)):
            if solver.pending_question is not None:
                answer(solver)
            world.drive(solver.step(world.status(), world.surroundings))
    return world, told


def kinds(events):
    return [e.kind for e in events]


def test_a_solid_line_is_crossed_with_the_passengers_yes():
    asked = []

    def yes(solver):
        asked.append(solver.pending_question)
        solver.approve(solver.pending_question.id)

    world, told = solid_line(11.0, yes)
    assert (asked[0].kind, asked[0].to, asked[0].needs) == (QuestionKind.APPROVAL, "passenger", ("solid_line",))
    assert kinds(told).count(EventKind.ASKED) == 1
    assert EventKind.RECOVERED in kinds(told)
    assert world.x > 80.0


def test_solid_line_declined_is_not_crossed_nor_asked_again():
    """When the passenger declines, the solid line is not crossed and the question is not repeated."""
    world, told = solid_line(60.0, lambda solver: solver.deny() if solver.pending_question.plan else None)
    assert EventKind.STARTED not in [e.kind for e in told if e.text != "pull_over"]
    assert kinds(told).count(EventKind.ANSWERED) == 1
    assert [e.question.kind for e in told if e.kind is EventKind.ASKED].count(QuestionKind.APPROVAL) == 1
    assert abs(world.y) < LANE_M / 2


def test_a_question_that_nobody_answers_is_withdrawn():
    brief = profile("default").asking.model_copy(update={"approval_within_s": 3.0})
    _, told = solid_line(10.0, lambda solver: None, ladder=ladder(asking=brief))
    asked = next(e for e in told if e.kind is EventKind.ASKED)
    gone = next(e for e in told if e.kind is EventKind.CANCELLED)
    assert gone.time_s - asked.time_s == pytest.approx(3.0, abs=0.15)


def test_what_needs_the_operator_is_not_released_by_the_passenger():
    def tries(solver):
        if solver.pending_question.to == "operator":
            with pytest.raises(QuestionError, match="for the operator"):
                solver.approve(by="passenger")

    _, told = solid_line(12.0, tries, ladder=ladder(solid_line="operator"))
    assert EventKind.ASKED in kinds(told)
    assert EventKind.STARTED not in kinds(told)
    _, told = solid_line(11.0, lambda s: s.approve(by="operator"), ladder=ladder(solid_line="operator"))
    assert EventKind.RECOVERED in kinds(told)


def test_a_yes_to_nothing_is_refused():
    solver = StuckSolver(lambda surroundings: None)
    with pytest.raises(QuestionError, match="no question is open"):
        solver.approve()
    with pytest.raises(QuestionError, match="no question is open"):
        solver.deny("q1")


# ---- the stop


def stopped_world(resume, change, seconds=40.0, **options):
    """Blocked by a wall of a truck until `change` says otherwise."""
    world = World(straight_road(oncoming=None), [thing("truck", 76.0)], x=66.0)
    rungs = QUICK | {"passenger": None, "remote": {"resume": resume, "look_every_s": 1.0, "pull_over": False}}
    told, directives = [], []
    with StuckSolver(world.scene, clock="lockstep", ladder=ladder(rungs=rungs), on_event=told.append, **options) as it:
        for _ in range(round(seconds / world.dt)):
            change(world, it)
            directive = it.step(world.status(), world.surroundings)
            directives.append(directive)
            world.drive(CONTINUE if not isinstance(directive, Execute) else directive)
            if isinstance(directive, SafeStop):
                world.speed = 0.0
    return world, told, directives


def goes_away(world, solver):
    if world.time_s > 20.0:
        world.objects = []


def test_at_the_end_it_stops_safely_and_calls_for_help():
    _, told, directives = stopped_world(Resume.OPERATOR, lambda world, solver: None, 25.0)
    assert isinstance(directives[-1], SafeStop)
    call = next(e for e in told if e.kind is EventKind.ASKED)
    assert (call.question.kind, call.question.to) == (QuestionKind.ASSISTANCE, "operator")
    assert "truck" in call.text


def test_resume_operator_stop_ends_only_with_approval():
    """A stop that only the operator may end lasts until the operator approves, even when the path is clear."""
    _, told, directives = stopped_world(Resume.OPERATOR, goes_away)
    assert isinstance(directives[-1], SafeStop)

    def with_yes(world, solver):
        goes_away(world, solver)
        if world.time_s > 30.0 and solver.pending_question is not None:
            solver.approve(by="operator")

    _, told, directives = stopped_world(Resume.OPERATOR, with_yes, 45.0)
    assert EventKind.RELEASED in kinds(told)
    assert directives[-1] is CONTINUE


@pytest.mark.integration
def test_resume_clear_stop_ends_with_clear_path():
    """With `Resume.CLEAR`, the stop ends when the path is clear."""
    _, told, directives = stopped_world(Resume.CLEAR, goes_away)
    released = next(e for e in told if e.kind is EventKind.RELEASED)
    assert 20.0 < released.time_s < 23.0
    assert directives[-1] is CONTINUE
    assert EventKind.CLOSED in kinds(told)


@pytest.mark.integration
def test_resume_plan_stop_ends_with_accepted_plan():
    """With `Resume.PLAN`, an accepted plan ends the stop; with `Resume.CLEAR`, it does not."""

    def road_opens(world, solver):
        if world.time_s > 20.0:
            world.road = TWO_WAY

    world, told, _ = stopped_world(Resume.PLAN, road_opens, 45.0)
    assert "a plan was accepted" in [e.text for e in told if e.kind is EventKind.RELEASED]
    assert world.x > 90.0
    world, told, directives = stopped_world(Resume.CLEAR, road_opens, 45.0)
    assert isinstance(directives[-1], SafeStop)


def test_resume_operator_stop_ignores_guidance():
    """A passenger's guidance does not end a stop that only the operator may end."""

    def words(world, solver):
        if world.time_s == 15.0:
            solver.guide("go around it")
            world.road = TWO_WAY

    _, told, directives = stopped_world(Resume.OPERATOR, words, 25.0)
    ended = next(e.text for e in told if e.kind is EventKind.GUIDANCE_ENDED)
    assert "only the operator" in ended
    assert isinstance(directives[-1], SafeStop)


@pytest.mark.integration
def test_resume_clear_stop_ends_with_guidance():
    """With `Resume.CLEAR`, a plan from a passenger's guidance ends the stop."""

    def words(world, solver):
        if world.time_s == 15.0:
            solver.guide("go around it")
            world.road = TWO_WAY

    world, told, _ = stopped_world(Resume.CLEAR, words, 35.0)
    assert "a plan was accepted" in [e.text for e in told if e.kind is EventKind.RELEASED]
    assert world.x > 90.0
