"""Whatever stands in any field of the surroundings: what cannot be true counts as not seen, and its field is named."""

from __future__ import annotations

import itertools
import math
import types
from enum import Enum
from typing import Union, get_args, get_origin

import pytest

from grids import sample
from stucksolver import CONTINUE, StuckSolver
from stucksolver.guard import Guard, RejectCode
from stucksolver.plan.behaviors import BorrowOncomingLane, KeepLane, RejoinRoute
from stucksolver.scene import (
    ControlKind,
    LaneSight,
    LightState,
    LineKind,
    ObjectKind,
    RoadGeometry,
    Surroundings,
    TrafficControl,
    Zone,
    ZoneKind,
)
from stucksolver.scene.base_model import FrozenModel
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.objects import Gesture
from stucksolver.scene.plausibility import LONGEST_TEXT, RANGES, implausibility
from stucksolver.solver import EventKind
from stucksolver.solver.surroundings_monitor import SurroundingsMonitor
from worlds import LANE_M, World, drive, straight_road, stubborn, thing

HUGE_INT = 10**400
NUMBERS_THAT_ARE_NONE = (math.nan, math.inf, -math.inf, 1e300, -1e300, HUGE_INT, True, "1.0", [1.0], (1.0,), object())
TEXTS_THAT_ARE_NONE = (7, b"id", ["id"], object(), "x" * (LONGEST_TEXT + 1), "\ud800")


def full() -> Surroundings:
    """Surroundings in which every field has a value and no list is empty."""
    road = straight_road(left=LineKind.BROKEN).model_copy(
        update={
            "zones": (
                Zone(kind=ZoneKind.JUNCTION, start_m=200.0, end_m=215.0),
                Zone(kind=ZoneKind.CROSSWALK, start_m=198.0, end_m=202.0),
            ),
            "destination_m": 390.0,
        }
    )
    known = {
        "seen_for_s": 4.0,
        "moved_s_ago": 9.0,
        "kind_confidence": 0.9,
        "position_sd_m": 0.1,
        "across_sd_m": 0.05,
        "emergency_lights": False,
        "brake_lights": True,
        "door_open": False,
        "gesture": Gesture.NONE,
    }
    world = World(road, [thing("lead", 65.0, **known), thing("far", 150.0, LANE_M, speed=-3.0, **known)])
    light = TrafficControl(kind=ControlKind.TRAFFIC_LIGHT, distance_m=140.0, applies=True, state=LightState.GREEN)
    limits = world.ego().limits.model_copy(update={"measured_acceleration_mps2": 1.2})
    ego = world.ego().model_copy(update={"limits": limits, "position_sd_m": 0.05})
    return world.surroundings().model_copy(
        update={"controls": (light,), "ego": ego, "sensor_faults": ("the rear camera is dirty",)}
    )


FULL = full()


# ---- every field, found by reflection


def leaves(value, annotation, path=()):
    """Yields (path, annotation, optional, model) of each field, and of the first entry of each list."""
    origin, inner = get_origin(annotation), get_args(annotation)
    if origin in (Union, types.UnionType):
        (kind,) = (item for item in inner if item is not type(None))
        for deeper, what, _, model in leaves(value, kind, path):
            yield deeper, what, deeper == path, model
    elif origin is tuple:
        yield path, annotation, False, None
        yield from leaves(value[0], inner[0], (*path, 0))
    elif isinstance(value, FrozenModel):
        yield path, type(value), False, None
        for name, field in type(value).model_fields.items():
            for deeper, what, optional, model in leaves(getattr(value, name), field.annotation, (*path, name)):
                yield deeper, what, optional, type(value) if model is None and deeper == (*path, name) else model
    else:
        yield path, annotation, False, None


def owner_of(path):
    """The model that holds the field on a path, and the field's name; entries of lists belong to their list."""
    names = [k for k, step in enumerate(path) if isinstance(step, str)]
    value = FULL
    for step in path[: names[-1]]:
        value = value[step] if isinstance(step, int) else getattr(value, step)
    return type(value), path[names[-1]]


def replaced(value, path, new):
    """The same value with another one at the end of a path, without any validation."""
    if not path:
        return new
    step, *rest = path
    if isinstance(step, int):
        return (*value[:step], replaced(value[step], rest, new), *value[step + 1 :])
    return value.model_copy(update={step: replaced(getattr(value, step), rest, new)})


