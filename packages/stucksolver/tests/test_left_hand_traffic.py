"""Left-hand traffic: a stack mirrors its data for the solver and the paths that it gets; people hear true sides."""

from __future__ import annotations

import re

import numpy as np
import pytest

from left_hand_worlds import LeftHandWorld, left_hand
from stucksolver.plan import Decision, Execute, PathPoint, RecoveryPlan
from stucksolver.plan.behaviors import REGISTRY, BorrowOncomingLane, ChangeLane, KeepLane
from stucksolver.plan.mirror import mirrored_decision, mirrored_directive, mirrored_plan
from stucksolver.reasoners.reasoner import ReasonerAnswer, ReasonerRequest
from stucksolver.record import Recorder, replay
from stucksolver.scene import LineKind, ObjectKind, ObservedSign, RoadGeometry, Scene, SignWord
from stucksolver.scene.mirror import mirrored_scene, mirrored_surroundings, with_sides_swapped
from stucksolver.solver import EventKind, StuckSolver
from worlds import LANE_M, World, drive, ladder, noticed, searched, straight_road, thing

SIDES = {
    "going round it on the left": "going round it on the right",
    "Pull over to the right edge of the road": "Pull over to the left edge of the road",
    "there is no driving lane on the left": "there is no driving lane on the right",
    "overtake on the right (91 %)": "overtake on the left (91 %)",
    "Overtake left": "Overtake right",
    "ChangeLane(side='left')": "ChangeLane(side='right')",
    "the right lane, from the left": "the left lane, from the right",
    "car 7 (queueing, lane left, 10 m ahead)": "car 7 (queueing, lane right, 10 m ahead)",
}
NO_SIDES = (
    "waiting is right: car 4 ahead is waiting in a queue",
    "it has the right of way",
    "they have left no gap for 20 s",
    "12 m left, required 14 m",
    "lane left1-oncoming is not visible",
    "it stands on the right of way",
)


def parked(x: float = 68.0, y: float = 0.0):
    return thing("7", x, y, kind=ObjectKind.CAR, stationary_s=60.0)


def both_worlds(**road):
    """The same situation in right-hand and in left-hand traffic."""
    right, left = straight_road(**road), left_hand(straight_road(**road))
    return World(right, [parked(y=-0.2)]), LeftHandWorld(left, [parked(y=0.2)])


# ---- the mirror


@pytest.mark.parametrize("text", [*SIDES, *NO_SIDES])
def test_sides_swapped_changes_sides_only(text):
    assert with_sides_swapped(text) == SIDES.get(text, text)
    assert with_sides_swapped(with_sides_swapped(text)) == text


@pytest.mark.parametrize("behavior", REGISTRY.values(), ids=REGISTRY)
def test_sides_swapped_covers_every_text_of_a_behavior(behavior):
    """A text of a behavior that names a side is in a form that the swap recognizes."""
    phrase = behavior.phrase
    for text in (behavior.summary, phrase.future, phrase.present, behavior.approval_note or ""):
        for side, other in (("left", "right"), ("right", "left")):
            filled = text.replace("{side}", side)
            assert re.findall(r"\b(?:left|right)\b", with_sides_swapped(filled)) == [
                other if word == side else side for word in re.findall(r"\b(?:left|right)\b", filled)
            ]


def test_mirror_twice_is_the_original():
    """The mirror is its own inverse, and its flag tells which of the two images it is."""
    world = World(straight_road(left=LineKind.BROKEN), [parked(y=0.4)], y=0.3, yaw=0.1)
    sign = ObservedSign(word=SignWord.DETOUR, distance_m=9.0, bearing_rad=0.2)
    scene = world.scene().model_copy(update={"route_command": "change_left", "signs": (sign,)})
    assert mirrored_surroundings(mirrored_surroundings(world.surroundings())) == world.surroundings()
    assert mirrored_scene(mirrored_scene(scene)) == scene
    image = mirrored_scene(scene)
    assert image.mirrored and image.route_command == "change_right" and image.signs[0].bearing_rad == -0.2
    assert mirrored_surroundings(world.surroundings()).road.key != world.road.key
    decision = searched(world, scene)
    assert mirrored_decision(mirrored_decision(decision)) == decision


