"""Implements a driver that passes a blocker in its lane when the pass keeps the required gaps.

It is the BehaviorAgent-like driver with a planner on top. It brakes for the same reasons on every line: lights, signs,
objects in the path, traffic at junctions.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import ClassVar

import carla
import numpy as np

from stucksolver_carla.drivers.behavior import BehaviorDriver, DrivePoint, DriverOptions, RoutePoint
from stucksolver_carla.drivers.behavior.acceleration_limits import EgoMotion
from stucksolver_carla.drivers.behavior.conflict_paths import JunctionConflicts
from stucksolver_carla.drivers.behavior.flow_speed import FLOW_MERGE, FlowAccelerationLimits, rear_flow_speed_mps
from stucksolver_carla.drivers.behavior.junction_yield import FASTEST_MPS, JunctionYield
from stucksolver_carla.drivers.behavior.lateral_offsets import LateralShift, offset_of, shifted_path
from stucksolver_carla.drivers.behavior.nearby_objects import HAZARD_LAMPS, NearbyObjects
from stucksolver_carla.drivers.behavior.path import Path
from stucksolver_carla.drivers.behavior.predictive_braking import TurnRates, allowed_acceleration, vehicles_pulling_out
from stucksolver_carla.drivers.behavior.pull_out import ROADSIDE_M as ROADSIDE_M
from stucksolver_carla.drivers.behavior.route_bodies import AHEAD_M, objects_on_route
from stucksolver_carla.drivers.behavior.route_lane_changes import DECELERATION_MPS2, LaneChangePlanner, lane_changes
from stucksolver_carla.drivers.behavior.route_line import rejoining_length
from stucksolver_carla.drivers.behavior.swept_path import nearest_hazards, sweep
from stucksolver_carla.drivers.planner.adjacent_lane_widths import AdjacentLaneWidths, lane_widths_along
from stucksolver_carla.drivers.planner.blockers import CONTACT_M, SLOW_SHARE, STOPPED_MPS, Blockers
from stucksolver_carla.drivers.planner.door_clearance import DoorClearance
from stucksolver_carla.drivers.planner.emergency_yield import (
    EMERGENCY_LAMPS,
    HOLD_M,
    approaches_from_behind,
    is_past,
    may_return,
    yield_candidates,
)
from stucksolver_carla.drivers.planner.flow_merge import FlowMergeYield
from stucksolver_carla.drivers.planner.pass_planner import (
    GAP_AFTER_M,
    PassCandidate,
    PassContext,
    cost_s,
    is_clear,
    objects_to_pass,
    pass_candidates,
    pass_path,
)
from stucksolver_carla.drivers.planner.square_turns import oncoming_paths, with_square_turn
from stucksolver_carla.drivers.planner.unprotected_turn import UnprotectedTurnYield

SQUARE_TURN_S = 8.0
"""Wait for an oncoming flow after which a left turn is driven squarely (s). A gap for the usual arc may never come.
Ours."""
SHORTEST_GAP_S = 25.0
"""Wait after which the ego joins a flow in the shortest accepted gap (s). The usual gap shrinks for 20 s. Ours."""
WAIT_GAP_M = 8.0
"""Gap at which the ego waits behind a blocker (m). From a shorter gap it could not leave the lane. Ours."""
LAMPS_PERIOD_S = 1.0
"""Time between two requests of kinds and lamps (s). Ours."""
SWEPT_M = 25.0
"""Length of the swept path that is checked before a pass (m). Ours."""
_SWEEP_MARGIN_M = 0.25
"""Clearance at the ego's sides in that check (m). Ours."""
_REACH_M = 1.8
"""Travel over which the ego's offset from the path fades (m); see `SteerController.MIN_REACH_M`."""
_ON_LINE_M = 0.3
"""Offset from the route's line below which the ego is on it (m). Ours."""
_ON_INTENDED_M = 0.4
"""Maximum distance from the intended line at which the ego may choose another one (m). It is larger, for example, while
the ego pulls out of a parking place. Ours."""
_START_TOLERANCE_M = 1.0
"""Distance to the start of a pass at which the pass is decided (m). Ours."""
_ONCOMING_MPS = -1.0
"""Speed along the route below which an object is oncoming (m/s). Ours."""
_STARTED_SHARE = 0.4
"""Share of the required gaps that holds after the start of a pass. Ours."""


