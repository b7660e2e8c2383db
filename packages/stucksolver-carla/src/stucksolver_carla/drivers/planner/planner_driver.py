"""A base driver that goes round what blocks its lane if nobody would come too near.

It is the BehaviorAgent-like driver with a planner on top. What makes that one brake (lights, signs, bodies in the path,
others at junctions) makes this one brake as well, on any line.
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
from stucksolver_carla.drivers.behavior.flow_speed import HURRIED, FlowAccelerationLimits, rear_flow_speed_mps
from stucksolver_carla.drivers.behavior.junction_yield import FASTEST_MPS, JunctionYield
from stucksolver_carla.drivers.behavior.lateral_offsets import LateralShift, offset_of, shifted_path
from stucksolver_carla.drivers.behavior.nearby_objects import HAZARD_LAMPS, NearbyObjects
from stucksolver_carla.drivers.behavior.path import Path
from stucksolver_carla.drivers.behavior.predictive_braking import TurnRates, allowed_acceleration, entering
from stucksolver_carla.drivers.behavior.pull_out import BESIDE_M as ROADSIDE_M
from stucksolver_carla.drivers.behavior.route_bodies import AHEAD_M, on_route
from stucksolver_carla.drivers.behavior.route_lane_changes import SLOWER_MPS2, LaneChangePlanner, lane_changes
from stucksolver_carla.drivers.behavior.route_line import rejoining_length
from stucksolver_carla.drivers.behavior.swept_path import nearest_hazards, sweep
from stucksolver_carla.drivers.planner.adjacent_lane_widths import AdjacentLaneWidths, sides_of
from stucksolver_carla.drivers.planner.blockers import SLOW_SHARE, STANDS_MPS, TOUCHES_M, Blockers
from stucksolver_carla.drivers.planner.door_clearance import Berths
from stucksolver_carla.drivers.planner.emergency_yield import (
    EMERGENCY_LAMPS,
    STRETCH_M,
    approaches_from_behind,
    aside,
    is_past,
    may_return,
)
from stucksolver_carla.drivers.planner.flow_merge import FlowMergeYield
from stucksolver_carla.drivers.planner.pass_planner import (
    ROOM_AFTER_M,
    PassCandidate,
    PassContext,
    cost_s,
    group_of,
    is_clear,
    pass_path,
    proposals,
)
from stucksolver_carla.drivers.planner.square_turns import stream_ways, with_square_turn
from stucksolver_carla.drivers.planner.unprotected_turn import UnprotectedTurnYield

SQUARES_AFTER_S = 8.0
"""After this wait for an oncoming stream a left turn is driven squarely (s): a gap for the usual arc may never come."""
PRESSES_AFTER_S = 25.0
"""After this wait a stream is joined in the shortest proven gap (s): the usual one shrinks for 20 s."""
WAITS_M = 8.0
"""Where it waits behind what it wants to pass: nearer, it could not swing out any more."""
LAMPS_EVERY_S = 1.0
SWEPT_M = 25.0
_SWEEP_MARGIN_M = 0.25
_REACH_M = 1.8
_ON_LINE_M = 0.3
_ON_WAY_M = 0.4
"""An ego farther from its intended place, such as on its way out of a parking place, takes no other way."""
_LATER_M = 1.0
_COMES_MPS = -1.0
_ONCE_BEGUN = 0.4


class PlannerDriver(BehaviorDriver):
    """Drives a `carla.Vehicle`; see `Driver`. `behavior` is `cautious`, `normal` or `aggressive`."""

    sees_m: ClassVar[float] = AHEAD_M
    upstream_m: ClassVar[float] = 180.0
    _stream_s: float | None = None
    """Waiting place before the stream that it crosses or joins in the shortest proven gap, on the route's line (m)."""

    def __init__(
        self,
        vehicle: carla.Vehicle,
        behavior: str = "normal",
        options: DriverOptions | None = None,
        carla_map: carla.Map | None = None,
    ) -> None:
        super().__init__(vehicle, behavior, options, carla_map)
        self._concerns = self._streams = FlowAccelerationLimits(
            self._profile, self._options, self._model, self._planner
        )
        self._sides: AdjacentLaneWidths | None = None
        self._berths, self._changes = Berths(), LaneChangePlanner([])
        self._shifts: list[LateralShift] = []
        """Where the driven line lies beside the route's, while nothing is passed."""
        self._yields_to: frozenset[int] = frozenset()
        self._blockers = Blockers()
        self._turning = TurnRates()
        self._pass: PassCandidate | None = None
        self._wait_m: float | None = None
        self._hazard_lamps: frozenset[int] = frozenset()
        self._emergency: frozenset[int] = frozenset()
        """Ids of vehicles with blue lights on."""
        self._lamps_at_s = -math.inf
        self._kinds: dict[int, str] = {}

    @property
    def passing(self) -> PassCandidate | None:
        """What it is passing, if anything."""
        return self._pass

    def set_route(self, route: Sequence[RoutePoint]) -> None:
        """Drive a route planned elsewhere.

        Raises:
            ValueError: The route is empty.
        """
        self._stream_s = None
        super().set_route(route)
        self._give_up_way()
        line = self._planner.route_line
        if line is not None:
            self._sides = sides_of(self._route, line)
            self._changes = LaneChangePlanner(lane_changes(self._route, line))

    def follow(self, path: Sequence[DrivePoint], reverse: bool = False, ignore: Collection[int] = frozenset()) -> None:
        """Drive `path`, no further than its end; back up along it with `reverse`.

        Raises:
            ValueError: The path cannot be driven.
        """
        self._give_up_way()
        super().follow(path, reverse, ignore)

    def release(self) -> None:
        """Drive the route again, from the nearest point of it ahead."""
        self._give_up_way()
        super().release()

    def _give_up_way(self) -> None:
        self._pass, self._shifts, self._yields_to = None, [], frozenset()

    def _giving_way(self, met: Sequence[JunctionConflicts]) -> JunctionYield:
        line = self._planner.route_line
        if self._stream_s is not None and line is not None:
            return UnprotectedTurnYield(met, self._profile, self._model, line, self._stream_s)
        return FlowMergeYield(met, self._profile, self._model, HURRIED)

    def _presses_on(self, line: Path, sides: AdjacentLaneWidths, motion: EgoMotion) -> bool:
        """True if it drives another line from now on because it has waited long enough for the stream ahead."""
        meeting, waited_s = self._give_way.waits_at
        if meeting is None or waited_s < SQUARES_AFTER_S or meeting.wait_s == self._stream_s:
            return False
        if self._planner.route_s + self._model.half_length > meeting.wait_s:
            return False  # in the junction it would no longer be on the other line
        if stream_ways(line, meeting):
            return self._square_the_turn(line, meeting, sides, motion)
        if waited_s > PRESSES_AFTER_S:
            self._stream_s = meeting.wait_s
            self._watch_line()
        return False

    def _square_the_turn(
        self, line: Path, meeting: JunctionConflicts, sides: AdjacentLaneWidths, motion: EgoMotion
    ) -> bool:
        """True if the left turn at a junction can be driven squarely, and is from now on."""
        self._stream_s = meeting.wait_s
        turn = with_square_turn(line, meeting, self._model.half_width, self._is_drivable)
        if turn is None:
            return False
        self._give_up_way()
        self._planner.set_line(turn.line, motion.pose, motion.speed)
        self._watch_line()
        self._sides = AdjacentLaneWidths(turn.moved(sides.s), sides.widths)
        self._changes = LaneChangePlanner(lane_changes(self._route, turn.line))
        return True

    def _is_drivable(self, x: float, y: float, z: float) -> bool:
        return self._map.get_waypoint(carla.Location(x, y, z), project_to_road=False) is not None

    @property
    def _at_the_roadside(self) -> bool:
        """True if it is beside its lane without having intended that."""
        if self._pass is not None or not super()._at_the_roadside:
            return False
        return abs(self._planner.beside_m - self._meant_m()) > ROADSIDE_M

    def _meant_m(self) -> float:
        """Intended offset from the route's line (m)."""
        return float(offset_of(self._shifts, np.array([self._planner.route_s]))[0])

    def _decide(self, motion: EgoMotion, around: NearbyObjects) -> None:
        planner, line = self._planner, self._planner.route_line
        self._wait_m, self._streams.flow_mps, self._out_of_the_way = None, 0.0, frozenset()
        if line is None or self._sides is None or planner.following or self._holding or planner.arrived:
            return
        if self._presses_on(line, self._sides, motion):
            return
        now_s = self._world.get_snapshot().timestamp.elapsed_seconds
        here = self._situation(line, motion, around, self._sides)
        self._blockers.see(here.bodies, now_s)
        self._learn(here, now_s)
        if self._yields_to:
            self._let_past(line, here, motion)
        elif self._pass is not None:
            self._go_on(line, here, motion)
            self._heed_no_oncoming(here)
        elif not self._makes_room(line, here, motion):
            self._look_for_a_way(line, here, motion, around, now_s)
            if self._pass is None and abs(here.d_m - self._meant_m()) < _ON_WAY_M:
                self._keep_its_place(line, here, motion)
        self._keep_pace(here)

    def _heed_no_oncoming(self, here: PassContext) -> None:
        """While its pass is proven: they will be past before it swings out, so where they are now is no obstacle."""
        if self._pass is not None and is_clear(here, self._pass, _ONCE_BEGUN):
            self._out_of_the_way = frozenset(here.bodies.actor_id[here.bodies.vs < _COMES_MPS].tolist())

    def _keep_its_place(self, line: Path, here: PassContext, motion: EgoMotion) -> None:
        """Where across the road the ego drives along its route: room beside doors, and lanes entered in gaps."""
        self._changes.look(here)
        wanted = self._berths.look(here.bodies, here.s_m, here.speed_mps, here.sides, here.model)
        wanted += self._changes.shifts()
        if wanted == self._shifts:
            return
        self._shifts = wanted
        join = rejoining_length(0.5, here.speed_mps)
        profile = self._profile
        path = shifted_path(line, here.s_m, here.d_m, wanted, join, profile.lateral_accel, profile.deceleration)
        self._planner.take(path, motion.pose)

    def _keep_pace(self, here: PassContext) -> None:
        """Drive no slower than the stream that the ego joins, or than traffic from behind."""
        stream = self._give_way.flow_mps if isinstance(self._give_way, FlowMergeYield) and self._give_way.going else 0.0
        behind = rear_flow_speed_mps(here.bodies, here.s_m, here.d_m, here.speed_mps, here.model.half_length)
        self._streams.flow_mps = min(max(stream, behind, self._changes.pace_mps), FASTEST_MPS)

    def _makes_room(self, line: Path, here: PassContext, motion: EgoMotion) -> bool:
        """True if the ego moves aside for an emergency vehicle behind it from now on."""
        whom = frozenset(approaches_from_behind(here)) & self._emergency
        if not whom:
            return False
        for way in aside(here, whom):
            if is_clear(here, way, _ONCE_BEGUN):
                self._pass, self._yields_to, self._shifts = way, whom, []
                self._planner.take(self._path(line, here, way), motion.pose)
                return True
        return False

    def _let_past(self, line: Path, here: PassContext, motion: EgoMotion) -> None:
        """Stay aside until it has passed and the lane is free again, or until the lane beside ends."""
        way = self._pass
        assert way is not None
        if here.s_m > way.back_m and abs(here.d_m) < _ON_LINE_M:
            self._give_up_way()
            self._planner.release(motion.pose, motion.speed)
            return
        if here.s_m > way.returns_m:
            return
        if here.s_m > way.beside_m and is_past(here, self._yields_to) and may_return(here):
            back = here.s_m + rejoining_length(way.offset_m, here.speed_mps)
            self._pass = replace(way, returns_m=here.s_m, back_m=back)
            self._planner.take(self._path(line, here, self._pass), motion.pose)
        elif here.s_m > way.returns_m - STRETCH_M / 2.0:
            self._pass = replace(way, returns_m=way.returns_m + STRETCH_M, back_m=way.back_m + STRETCH_M)
            self._planner.take(self._path(line, here, self._pass), motion.pose)

    def _situation(
        self, line: Path, motion: EgoMotion, around: NearbyObjects, sides: AdjacentLaneWidths
    ) -> PassContext:
        planner = self._planner
        bodies = on_route(line, planner.route_s, around)
        cruise = self._concerns.top_speed(self._vehicle.get_speed_limit())
        speed = max(motion.speed, 0.0)
        return PassContext(planner.route_s, planner.beside_m, speed, cruise, bodies, sides, self._model)

    def _look_for_a_way(
        self, line: Path, here: PassContext, motion: EgoMotion, around: NearbyObjects, now_s: float
    ) -> None:
        first = self._blockers.first(here, now_s, self._lights.next_line(here.s_m), self._hazard_lamps)
        if first is None:
            return
        lane_m = max(here.sides.room(here.s_m, here.s_m + 1.0).half - 0.05, here.model.half_width + TOUCHES_M)
        group = group_of(here, first, lane_m)
        ways = sorted(proposals(here, group), key=lambda way: cost_s(here, way))
        if not ways:
            return
        gap = float((here.bodies.s - here.bodies.along)[group].min()) - here.s_m - here.model.half_length
        self._wait_m = gap
        for way in ways:
            if way.begins_m > here.s_m + _LATER_M:
                # Not yet: it is the same question when the place is reached.
                continue
            if is_clear(here, way):
                path = self._path(line, here, way)
                if self._meets_nothing(path, motion, around):
                    self._pass, self._shifts = way, []
                    self._planner.take(path, motion.pose)
                    self._wait_m = None
                    return

    def _go_on(self, line: Path, here: PassContext, motion: EgoMotion) -> None:
        way = self._pass
        assert way is not None
        if here.s_m > way.back_m and abs(here.d_m) < _ON_LINE_M:
            self._pass = None
            self._planner.release(motion.pose, motion.speed)
            return
        if here.s_m > way.returns_m:
            return
        bodies, half = here.bodies, here.model.half_length
        passed = bodies.among(way.around)
        follows = np.abs(bodies.d) - bodies.aside < here.model.half_width + TOUCHES_M
        follows &= bodies.vs < here.cruise_mps * SLOW_SHARE
        follows &= (bodies.s > here.s_m) & (bodies.s - bodies.along < way.returns_m + ROOM_AFTER_M + half)
        members = passed | (follows & (np.abs(bodies.vs) < 4.0))
        if not members.any():
            return
        start = float((bodies.s - bodies.along)[members].min())
        if here.s_m + half < start - 1.0 and not is_clear(here, way, _ONCE_BEGUN):
            self._pass = None
            self._planner.release(motion.pose, motion.speed)
            return
        end, pace = float((bodies.s + bodies.along)[members].max()), max(float(bodies.vs[members].max()), 0.0)
        left = max(end + ROOM_AFTER_M + half - here.s_m, 0.0)
        meets = here.s_m + left * max(way.speed_mps, 1.0) / max(way.speed_mps - pace, 1.0)
        if meets > way.returns_m + _LATER_M and here.s_m >= way.beside_m:
            ids = way.around | frozenset(bodies.actor_id[members].tolist())
            back = meets + way.back_m - way.returns_m
            self._pass = replace(way, returns_m=meets, back_m=back, around=ids, ends_m=end)
            self._planner.take(self._path(line, here, self._pass), motion.pose)

    def _path(self, line: Path, here: PassContext, way: PassCandidate) -> Path:
        return pass_path(line, here, way, self._profile.lateral_accel, self._profile.deceleration)

    def _meets_nothing(self, path: Path, motion: EgoMotion, around: NearbyObjects) -> bool:
        """True if the body, swept along the way out, stays clear of all standing bodies."""
        standing = around.part(np.hypot(around.vx, around.vy) < 0.3)
        where = path.project(motion.pose)
        swept = sweep(path, where, motion.pose, self._model, _REACH_M, SWEPT_M)
        return not nearest_hazards(swept, standing, self._model, _SWEEP_MARGIN_M, _SWEEP_MARGIN_M)

    def _learn(self, here: PassContext, now_s: float) -> None:
        """Find out which bodies are objects and which vehicles have hazard or blue lights on; once a second."""
        if now_s < self._lamps_at_s + LAMPS_EVERY_S:
            return
        self._lamps_at_s = now_s
        new = [item for item in here.bodies.actor_id.tolist() if item not in self._kinds]
        if new:
            self._kinds.update({actor.id: str(actor.type_id) for actor in self._world.get_actors(new)})
        self._blockers.things = frozenset(
            item for item, kind in self._kinds.items() if not kind.startswith(("vehicle.", "walker.", "animal."))
        )
        if (here.bodies.speed < STANDS_MPS).any() or approaches_from_behind(here):
            lamps = {int(state): int(on) for state, on in self._world.get_vehicles_light_states().items()}
            self._hazard_lamps = frozenset(lamp for lamp, on in lamps.items() if on & HAZARD_LAMPS == HAZARD_LAMPS)
            self._emergency = frozenset(lamp for lamp, on in lamps.items() if on & EMERGENCY_LAMPS)

    def _acceleration(self, path: Path, way: EgoMotion, around: NearbyObjects) -> float:
        allowed = super()._acceleration(path, way, around)
        if self._wait_m is not None:
            allowed = min(allowed, self._concerns.wait(self._wait_m - WAITS_M, way.speed))
        turning = self._turning.see(around, self._tick_s())
        if self._planner.following or self._holding:
            return allowed
        if self._pass is None and self._changes.wait_m is not None:
            slips_back = max(self._changes.most_mps - way.speed, -SLOWER_MPS2)
            allowed = min(allowed, slips_back, self._concerns.stop_line(self._changes.wait_m, way.speed))
        where = self._planner.where
        seen = on_route(path, where.s, around)
        for hazard in entering(seen, where, self._model):
            allowed = min(allowed, self._concerns.hazard(hazard, way.speed))
        # A vehicle that sets off in a proven gap does not brake for those against whom it was proven.
        proven = self._changes.judged if self._pass is None else frozenset()
        if self._give_way.going and isinstance(self._give_way, FlowMergeYield):
            proven |= self._give_way.judged
        seen = seen.part(~seen.among(proven))
        known = np.isin(around.actor_id, seen.actor_id)
        speed, others = max(way.speed, 0.0), around.part(known)
        return allowed_acceleration(path, where, speed, allowed, seen, others, turning[known], self._model)
