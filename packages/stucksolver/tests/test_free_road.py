"""A driver that stands on a free road is moved on; one that waits with reason is not."""

from __future__ import annotations

import math

import pytest

from stucksolver.scene import ControlKind, LightState, ObjectKind, TrafficControl, Zone, ZoneKind
from stucksolver.solver import EventKind
from test_duties import behaviors_of, decide
from worlds import LANE_M, World, drive, red_light, straight_road, thing

TWO_WAY = straight_road()
K = ObjectKind


def plan(world, stopped_s=10.0):
    return [(b.name, b.speed_mps) for b in behaviors_of(decide(world, stopped_s=stopped_s))]


def test_on_a_free_road_it_drives_on_after_eight_seconds():
    assert decide(World(TWO_WAY), stopped_s=7.0).plan is None
    assert plan(World(TWO_WAY)) == [("keep_lane", 5.5)]


@pytest.mark.integration
def test_solver_driver_never_sets_off_is_moved():
    """A driver that never sets off is moved by the solver."""
    world = World(TWO_WAY, cruise_mps=0.0)
    seen = drive(world, 60.0)
    assert EventKind.RECOVERED in seen.kinds()
    assert world.x > 80.0


@pytest.mark.parametrize("state", [LightState.RED, LightState.YELLOW, LightState.UNKNOWN])
@pytest.mark.parametrize("distance", [3.0, 15.0, 28.0])
def test_onward_light_not_known_green_stays(state, distance):
    """The ego does not drive on toward a light that is not known to be green."""
    assert decide(World(TWO_WAY, controls=(red_light(distance, state),)), stopped_s=10.0).plan is None


def test_onward_green_light_or_other_lanes_red_drives_on():
    """The ego drives on past a green light or a red light of another lane."""
    assert plan(World(TWO_WAY, controls=(red_light(15.0, applies=False),))) == [("keep_lane", 5.5)]
    assert plan(World(TWO_WAY, controls=(red_light(15.0, LightState.GREEN),))) == [("keep_lane", 5.5)]


def test_onward_after_stop_sign_creeps_over_line():
    """After its stop at a stop sign, the ego creeps over the line."""
    sign = TrafficControl(kind=ControlKind.STOP_SIGN, distance_m=2.0, applies=True)
    assert plan(World(TWO_WAY, controls=(sign,))) == [("keep_lane", 2.2)]


@pytest.mark.parametrize(
    "other",
    [
        thing("walker", 60.0, -3.0, kind=K.PEDESTRIAN, sideways=1.0),
        thing("flagger", 70.0, -4.0, kind=K.FLAGGER),
        thing("bus", 65.0, LANE_M, kind=K.SCHOOL_BUS),
        thing("ambulance", 20.0, speed=8.0, kind=K.EMERGENCY, emergency_lights=True),
        thing("crossing", 62.0, -12.0, sideways=6.0, yaw=math.pi / 2),
    ],
    ids=lambda o: o.id,
)
def test_whoever_waits_with_reason_waits_on(other):
    world = World(TWO_WAY, [other])
    found = decide(world, stopped_s=10.0)
    assert found.plan is None or "keep_lane" not in [b.name for b in found.plan.behaviors]


def test_a_junction_whose_exit_is_full_is_not_entered():
    road = straight_road(zones=(Zone(kind=ZoneKind.JUNCTION, start_m=56.0, end_m=76.0),))
    assert decide(World(road, [thing("last", 80.0, stationary_s=20.0)]), stopped_s=30.0).plan is None


def test_beside_the_lanes_it_comes_back_first():
    assert [name for name, _ in plan(World(TWO_WAY, y=-2.5))] == ["rejoin_route"]
