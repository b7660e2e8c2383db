"""What must not matter to a guard: left and right, where the map's origin is, the order in which things are listed.

`comparing` has every plan that is judged within it judged again in the same world mirrored, turned and moved, and with
its objects listed the other way round between others that are far away.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import pytest

from stucksolver.guard import NOBODY, Guard, RejectCode, Verdict
from stucksolver.guard.proven_plan import ProvenPlan
from stucksolver.scene import ObjectKind, RoadGeometry, Surroundings, TrackedObject
from stucksolver.scene.frenet_scene import FrenetScene
from worlds import thing

ALIKE = 0.02
"""Gaps (m) and times (s) are the same within this."""
TURNED_RAD = 2.0
MOVED_M = (300.0, -40.0)
FAR = (
    thing("far off", -400.0, 250.0, kind=ObjectKind.VAN),
    thing("far behind", -300.0, 90.0, kind=ObjectKind.PEDESTRIAN, speed=1.0),
)


def mirrored(surroundings: Surroundings) -> Surroundings:
    """Left for right, along the local x axis."""

    def other(obj: TrackedObject) -> TrackedObject:
        return obj.model_copy(update={"y_m": -obj.y_m, "yaw_rad": -obj.yaw_rad, "vy_mps": -obj.vy_mps})

    road = surroundings.road
    lanes = tuple(s.model_copy(update={"offset_m": tuple(-o for o in s.offset_m)}) for s in road.lanes)
    reference = tuple((x, -y) for x, y in road.reference)
    mirror: RoadGeometry = road.model_copy(
        update={"key": f"{road.key} mirrored", "reference": reference, "lanes": lanes}
    )
    ego = surroundings.ego.model_copy(update={"y_m": -surroundings.ego.y_m, "yaw_rad": -surroundings.ego.yaw_rad})
    return surroundings.model_copy(
        update={"ego": ego, "objects": tuple(map(other, surroundings.objects)), "road": mirror}
    )


def turned(surroundings: Surroundings) -> Surroundings:
    """The same with another origin and other axes."""
    cos, sin = math.cos(TURNED_RAD), math.sin(TURNED_RAD)

    def place(x: float, y: float) -> tuple[float, float]:
        return cos * x - sin * y + MOVED_M[0], sin * x + cos * y + MOVED_M[1]

    def other(obj: TrackedObject) -> TrackedObject:
        x, y = place(obj.x_m, obj.y_m)
        vx, vy = cos * obj.vx_mps - sin * obj.vy_mps, sin * obj.vx_mps + cos * obj.vy_mps
        yaw = obj.yaw_rad + TURNED_RAD
        return obj.model_copy(update={"x_m": x, "y_m": y, "vx_mps": vx, "vy_mps": vy, "yaw_rad": yaw})

    x, y = place(surroundings.ego.x_m, surroundings.ego.y_m)
    ego = surroundings.ego.model_copy(update={"x_m": x, "y_m": y, "yaw_rad": surroundings.ego.yaw_rad + TURNED_RAD})
    reference = tuple(place(*point) for point in surroundings.road.reference)
    road = surroundings.road.model_copy(update={"key": f"{surroundings.road.key} turned", "reference": reference})
    return surroundings.model_copy(
        update={"ego": ego, "objects": tuple(map(other, surroundings.objects)), "road": road}
    )


def shuffled(surroundings: Surroundings) -> Surroundings:
    """Listed the other way round, between others who are far from everything."""
    objects = (FAR[0], *reversed(surroundings.objects), FAR[1])
    road = surroundings.road.model_copy(
        update={"zones": tuple(reversed(surroundings.road.zones)), "key": f"{surroundings.road.key} shuffled"}
    )
    return surroundings.model_copy(
        update={"objects": objects, "controls": tuple(reversed(surroundings.controls)), "road": road}
    )


NOT_LAID_OUT = {RejectCode.NO_PATH, RejectCode.STALE, RejectCode.IMPLAUSIBLE, RejectCode.APPROVAL}
"""Refusals before there is a path."""
VARIANTS = {"mirrored": mirrored, "turned": turned, "shuffled": shuffled}


def same_plan(proven: ProvenPlan, view: FrenetScene, flipped: bool) -> ProvenPlan:
    """What was proven, in the variant's own frame."""
    path = proven.path
    enters = tuple(next(lane for lane in view.frame.lanes if lane.strip.id == own.strip.id) for own in path.enters)
    if flipped:
        path = replace(path, d=-path.d, yaw=None if path.yaw is None else -path.yaw)
    return replace(proven, path=replace(path, enters=enters))


class Judge(Guard):
    """Lays out what it is given, since behaviors know left from right: on which side oncoming traffic is, say."""

    given: ProvenPlan | None = None

    def lay_out(self, *_args: object, **_more: object) -> ProvenPlan:
        assert self.given is not None
        return self.given


def differs(name: str, first: Verdict, other: Verdict) -> str:
    """How two verdicts differ, empty if they do not. In another order somebody else may be named for the same."""
    ours, theirs = ({r.code for r in v.rejects} for v in (first, other))
    if ours != theirs or first.abort is not other.abort:
        return f"{name}: {first} {first.abort} / {other} {other.abort}"
    if name == "shuffled" or first.brake_mps2 != pytest.approx(other.brake_mps2, abs=ALIKE):
        return "" if first.brake_mps2 == pytest.approx(other.brake_mps2, abs=ALIKE) else f"{name}: brakes otherwise"
    for a, b in zip(first.rejects, other.rejects, strict=True):
        if a.object_id != b.object_id or (a.gap_m, a.time_s) != pytest.approx((b.gap_m, b.time_s), abs=ALIKE):
            return f"{name}: {a} / {b}"
    return ""


@contextmanager
def comparing(every: int = 1) -> Iterator[list[str]]:
    """Gives the differences found, a list that grows. Of the looks at running plans every so many are compared."""
    found: list[str] = []
    accepted, known, looks = Guard.accept, Guard.recheck, 0

    def note(name: str, first: Verdict, other: Verdict) -> None:
        text = differs(name, first, other)
        if text:
            found.append(text)

    def accept(guard, behaviors, view, guided, approvals=NOBODY, stops=False):
        verdict, proven = accepted(guard, behaviors, view, guided, approvals, stops)
        if verdict.rejects and verdict.rejects[0].code in NOT_LAID_OUT:
            return verdict, proven
        laid = guard.lay_out(behaviors, view, guided, approvals, stops)
        for name, change in VARIANTS.items():
            there, judge = FrenetScene(change(view.surroundings)), Judge(guard.policy)
            judge.given = same_plan(laid, there, name == "mirrored")
            note(name, verdict, accepted(judge, behaviors, there, guided, approvals, stops)[0])
        return verdict, proven

    def recheck(guard, proven, view, giving_way=False):
        nonlocal looks
        looks += 1
        verdict = known(guard, proven, view, giving_way)
        if looks % every == 0 or not verdict.accepted:
            for name, change in VARIANTS.items():
                there = FrenetScene(change(view.surroundings))
                note(name, verdict, known(guard, same_plan(proven, there, name == "mirrored"), there, giving_way))
        return verdict

    Guard.accept, Guard.recheck = accept, recheck  # type: ignore[method-assign]
    try:
        yield found
    finally:
        Guard.accept, Guard.recheck = accepted, known  # type: ignore[method-assign]
