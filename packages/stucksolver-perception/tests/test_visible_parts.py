"""What the camera can see of recorded lamps, doors and gestures: from the mask, and as measured in staged scenes."""

from __future__ import annotations

import numpy as np
import pytest

from stucksolver.scene import ObjectKind
from stucksolver.scene.objects import Gesture
from stucksolver_perception.camera.crops import windows_of
from stucksolver_perception.measurements import LidarSweep
from stucksolver_perception.recording import GESTURES, KINDS, PARTS, Recorded, Truth
from stucksolver_perception.rig import load_rig
from stucksolver_perception.visible_parts import BRAKE, LEFT, RIGHT, SPECIAL, VisibleAttributes, VisibleParts

RIG = load_rig().camera
CAR, OTHER = 300, 301
FRONT_LEFT, FRONT_RIGHT = 1, 2


def seen(
    *,
    yaw: float = 0.0,
    lamps: int = 0,
    doors: int = 0,
    kind: ObjectKind = ObjectKind.CAR,
    shown: int = -1,
    gesture: Gesture | None = None,
    hide: tuple[slice, slice] | None = None,
    wide_px: int = 0,
    sign: tuple[float, float] | None = None,
    before: tuple[float, float] | None = None,
) -> VisibleAttributes:
    """A car or a flagger 15 m ahead, which fills its rectangle in the mask and `wide_px` more to either side.

    In `hide`, rows and columns as shares of the rectangle, something else is in front of it. A `sign` of 0.6 m that
    belongs to it, or one of 1 m nearby `before` it, has its middle so far to the left of it, and so high (m).
    """
    size = (0.5, 0.5, 1.8) if kind is ObjectKind.FLAGGER else (4.5, 1.9, 1.5)
    box = np.array([[15.0, 0.0, size[2] / 2.0, *size, yaw]])
    windows = windows_of(RIG, box)
    left, top, right, bottom = windows.rectangle[0].astype(int).tolist()
    mask = np.zeros((RIG.height_px, RIG.width_px), np.uint16)
    mask[top : bottom + 1, left - wide_px : right + 1 + wide_px] = CAR
    if hide is not None:
        part = mask[top : bottom + 1, left : right + 1]
        rows, columns = (
            slice(*(round(item * length) for item in (share.start, share.stop)))
            for share, length in zip(hide, part.shape, strict=True)
        )
        part[rows, columns] = OTHER
    for middle, half_m, owner in ((sign, 0.3, CAR), (before, 0.5, OTHER)):
        if middle is not None:
            corners = np.array(
                [(15.0, middle[0] + a, middle[1] + b) for a, b in ((half_m, half_m), (-half_m, -half_m))]
            )
            column, row, _ = RIG.project(corners)
            mask[int(row[0]) : int(row[1]) + 1, int(column[0]) : int(column[1]) + 1] = owner
    truth = Truth(
        np.array([CAR]),
        np.array([KINDS.index(kind)]),
        np.zeros((1, 9)),
        np.array([lamps]),
        np.array([doors]),
        np.array([-1 if gesture is None else GESTURES.index(gesture)]),
        np.array([shown]),
        ("",),
    )
    tick = Recorded(
        0.0,
        np.zeros(9),
        LidarSweep(0.0, np.zeros((0, 4), np.float32)),
        np.zeros(7),
        np.zeros(3),
        0.0,
        truth,
        None,
        b"",
        mask,
    )
    return VisibleParts(tick, RIG, box).get(0, windows.rectangle[0])


def test_visible_lamps_rear_from_behind_and_brake_not_ahead() -> None:
    """Rear lamps are visible from behind, and brake lamps are not visible from ahead."""
    behind = seen(lamps=BRAKE | LEFT).lamps
    assert (behind["brake_lights"], behind["left_blinker"], behind["right_blinker"]) == (True, True, False)
    ahead = seen(yaw=np.pi, lamps=BRAKE | RIGHT).lamps
    assert (ahead["brake_lights"], ahead["left_blinker"], ahead["right_blinker"]) == (None, False, True)


def test_from_its_left_only_a_vehicles_left_blinkers_are_seen() -> None:
    # It drives to the right of the image: its right side is towards the camera.
    told = seen(yaw=-np.pi / 2, lamps=LEFT | RIGHT).lamps
    assert (told["left_blinker"], told["right_blinker"]) == (None, True)
    told = seen(yaw=np.pi / 2, lamps=LEFT | RIGHT).lamps
    assert (told["left_blinker"], told["right_blinker"]) == (True, None)


