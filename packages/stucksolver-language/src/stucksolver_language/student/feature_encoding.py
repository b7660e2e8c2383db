"""A scene and its candidate plans as numbers: rows for the ego, objects, lanes, controls and past attempts.

Unknown values are 0, with a second number that marks them. Unused rows are masked.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from stucksolver.plan import RecoveryPlan
from stucksolver.plan.behaviors import Behavior
from stucksolver.scene import (
    AttemptOutcome,
    Claim,
    ControlKind,
    DirectedSide,
    FailedAttempt,
    GuidanceIntent,
    Interpretation,
    LaneDirection,
    LaneKind,
    LaneRelation,
    LightState,
    LineKind,
    ObjectKind,
    RejectCode,
    Scene,
    SceneLane,
    SceneObject,
    TrafficControl,
)
from stucksolver_language.student.vocabulary import Vocabulary

VERSION = 1
"""Version of the encoding.

It increases with every change of the numbers below. Weights of another version are rejected.
"""
MOST = {"objects": 24, "lanes": 8, "controls": 4, "attempts": 4}
"""Maximum number of rows of each kind. Farther objects and older attempts are omitted. Ours."""
SLOTS = 4
"""Number of behaviors of a plan that are encoded. Later ones are ignored."""
Floats = NDArray[np.float32]


@dataclass(frozen=True)
class EncodedScene:
    """A scene as numbers.

    Attributes:
        rows: By kind of row, (rows of that kind, its width); `ego` has one row.
        mask: True for each row in use, in the order ego, objects, lanes, controls, attempts.
        ids: Ids of the objects that have a row, in order.
    """

    rows: dict[str, Floats]
    mask: NDArray[np.bool_]
    ids: tuple[str, ...]


def encode(scene: Scene) -> EncodedScene:
    """Return a scene as numbers. An utterance counts only through its interpretation."""
    near = sorted(scene.objects, key=_importance)[: MOST["objects"]]
    lists: dict[str, list[list[float]]] = {
        "objects": [_object(o) for o in near],
        "lanes": [_lane(lane) for lane in sorted(scene.lanes, key=_lane_order)[: MOST["lanes"]]],
        "controls": [_control(c) for c in scene.controls[: MOST["controls"]]],
        "attempts": [_attempt(a, scene.time_s) for a in scene.attempts[-MOST["attempts"] :]],
    }
    rows = {"ego": np.array([_ego(scene)], np.float32)}
    mask = [np.ones(1, np.bool_)]
    for name, found in lists.items():
        table = np.zeros((MOST[name], WIDTHS[name]), np.float32)
        if found:
            table[: len(found)] = found
        rows[name] = table
        mask.append(np.arange(MOST[name]) < len(found))
    return EncodedScene(rows, np.concatenate(mask), tuple(o.id for o in near))


def encode_plans(
    plans: Sequence[RecoveryPlan], ids: Sequence[str], words: Vocabulary
) -> tuple[Floats, NDArray[np.int64]]:
    """Return plans as numbers (n, SLOTS, width), and the rows of the objects that they name (n, SLOTS).

    An object without a row, or none at all, is encoded as the number of object rows.

    Raises:
        KeyError: A behavior is not in the vocabulary.
    """
    found = np.zeros((len(plans), SLOTS, words.width + 1), np.float32)
    named = np.full((len(plans), SLOTS), MOST["objects"], np.int64)
    places = {name: place for place, name in enumerate(ids)}
    known: dict[Behavior, tuple[list[float], int]] = {}
    for number, plan in enumerate(plans):
        for slot, behavior in enumerate(plan.behaviors[:SLOTS]):
            if behavior not in known:
                # Plans share behaviors, so each behavior is encoded only once.
                ids_in = (places[v] for k, v in behavior if k.endswith("_id") and v in places)
                known[behavior] = [*words.row(behavior), 1.0], next(ids_in, MOST["objects"])
            found[number, slot], named[number, slot] = known[behavior]
    return found, named


# ---- rows


def _ego(scene: Scene) -> list[float]:
    ego = scene.ego
    reading = None if scene.guidance is None else scene.guidance.reading
    return [
        ego.speed_mps / 5.0,
        *_long(ego.stopped_for_s),
        *_long(ego.progress_20s_m),
        *_long(ego.distance_to_destination_m),
        ego.lateral_offset_m / 2.0,
        float(ego.at_destination),
        ego.length_m / 5.0,
        ego.width_m / 2.0,
        *_long(scene.speed_limit_mps),
        len(scene.attempts) / 3.0,
        *(float(item in scene.claims) for item in Claim),
        *_words(reading),
    ]


def _words(reading: Interpretation | None) -> list[float]:
    intent = None if reading is None else reading.intent
    side = None if reading is None else reading.side
    return [float(reading is not None), *_one_of(intent, GuidanceIntent), *_one_of(side, DirectedSide)]


def _object(o: SceneObject) -> list[float]:
    return [
        *_one_of(o.kind, ObjectKind),
        *_one_of(o.lane, LaneRelation),
        *_long(o.gap_m),
        _short(o.gap_m or 0.0, 10.0),
        _short(o.left_edge_m, 2.0),
        _short(o.right_edge_m, 2.0),
        _short(o.speed_along_mps, 3.0),
        _short(o.speed_across_mps, 1.0),
        float(o.in_path),
        _short(o.x_m, 20.0),
        _short(o.y_m, 5.0),
        math.cos(o.yaw_rad),
        math.sin(o.yaw_rad),
        o.length_m / 5.0,
        o.width_m / 2.0,
        o.height_m / 2.0,
        *_long(o.stationary_s),
        *_long(o.moved_s_ago),
        *_long(o.seen_for_s),
        float(o.pushed),
        *(part for lit in (o.hazard_lights, o.emergency_lights, o.brake_lights) for part in _lit(lit)),
    ]


def _lane(lane: SceneLane) -> list[float]:
    return [
        *_one_of(lane.relation, LaneRelation),
        *_one_of(lane.direction, LaneDirection),
        *_one_of(lane.kind, LaneKind),
        *_one_of(lane.line, LineKind),
        lane.width_m / 3.5,
        float(lane.may_enter),
        *_long(lane.free_ahead_m),
        *_long(lane.free_behind_m),
        *_long(lane.sight_ahead_m),
    ]


def _control(control: TrafficControl) -> list[float]:
    return [
        *_one_of(control.kind, ControlKind),
        *_one_of(control.state, LightState),
        *_lit(control.applies),
        *_long(control.distance_m),
    ]


def _attempt(attempt: FailedAttempt, now_s: float) -> list[float]:
    return [
        *_long(now_s - attempt.time_s),
        *_one_of(attempt.ended, AttemptOutcome),
        *(float(code in attempt.codes) for code in RejectCode),
    ]


def _one_of(value: Enum | None, kind: type[Enum]) -> list[float]:
    return [float(value is item) for item in kind]


def _long(value: float | None) -> list[float]:
    """Return a time (s) or a distance (m) of any size on a logarithmic scale, and whether it is known."""
    return [0.0, 0.0] if value is None else [math.copysign(math.log1p(abs(value)), value) / 3.0, 1.0]


def _short(value: float, unit: float) -> float:
    """Return a value on a scale that is linear near 0 and bounded far from it."""
    return 3.0 * math.tanh(value / (3.0 * unit))


def _lit(value: bool | None) -> list[float]:
    return [0.0, 0.0] if value is None else [float(value), 1.0]


def _importance(o: SceneObject) -> float:
    """Sort key: nearest first, objects in the path before others."""
    return math.hypot(o.x_m, o.y_m) * (0.5 if o.in_path else 1.0)


def _lane_order(lane: SceneLane) -> tuple[bool, bool]:
    """Sort key: drivable lanes before the others."""
    return lane.kind is not LaneKind.DRIVING, lane.direction is not LaneDirection.SAME


WIDTHS = {
    "ego": 14 + len(Claim) + 1 + len(GuidanceIntent) + len(DirectedSide),
    "objects": len(ObjectKind) + len(LaneRelation) + 28,
    "lanes": len(LaneRelation) + len(LaneDirection) + len(LaneKind) + len(LineKind) + 8,
    "controls": len(ControlKind) + len(LightState) + 4,
    "attempts": 2 + len(AttemptOutcome) + len(RejectCode),
}
"""Width of each kind of row."""