def test_mirrored_scene_equals_scene_of_mirrored_surroundings():
    """It makes no difference whether a scene is mirrored, or built from mirrored surroundings."""
    world = World(straight_road(left=LineKind.BROKEN), [parked(y=0.4), thing("9", 90.0, LANE_M, speed=3.0)], y=0.3)
    built = world.scene(mirrored_surroundings(world.surroundings()))
    assert built.model_copy(update={"mirrored": True}) == mirrored_scene(world.scene())


def test_plan_and_directive_mirror_side_and_path():
    change, keep = ChangeLane(side="left", distance_m=30.0, speed_mps=5.0), KeepLane(distance_m=20.0, speed_mps=5.0)
    plan = RecoveryPlan(behaviors=(change, keep))
    image = mirrored_plan(plan)
    assert isinstance(image.behaviors[0], ChangeLane) and image.behaviors[0].side == "right"
    assert image.behaviors[1] == plan.behaviors[1]
    path = (PathPoint(x_m=1.0, y_m=2.0, speed_mps=3.0), PathPoint(x_m=2.0, y_m=-2.5, speed_mps=3.0, no_stop=True))
    directive = Execute(behavior=plan.behaviors[0], path=path)
    turned = mirrored_directive(directive)
    assert isinstance(turned, Execute)
    assert [(p.x_m, p.y_m, p.no_stop) for p in turned.path] == [(1.0, -2.0, False), (2.0, 2.5, True)]
    assert mirrored_directive(turned) == directive


def test_data_without_the_flag_are_readable():
    """Records and stacks from before the flag mean right-hand traffic."""
    world = World(straight_road(), [parked()])
    road, scene = world.road.model_dump(mode="json"), world.scene().model_dump(mode="json")
    del road["mirrored"], scene["mirrored"]
    assert not RoadGeometry.model_validate(road).mirrored
    assert not Scene.model_validate(scene).mirrored


# ---- driven


@pytest.mark.parametrize("road", [{}, {"oncoming": None, "left": LineKind.BROKEN}], ids=["oncoming", "same direction"])
def test_left_hand_world_drives_the_mirror_image(road):
    """The same plans, the same speeds and the mirrored path: the pass leads past the obstacle on the right."""
    right, left = both_worlds(**road)
    traces = []
    for world in (right, left):
        trace: list[tuple[float, float, float]] = []
        told = drive(world, 40.0, every_tick=lambda w, t=trace: t.append((w.x, w.y, w.speed)))
        assert EventKind.RECOVERED in told.kinds()
        assert told.nearest_m > 0.3
        traces.append(trace)
    assert max(y for _, y, _ in traces[0]) > 2.0
    assert np.allclose(np.array(traces[1]) * (1.0, -1.0, 1.0), traces[0], atol=1e-6)


@pytest.mark.parametrize(("side", "passes"), [("right", True), ("left", False)])
def test_left_hand_passenger_names_true_side(side, passes):
    """In left-hand traffic, the oncoming lane is on the right, so only "on the right" asks for it."""
    world = LeftHandWorld(left_hand(straight_road()), [thing("7", 90.0, speed=3.0)], speed=3.0)
    told = drive(world, 20.0, words={2.0: f"overtake on the {side}"})
    assert (EventKind.STARTED in told.kinds()) is passes
    heard = next(e for e in told.events if e.kind is EventKind.GUIDANCE)
    assert heard.text == f"overtake on the {side}"
    assert heard.mirrored and heard.reading.side.value != side
    if passes:
        assert min(d.path[-1].y_m for d in told.directives if isinstance(d, Execute) and d.path) >= -0.1


