"""Criteria about single events: collisions, lights, signs, and what scenarios report."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

carla = pytest.importorskip("carla")

from judged import moment  # noqa: E402

from stucksolver_eval.criteria.collision import CollisionRule, ContactEpisode, kind_of  # noqa: E402
from stucksolver_eval.criteria.red_light import crosses  # noqa: E402
from stucksolver_eval.criteria.scenario_events import ScenarioEvents  # noqa: E402
from stucksolver_eval.criteria.stop_sign import StopSign, affects  # noqa: E402

HERE, NEAR, FAR = carla.Location(0, 0, 0), carla.Location(4, 0, 0), carla.Location(6, 0, 0)


def contact(other_id: int) -> ContactEpisode:
    return ContactEpisode(0, other_id, "vehicle.x")


@pytest.mark.parametrize(
    ("other", "kind"),
    [
        ("static.prop.container", "collisions_layout"),
        ("traffic.traffic_light", "collisions_layout"),
        ("static.sidewalk", None),
        ("vehicle.audi.a2", "collisions_vehicle"),
        ("walker.pedestrian.0001", "collisions_pedestrian"),
        ("", None),
    ],
)
def test_collisions_are_told_apart_by_the_others_type(other: str, kind: str | None) -> None:
    assert kind_of(other) == kind


def test_a_standing_ego_is_not_blamed() -> None:
    rule = CollisionRule()
    assert not rule.counts(contact(7), 0.0, HERE, speed_mps=0.09)
    assert rule.counts(contact(7), 0.0, HERE, speed_mps=0.1)


def test_the_same_other_counts_again_after_five_seconds() -> None:
    rule = CollisionRule()
    assert rule.counts(contact(7), 0.0, HERE, 1.0)
    rule.pass_time(5.0, FAR)
    assert not rule.counts(contact(7), 5.0, FAR, 1.0)
    rule.pass_time(5.05, FAR)
    assert rule.counts(contact(7), 5.05, FAR, 1.0)


def test_another_counts_only_five_metres_on() -> None:
    rule = CollisionRule()
    assert rule.counts(contact(7), 0.0, HERE, 1.0)
    rule.pass_time(1.0, NEAR)
    assert not rule.counts(contact(8), 1.0, NEAR, 1.0)
    rule.pass_time(2.0, FAR)
    assert rule.counts(contact(8), 2.0, FAR, 1.0)


def test_the_levels_geometry_is_not_remembered() -> None:
    rule = CollisionRule()
    assert rule.counts(contact(0), 0.0, HERE, 1.0)
    rule.pass_time(1.0, FAR)
    assert rule.counts(contact(0), 1.0, FAR, 1.0)


def test_segments_cross_only_where_both_reach() -> None:
    line = ((0.0, -2.0), (0.0, 2.0))
    assert crosses(((-1.0, 0.0), (1.0, 0.5)), line)
    assert not crosses(((-3.0, 0.0), (-1.0, 0.0)), line)
    assert not crosses(((-1.0, 3.0), (1.0, 3.0)), line)


def lane(start_x: float) -> list[SimpleNamespace]:
    places = [carla.Location(start_x + 0.5 * k, 0.0, 0.0) for k in range(9)]
    return [SimpleNamespace(transform=carla.Transform(place)) for place in places]


@pytest.mark.parametrize(("start_x", "is_affected"), [(-4.5, False), (-3.9, True), (0.5, True), (1.3, False)])
def test_stop_sign_affects_vehicles_near_and_entering_its_box(start_x: float, is_affected: bool) -> None:
    """A stop sign affects a vehicle that is near its box and heads into it."""
    sign = StopSign(None, carla.Location(0, 0, 0), half_x=1.2, half_y=1.2)
    assert affects(sign, lane(start_x)) is is_affected


def event(kind: str, value: float) -> SimpleNamespace:
    return SimpleNamespace(time_s=3.0, kind=kind, text="text", value=value)


def test_what_scenarios_report_is_noted_once_each() -> None:
    events = [event("started", 0.0), event("scenario_timeout", 240.0), event("yield_emergency_vehicle", 1.0)]
    criterion = ScenarioEvents(events)
    criterion.update(moment(3.0, 0.0))
    events.append(event("yield_emergency_vehicle", 0.0))
    criterion.update(moment(3.05, 0.0))
    criterion.update(moment(3.1, 0.0))
    assert [i.kind for i in criterion.infractions] == ["scenario_timeouts", "yield_emergency_vehicle_infractions"]