def wrong_values(path, annotation, optional):
    """Values that must not stand there: wrong types, no numbers, beyond all bounds, below nought where that is none."""
    nothing = () if optional else (None,)
    origin = get_origin(annotation)
    if origin is tuple:
        return (*nothing, "text", 5, list(range(3)), {"a": 1}, object(), (object(),), ("",) * 200_000)
    if isinstance(annotation, type) and issubclass(annotation, FrozenModel):
        return (*nothing, "text", 5, {}, object(), [])
    if isinstance(annotation, type) and issubclass(annotation, Enum):
        return (*nothing, next(iter(annotation)).value, "no such kind", 0, object())
    if annotation is bool:
        return (*nothing, 0, 1, "yes", math.nan, object())
    if annotation is str:
        return (*nothing, *TEXTS_THAT_ARE_NONE)
    model, name = owner_of(path)
    least, most = RANGES[model][name]
    beyond = (least - 1.0, most * 1.01 + 1.0)
    fractions = (0.5,) if annotation is int else ()
    return (*nothing, *NUMBERS_THAT_ARE_NONE, *beyond, *fractions)


FIELDS = [leaf for leaf in leaves(FULL, Surroundings) if leaf[0]]


def dotted(path):
    return "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in path).removeprefix(".")


def test_why_unsound_full_surroundings_are_sound():
    assert implausibility(FULL) is None
    assert {name for path, *_ in FIELDS for name in path if isinstance(name, str)} >= set(RANGES[RoadGeometry])


@pytest.mark.parametrize(("path", "annotation", "optional", "_"), FIELDS, ids=[dotted(field[0]) for field in FIELDS])
def test_why_unsound_any_field_wrong_names_it(path, annotation, optional, _):
    for value in wrong_values(path, annotation, optional):
        wrong = implausibility(replaced(FULL, path, value))
        assert wrong is not None, f"{dotted(path)} may be {value!r}"
        assert [step for step in path if isinstance(step, str)][-1] in wrong
        assert len(wrong) < 300 and "\n" not in wrong


@pytest.mark.parametrize(("path", "annotation", "optional", "_"), FIELDS, ids=[dotted(field[0]) for field in FIELDS])
def test_senses_any_field_wrong_count_as_not_seen(path, annotation, optional, _):
    senses = SurroundingsMonitor()
    assert senses.look(lambda: FULL, 0.0) is FULL
    for k, value in enumerate(wrong_values(path, annotation, optional), 1):
        spoilt = replaced(FULL, path, value)
        aged = senses.look(lambda spoilt=spoilt: spoilt, 2.0 * k)
        assert aged is not None and aged.age_s == pytest.approx(2.0 * k) and aged.objects == FULL.objects
        assert "are inconsistent" in senses.fault


@pytest.mark.parametrize("field", [item[0][-1] for item in FIELDS if item[3] is Surroundings])
def test_why_unsound_missing_field_names_it(field):
    spoilt = FULL.model_copy()
    del spoilt.__dict__[field]
    assert field in implausibility(spoilt)


class Raises:
    """Raises at whatever it is asked."""

    def __getattribute__(self, name):
        raise RuntimeError("never read me")


def test_why_unsound_no_surroundings_at_all_raises_nothing():
    for what in (None, 7, "text", [], {}, Raises()):
        assert implausibility(what)
        senses = SurroundingsMonitor()
        assert senses.look(lambda what=what: what, 0.0) is None and senses.fault


# ---- fields that contradict each other


def road(**changes):
    return FULL.model_copy(update={"road": FULL.road.model_copy(update=changes)})


def own(**changes):
    lanes = FULL.road.lanes
    return road(lanes=(lanes[0].model_copy(update=changes), *lanes[1:]))


CONTRADICTIONS = {
    "objects[1].id": FULL.model_copy(update={"objects": (FULL.objects[0],) * 2}),
    "sight[1].lane_id": FULL.model_copy(
        update={"sight": (FULL.sight[0], LaneSight(lane_id="nowhere", ahead_m=90.0, behind_m=9.0))}
    ),
    "road.lanes[1].id": road(lanes=(FULL.road.lanes[0],) * 2),
    "road.lanes[0].offset_m": own(offset_m=(0.0, 0.0)),
    "road.lanes[0].offset_m has stations": own(start=5),
    "road.zones[0].end_m": road(zones=(Zone(kind=ZoneKind.JUNCTION, start_m=9.0, end_m=2.0),)),
    "road.zones[1].start_m": road(
        zones=(
            Zone(kind=ZoneKind.JUNCTION, start_m=90.0, end_m=110.0),
            Zone(kind=ZoneKind.JUNCTION, start_m=100.0, end_m=120.0),
        )
    ),
    "road.reference": road(reference=((0.0, 0.0),), lanes=()),
}


