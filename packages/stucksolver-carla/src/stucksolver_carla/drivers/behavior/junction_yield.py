"""Gives way where others cross or join the route: wait before the junction for a gap, then go through.

The drives of the ego and of the others along their routes are predicted in steps. If the boxes come too near, the ego
waits. It never stops where the ways meet. CARLA's world frame, meters, radians, seconds.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import ClassVar, NamedTuple

from stucksolver_carla.drivers.behavior.acceleration_limits import PaceFactors
from stucksolver_carla.drivers.behavior.conflict_paths import ConflictPath, JunctionConflicts
from stucksolver_carla.drivers.behavior.conflicting_traffic import (
    LEAST_MPS,
    SHOWN_M,
    ConflictingVehicle,
    TurnStatistics,
    comes,
    flow_speed_mps,
    is_red,
    moving,
    vehicles_on_path,
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

BRISK = PaceFactors(1.3, 1.2)
"""How to drive into a gap."""
_LOOKS_M = 20.0
_LOOKS_S = 4.0
CREEPS_MPS = 1.0
"""An ego by sensors may creep up to the others' way: it sets off for a gap, sees that there is none, and knows its own
place to some decimeters only. If it is slower than this (m/s) ...
"""
NOSE_M = 1.0
"""... and no further in that way than this (m), it still waits. If it gives up no further than this past the line
before a junction or ramp, it stays there and has the whole ramp to run up.
"""
SETTLED_S = 0.15
"""By sensors, a standing ego sets off when the way has been free for so long: two looks. One that has set off gives up
when it has not been free for so long: a single noisy speed would take the best gap away.
"""
SENSED_HORIZON_S = 12.0
"""By sensors the drives are predicted for so long: up to a ramp's end, and `own_drive.JOINED_S` more. Else a gap on a
ramp of six seconds would seem long enough until the ego is half-way down, and can go neither on nor back.
"""
FASTER_MPS = 2.0
"""By sensors, a stream that is faster than the ego's own speed by more than this (m/s) is joined at its pace, ..."""
FASTEST_MPS = 22.0
"""... up to this (m/s)."""
LOOKING_MPS = 5.0
"""Speed before a turn across possible traffic: slow enough to see and still be able to wait."""
_A_TURN_MPS = 9.0
_HARD_MPS2 = 5.0
FULL_MPS2 = 7.0
_AT_THE_LINE_M = 3.0
START_LAG_S = 0.3
TO_GO = Margin(1.0, 0.8, 0.5, 0.2)
PATIENCE_S = 20.0
"""After this wait the ego accepts its smallest gap: accepted gaps shrink with the time waited."""
AFTER_WAITING = Margin(0.5, 0.3, 0.3, 0.1)
TO_GO_ON = Margin(0.5, 0.1, 0.0, 0.0)
"""For a vehicle that has set off: smaller, so that it does not hesitate."""


class YieldDecision(NamedTuple):
    """The result of `JunctionYield` for one tick."""

    wait_m: float | None
    """Distance from the front bumper to the waiting place (m); None if the way is free."""
    passing: frozenset[int]
    """Ids of those who will be out of the way in time, although they may be in it now."""
    look_m: float | None = None
    """Distance from the front bumper to where to be slow enough to look (m)."""
    leader: LeadVehicle | None = None
    """The vehicle behind which to join the flow."""


FREE = YieldDecision(None, frozenset())


class EgoSpeeds(NamedTuple):
    """The ego's speed along its route, and its speed if nothing held it back (m/s)."""

    speed: float
    top_mps: float