class PlannerDriver(BehaviorDriver):
    """Drives a `carla.Vehicle`; see `Driver`. `behavior` is `cautious`, `normal` or `aggressive`."""

    sees_m: ClassVar[float] = AHEAD_M
    upstream_m: ClassVar[float] = 180.0
    _flow_wait_s: float | None = None
    """Arc length of the waiting place before the flow that is crossed or joined in the shortest gap (m)."""

    def __init__(
        self,
        vehicle: carla.Vehicle,
        behavior: str = "normal",
        options: DriverOptions | None = None,
        carla_map: carla.Map | None = None,
    ) -> None:
        super().__init__(vehicle, behavior, options, carla_map)
        self._limits = self._merge_limits = FlowAccelerationLimits(
            self._profile, self._options, self._model, self._planner
        )
        self._sides: AdjacentLaneWidths | None = None
        self._door_clearance, self._route_changes = DoorClearance(), LaneChangePlanner([])
        self._shifts: list[LateralShift] = []
        """Shifts of the driven line from the route's line while the ego passes no blocker."""
        self._emergency_ids: frozenset[int] = frozenset()
        self._blockers = Blockers()
        self._turn_rates = TurnRates()
        self._pass: PassCandidate | None = None
        self._wait_m: float | None = None
        self._hazard_lamps: frozenset[int] = frozenset()
        self._emergency_lamps: frozenset[int] = frozenset()
        """Ids of vehicles with their emergency lights on."""
        self._lamps_read_s = -math.inf
        self._kinds: dict[int, str] = {}

    @property
    def passing(self) -> PassCandidate | None:
        """The present pass; None without one."""
        return self._pass

    def set_route(self, route: Sequence[RoutePoint]) -> None:
        """Drive a route.

        Raises:
            ValueError: The route is empty.
        """
        self._flow_wait_s = None
        super().set_route(route)
        self._drop_pass()
        line = self._planner.route_line
        if line is not None:
            self._sides = lane_widths_along(self._route, line)
            self._route_changes = LaneChangePlanner(lane_changes(self._route, line))

    def follow(self, path: Sequence[DrivePoint], reverse: bool = False, ignore: Collection[int] = frozenset()) -> None:
        """Drive `path` up to its end, backward with `reverse`.

        Raises:
            ValueError: The path has too few points, or invalid ones.
        """
        self._drop_pass()
        super().follow(path, reverse, ignore)

    def release(self) -> None:
        """Drive the route again, from its nearest point ahead."""
        self._drop_pass()
        super().release()

    def _drop_pass(self) -> None:
        self._pass, self._shifts, self._emergency_ids = None, [], frozenset()

    def _make_yield(self, conflicts: Sequence[JunctionConflicts]) -> JunctionYield:
        line = self._planner.route_line
        if self._flow_wait_s is not None and line is not None:
            return UnprotectedTurnYield(conflicts, self._profile, self._model, line, self._flow_wait_s)
        return FlowMergeYield(conflicts, self._profile, self._model, FLOW_MERGE)

    def _switch_line_for_flow(self, line: Path, sides: AdjacentLaneWidths, motion: EgoMotion) -> bool:
        """Return True if the ego changes to another line, because it has waited long enough for the flow ahead."""
        junction, waited_s = self._yield.waits_at
        if junction is None or waited_s < SQUARE_TURN_S or junction.wait_s == self._flow_wait_s:
            return False
        if self._planner.route_s + self._model.half_length > junction.wait_s:
            return False  # inside the junction the ego would not be on the other line
        if oncoming_paths(line, junction):
            return self._switch_to_square_turn(line, junction, sides, motion)
        if waited_s > SHORTEST_GAP_S:
            self._flow_wait_s = junction.wait_s
            self._read_line()
        return False

    def _switch_to_square_turn(
        self, line: Path, junction: JunctionConflicts, sides: AdjacentLaneWidths, motion: EgoMotion
    ) -> bool:
        """Change to a square turn across the oncoming lanes. Return False if that is not possible."""
        self._flow_wait_s = junction.wait_s
        turn = with_square_turn(line, junction, self._model.half_width, self._is_drivable, sides.edge_side)
        if turn is None:
            return False
        self._drop_pass()
        self._planner.set_line(turn.line, motion.pose, motion.speed)
        self._read_line()
        self._sides = AdjacentLaneWidths(turn.arc_lengths_on_new(sides.s), sides.widths, sides.edge_side)
        self._route_changes = LaneChangePlanner(lane_changes(self._route, turn.line))
        return True

    def _is_drivable(self, x: float, y: float, z: float) -> bool:
        return self._map.get_waypoint(carla.Location(x, y, z), project_to_road=False) is not None

    @property
    def _is_at_roadside(self) -> bool:
        """True if the ego is next to its lane without a pass or a shift there."""
        if self._pass is not None or not super()._is_at_roadside:
            return False
        return abs(self._planner.beside_m - self._intended_offset_m()) > ROADSIDE_M

    def _intended_offset_m(self) -> float:
        """Return the intended offset from the route's line (m)."""
        return float(offset_of(self._shifts, np.array([self._planner.route_s]))[0])

    def _choose_line(self, motion: EgoMotion, around: NearbyObjects) -> None:
        planner, line = self._planner, self._planner.route_line
        self._wait_m, self._merge_limits.flow_mps, self._cleared_ids = None, 0.0, frozenset()
        if line is None or self._sides is None or planner.following or self._holding or planner.arrived:
            return
        if self._switch_line_for_flow(line, self._sides, motion):
            return
        now_s = self._world.get_snapshot().timestamp.elapsed_seconds
        context = self._context(line, motion, around, self._sides)
        self._blockers.observe(context.bodies, now_s)
        self._read_kinds_and_lamps(context, now_s)
        if self._emergency_ids:
            self._continue_emergency_yield(line, context, motion)
        elif self._pass is not None:
            self._continue_pass(line, context, motion)
            self._clear_oncoming(context)
        elif not self._start_emergency_yield(line, context, motion):
            self._start_pass(line, context, motion, around, now_s)
            if self._pass is None and abs(context.d_m - self._intended_offset_m()) < _ON_INTENDED_M:
                self._shift_in_lane(line, context, motion)
        self._follow_flow(context)

    def _clear_oncoming(self, context: PassContext) -> None:
        """Ignore oncoming traffic while the pass is clear, because it will be gone when the ego leaves its lane."""
        if self._pass is not None and is_clear(context, self._pass, _STARTED_SHARE):
            self._cleared_ids = frozenset(context.bodies.actor_id[context.bodies.vs < _ONCOMING_MPS].tolist())

    def _shift_in_lane(self, line: Path, context: PassContext, motion: EgoMotion) -> None:
        """Shift the line along the route: clearance to doors, and lane changes in accepted gaps."""
        self._route_changes.update(context)
        shifts = self._door_clearance.update(
            context.bodies, context.s_m, context.speed_mps, context.sides, context.model
        )
        shifts += self._route_changes.shifts()
        if shifts == self._shifts:
            return
        self._shifts = shifts
        join_m = rejoining_length(0.5, context.speed_mps)
        profile = self._profile
        path = shifted_path(line, context.s_m, context.d_m, shifts, join_m, profile.lateral_accel, profile.deceleration)
        self._planner.take(path, motion.pose)

    def _follow_flow(self, context: PassContext) -> None:
        """Set the flow speed from the flow that the ego joins and from the rear traffic."""
        flow_mps = self._yield.flow_mps if isinstance(self._yield, FlowMergeYield) and self._yield.has_started else 0.0
        rear_mps = rear_flow_speed_mps(
            context.bodies, context.s_m, context.d_m, context.speed_mps, context.model.half_length
        )
        self._merge_limits.flow_mps = min(max(flow_mps, rear_mps, self._route_changes.pace_mps), FASTEST_MPS)

    def _start_emergency_yield(self, line: Path, context: PassContext, motion: EgoMotion) -> bool:
        """Move into an adjacent lane for an emergency vehicle behind the ego. Return False without such a move."""
        emergency_ids = frozenset(approaches_from_behind(context)) & self._emergency_lamps
        if not emergency_ids:
            return False
        for candidate in yield_candidates(context, emergency_ids):
            if is_clear(context, candidate, _STARTED_SHARE):
                self._pass, self._emergency_ids, self._shifts = candidate, emergency_ids, []
                self._planner.take(self._path(line, context, candidate), motion.pose)
                return True
        return False

    def _continue_emergency_yield(self, line: Path, context: PassContext, motion: EgoMotion) -> None:
        """Stay in the adjacent lane until the emergency vehicle has passed and the ego's lane is free."""
        candidate = self._pass
        assert candidate is not None
        if context.s_m > candidate.back_m and abs(context.d_m) < _ON_LINE_M:
            self._drop_pass()
            self._planner.release(motion.pose, motion.speed)
            return
        if context.s_m > candidate.returns_m:
            return
        if context.s_m > candidate.beside_m and is_past(context, self._emergency_ids) and may_return(context):
            back_m = context.s_m + rejoining_length(candidate.offset_m, context.speed_mps)
            self._pass = replace(candidate, returns_m=context.s_m, back_m=back_m)
            self._planner.take(self._path(line, context, self._pass), motion.pose)
        elif context.s_m > candidate.returns_m - HOLD_M / 2.0:
            self._pass = replace(candidate, returns_m=candidate.returns_m + HOLD_M, back_m=candidate.back_m + HOLD_M)
            self._planner.take(self._path(line, context, self._pass), motion.pose)

    def _context(self, line: Path, motion: EgoMotion, around: NearbyObjects, sides: AdjacentLaneWidths) -> PassContext:
        planner = self._planner
        bodies = objects_on_route(line, planner.route_s, around)
        cruise = self._limits.top_speed(self._vehicle.get_speed_limit())
        speed = max(motion.speed, 0.0)
        return PassContext(planner.route_s, planner.beside_m, speed, cruise, bodies, sides, self._model)

    def _start_pass(
        self, line: Path, context: PassContext, motion: EgoMotion, around: NearbyObjects, now_s: float
    ) -> None:
        first_blocker = self._blockers.first_blocker(
            context, now_s, self._lights.next_line(context.s_m), self._hazard_lamps
        )
        if first_blocker is None:
            return
        lane_m = max(
            context.sides.narrowest(context.s_m, context.s_m + 1.0).half - 0.05, context.model.half_width + CONTACT_M
        )
        group = objects_to_pass(context, first_blocker, lane_m)
        candidates = sorted(pass_candidates(context, group), key=lambda candidate: cost_s(context, candidate))
        if not candidates:
            return
        gap_m = float((context.bodies.s - context.bodies.along)[group].min()) - context.s_m - context.model.half_length
        self._wait_m = gap_m
        for candidate in candidates:
            if candidate.begins_m > context.s_m + _START_TOLERANCE_M:
                # The pass is decided later, when the ego reaches its start.
                continue
            if is_clear(context, candidate):
                path = self._path(line, context, candidate)
                if self._is_swept_path_clear(path, motion, around):
                    self._pass, self._shifts = candidate, []
                    self._planner.take(path, motion.pose)
                    self._wait_m = None
                    return

    def _continue_pass(self, line: Path, context: PassContext, motion: EgoMotion) -> None:
        candidate = self._pass
        assert candidate is not None
        if context.s_m > candidate.back_m and abs(context.d_m) < _ON_LINE_M:
            self._pass = None
            self._planner.release(motion.pose, motion.speed)
            return
        if context.s_m > candidate.returns_m:
            return
        bodies, half = context.bodies, context.model.half_length
        is_passed = bodies.has_id_in(candidate.around)
        is_following = np.abs(bodies.d) - bodies.aside < context.model.half_width + CONTACT_M
        is_following &= bodies.vs < context.cruise_mps * SLOW_SHARE
        is_following &= (bodies.s > context.s_m) & (bodies.s - bodies.along < candidate.returns_m + GAP_AFTER_M + half)
        is_member = is_passed | (is_following & (np.abs(bodies.vs) < 4.0))
        if not is_member.any():
            return
        start = float((bodies.s - bodies.along)[is_member].min())
        if context.s_m + half < start - 1.0 and not is_clear(context, candidate, _STARTED_SHARE):
            self._pass = None
            self._planner.release(motion.pose, motion.speed)
            return
        end, pace = float((bodies.s + bodies.along)[is_member].max()), max(float(bodies.vs[is_member].max()), 0.0)
        remaining_m = max(end + GAP_AFTER_M + half - context.s_m, 0.0)
        returns_m = context.s_m + remaining_m * max(candidate.speed_mps, 1.0) / max(candidate.speed_mps - pace, 1.0)
        if returns_m > candidate.returns_m + _START_TOLERANCE_M and context.s_m >= candidate.beside_m:
            ids = candidate.around | frozenset(bodies.actor_id[is_member].tolist())
            back_m = returns_m + candidate.back_m - candidate.returns_m
            self._pass = replace(candidate, returns_m=returns_m, back_m=back_m, around=ids, ends_m=end)
            self._planner.take(self._path(line, context, self._pass), motion.pose)

    def _path(self, line: Path, context: PassContext, candidate: PassCandidate) -> Path:
        return pass_path(line, context, candidate, self._profile.lateral_accel, self._profile.deceleration)

    def _is_swept_path_clear(self, path: Path, motion: EgoMotion, around: NearbyObjects) -> bool:
        """Return True if the swept path contains no stopped object."""
        stopped = around.part(np.hypot(around.vx, around.vy) < 0.3)
        where = path.project(motion.pose)
        swept = sweep(path, where, motion.pose, self._model, _REACH_M, SWEPT_M)
        return not nearest_hazards(swept, stopped, self._model, _SWEEP_MARGIN_M, _SWEEP_MARGIN_M)

    def _read_kinds_and_lamps(self, context: PassContext, now_s: float) -> None:
        """Read the kinds of new objects, and the vehicles with hazard or emergency lights, once per second."""
        if now_s < self._lamps_read_s + LAMPS_PERIOD_S:
            return
        self._lamps_read_s = now_s
        new_ids = [actor_id for actor_id in context.bodies.actor_id.tolist() if actor_id not in self._kinds]
        if new_ids:
            self._kinds.update({actor.id: str(actor.type_id) for actor in self._world.get_actors(new_ids)})
        self._blockers.static_ids = frozenset(
            actor_id
            for actor_id, kind in self._kinds.items()
            if not kind.startswith(("vehicle.", "walker.", "animal."))
        )
        if (context.bodies.speed < STOPPED_MPS).any() or approaches_from_behind(context):
            lamps = {int(state): int(lit) for state, lit in self._world.get_vehicles_light_states().items()}
            self._hazard_lamps = frozenset(
                actor_id for actor_id, lit in lamps.items() if lit & HAZARD_LAMPS == HAZARD_LAMPS
            )
            self._emergency_lamps = frozenset(actor_id for actor_id, lit in lamps.items() if lit & EMERGENCY_LAMPS)

    def _acceleration(self, path: Path, candidate: EgoMotion, around: NearbyObjects) -> float:
        allowed = super()._acceleration(path, candidate, around)
        if self._wait_m is not None:
            allowed = min(allowed, self._limits.wait(self._wait_m - WAIT_GAP_M, candidate.speed))
        turning = self._turn_rates.observe(around, self._tick_s())
        if self._planner.following or self._holding:
            return allowed
        if self._pass is None and self._route_changes.wait_m is not None:
            fall_back_mps2 = max(self._route_changes.max_mps - candidate.speed, -DECELERATION_MPS2)
            allowed = min(allowed, fall_back_mps2, self._limits.stop_line(self._route_changes.wait_m, candidate.speed))
        where = self._planner.where
        bodies = objects_on_route(path, where.s, around)
        for hazard in vehicles_pulling_out(bodies, where, self._model):
            allowed = min(allowed, self._limits.hazard(hazard, candidate.speed))
        # In an accepted gap the ego does not brake for the vehicles for which the gap was checked.
        checked_ids = self._route_changes.checked_ids if self._pass is None else frozenset()
        if self._yield.has_started and isinstance(self._yield, FlowMergeYield):
            checked_ids |= self._yield.checked_ids
        bodies = bodies.part(~bodies.has_id_in(checked_ids))
        is_known = np.isin(around.actor_id, bodies.actor_id)
        speed, objects = max(candidate.speed, 0.0), around.part(is_known)
        return allowed_acceleration(path, where, speed, allowed, bodies, objects, turning[is_known], self._model)
