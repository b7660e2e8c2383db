"""A model that looks at the picture contradicts perception: it is recorded, and what perception grants is withdrawn."""

from __future__ import annotations

import base64
from dataclasses import dataclass

import pytest

from stucksolver.plan import Intent, Observation, ObservedControl, Participant
from stucksolver.reasoners import ReasonerAnswer
from stucksolver.reasoners.search import SearchReasoner
from stucksolver.record import Recorder, replay
from stucksolver.scene import CameraImage, ControlKind, LaneRelation, LightState, ObjectKind
from stucksolver.solver import EventKind
from stucksolver.solver.state_machine.perception_disagreement import (
    DISPUTE_DURATION_S,
    LIGHT,
    find_disagreements,
    mask_disputed,
    update_disputes,
)
from worlds import World, drive, red_light, straight_road, stubborn, thing

K = ObjectKind
PICTURE = CameraImage(width=8, height=8, jpeg=base64.b64encode(bytes(range(64))))
BAG = {"kind": K.BAG, "height": 0.1, "seen_for_s": 5.0, "kind_confidence": 0.95}


@dataclass
class Pictured(World):
    """A world whose scenes have a picture."""

    def scene(self, surroundings=None):
        return super().scene(surroundings).model_copy(update={"image": PICTURE})


class SeesAnother:
    """A model with the rules' plan that takes one object of the picture for something else."""

    name = "sees another"

    def __init__(self, object_id, kind):
        self._seen = Participant(
            object_id=object_id, kind=kind, lane=LaneRelation.EGO, distance_m=None, intent=Intent.UNKNOWN
        )

    def decide(self, request):
        answer = SearchReasoner().decide(request)
        observation = answer.decision.observation.model_copy(update={"participants": (self._seen,)})
        return ReasonerAnswer(answer.decision.model_copy(update={"observation": observation}), self.name)


def street(**more):
    return Pictured(straight_road(), [thing("it", 62.0, **{**BAG, **more})], cruise_mps=5.0)


def observed(*pairs, light=None):
    """What a model says of objects, as (id, kind), and of the light."""
    found = [
        Participant(object_id=pair, kind=kind, lane=LaneRelation.EGO, distance_m=None, intent=Intent.UNKNOWN)
        for pair, kind in pairs
    ]
    lights = [ObservedControl(kind=ControlKind.TRAFFIC_LIGHT, state=light, applies=True, distance_m=None)]
    return Observation(controls=tuple(lights if light else ()), participants=tuple(found), summary="")


@pytest.mark.integration
def test_drive_over_disputed_object_is_blocked_and_reported():
    """A bag that the reasoner takes for debris is not driven over, and the disagreement is reported."""
    agrees = drive(street(), 25.0, ladder=stubborn(), reasoner=SeesAnother("it", K.BAG))
    assert agrees.nearest_m < 0.0, "else this shows nothing"
    contradicts = drive(street(), 25.0, ladder=stubborn(), reasoner=SeesAnother("it", K.DEBRIS))
    assert contradicts.texts(EventKind.PERCEPTION_DISPUTED)[0] == (
        "perception says that object it is bag, the reasoner sees debris; it counts as unknown"
    )
    assert contradicts.nearest_m > 0.0


@pytest.mark.integration
def test_a_record_with_a_contradiction_is_derived_again(tmp_path):
    with Recorder(tmp_path) as recorder:
        drive(street(), 15.0, ladder=stubborn(), reasoner=SeesAnother("it", K.DEBRIS), record=recorder)
    files = sorted(tmp_path.glob("*.jsonl*"))
    assert files
    reports = [replay(file) for file in files]
    assert [finding for report in reports for finding in report.findings] == []


@pytest.mark.parametrize("said", [K.BAG, K.LITTER, K.UNKNOWN])
def test_what_is_treated_alike_or_not_known_is_no_contradiction(said):
    assert find_disagreements(street().scene(), observed(("it", said))) == ()


def test_a_model_that_had_no_picture_contradicts_nothing():
    scene = street().scene().model_copy(update={"image": None})
    assert find_disagreements(scene, observed(("it", K.DEBRIS), light=LightState.RED)) == ()


@pytest.mark.parametrize("kind", [K.PEDESTRIAN, K.ANIMAL, K.SCHOOL_BUS, K.CAR, K.CROSSING_GATE, K.FLAGGER])
def test_disagreement_bag_changes_no_restrictive_kind(kind):
    """An object of a kind that forbids driving over keeps it if the reasoner reports a bag."""
    world = street(kind=kind, height=1.5)
    found = find_disagreements(world.scene(), observed(("it", K.BAG)))
    assert [item.counts for item in found] == [False]
    doubts = update_disputes({}, found, 10.0)
    assert mask_disputed(world.surroundings(), doubts, 11.0).objects[0].kind is kind


@pytest.mark.parametrize("shown", [LightState.GREEN, LightState.OFF])
def test_disagreement_red_light_counts_as_unknown_for_limited_time(shown):
    """A green or dark light that the reasoner reports as red counts as unknown for a while."""
    world = Pictured(straight_road(), controls=(red_light(20.0, shown),))
    doubts = update_disputes({}, find_disagreements(world.scene(), observed(light=LightState.RED)), 10.0)
    assert set(doubts) == {LIGHT}
    seen = world.surroundings()
    assert mask_disputed(seen, doubts, 10.0 + DISPUTE_DURATION_S - 0.1).controls[0].state is LightState.UNKNOWN
    assert mask_disputed(seen, doubts, 10.0 + DISPUTE_DURATION_S + 0.1) is seen


@pytest.mark.parametrize("shown", [LightState.RED, LightState.YELLOW])
def test_disagreement_green_keeps_red_or_yellow_light(shown):
    """A red or yellow light stays so, whatever the reasoner reports."""
    world = Pictured(straight_road(), controls=(red_light(20.0, shown),))
    found = find_disagreements(world.scene(), observed(light=LightState.GREEN))
    assert [item.counts for item in found] == [False]
    assert update_disputes({}, found, 0.0) == {}