class JunctionYield:
    """Remembers, for one route, at which junction the ego has set off."""

    shown_m: ClassVar[float] = SHOWN_M
    """See `TurnStatistics`."""
    waits_with_its_nose_in: ClassVar[bool] = False
    """True if it waits as by sensors, see `NOSE_M`, with ground truth as well."""

    def __init__(
        self,
        meetings: Sequence[JunctionConflicts],
        profile: DriverProfile,
        model: VehicleModel,
        pace: PaceFactors = BRISK,
        *,
        sensed: bool = False,
    ) -> None:
        """`sensed`: the ego's place and the others' are known by sensors; see `NOSE_M` and `SETTLED_S`."""
        self._sensed = sensed
        self._clear_s = self._met_s = 0.0
        self._due = list(meetings)
        self.pace = pace
        """How to drive into a gap."""
        self._profile = replace(profile, acceleration=profile.acceleration + pace.more_mps2)
        self._model = model
        self._going: JunctionConflicts | None = None
        self._waited_s = 0.0
        self._habits = TurnStatistics(self.shown_m)
        self._pace_before, self._now_s = LaneSpeedPrior(), 0.0
        self.flow_mps = 0.0
        """By sensors: pace of a faster stream that the ego joins at the junction ahead (m/s); 0 without one."""

    @property
    def waits_at(self) -> tuple[JunctionConflicts | None, float]:
        """The junction ahead, if any, and how long it has waited there so far (s)."""
        return (self._due[0] if self._due else None), self._waited_s

    @property
    def going(self) -> bool:
        """True if it has set off in a gap."""
        return self._going is not None

    def stay(self) -> None:
        """Something else stops the ego: it has not set off."""
        self._going = None

    def look(self, line: Path, s: float, motion: EgoSpeeds, around: NearbyObjects, dt_s: float) -> YieldDecision:
        """Decide whether the ego must wait, with its center at arc length `s` of the route's `line`.

        `dt_s` is the time since the last look (s).
        """
        speed = motion.speed
        half = self._model.half_length
        front = s + half
        self._now_s += dt_s
        self._forget(s)
        if not self._due or self._due[0].wait_s - front > _LOOKS_M + _LOOKS_S * speed:
            return FREE
        meeting = self._due[0]
        coming = self._coming(meeting, around)
        own = self._drive(line, s, speed, self._top_mps(motion, coming))
        held = self._sensed and can_stop(speed, min(meeting.wait_s + NOSE_M, meeting.first_s) - front, _HARD_MPS2)
        place_s = meeting.wait_s if held or front <= meeting.wait_s else meeting.first_s
        room = place_s - front
        if not held and self._must_go(speed, room):
            self._going = meeting
            return self._gone(meeting, own.judge(coming, TO_GO_ON), front, speed)
        room = max(room, 0.0) if self._sensed else room
        going = self._going is meeting
        found = own.judge(coming, TO_GO_ON if going else self._margin())
        if self._sensed and going and found.met and found.pass_soon:
            return YieldDecision(room, frozenset())
        self._clear_s = 0.0 if found.met else self._clear_s + dt_s
        self._met_s = self._met_s + dt_s if found.met else 0.0
        if self._sensed and going and 0.0 < self._met_s < SETTLED_S:
            return YieldDecision(None, found.passing, None, found.leader)
        if self._sensed and going and found.met and not own.judge(_not_yet_there(coming), self._margin()).met:
            # It set off faster than foretold behind someone who is passing: giving up would take the gap away.
            return YieldDecision(room, frozenset())
        if self._sensed and not going and speed < LEAST_MPS and not found.met and self._clear_s < SETTLED_S:
            return YieldDecision(room, frozenset())
        self._waited_s += dt_s if speed < LEAST_MPS and room < _AT_THE_LINE_M else 0.0
        decided = room < _AT_THE_LINE_M or not can_stop(speed, room, self._profile.deceleration)
        self._going = None if found.met or not (going or decided) else meeting
        if found.met:
            return YieldDecision(room, frozenset())
        look_m = room if front <= meeting.wait_s and _asks_to_look(meeting, line) else None
        return YieldDecision(None, found.passing, look_m, found.leader)

    def _forget(self, s: float) -> None:
        """Drop the junctions that an ego with its center at `s` has left."""
        while self._due and s - self._model.half_length > self._due[0].last_s:
            self._due.pop(0)
            self._going, self._waited_s, self._habits = None, 0.0, TurnStatistics(self.shown_m)

    def _coming(
        self, meeting: JunctionConflicts, around: NearbyObjects
    ) -> list[tuple[ConflictPath, ConflictingVehicle]]:
        """Return those who come by a junction's ways and are not expected to wait or to turn off."""
        others = moving(around)
        under_way = [(way, vehicle) for way in meeting.ways for vehicle in vehicles_on_path(way, others)]
        self._habits.see([seen for seen in under_way if not (self._sensed and seen[1].actor_id >= FIRST_FAR_ID)])
        if self._sensed:
            paced = self._pace_before.of(under_way, self._now_s)
            # Who has set off gives up for what is measured: a fast car's trailing returns may be a new track, too, and
            # of whom only the camera sees just the nearest possible place is told, up to 20 m before the true one.
            measured = [seen for seen in under_way if seen[1].actor_id < FIRST_FAR_ID]
            under_way = with_flow_speed(measured if self.going else paced)
        return [(way, item) for way, item in under_way if comes(way, item) and self._habits.expect(way, item)]

    def _drive(self, line: Path, s: float, speed: float, top_mps: float) -> EgoRollout:
        """Return the ego's drive if it goes now."""
        horizon_s = SENSED_HORIZON_S if self._sensed else HORIZON_S
        gone = predict_drive(
            line, s, speed, top_mps, self._profile, self.pace.bends, self._lag_s(), horizon_s=horizon_s
        )
        return EgoRollout(line, gone, self._model, followers=not self._sensed)

    def _must_go(self, speed: float, room: float) -> bool:
        """True if the ego can no longer stop before the others' way, `room` meters ahead; see `NOSE_M`."""
        creeps = (self._sensed or self.waits_with_its_nose_in) and speed < CREEPS_MPS and room > -NOSE_M
        return not creeps and not can_stop(speed, room, _HARD_MPS2)

    def _lag_s(self) -> float:
        """Return how long a standing ego takes to set off (s).

        None by sensors for one that has set off: it would seem too late at every look, and give up, as the gap that it
        takes after a long wait is hardly longer than the one in which it goes on.
        """
        return 0.0 if self._sensed and self.going else START_LAG_S

    def _top_mps(self, motion: EgoSpeeds, coming: Sequence[tuple[ConflictPath, ConflictingVehicle]]) -> float:
        """Return the ego's highest speed with the present traffic (m/s)."""
        pace = flow_speed_mps(coming)
        fast = self._sensed and motion.top_mps + FASTER_MPS < pace < math.inf
        self.flow_mps = min(pace, FASTEST_MPS) if fast else 0.0
        return self.flow_mps or min(motion.top_mps, pace)

    def _gone(self, meeting: JunctionConflicts, found: PredictedConflict, front: float, speed: float) -> YieldDecision:
        """Past the waiting place, still brake for whoever comes regardless, but not in another's way."""
        rooms = [way.route_meets_s - front for way in found.met if self._may_stop_before(way, meeting, front)]
        room = min(rooms, default=-1.0)
        stops = can_stop(speed, room, FULL_MPS2)
        return YieldDecision(room, frozenset()) if stops else YieldDecision(None, found.passing, None, found.leader)

    def _may_stop_before(self, way: ConflictPath, meeting: JunctionConflicts, front: float) -> bool:
        if way.route_meets_s <= front:
            return False
        rear = way.route_meets_s - 2.0 * self._model.half_length - 1.0
        first = [item for item in meeting.ways if item.goes_first and item is not way]
        return not way.joins or not any(
            item.route_meets_s < way.route_meets_s and item.route_parts_s > rear for item in first
        )

    def _margin(self) -> Margin:
        share = min(self._waited_s / PATIENCE_S, 1.0)
        return Margin(*(a + share * (b - a) for a, b in zip(TO_GO, AFTER_WAITING, strict=True)))


def _not_yet_there(
    coming: Sequence[tuple[ConflictPath, ConflictingVehicle]],
) -> list[tuple[ConflictPath, ConflictingVehicle]]:
    """Return them without those whose front is where their way crosses the route, or past that."""
    return [(way, item) for way, item in coming if way.joins or item.s + item.half_length < way.meets_s]


def _asks_to_look(meeting: JunctionConflicts, line: Path) -> bool:
    """True for a turn with a way that has priority and is not held by a light."""
    inside = (line.s >= meeting.wait_s) & (line.s <= meeting.last_s)
    if float(line.speed[inside].min()) > _A_TURN_MPS:
        return False
    return any(way.goes_first and not any(map(is_red, way.lights)) for way in meeting.ways)