class Says:
    """A reasoner with one plan and one sentence, in the solver's own sides."""

    name = "says"

    def __init__(self, behavior, rationale: str) -> None:
        self._behavior, self._rationale = behavior, rationale

    def decide(self, request: ReasonerRequest) -> ReasonerAnswer:
        base = noticed(request.scene)
        plan = RecoveryPlan(behaviors=(self._behavior,))
        return ReasonerAnswer(base.model_copy(update={"plan": plan, "rationale": self._rationale}), self.name)


def test_left_hand_events_name_true_sides():
    """Texts and reject reasons name the side that people see; the plan in the event stays the solver's own."""
    says = Says(ChangeLane(side="right", distance_m=30.0, speed_mps=5.0), "change lanes to the right")
    told = drive(LeftHandWorld(left_hand(straight_road()), [parked()]), 6.0, reasoner=says)
    decided = next(e for e in told.events if e.kind is EventKind.DECIDED and e.verdict is not None)
    assert decided.mirrored and decided.text == "change lanes to the left"
    assert "there is no driving lane on the left" in str(decided.verdict)
    assert decided.decision.plan.behaviors[0].side == "right"


def test_left_hand_question_names_true_side():
    """A question to a person names the side that people see, as an event and as the open question."""
    says = Says(BorrowOncomingLane(past_object_id="7", speed_mps=5.0), "pass it on the left")
    world = LeftHandWorld(left_hand(straight_road(oncoming=LineKind.SOLID)), [parked()])
    asked = []
    with StuckSolver(
        world.scene, ladder=ladder(solid_line="passenger"), reasoner=says, clock="lockstep", on_event=asked.append
    ) as solver:
        while solver.pending_question is None and world.time_s < 30.0:
            world.drive(solver.step(world.status(), world.surroundings))
        question = solver.pending_question
    assert question is not None and question.text.startswith("pass it on the right. May I?")
    assert next(e.question for e in asked if e.kind is EventKind.ASKED) == question


def test_left_hand_notice_names_true_side():
    """What the vehicle waits for is said with the side that people see, in the event and in its notice."""
    world = LeftHandWorld(left_hand(straight_road()), [parked()], sight_m=40.0)
    told = drive(world, 40.0)
    notices = [e.notice.reason.text for e in told.events if e.kind is EventKind.WAITING]
    assert notices and all("on the right" in text and "on the left" not in text for text in notices)
    assert notices == [e.text for e in told.events if e.kind is EventKind.WAITING]


def test_left_hand_record_replays(tmp_path):
    """The record holds what the solver had, and its replay computes the same again."""
    recorder = Recorder(tmp_path)
    drive(LeftHandWorld(left_hand(straight_road()), [parked()]), 40.0, record=recorder)
    recorder.close()
    report = replay(recorder.files[0])
    assert report.matches and report.ended


def test_decision_names_true_sides_for_people():
    decision = Decision.model_validate(searched(World(straight_road(), [parked()])).model_dump())
    plan = RecoveryPlan(behaviors=(ChangeLane(side="left", distance_m=30.0, speed_mps=5.0),))
    shown = mirrored_decision(decision.model_copy(update={"plan": plan, "rationale": "change to the left lane"}))
    assert shown.plan.behaviors[0].side == "right"
    assert shown.rationale == "change to the right lane"


def test_left_hand_drawing_shows_oncoming_lane_on_the_right(tmp_path):
    """A drawing of a record is as people see it: the road's left side is up, and the oncoming lane is down."""
    pytest.importorskip("matplotlib")
    from matplotlib.figure import Figure

    from stucksolver.record import drawing

    recorder = Recorder(tmp_path)
    drive(LeftHandWorld(left_hand(straight_road()), [parked()]), 12.0, record=recorder)
    recorder.close()
    (axes,) = np.atleast_1d(Figure().subplots(1, 1))
    moment = drawing._read(recorder.files[0])[-1]
    drawing._draw(axes, moment, 0.0)
    assert axes.yaxis_inverted()
