"""Riders beside the lanes: whoever rides straight across the route at a junction is waited for."""

from __future__ import annotations

import numpy as np
import pytest
from test_square_turns import SQUARE, WAIT_S, cars, met_on, watch
from test_streams import MODEL

from stucksolver_carla.drivers.behavior.junction_yield import EgoSpeeds
from stucksolver_carla.drivers.planner.crossing_cyclists import crossing_riders

BICYCLE_LANE_Y = -6.2
"""Beyond the oncoming lane."""


def riders(*places, y=BICYCLE_LANE_Y, yaw=np.pi, speed=9.0, half_width=0.35):
    """Bicycles at these x; by default they come towards the route."""
    n, found = len(places), cars(*places)
    one = np.ones(n)
    return type(found)(
        found.actor_id, found.is_walker, found.x, one * y, one * yaw, one * 0.8, one * half_width, found.bottom,
        found.top, one * speed * np.cos(yaw), one * speed * np.sin(yaw),
    )  # fmt: skip


def test_crossing_cyclist_has_its_own_conflict_path() -> None:
    """A cyclist that rides straight across the turn has a conflict path of its own."""
    ((way, rider),) = crossing_riders(SQUARE, met_on(SQUARE), riders(110.0))
    assert way.goes_first
    x, y, _ = SQUARE.at(np.array([way.route_meets_s, way.route_parts_s]))
    assert np.abs(y - BICYCLE_LANE_Y) == pytest.approx([1.7, 1.7], abs=0.3)
    assert 110.0 - way.parts_s < x.min() + 1.0 < 110.0 - way.meets_s + 2.0
    assert rider.speed == pytest.approx(9.0)


@pytest.mark.parametrize(
    "who",
    [
        {"speed": 0.5},
        {"half_width": 0.9},
        {"y": 5.0},
        {"y": 0.0, "yaw": 0.0},
        {"y": -3.5},
    ],
    ids=["hardly rides", "a car", "rides elsewhere", "rides in the ego's lane", "is on a lane that is known"],
)
def test_nobody_else_does(who) -> None:
    assert crossing_riders(SQUARE, met_on(SQUARE), riders(50.0 if who.get("yaw") == 0.0 else 110.0, **who)) == []


def test_one_who_has_crossed_is_no_reason_to_wait() -> None:
    assert crossing_riders(SQUARE, met_on(SQUARE), riders(60.0)) == []


def test_ego_waits_before_junction_for_close_cyclists() -> None:
    """The ego waits before the junction for cyclists that follow each other closely."""
    for first in np.arange(0.0, 8.0, 0.5):
        gives_way = watch()
        train = riders(*np.arange(first + 60.0, 140.0, 8.0))
        found = gives_way.decide(SQUARE, WAIT_S - 1.0 - MODEL.half_length, EgoSpeeds(0.0, 12.0), train, 0.05)
        assert found.wait_m is not None
