"""Into a stream: at its pace, behind whoever leads, and not into it without a gap."""

from __future__ import annotations

import math

import numpy as np
import pytest

from stucksolver_carla.drivers.behavior.acceleration_limits import USUAL
from stucksolver_carla.drivers.behavior.conflict_paths import ConflictPath, JunctionConflicts
from stucksolver_carla.drivers.behavior.ego_rollout import PredictedConflict
from stucksolver_carla.drivers.behavior.flow_speed import FlowAccelerationLimits, rear_flow_speed_mps
from stucksolver_carla.drivers.behavior.junction_yield import EgoSpeeds, YieldDecision
from stucksolver_carla.drivers.behavior.local_planner import LocalPlanner
from stucksolver_carla.drivers.behavior.options import DriverOptions
from stucksolver_carla.drivers.behavior.path import make_path
from stucksolver_carla.drivers.behavior.profiles import profile_named
from stucksolver_carla.drivers.behavior.route_bodies import RouteObjects
from stucksolver_carla.drivers.behavior.swept_path import Hazard
from stucksolver_carla.drivers.behavior.vehicle_model import VehicleModel
from stucksolver_carla.drivers.planner.flow_merge import FlowMergeYield

PROFILE, MODEL = profile_named("normal"), VehicleModel(2.4, 1.0, 2.9, 1.2)
LINE = make_path(np.arange(0.0, 300.0), np.zeros(300), np.full(300, 30.0))


def concerns(flow_mps):
    planner = LocalPlanner(PROFILE.lateral_accel, PROFILE.deceleration)
    found = FlowAccelerationLimits(PROFILE, DriverOptions(), MODEL, planner)
    found.flow_mps = flow_mps
    found.cruise(LINE, 8.0, 30.0, "", USUAL)
    return found


def way(meets_s, parts_s, joins=False):
    """A way that goes first and meets the route there."""
    s = np.arange(0.0, 100.0)
    return ConflictPath(
        x=s,
        y=s,
        yaw=0.0 * s,
        s=s,
        inside_s=40.0,
        meets_s=50.0,
        parts_s=60.0,
        route_meets_s=meets_s,
        route_parts_s=parts_s,
        straight=True,
        bend_mps=20.0,
        joins=joins,
        approach=(1, 0, -1),
        goes_first=True,
        lights=(),
    )


def gone(meeting, met, front, speed):
    found = PredictedConflict(met, frozenset(), None)
    return FlowMergeYield([meeting], PROFILE, MODEL)._committed_decision(meeting, found, front, speed)


@pytest.mark.parametrize(("flow_mps", "faster"), [(0.0, False), (5.0, False), (12.0, True)])
def test_cruise_flow_faster_than_limit_sets_speed(flow_mps, faster) -> None:
    """A traffic flow sets the speed where it is faster than the limit."""
    wanted = concerns(flow_mps).cruise(LINE, 8.0, 30.0, "right", USUAL)
    assert (wanted > 0.5) == faster


def test_hazard_lead_driving_away_in_flow_does_not_slow() -> None:
    """In a flow, the ego does not fall back behind a lead vehicle that drives away."""
    near = Hazard(1, 5.0, 11.0, False)
    assert concerns(11.0).hazard(near, 9.0) > 1.0
    assert concerns(0.0).hazard(near, 9.0) < concerns(11.0).hazard(near, 9.0)


def test_hazard_in_traffic_at_limit_keeps_usual_gap() -> None:
    """In traffic that keeps to the limit, the usual gap is kept."""
    near = Hazard(1, 4.0, 7.5, False)
    assert concerns(7.4).hazard(near, 7.0) == pytest.approx(concerns(0.0).hazard(near, 7.0))


@pytest.mark.parametrize(
    "hazard", [Hazard(1, 5.0, 0.0, False), Hazard(1, 1.0, 11.0, False), Hazard(1, 8.0, 4.0, False)]
)
def test_hazard_stopped_near_or_slow_lead_brakes_in_flow(hazard) -> None:
    """The ego brakes for an object that is stopped, too near, or slower than the flow."""
    assert concerns(11.0).hazard(hazard, 9.0) == pytest.approx(concerns(0.0).hazard(hazard, 9.0))


def test_yield_past_line_stops_before_path_not_entered() -> None:
    """An ego past the line stops before a vehicle's path that it has not entered yet."""
    crossed, ahead, joined = way(20.0, 26.0), way(30.0, 40.0), way(42.0, 50.0, joins=True)
    meeting = JunctionConflicts(18.0, (crossed, ahead, joined))
    assert gone(meeting, (joined,), 24.0, 3.0).wait_m == pytest.approx(6.0)
    assert gone(meeting, (joined,), 29.5, 9.0) == YieldDecision(None, frozenset())


def test_one_that_has_crept_up_to_the_others_still_waits() -> None:
    watch = FlowMergeYield([], PROFILE, MODEL)
    assert not watch._cannot_wait(0.3, -0.5)
    assert watch._cannot_wait(4.0, -0.5)
    assert watch._cannot_wait(0.3, -3.0)


def test_nobody_sets_the_pace_on_an_empty_road() -> None:
    assert FlowMergeYield([], PROFILE, MODEL)._top_mps(EgoSpeeds(5.0, 8.0), []) == 8.0
    assert not math.isinf(FlowMergeYield([], PROFILE, MODEL).flow_mps)


@pytest.mark.parametrize(
    ("gap_m", "aside_m", "speed", "pace"),
    [
        (8.0, 0.0, 11.0, 11.0),
        (20.0, 0.0, 11.0, 11.0),
        (60.0, 0.0, 11.0, 0.0),
        (8.0, 3.5, 11.0, 0.0),
        (-20.0, 0.0, 11.0, 0.0),
    ],
)
def test_rear_flow_speed_is_that_of_close_follower(gap_m, aside_m, speed, pace) -> None:
    """The flow speed is that of a follower close behind in the same lane."""
    x = 100.0 - 4.8 - gap_m
    zero, flags = np.zeros(1), np.zeros(1, np.bool_)
    bodies = RouteObjects(
        np.array([5]), flags, np.array([x]), np.array([aside_m]), zero + 2.4, zero + 0.9, zero + 11.0, zero
    )
    assert rear_flow_speed_mps(bodies, 100.0, 0.0, 10.9, MODEL.half_length) == pace
