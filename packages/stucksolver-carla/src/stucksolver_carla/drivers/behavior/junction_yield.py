"""Decides at junctions whether the ego yields to traffic that crosses or joins its route.

The drives of the ego and of other vehicles along their paths are predicted in steps. If the boxes come too near, the
ego waits before the junction. It never stops inside a conflict. The frame is CARLA's world frame (m, rad, s).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import ClassVar, NamedTuple

from stucksolver_carla.drivers.behavior.acceleration_limits import PaceFactors
from stucksolver_carla.drivers.behavior.conflict_paths import ConflictPath, JunctionConflicts
from stucksolver_carla.drivers.behavior.conflicting_traffic import (
    COMMITTED_M,
    MIN_MPS,
    ConflictingVehicle,
    TurnStatistics,
    flow_speed_mps,
    is_red,
    moving_vehicles,
    vehicles_on_path,
    will_conflict,
    with_flow_speed,
)
from stucksolver_carla.drivers.behavior.ego_rollout import (
    HORIZON_S,
    EgoRollout,
    LeadVehicle,
    Margin,
    PredictedConflict,
    can_stop,
    predict_drive,
)
from stucksolver_carla.drivers.behavior.lane_speed_prior import LaneSpeedPrior
from stucksolver_carla.drivers.behavior.nearby_objects import FIRST_FAR_ID, NearbyObjects
from stucksolver_carla.drivers.behavior.path import Path
from stucksolver_carla.drivers.behavior.profiles import DriverProfile
from stucksolver_carla.drivers.behavior.vehicle_model import VehicleModel

GAP_PACE = PaceFactors(1.3, 1.2)
"""Pace of a drive through a gap. Ours."""
_APPROACH_M = 20.0
"""Distance to the waiting place from which a junction is considered: the constant part (m). Ours."""
_APPROACH_S = 4.0
"""Distance to the waiting place from which a junction is considered: the part that grows with speed (s). Ours."""
CREEP_MPS = 1.0
"""Speed below which an ego in sensor mode may still wait with its front inside a conflict path (m/s); see `NOSE_M`.

The ego may have crept there: it starts for a gap, then detects that there is none, and its position is accurate only to
some decimeters. Ours."""
NOSE_M = 1.0
"""Distance inside a conflict path up to which the ego may still wait (m). Sensor mode only.

An ego that aborts its start within this distance past the line stays there. Before a ramp, it then has the whole ramp
for accelerating. Ours."""
SETTLED_S = 0.15
"""Time for which a result must hold before the ego starts, or aborts a start (s). Sensor mode only.

This is two results of perception. Otherwise a single noisy speed would take the best gap away. Ours."""
SENSOR_HORIZON_S = 12.0
"""Horizon of the rollout in sensor mode (s): up to the end of a ramp, and `ego_rollout.JOINED_S` more.

With a shorter horizon, a gap on a ramp of six seconds would seem long enough until the ego is half-way down and can
neither continue nor stop. Ours."""
FLOW_EXCESS_MPS = 2.0
"""Speed of a flow above the ego's from which the ego joins at the flow's speed (m/s). Sensor mode only. Ours."""
FASTEST_MPS = 22.0
"""Maximum speed at which the ego joins a flow (m/s). Ours."""
LOOK_MPS = 5.0
"""Speed before a turn across possible traffic, from which the ego can still stop for traffic (m/s). Ours."""
_TURN_MPS = 9.0
"""Speed bound of the line below which the route turns (m/s). Ours."""
_HARD_MPS2 = 5.0
"""Deceleration up to which the ego still stops before a conflict path (m/s²). Ours."""
FULL_MPS2 = 7.0
"""Deceleration up to which an ego past the waiting place still stops for traffic that does not yield (m/s²). Ours."""
_AT_LINE_M = 3.0
"""Distance to the waiting place below which the ego is at the line (m). Ours."""
START_LAG_S = 0.3
"""Delay between the decision and the start of a stopped ego (s). Ours."""
START_MARGIN = Margin(1.0, 0.8, 0.5, 0.2)
"""Required gap for a start without a wait. Ours."""
PATIENCE_S = 20.0
"""Wait after which the ego accepts its smallest gap (s): accepted gaps shrink with the time waited. Ours."""
PATIENT_MARGIN = Margin(0.5, 0.3, 0.3, 0.1)
"""Required gap for a start after `PATIENCE_S`. Ours."""
COMMITTED_MARGIN = Margin(0.5, 0.1, 0.0, 0.0)
"""Required gap after the start. It is smaller, so that the ego does not hesitate. Ours."""


class YieldDecision(NamedTuple):
    """The result of `JunctionYield` for one tick."""

    wait_m: float | None
    """Distance from the front bumper to the waiting place (m); None if the ego may drive."""
    passing: frozenset[int]
    """Ids of vehicles that will leave the ego's path in time, although they may be in it now."""
    look_m: float | None = None
    """Distance from the front bumper to the place of `LOOK_MPS` (m); None without one."""
    leader: LeadVehicle | None = None
    """The vehicle behind which the ego joins the flow; None without one."""


