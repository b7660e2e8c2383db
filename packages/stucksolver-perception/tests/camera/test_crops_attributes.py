"""What is said of an object after one look and after several; what is not known is never guessed."""

import numpy as np

from stucksolver.scene import ObjectKind
from stucksolver.scene.objects import Gesture
from stucksolver_perception.camera.attribute_filter import AttributeFilter
from stucksolver_perception.camera.attributes import Attributes, attributes_of
from stucksolver_perception.camera.crop_network import GESTURES, KINDS, LAMPS, LIGHTS, NOTHING, CropAnswers


class Thresholds:
    """In place of a network, of which only these are used."""

    least_kind = np.full(len(KINDS), 0.9)
    least_lamp = np.full((len(LAMPS), 3), 0.9)
    least_gesture = np.full(len(GESTURES), 0.9)


def answers(
    kind: str,
    sure: float,
    lamps: tuple[tuple[float, float, float], ...],
    gesture: tuple[float, ...] = (0.2,) * len(GESTURES),
) -> CropAnswers:
    light = np.full((1, len(LIGHTS)), 0.2)
    return CropAnswers(shares(kind, sure)[None], np.array([lamps]), light, np.array([gesture]))


def shares(kind: str, sure: float) -> np.ndarray:
    told = np.full(len(KINDS), (1.0 - sure) / (len(KINDS) - 1))
    told[KINDS.index(kind)] = sure
    return told


def look(kind: str = "car", sure: float = 0.95, **known: bool | Gesture | None) -> Attributes:
    hidden = kind == NOTHING
    said = None if hidden or sure < 0.9 else ObjectKind(kind)
    return Attributes(said, sure, shares(kind, sure), hidden, **known)


ON, OFF, DOUBT = (0.02, 0.95, 0.03), (0.95, 0.03, 0.02), (0.5, 0.45, 0.05)


def test_an_answer_below_its_threshold_is_none() -> None:
    [one] = attributes_of(answers("bag", 0.89, (ON, OFF, DOUBT, DOUBT, (0.0, 0.0, 1.0))), Thresholds())
    assert one.kind is None
    assert one.kind_confidence == 0.89
    assert (one.brake_lights, one.left_blinker, one.right_blinker) == (True, False, None)
    assert one.door_open is None
    [sure] = attributes_of(answers("bag", 0.91, (OFF,) * 5), Thresholds())
    assert sure.kind is ObjectKind.BAG


def test_a_hidden_object_has_neither_kind_nor_lamps() -> None:
    [one] = attributes_of(answers(NOTHING, 0.99, (ON,) * 5), Thresholds())
    assert one.hidden is True
    assert one.kind is None
    assert one.brake_lights is None
    assert one.hazard_lights is None


def test_only_a_flagger_has_a_gesture() -> None:
    stop = tuple(0.92 if name == "stop" else 0.02 for name in GESTURES)
    unseen = tuple(0.92 if name == "unseen" else 0.02 for name in GESTURES)
    unsure = tuple(0.6 if name == "stop" else 0.1 for name in GESTURES)
    read = [
        attributes_of(answers(kind, 0.95, (OFF,) * 5, shown), Thresholds())[0].gesture
        for kind, shown in (("flagger", stop), ("flagger", unseen), ("flagger", unsure), ("pedestrian", stop))
    ]
    assert read == [Gesture.STOP, None, None, None]


def test_a_gesture_is_reported_after_two_looks_that_agree() -> None:
    memory = AttributeFilter()
    memory.add(1, look("flagger", gesture=Gesture.STOP), 0.0)
    assert memory.get(1, 0.1).gesture is None
    memory.add(1, look("flagger", gesture=Gesture.GO), 0.2)
    memory.add(1, look("flagger", gesture=Gesture.GO), 0.4)
    assert memory.get(1, 0.4).gesture is Gesture.GO


def test_hazard_lights_are_both_blinkers() -> None:
    assert Attributes(left_blinker=True, right_blinker=True).hazard_lights is True
    assert Attributes(left_blinker=True, right_blinker=False).hazard_lights is False
    assert Attributes(left_blinker=None, right_blinker=False).hazard_lights is False
    assert Attributes(left_blinker=True).hazard_lights is None


def test_who_was_never_seen_is_not_known() -> None:
    memory = AttributeFilter()
    memory.add(1, Attributes(), 0.0)
    assert memory.get(1, 0.0) is None
    assert memory.get(2, 0.0) is None


def test_one_look_is_not_enough_for_a_kind() -> None:
    memory = AttributeFilter()
    memory.add(1, look("bag", 0.999), 0.0)
    assert memory.get(1, 0.0).kind is None
    for step in range(1, 4):
        memory.add(1, look("bag", 0.999), 0.5 * step)
    assert memory.get(1, 1.5).kind is ObjectKind.BAG


def test_looks_that_are_never_sure_never_make_a_kind() -> None:
    memory = AttributeFilter()
    for step in range(20):
        memory.add(1, look("bag", 0.8), 0.5 * step)
    assert memory.get(1, 10.0).kind is None


def test_a_bag_that_looks_like_a_rock_again_is_a_bag_no_more() -> None:
    memory = AttributeFilter()
    for step in range(20):
        memory.add(1, look("bag", 0.999), 0.5 * step)
    assert memory.get(1, 9.5).kind is ObjectKind.BAG
    memory.add(1, look("debris", 0.999), 10.0)
    assert memory.get(1, 10.0).kind is None


def test_a_hidden_moment_does_not_change_the_kind() -> None:
    memory = AttributeFilter()
    for step in range(6):
        memory.add(1, look("bus", 0.99), 0.5 * step)
    memory.add(1, look(NOTHING, 0.99), 3.0)
    known = memory.get(1, 3.0)
    assert known.kind is ObjectKind.BUS
    assert known.hidden is True


def test_a_blinker_that_is_dark_now_and_then_blinks() -> None:
    memory = AttributeFilter()
    for step, lit in enumerate((True, False, False)):
        memory.add(1, look(left_blinker=lit, right_blinker=lit), 0.4 * step)
    assert memory.get(1, 0.8).hazard_lights is True


def test_a_blinker_is_off_only_after_a_while() -> None:
    memory = AttributeFilter()
    for step in range(2):
        memory.add(1, look(left_blinker=False), 0.5 * step)
    assert memory.get(1, 0.5).left_blinker is None
    memory.add(1, look(left_blinker=False), 1.0)
    assert memory.get(1, 1.0).left_blinker is False


def test_nothing_is_known_of_lamps_after_a_while_without_a_look() -> None:
    memory = AttributeFilter()
    for step in range(4):
        memory.add(1, look(brake_lights=True, left_blinker=True, emergency_lights=True, door_open=False), 0.5 * step)
    now = memory.get(1, 1.5)
    assert (now.brake_lights, now.left_blinker, now.emergency_lights, now.door_open) == (True, True, True, False)
    late = memory.get(1, 3.5)
    assert (late.brake_lights, late.left_blinker, late.emergency_lights, late.door_open) == (None,) * 4
    memory.add(1, look(emergency_lights=True), 9.0)
    assert memory.get(1, 9.0).emergency_lights is None


def test_tracks_that_are_gone_are_forgotten() -> None:
    memory = AttributeFilter()
    memory.add(1, look(), 0.0)
    memory.add(2, look(), 0.0)
    memory.keep({2: None})
    assert memory.get(1, 0.0) is None
    assert memory.get(2, 0.0) is not None