@pytest.mark.parametrize("field", CONTRADICTIONS)
def test_why_unsound_contradiction_names_the_field(field):
    assert implausibility(CONTRADICTIONS[field]).startswith(field)


@pytest.mark.parametrize("sights", list(itertools.permutations((40.0, 300.0, 120.0))))
def test_view_two_sights_of_a_lane_the_smaller_counts(sights):
    """A lane of which two lengths are stated is seen as far as the smaller says, in whatever order they come."""
    world = World(straight_road(), [thing("lead", 65.0)])
    entries = tuple(LaneSight(lane_id="oncoming", ahead_m=ahead, behind_m=ahead / 10.0) for ahead in sights)
    seen = world.surroundings()
    view = FrenetScene(seen.model_copy(update={"sight": (*seen.sight[:1], *entries)}))
    oncoming = next(lane for lane in view.frame.lanes if lane.strip.id == "oncoming")
    assert (view.sight_ahead_m(oncoming), view.sight_behind_m(oncoming)) == (40.0, 4.0)
    assert view.backwards.sight_ahead_m(view.backwards.frame.same_lane(oncoming)) == 4.0
    verdict, _ = Guard().accept([BorrowOncomingLane(past_object_id="lead", speed_mps=5.0)], view, False)
    assert RejectCode.ONCOMING_SIGHT in verdict.codes


# ---- what is harmless: order, and overlaps of crosswalks and of level crossings


ZONES = (
    Zone(kind=ZoneKind.JUNCTION, start_m=140.0, end_m=160.0),
    Zone(kind=ZoneKind.CROSSWALK, start_m=137.0, end_m=143.0),
    Zone(kind=ZoneKind.CROSSWALK, start_m=139.0, end_m=145.0),
    Zone(kind=ZoneKind.LEVEL_CROSSING, start_m=200.0, end_m=224.0),
)
PLANS = (
    BorrowOncomingLane(past_object_id="lead", speed_mps=5.0),
    KeepLane(distance_m=80.0, speed_mps=5.0),
    KeepLane(distance_m=20.0, speed_mps=5.0),
    RejoinRoute(),
)


@pytest.mark.integration
@pytest.mark.parametrize("x", sample([60.0, 118.0, 136.0, 146.0, 205.0], 2))
def test_guard_order_of_zones_and_lanes_changes_no_verdict(x):
    base = straight_road()
    found = set()
    for zones in itertools.permutations(ZONES):
        for lanes in (base.lanes, base.lanes[::-1]):
            laid = base.model_copy(update={"zones": zones, "lanes": lanes, "key": f"{zones}{lanes[0].id}"})
            view = World(laid, [thing("lead", x + 15.0)], x=x).view()
            found.add(tuple(frozenset(Guard().accept([plan], view, False)[0].codes) for plan in PLANS))
    assert len(found) == 1


# ---- through the solver


@pytest.mark.parametrize(
    ("field", "spoilt"),
    [
        (
            "road.zones[0].start_m",
            {"zones": (Zone.model_construct(kind=ZoneKind.JUNCTION, start_m=math.nan, end_m=9.0),)},
        ),
        ("road.lanes[0].speed_limit_mps", {"lanes": None}),
    ],
)
def test_step_implausible_road_is_one_event_and_no_plan(field, spoilt):
    world = World(straight_road(), [thing("lead", 60.0)])
    if spoilt.get("lanes", ()) is None:
        first, *rest = world.road.lanes
        spoilt = {"lanes": (first.model_copy(update={"speed_limit_mps": -5.0}), *rest)}
    bad, told = world.road.model_copy(update=spoilt), []
    with StuckSolver(world.scene, clock="lockstep", ladder=stubborn(), on_event=told.append) as solver:
        for _ in range(400):
            seen = world.surroundings().model_copy(update={"road": bad})
            assert solver.step(world.status(), lambda seen=seen: seen) is CONTINUE
            world.drive(CONTINUE)
    faults = [e.text for e in told if e.kind is EventKind.FAULT]
    assert len(faults) == 1 and field in faults[0]
    assert EventKind.STARTED not in [e.kind for e in told]


@pytest.mark.integration
def test_step_sound_world_still_recovers():
    assert EventKind.RECOVERED in drive(World(straight_road(), [thing("lead", 60.0)]), 30.0).kinds()


def test_why_unsound_enum_member_of_another_kind_is_refused():
    lead = FULL.objects[0].model_copy(update={"kind": ControlKind.STOP_SIGN})
    assert "objects[0].kind" in implausibility(FULL.model_copy(update={"objects": (lead,)}))
    assert ObjectKind.CAR.value == "car"