FREE = YieldDecision(None, frozenset())
"""The decision to drive without any restriction."""


class EgoSpeeds(NamedTuple):
    """The ego's speed along its route, and its speed without traffic (m/s)."""

    speed: float
    top_mps: float


class JunctionYield:
    """The decisions for one route, with the junction at which the ego has started."""

    committed_m: ClassVar[float] = COMMITTED_M
    """See `TurnStatistics`."""
    may_wait_in_path: ClassVar[bool] = False
    """True if `NOSE_M` also applies with ground truth."""

    def __init__(
        self,
        junctions: Sequence[JunctionConflicts],
        profile: DriverProfile,
        model: VehicleModel,
        pace: PaceFactors = GAP_PACE,
        *,
        sensor_mode: bool = False,
    ) -> None:
        """Create the decisions. `sensor_mode`: positions come from sensors; see `NOSE_M` and `SETTLED_S`."""
        self._sensor_mode = sensor_mode
        self._free_s = self._conflict_s = 0.0
        self._due = list(junctions)
        self.pace = pace
        """Pace of the drive through a gap."""
        self._profile = replace(profile, acceleration=profile.acceleration + pace.more_mps2)
        self._model = model
        self._going: JunctionConflicts | None = None
        self._waited_s = 0.0
        self._turn_statistics = TurnStatistics(self.committed_m)
        self._speed_prior, self._now_s = LaneSpeedPrior(), 0.0
        self.flow_mps = 0.0
        """Speed of a faster flow that the ego joins at the junction ahead (m/s); 0 without one. Sensor mode only."""

    @property
    def waits_at(self) -> tuple[JunctionConflicts | None, float]:
        """The junction ahead, or None, and the time waited there (s)."""
        return (self._due[0] if self._due else None), self._waited_s

    @property
    def has_started(self) -> bool:
        """True if the ego has started in a gap."""
        return self._going is not None

    def stay(self) -> None:
        """Cancel the start, because a light or a stop sign stops the ego."""
        self._going = None

    def decide(self, line: Path, s: float, motion: EgoSpeeds, around: NearbyObjects, dt_s: float) -> YieldDecision:
        """Return the decision for an ego with its center at arc length `s` of the route's `line`.

        `dt_s` is the time since the last call (s).
        """
        speed = motion.speed
        half = self._model.half_length
        front = s + half
        self._now_s += dt_s
        self._drop_passed(s)
        if not self._due or self._due[0].wait_s - front > _APPROACH_M + _APPROACH_S * speed:
            return FREE
        junction = self._due[0]
        traffic = self._conflicting_traffic(junction, around)
        rollout = self._rollout(line, s, speed, self._top_mps(motion, traffic))
        may_wait_at_line = self._sensor_mode and can_stop(
            speed, min(junction.wait_s + NOSE_M, junction.first_s) - front, _HARD_MPS2
        )
        stop_s = junction.wait_s if may_wait_at_line or front <= junction.wait_s else junction.first_s
        room_m = stop_s - front
        if not may_wait_at_line and self._cannot_wait(speed, room_m):
            self._going = junction
            return self._committed_decision(junction, rollout.predict_conflict(traffic, COMMITTED_MARGIN), front, speed)
        room_m = max(room_m, 0.0) if self._sensor_mode else room_m
        has_started = self._going is junction
        conflict = rollout.predict_conflict(traffic, COMMITTED_MARGIN if has_started else self._margin())
        if self._sensor_mode and has_started and conflict.met and conflict.pass_soon:
            return YieldDecision(room_m, frozenset())
        self._free_s = 0.0 if conflict.met else self._free_s + dt_s
        self._conflict_s = self._conflict_s + dt_s if conflict.met else 0.0
        if self._sensor_mode and has_started and 0.0 < self._conflict_s < SETTLED_S:
            return YieldDecision(None, conflict.passing, None, conflict.leader)
        if (
            self._sensor_mode
            and has_started
            and conflict.met
            and not rollout.predict_conflict(_before_conflict(traffic), self._margin()).met
        ):
            # The ego started faster than predicted, behind a vehicle that is still passing. It waits for that vehicle,
            # but does not abort, because that would take the gap away.
            return YieldDecision(room_m, frozenset())
        if self._sensor_mode and not has_started and speed < MIN_MPS and not conflict.met and self._free_s < SETTLED_S:
            return YieldDecision(room_m, frozenset())
        self._waited_s += dt_s if speed < MIN_MPS and room_m < _AT_LINE_M else 0.0
        must_decide = room_m < _AT_LINE_M or not can_stop(speed, room_m, self._profile.deceleration)
        self._going = None if conflict.met or not (has_started or must_decide) else junction
        if conflict.met:
            return YieldDecision(room_m, frozenset())
        look_m = room_m if front <= junction.wait_s and _requires_look(junction, line) else None
        return YieldDecision(None, conflict.passing, look_m, conflict.leader)

    def _drop_passed(self, s: float) -> None:
        """Drop the junctions behind an ego with its center at `s`."""
        while self._due and s - self._model.half_length > self._due[0].last_s:
            self._due.pop(0)
            self._going, self._waited_s, self._turn_statistics = None, 0.0, TurnStatistics(self.committed_m)

    def _conflicting_traffic(
        self, junction: JunctionConflicts, around: NearbyObjects
    ) -> list[tuple[ConflictPath, ConflictingVehicle]]:
        """Return the vehicles on a junction's paths that are not expected to wait or to take another path."""
        vehicles = moving_vehicles(around)
        pairs = [(path, vehicle) for path in junction.ways for vehicle in vehicles_on_path(path, vehicles)]
        self._turn_statistics.observe(
            [pair for pair in pairs if not (self._sensor_mode and pair[1].actor_id >= FIRST_FAR_ID)]
        )
        if self._sensor_mode:
            with_prior = self._speed_prior.with_prior_speed(pairs, self._now_s)
            # After the start, the ego aborts only for measured speeds. The trailing returns of a fast car may form a
            # new track too. And for a vehicle that only the camera tracks, just the nearest possible position is
            # reported, up to 20 m before the true one.
            measured = [pair for pair in pairs if pair[1].actor_id < FIRST_FAR_ID]
            pairs = with_flow_speed(measured if self.has_started else with_prior)
        return [
            (path, item)
            for path, item in pairs
            if will_conflict(path, item) and self._turn_statistics.may_take(path, item)
        ]

    def _rollout(self, line: Path, s: float, speed: float, top_mps: float) -> EgoRollout:
        """Return the rollout of an ego that starts now."""
        horizon_s = SENSOR_HORIZON_S if self._sensor_mode else HORIZON_S
        arc_lengths = predict_drive(
            line, s, speed, top_mps, self._profile, self.pace.bends, self._lag_s(), horizon_s=horizon_s
        )
        return EgoRollout(line, arc_lengths, self._model, followers=not self._sensor_mode)

    def _cannot_wait(self, speed: float, room: float) -> bool:
        """Return True if the ego can no longer stop before the conflict path, `room` meters ahead; see `NOSE_M`."""
        is_creeping = (self._sensor_mode or self.may_wait_in_path) and speed < CREEP_MPS and room > -NOSE_M
        return not is_creeping and not can_stop(speed, room, _HARD_MPS2)

    def _lag_s(self) -> float:
        """Return the delay of the start of a stopped ego (s).

        In sensor mode it is 0 after the decision to start. Otherwise the ego would seem too late on every tick and
        abort, because the gap after a long wait is hardly longer than the gap that it requires after the start.
        """
        return 0.0 if self._sensor_mode and self.has_started else START_LAG_S

    def _top_mps(self, motion: EgoSpeeds, traffic: Sequence[tuple[ConflictPath, ConflictingVehicle]]) -> float:
        """Return the ego's highest speed with the present traffic (m/s)."""
        pace = flow_speed_mps(traffic)
        is_faster = self._sensor_mode and motion.top_mps + FLOW_EXCESS_MPS < pace < math.inf
        self.flow_mps = min(pace, FASTEST_MPS) if is_faster else 0.0
        return self.flow_mps or min(motion.top_mps, pace)

    def _committed_decision(
        self, junction: JunctionConflicts, conflict: PredictedConflict, front: float, speed: float
    ) -> YieldDecision:
        """Return the decision past the waiting place: brake for traffic that does not yield, but not inside a path."""
        rooms_m = [path.route_meets_s - front for path in conflict.met if self._may_stop_before(path, junction, front)]
        room = min(rooms_m, default=-1.0)
        can_wait = can_stop(speed, room, FULL_MPS2)
        return (
            YieldDecision(room, frozenset())
            if can_wait
            else YieldDecision(None, conflict.passing, None, conflict.leader)
        )

    def _may_stop_before(self, path: ConflictPath, junction: JunctionConflicts, front: float) -> bool:
        if path.route_meets_s <= front:
            return False
        rear = path.route_meets_s - 2.0 * self._model.half_length - 1.0
        priority_paths = [item for item in junction.ways if item.goes_first and item is not path]
        return not path.joins or not any(
            item.route_meets_s < path.route_meets_s and item.route_parts_s > rear for item in priority_paths
        )

    def _margin(self) -> Margin:
        share = min(self._waited_s / PATIENCE_S, 1.0)
        return Margin(*(a + share * (b - a) for a, b in zip(START_MARGIN, PATIENT_MARGIN, strict=True)))


def _before_conflict(
    traffic: Sequence[tuple[ConflictPath, ConflictingVehicle]],
) -> list[tuple[ConflictPath, ConflictingVehicle]]:
    """Return the pairs without vehicles whose front has reached the conflict on a crossing path."""
    return [(path, item) for path, item in traffic if path.joins or item.s + item.half_length < path.meets_s]


def _requires_look(junction: JunctionConflicts, line: Path) -> bool:
    """Return True for a turn with a priority path whose traffic no red light stops."""
    inside = (line.s >= junction.wait_s) & (line.s <= junction.last_s)
    if float(line.speed[inside].min()) > _TURN_MPS:
        return False
    return any(path.goes_first and not any(map(is_red, path.lights)) for path in junction.ways)