def test_a_lamp_behind_something_is_not_seen_but_known() -> None:
    told = seen(lamps=BRAKE | LEFT, hide=(slice(0, 1), slice(0, 0.4)))
    assert told.lamps["left_blinker"] is None
    assert told.lamps["right_blinker"] is False
    assert told.lamps["brake_lights"] is True, "the right one is seen"
    assert told.truth_flags["left_blinker"] is True
    hidden = seen(lamps=BRAKE, hide=(slice(0.4, 1), slice(0, 1)))
    assert hidden.lamps["brake_lights"] is None


@pytest.mark.parametrize(("doors", "expected"), [(0, False), (FRONT_LEFT, True), (FRONT_RIGHT, True)])
def test_an_open_door_is_seen_from_behind(doors: int, expected: bool) -> None:
    wide = 60 if doors else 0
    assert seen(doors=doors, wide_px=wide).lamps["door_open"] is expected


def test_visible_door_on_far_side_is_unknown() -> None:
    """An open door on the far side leaves the state unknown."""
    # Its left side is towards the camera.
    told = seen(yaw=np.pi / 2, doors=FRONT_RIGHT)
    assert "door_open" not in told.lamps
    assert told.truth_flags["door_open"] is True
    assert seen(yaw=np.pi / 2, doors=FRONT_LEFT).lamps["door_open"] is True


def test_only_emergency_vehicles_and_school_buses_have_emergency_lights() -> None:
    assert seen(lamps=SPECIAL).lamps["emergency_lights"] is False
    assert seen(lamps=SPECIAL).truth_flags["emergency_lights"] is False
    assert seen(kind=ObjectKind.EMERGENCY, lamps=SPECIAL).lamps["emergency_lights"] is True
    covered = seen(kind=ObjectKind.EMERGENCY, lamps=SPECIAL, hide=(slice(0, 0.5), slice(0, 1)))
    assert covered.lamps["emergency_lights"] is None


def test_what_was_measured_as_unseen_is_not_seen() -> None:
    brake = 1 << PARTS.index("brake_lights")
    told = seen(lamps=BRAKE | LEFT, shown=brake).lamps
    assert (told["brake_lights"], told["left_blinker"]) == (True, None)
    # A change of pixels alone may come from another vehicle's lamp.
    assert seen(yaw=np.pi, lamps=BRAKE, shown=brake).lamps["brake_lights"] is None


def test_unknown_lamps_and_doors_are_missing() -> None:
    told = seen(lamps=-1, doors=-1)
    assert told.lamps == {}
    assert told.truth_flags == {}


def test_a_flaggers_gesture_is_seen_if_its_paddle_is() -> None:
    flagger = ObjectKind.FLAGGER
    told = seen(kind=flagger, gesture=Gesture.STOP, sign=(-0.2, 2.18))
    assert (told.gesture, told.is_flagger, told.lamps) == (Gesture.STOP, True, {})
    assert seen(kind=flagger, gesture=Gesture.GO, sign=(-0.85, 2.18)).gesture is Gesture.GO
    assert seen(kind=flagger, gesture=Gesture.SLOW, sign=(-0.2, 1.82)).gesture is Gesture.SLOW
    # Turned by a quarter to the left, its right hand is towards the camera, and the stretched arm before its body.
    assert seen(kind=flagger, gesture=Gesture.STOP, yaw=np.pi / 2, sign=(0.76, 2.18)).gesture is Gesture.STOP
    covered = seen(kind=flagger, gesture=Gesture.STOP, sign=(-0.2, 2.18), before=(-0.2, 2.18))
    assert (covered.gesture, covered.is_flagger) == (None, True)
    body = (slice(0, 1), slice(0, 0.95))
    assert seen(kind=flagger, gesture=Gesture.STOP, sign=(-0.2, 2.18), hide=body).gesture is None
    assert seen(kind=ObjectKind.PEDESTRIAN).is_flagger is False


def test_visible_flagger_without_paddle_needs_unoccluded_place() -> None:
    """A flagger without a paddle is labeled so only if nothing occludes the place of the paddle."""
    flagger = ObjectKind.FLAGGER
    assert seen(kind=flagger, gesture=Gesture.NONE).gesture is Gesture.NONE
    assert seen(kind=flagger, gesture=Gesture.NONE, before=(0.9, 2.18)).gesture is Gesture.NONE
